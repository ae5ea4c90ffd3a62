"""What a step of a switching sub-model costs, how long training takes, and what they save on unseen routes.

    MODELCAST_DATA=DIR python benchmarks/switching.py [--left-out]

A step is the filter of one new sample, the fit that reads it, and one prediction; the time is per vehicle,
of a thousand vehicles in one compiled loop. Training is that of `modelcast train --add shs hdp-hmm` on the
five OpenACC files, reading left out. With ``--left-out``, messages are counted on every route of them, by
sub-models trained without it.
"""

import argparse
import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from measured import record
from modelcast.io.trips import read_trips
from modelcast.models.bank import Bank
from modelcast.models.members import ReadyBank
from modelcast.models.point_kernels import fit_batch, predict_each
from modelcast.models.profile import default_profile
from modelcast.models.switching import StochasticHybridSystem
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.arrays import sensed
from modelcast.station.banks import BASELINE_BANK, bank_from_text
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sensing.streaming import observe_newest
from modelcast.study.case import TripCase, make_case
from modelcast.study.routes import routes
from modelcast.study.settings import EvaluationSettings
from modelcast.study.training.switching import train_switching
from modelcast.trips.trajectory import Trajectory

__all__ = ["main"]

VEHICLES = 1000
REPEATS = 50
AGES_S = (0.5, 2.0, 10.0)
THRESHOLDS_M = (0.2, 0.5)
OTHERS = ("gp-linear", "paper", "ctra")


def shortest(run: Callable[[], None]) -> float:
    """Return the shortest of many runs, in microseconds a vehicle."""
    found: list[float] = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        run()
        found.append(time.perf_counter() - begin)
    return 1e6 * min(found) / VEHICLES


def step_times(model: StochasticHybridSystem) -> str:
    """Return microseconds of filter, fit and predictions."""
    ready = ReadyBank.of(Bank((model,)), 0.1)
    held = sensed(VEHICLES, 4, ready.sample_columns)
    rng = np.random.default_rng(0)
    held.samples[..., 2:6] = rng.normal(0.0, [10.0, 10.0, 1.0, 0.1], (*held.samples.shape[:2], 4))
    held.samples[..., 7:] = 1.0 / len(model.modes)
    held.history[:], held.taken[:] = 5, 3
    vehicle, members = np.arange(VEHICLES), ready.members
    filtered = shortest(lambda: observe_newest(members, held, vehicle))
    window = np.ascontiguousarray(held.samples[:, 6:7])
    parameters = np.empty((VEHICLES, len(model.parameter_names)))
    fitted = shortest(lambda: fit_batch(int(members.fits[0]), window, members.constants, parameters))
    moved = np.empty((VEHICLES, 2))
    times: list[float] = []
    for age_s in AGES_S:
        ages_s = np.full(VEHICLES, age_s)
        times.append(
            shortest(
                lambda ages_s=ages_s: predict_each(
                    int(members.predicts[0]), parameters, ages_s, members.constants, np.inf, np.inf, moved
                )
            )
        )
    ages = ", ".join(f"{age_s:g} s ahead {us:.2f}" for age_s, us in zip(AGES_S, times, strict=True))
    whole = filtered + fitted + times[-1]
    record(f"{model.name}: filter, fit and predict {AGES_S[-1]:g} s ahead", whole, "µs a vehicle")
    return f"filter {filtered:.2f}, fit {fitted:.2f}, predict {ages}; filter, fit, predict {whole:.2f}"


def messages(cases: Sequence[TripCase], bank: Bank) -> list[int]:
    """Return messages at each threshold."""
    total = [0] * len(THRESHOLDS_M)
    for case in cases:
        ready = TripRuntime(case.seen, bank, case.estimator, quantised=True)
        for at, threshold_m in enumerate(THRESHOLDS_M):
            walk = ready.run(ErrorDriven(threshold_m, "order", "on-failure"))
            total[at] += walk.updates + walk.identifications
    return total


def left_out(trips: Sequence[Trajectory]) -> None:
    """Print messages over the baseline's on routes that the sub-models were not trained on."""
    route = routes(trips)
    asked = EvaluationSettings(protocol="recorded")
    totals: dict[str, list[int]] = {}
    for own in range(int(route.max()) + 1):
        others = [trip for trip, its in zip(trips, route, strict=True) if its != own]
        cases = [make_case(trip, asked) for trip, its in zip(trips, route, strict=True) if its == own]
        found = train_switching(others, seed=0)
        banks = {
            "baseline": BASELINE_BANK,
            **{name: bank_from_text(name) for name in OTHERS},
            **{model.name: Bank((model,)) for model in found.models},
        }
        for name, bank in banks.items():
            held = totals.setdefault(name, [0] * len(THRESHOLDS_M))
            totals[name] = [a + b for a, b in zip(held, messages(cases, bank), strict=True)]
    print(f"messages over the baseline's, {len(trips)} trips on {int(route.max()) + 1} routes left out:")
    for name, counts in totals.items():
        ratios = " / ".join(f"{one / base:.2f}" for one, base in zip(counts, totals["baseline"], strict=True))
        print(f"  {name:10} {ratios}")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--left-out", action="store_true")
    chosen = parser.parse_args()
    for name in ("shs", "hdp-hmm"):
        model = default_profile().sub_model(name)
        if isinstance(model, StochasticHybridSystem):
            print(f"{name}, {len(model.modes)} modes, us a vehicle: {step_times(model)}")
    trips = list(read_trips([Path(os.environ["MODELCAST_DATA"]) / "openacc_zalazone"]))
    begin = time.perf_counter()
    found = train_switching(trips, seed=0)
    spent_s = time.perf_counter() - begin
    steps = found.record["shs"]["steps"]
    record("training of shs and hdp-hmm", spent_s, "s", sizes={"trips": len(trips)})
    print(f"training both on {len(trips)} trips, {steps} steps: {spent_s:.0f} s")
    if chosen.left_out:
        left_out(trips)


if __name__ == "__main__":
    main()
