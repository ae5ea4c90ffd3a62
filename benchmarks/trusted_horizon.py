"""How far should a sub-model be trusted? Tracking errors at 40 % losses by trusted horizon, at equal rate.

Prints one table a set of trips: for each sub-model, trusted horizon and turn, p90 and p99 of the tracking
error over the smaller of the two equal-rate baselines' (error-driven and periodic, total rate), and messages.
"""

import itertools
import os
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

from modelcast.core.arrays import SingleArray
from modelcast.io.trips import read_trips
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.gp import GaussianProcess
from modelcast.models.kinematic import ConstantTurnRateAcceleration, ConstantTurnRateVelocity
from modelcast.models.trusted import Trusted
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import BASELINE_BANK
from modelcast.study.case import TripCase, make_case
from modelcast.study.settings import EvaluationSettings
from modelcast.study.tracking import run_tracking

PACKET_ERROR_RATIO = 0.4
THRESHOLDS_M = (0.2, 0.3, 0.4, 0.5)
TRUSTS_S = [
    (np.inf, np.inf),
    *itertools.product((0.5, 1.0, 1.5, 2.0, 4.0), (0.0, 2.0, np.inf)),
]
SETS = {
    "dynamic": ("openacc_zalazone", "*dynamic*", 3),
    "handling": ("openacc_zalazone", "*handling*", 2),
    "spmd": ("spmd", "bsm_p1_dev.csv", 40),
    "smartloc": ("", "smartloc", 40),
    "comma2k19": ("", "comma2k19", 60),
}


def members(protocol: str) -> list[AbstractSubModel]:
    """The sub-models compared; the noise floor follows the protocol."""
    floor_m = 0.001 if protocol == "recorded" else 0.01
    return [
        ConstantTurnRateVelocity(),
        ConstantTurnRateAcceleration(),
        GaussianProcess(form="intercept", noise_floor_m=floor_m),
    ]


def ratios(
    cases: list[TripCase], member: AbstractSubModel, settings: EvaluationSettings
) -> list[tuple[float, float, float]]:
    """Messages, and p90 and p99 over the harder baseline's, at each threshold."""
    errors: dict[tuple[str, float], list[SingleArray]] = defaultdict(list)
    messages: dict[float, float] = defaultdict(float)
    for case in cases:
        mbc = TripRuntime(case.seen, Bank((member,)), case.estimator)
        baseline = TripRuntime(case.seen, BASELINE_BANK, case.estimator)
        for run in run_tracking(case, mbc, baseline, settings):
            who = run.contender
            if who.policy == "mbc":
                messages[who.threshold_m] += run.messages[0]
            if who.policy == "mbc" or who.rate_basis == "total":
                errors[who.policy, who.threshold_m].append(run.after_m.ravel())
    rows = []
    for threshold_m in settings.thresholds_m:
        p90, p99 = (
            {
                policy: float(np.quantile(np.concatenate(errors[policy, threshold_m]), share))
                for policy in ("mbc", "baseline-matched", "baseline-periodic")
            }
            for share in (0.9, 0.99)
        )
        rows.append((messages[threshold_m], *(p.pop("mbc") / min(p.values()) for p in (p90, p99))))
    return rows


def main() -> None:
    """Print the table of one set of trips: name and protocol from the command line."""
    name, protocol = sys.argv[1:]
    folder, pattern, seeds = SETS[name]
    settings = EvaluationSettings(THRESHOLDS_M, (PACKET_ERROR_RATIO,), seeds=seeds, protocol=protocol)
    files = sorted((Path(os.environ["MODELCAST_DATA"]) / folder).glob(pattern))
    cases = [make_case(trip, settings) for trip in read_trips(files)]
    print(f"{name}, {protocol}: p90/p99 over the harder equal-rate baseline at {THRESHOLDS_M} m (messages)")
    for member, (horizon_s, turn_s) in itertools.product(members(protocol), TRUSTS_S):
        damped = Trusted(member, horizon_s, turn_s) if np.isfinite(horizon_s) else member
        cells = [f"{p90:.2f}/{p99:.2f} ({n:.0f})" for n, p90, p99 in ratios(cases, damped, settings)]
        print(f"{member.name:13s} {horizon_s:4} s, turn {turn_s:4} s | " + " | ".join(cells), flush=True)


if __name__ == "__main__":
    main()
