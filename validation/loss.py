"""What losses cost, and what a sender does about them: tracking errors at 40 % losses, at equal rate.

``loss.py trust`` prints p90 and p99 of the tracking error of free ``ctra`` by trusted horizon and turn, each
over the harder of the two equal-rate baselines' (constant velocity: error-driven with its own threshold, and
periodic). ``loss.py rules`` compares beliefs, budgets and keep-alives of one horizon the same way, beside the
same sender that believes in what it sent at the same number of messages, and constant velocity with the rule.

Every row has a source and a protocol: the mean of the ratios over the thresholds 0.2, 0.3, 0.4 and 0.5 m
(geometric), the worst of them behind it, then messages over those of the first row. ``--sources``,
``--protocols`` and ``--senders`` name some.
"""

import argparse
import os
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from itertools import islice, product
from pathlib import Path

import numpy as np

from modelcast.core.arrays import FloatArray, SingleArray
from modelcast.io.trips import read_trips
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.trusted import Trusted
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import BASELINE_BANK
from modelcast.study.case import TripCase, make_case
from modelcast.study.metrics import quantiles
from modelcast.study.settings import EvaluationSettings
from modelcast.study.tracking import Contender, LossRuns, TrackingRun, walks_under_loss

PACKET_ERROR_RATIO = 0.4
THRESHOLDS_M = (0.2, 0.3, 0.4, 0.5)
PROTOCOLS = ("recorded", "sensor")
SOURCES = {
    "openacc": ("openacc_zalazone", 1),
    "tampa": ("roads/tampa_dev.parquet", 1),
    "kitti": ("roads/kitti_00-04.parquet", 8),
    "boreas": ("roads/boreas_2021-08-05.parquet", 10),
    "spmd": ("spmd/bsm_p1_dev.csv", 24),
    "smartloc": ("smartloc", 40),
    "comma2k19": ("comma2k19", 60),
}
"""Place in the data folder, and runs drawn: the fewer the longer the source."""

FREE = ConstantTurnRateAcceleration()
HORIZON_S, TURN_S = 1.5, 1.0

RIVALS = {"cv": ("baseline-matched", "baseline-periodic"), "free": ("baseline-matched",)}
"""Who is held against a sender, and in which readings of its number of messages."""


def trusts() -> dict[str, tuple[Bank, dict[str, object]]]:
    """The free model with every trusted horizon and turn."""
    found: dict[str, tuple[Bank, dict[str, object]]] = {"whole": (Bank((FREE,)), {})}
    for horizon_s, turn_s in product((1.0, 1.5, 2.0, 3.0), (0.5, 1.0, 2.0)):
        found[f"{horizon_s:g} s, turn {turn_s:g} s"] = (Bank((Trusted(FREE, horizon_s, turn_s),)), {})
    return found


def rules() -> dict[str, tuple[Bank, dict[str, object]]]:
    """Beliefs, budgets and keep-alives with one trusted horizon; constant velocity and the shipped bank."""
    member: AbstractSubModel = Trusted(FREE, HORIZON_S, TURN_S)
    free, shipped = Bank((member,)), EvaluationSettings().bank
    found: dict[str, tuple[Bank, dict[str, object]]] = {
        "free, sent": (free, {"believe": "sent"}),
        "free, sent, keep-alive 1.05 s": (free, {"believe": "sent", "keep_alive_s": 1.05}),
    }
    for label, budget in (("1", 1.0), ("4/3", 4.0 / 3.0), ("2", 2.0), ("open", np.inf)):
        found[f"free, expected, budget {label}"] = (free, {"believe": "expected", "budget": budget})
    found["free, expected, keep-alive 1.05 s"] = (free, {"believe": "expected", "keep_alive_s": 1.05})
    found["free, expected, keep-alive 5 s"] = (free, {"believe": "expected", "keep_alive_s": 5.0})
    found["cv, expected"] = (BASELINE_BANK, {"believe": "expected"})
    found["shipped, sent"] = (shipped, {"believe": "sent"})
    found["shipped, expected"] = (shipped, {"believe": "expected"})
    return found


