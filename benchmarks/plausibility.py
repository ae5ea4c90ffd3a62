"""Find out how many samples of recorded trips are found implausible, and what a check costs.

Every sample is a message. Trips without heading (OpenACC) state the causal velocity estimate that their
senders would use; the others their own columns.
"""

import os
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np

from measured import record
from modelcast.io.trips import read_trips
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.station.receiver.heard import Heard, HeardKind
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap
from modelcast.station.receiver.plausibility import Finding, Plausibility, PlausibilityState
from modelcast.station.receiver.statements import Statements, statements_of
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.station.sensing.velocity import velocity_estimator_for

ROUNDS, TURNS = 9, 3
VEHICLES, STEPS = 300, 50
EVERY = (1, 5, 20)
RECORDINGS = ("nyc_cvpd", "spmd/bsm_p1_dev.csv", "comma2k19", "smartloc", "openacc_zalazone")


def main() -> int:
    """Measure and print."""
    folder = os.environ.get("MODELCAST_DATA", "")
    if not folder:
        print("MODELCAST_DATA is not set")
        return 2
    timings()
    found: dict[tuple[str, int], Counter[str]] = {}
    trips: Counter[str] = Counter()
    for trip in read_trips([Path(folder) / name for name in RECORDINGS]):
        trips[trip.source] += 1
        given = statements_of(trip)
        if given is None:
            velocity_mps = sample_matrix(trip, velocity_estimator_for(trip))[:, 2:4].copy()
            given = Statements(
                np.zeros(len(trip), dtype=np.int64),
                trip.t_s,
                position_m=trip.position_m,
                velocity_mps=velocity_mps,
                received_s=trip.t_s,
            )
        for every in EVERY:
            findings, _ = Plausibility().check(PlausibilityState(), thinned(given, every))
            names = (Finding(one).name for one in findings)
            found.setdefault((trip.source, every), Counter()).update(names)
    for (source, every), counts in sorted(found.items()):
        print(f"{source:10s} {trips[source]:3d} trips, every {every:2d}th: {dict(counts)}")
    return 0


def thinned(given: Statements, every: int) -> Statements:
    """Return every so many-th report."""
    return Statements(
        given.vehicle[::every].copy(),
        given.t_s[::every].copy(),
        position_m=given.position_m[::every].copy(),
        velocity_mps=given.velocity_mps[::every].copy(),
        received_s=given.received_s[::every].copy(),
    )


def timings() -> None:
    """Print the cost of a check in batch, and of a message at the map with and without."""
    vehicle = np.tile(np.arange(VEHICLES), STEPS)
    t_s = np.repeat(np.arange(STEPS) * 0.1, VEHICLES)
    whole = Statements(
        vehicle,
        t_s,
        position_m=np.stack([20 * t_s, 5.0 * vehicle], axis=1),
        velocity_mps=np.tile([20.0, 0.0], (t_s.size, 1)),
        received_s=t_s,
    )
    checks = Plausibility()
    checks.check(PlausibilityState(), whole)
    check_us = batch_us(checks, whole)
    record("check a message", check_us, "µs", sizes={"vehicles": VEHICLES})
    print(f"{VEHICLES} vehicles, {STEPS} steps, one batch a step: {check_us:.2f} µs a message")
    bank = Bank((ConstantVelocity(),))
    maps = {
        "without": LocalDynamicMap((bank,)),
        "with": LocalDynamicMap((bank,), plausibility=checks),
    }
    least = dict.fromkeys(maps, np.inf)
    for _ in range(TURNS):
        for name, around in maps.items():
            least[name] = min(least[name], map_us(around, whole))
    for name, took_us in least.items():
        record(f"hear a message, {name} plausibility", took_us, "µs", sizes={"remotes": VEHICLES})
        print(f"LocalDynamicMap.hear {name} plausibility, {VEHICLES} remotes: {took_us:.2f} µs a message")


def batch_us(checks: Plausibility, whole: Statements) -> float:
    """Return the shortest time a message of all rounds [µs]."""

    def run() -> None:
        state = PlausibilityState()
        for step in range(STEPS):
            part = slice(step * VEHICLES, (step + 1) * VEHICLES)
            one = Statements(
                whole.vehicle[part],
                whole.t_s[part],
                position_m=whole.position_m[part],
                velocity_mps=whole.velocity_mps[part],
                received_s=whole.received_s[part],
            )
            _, state = checks.check(state, one)

    return least_us(run, whole.t_s.size)


def map_us(around: LocalDynamicMap, whole: Statements) -> float:
    """Return the shortest time a message of all rounds, one batch a step [µs]."""
    unknown, none = np.full(VEHICLES, np.nan), np.full(VEHICLES, -1)
    batches = [
        Heard(
            np.full(VEHICLES, int(HeardKind.UPDATE)),
            whole.vehicle[part],
            np.full(VEHICLES, step),
            t_s=whole.t_s[part],
            received_s=whole.received_s[part],
            position_m=whole.position_m[part],
            speed_mps=unknown,
            heading_rad=unknown,
            acceleration_mps2=unknown,
            yaw_rate_radps=unknown,
            profile=np.zeros(VEHICLES, dtype=np.int64),
            in_use=np.zeros(VEHICLES, dtype=np.int64),
            parameters=whole.velocity_mps[part],
            length_m=unknown,
            width_m=unknown,
            user=none,
        )
        for step in range(STEPS)
        for part in [slice(step * VEHICLES, (step + 1) * VEHICLES)]
    ]

    def run() -> None:
        state = around.init()
        for batch in batches:
            _, state = around.hear(state, batch)

    run()
    return least_us(run, whole.t_s.size)


def least_us(run: Callable[[], None], messages: int) -> float:
    """Return the shortest over rounds, since other work may run [µs]."""
    times = []
    for _ in range(ROUNDS):
        begin = time.perf_counter_ns()
        run()
        times.append((time.perf_counter_ns() - begin) / messages / 1e3)
    return min(times)


if __name__ == "__main__":
    sys.exit(main())
