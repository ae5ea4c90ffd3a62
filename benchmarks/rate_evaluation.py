"""Message rates of hybrid and baseline at four thresholds: processor time of one core against real time."""

import os
import statistics
import time
from pathlib import Path

from measured import record
from modelcast.io.trips import read_trips
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import BASELINE_BANK
from modelcast.study.case import TripCase, make_case
from modelcast.study.rate import count_rates
from modelcast.study.settings import EvaluationSettings

FILE = "openacc_zalazone/no_ACC__handling_part22.csv"
ROUNDS = 9
LEAST_RATIO = 10_000


def count_all(cases: list[TripCase], settings: EvaluationSettings) -> int:
    """Send along every trip by both policies at every threshold; nothing is kept from an earlier call."""
    messages = 0
    for case in cases:
        mbc = TripRuntime(case.seen, settings.bank, case.estimator)
        baseline = TripRuntime(case.seen, BASELINE_BANK, case.estimator)
        for count, _sent in count_rates(case, mbc, baseline, settings):
            messages += count.updates + count.identifications
    return messages


def main() -> None:
    """Time the rates of one file's trips."""
    settings = EvaluationSettings()
    trips = read_trips(Path(os.environ["MODELCAST_DATA"]) / FILE)
    cases = [make_case(trip, settings) for trip in trips]
    duration_s = sum(case.truth.duration_s for case in cases)
    messages = count_all(cases, settings)  # compiles
    times: list[float] = []
    for _ in range(ROUNDS):
        start = time.process_time()
        count_all(cases, settings)
        times.append(time.process_time() - start)
    median = statistics.median(times)
    print(f"rate evaluation: {len(cases)} trips, {duration_s:.0f} s, {messages} messages")
    print(f"  median {1e3 * median:.0f} ms, best {1e3 * min(times):.0f} ms of {ROUNDS} runs")
    record("message rates at four thresholds, default bank", duration_s / median, "times real time")
    print(f"  {duration_s / median:,.0f} times real time (at least {LEAST_RATIO:,})")


if __name__ == "__main__":
    main()