class Pool:
    """Errors of all trips of a source, by who made them and threshold."""

    def __init__(self) -> None:
        self._errors: dict[tuple[str, float], list[SingleArray]] = defaultdict(list)
        self._weights_s: dict[tuple[str, float], list[float]] = defaultdict(list)
        self.messages = 0.0

    def add(self, who: str, threshold_m: float, run: TrackingRun, dt_s: float) -> None:
        """Add one trip's."""
        errors = run.after_m.ravel()
        self._errors[who, threshold_m].append(np.sort(errors[~np.isnan(errors)]))
        self._weights_s[who, threshold_m].append(dt_s)

    def over(self, rivals: Sequence[str]) -> FloatArray:
        """p90 and p99 of the sender over the least of the rivals', by threshold, (4, 2)."""

        def tail(who: str, threshold_m: float) -> FloatArray:
            key = who, threshold_m
            return quantiles(self._errors[key], self._weights_s[key], [0.9, 0.99])

        return np.array(
            [
                tail("own", threshold_m) / np.min([tail(rival, threshold_m) for rival in rivals], axis=0)
                for threshold_m in THRESHOLDS_M
            ]
        )


class Staged:
    """A trip, and who is held against the sender over it: constant velocity, and free beside it."""

    def __init__(self, case: TripCase, settings: EvaluationSettings) -> None:
        free = Bank((Trusted(FREE, HORIZON_S, TURN_S),))
        self.case = case
        self.rivals = {
            name: LossRuns(case, TripRuntime(case.seen, bank, case.estimator, quantised=True), settings)
            for name, bank in (("cv", BASELINE_BANK), ("free", free))
        }


def pooled(staged: Sequence[Staged], bank: Bank, settings: EvaluationSettings) -> Pool:
    """The errors of a sender over trips, and of its rivals at its number of messages."""
    pool = Pool()
    for trip in staged:
        case = trip.case
        ready = TripRuntime(case.seen, bank, case.estimator, quantised=True)
        for threshold_m in THRESHOLDS_M:
            walks = walks_under_loss([ready], settings, threshold_m)
            own = trip.rivals["cv"].walked(ready, walks, Contender("own", bank.name, None, threshold_m))
            pool.messages += sum(own.messages)
            pool.add("own", threshold_m, own, case.truth.dt_s)
            plain = replace(settings, keep_alive_s=2.0).policy(threshold_m, keep_alive=True)
            for name, readings in RIVALS.items():
                runs = trip.rivals[name].equal_rate(plain, walks, "total")
                for run in islice(runs, len(readings)):
                    pool.add(f"{name} {run.contender.policy}", threshold_m, run, case.truth.dt_s)
    return pool


def cell(ratios: FloatArray) -> str:
    """Geometric means of p90 and p99, and the worst of the thresholds."""
    mean, worst = np.exp(np.log(ratios).mean(axis=0)), ratios.max(axis=0)
    return f"{mean[0]:.2f}/{mean[1]:.2f} ({worst[0]:.2f}/{worst[1]:.2f})"


def main() -> None:
    """Print the rows of a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("table", choices=("trust", "rules"))
    parser.add_argument("--sources", nargs="+", choices=tuple(SOURCES), default=tuple(SOURCES))
    parser.add_argument("--senders", nargs="+", help="rows to print, by their names; all where not given")
    parser.add_argument("--protocols", nargs="+", choices=PROTOCOLS, default=PROTOCOLS)
    given = parser.parse_args()
    variants = trusts() if given.table == "trust" else rules()
    if given.senders:
        variants = {name: variants[name] for name in given.senders}
    over: dict[str, list[FloatArray]] = defaultdict(list)
    print("| source | protocol | sender | over cv: p90/p99 (worst) | over free, sent | messages |")
    print("|---|---|---|---|---|---|")
    for source, protocol in product(given.sources, given.protocols):
        place, seeds = SOURCES[source]
        settings = EvaluationSettings(
            THRESHOLDS_M, (PACKET_ERROR_RATIO,), seeds=seeds, protocol=protocol, believe="sent"
        )
        path = Path(os.environ["MODELCAST_DATA"]) / place
        files = sorted(path.glob("*.csv")) if source == "openacc" else [path]
        staged = [Staged(make_case(trip, settings), settings) for trip in read_trips(files)]
        first = 0.0
        for name, (bank, changes) in variants.items():
            pool = pooled(staged, bank, replace(settings, bank=bank, **changes))
            first = first or pool.messages
            rows = [
                pool.over([f"{rival} {reading}" for reading in readings])
                for rival, readings in RIVALS.items()
            ]
            over[name].append(np.concatenate(rows, axis=1))
            cells = " | ".join(cell(row) for row in rows)
            print(f"| {source} | {protocol} | {name} | {cells} | {pool.messages / first:.2f} |", flush=True)
    for name, each in over.items():
        mean = np.exp(np.mean([np.log(one).mean(axis=0) for one in each], axis=0))
        print(f"| mean | | {name} | {mean[0]:.2f}/{mean[1]:.2f} | {mean[2]:.2f}/{mean[3]:.2f} | |")


if __name__ == "__main__":
    main()
