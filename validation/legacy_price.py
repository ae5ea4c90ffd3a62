"""What it costs to mind legacy receivers: messages and their errors at every ``--legacy-threshold``.

The profile's bank sends by its own rules at 20 and 50 cm, with a keep-alive of 2 s and no losses, over the
trips of `judged.SOURCES` that it was not trained on. A legacy receiver coasts place, speed and heading of
Part I at constant velocity; its error is taken against the truth at every sample. Beside it stands the
sender of constant velocity alone, whose receivers all are legacy ones. ``--write`` puts the table into
``docs/mixed.md``, ``--check`` tells by its exit code whether that page has it.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import groupby
from math import inf, isfinite
from pathlib import Path

import numpy as np

from judged import PROTOCOLS, SOURCES, unseen
from legacy import Pool
from modelcast.core.arrays import FloatArray
from modelcast.models.point_kernels import VELOCITY_EAST, VELOCITY_NORTH
from modelcast.models.profile import default_profile
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime, sense_trip
from modelcast.station.banks import BASELINE_BANK, named_bank
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.study.case import TripCase, make_case
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "mixed.md"
BLOCK = "legacy-price"
THRESHOLDS_M = (0.2, 0.5)
LEGACY_M = (inf, 2.0, 1.0, 0.5, 0.2)
KEEP_ALIVE_S = 2.0
BASELINE = "constant velocity"

Key = tuple[str, float]
"""Who sends, as a legacy threshold or `BASELINE`, and at which error."""


@dataclass
class Found:
    """Of one source in one protocol: messages and errors of legacy receivers [m], by who sends."""

    source: str
    protocol: str
    messages: dict[Key, int] = field(default_factory=dict[Key, int])
    errors: dict[Key, Pool] = field(default_factory=dict[Key, Pool])

    def add(self, who: str, walk: TripMessages, errors_m: FloatArray, dt_s: float) -> None:
        """Add one trip's."""
        key = who, walk.policy.threshold_m
        self.messages[key] = self.messages.get(key, 0) + int(walk.transmits.sum())
        self.errors.setdefault(key, Pool()).add(errors_m, dt_s)


def legacy_errors(case: TripCase, ready: TripRuntime, walk: TripMessages) -> FloatArray:
    """Error at every sample of who coasts the last update's place, speed and heading, (T,) [m]."""
    update, member = walk.update_index, walk.in_use
    east, north = ready.own.part_one.places[member[update], :2].T
    stated = np.stack([ready.parameters[update, east], ready.parameters[update, north]], axis=1)
    own = ready.samples[update][:, [VELOCITY_EAST, VELOCITY_NORTH]]
    velocity_mps = np.where((east >= 0)[:, None], stated, own)
    age_s = case.truth.t_s - ready.stated_s[update]
    believed_m = ready.stated_m[update] + velocity_mps * age_s[:, None]
    return np.hypot(*(case.truth.position_m - believed_m).T)


def name_of(legacy_m: float) -> str:
    """A threshold in words."""
    return f"{100 * legacy_m:g} cm" if isfinite(legacy_m) else "off"


def add_trip(found: Found, trip: Trajectory) -> None:
    """Count one trip."""
    case = make_case(trip, EvaluationSettings(protocol=found.protocol))
    sensed = sense_trip(case.seen, case.estimator, quantised=True)
    bank = named_bank("default")
    ready = TripRuntime(case.seen, bank.bank, case.estimator, quantised=True, sensed=sensed)
    policies = [
        ErrorDriven(threshold_m, bank.start, bank.identify, KEEP_ALIVE_S, legacy_threshold_m=legacy_m)
        for threshold_m in THRESHOLDS_M
        for legacy_m in LEGACY_M
    ]
    for walk in ready.run_each(policies):
        who = name_of(walk.policy.legacy_threshold_m)
        found.add(who, walk, legacy_errors(case, ready, walk), case.truth.dt_s)
    straight = TripRuntime(case.seen, BASELINE_BANK, case.estimator, quantised=True, sensed=sensed)
    rules = [ErrorDriven(one, max_inter_transmit_time_s=KEEP_ALIVE_S) for one in THRESHOLDS_M]
    for walk in straight.run_each(rules):
        found.add(BASELINE, walk, legacy_errors(case, straight, walk), case.truth.dt_s)


def judge(data: Path, sources: Sequence[str]) -> list[Found]:
    """Count all trips of some sources that the shipped profile was not trained on."""
    results: list[Found] = []
    for source, pairs in groupby(unseen(default_profile(), data, sources), key=lambda pair: pair[0]):
        own = [Found(source, protocol) for protocol in PROTOCOLS]
        for _, trip in pairs:
            for found in own:
                add_trip(found, trip)
        print(f"{source} is counted", file=sys.stderr, flush=True)
        results += own
    return results


def _cell(values: Sequence[float]) -> str:
    return " / ".join(f"{one:.2f}" for one in values)


def table(results: Sequence[Found]) -> list[str]:
    """Messages over those of the bank that minds nobody, and the 99th percentile of legacy errors [m]."""
    senders = [*map(name_of, LEGACY_M), BASELINE]
    heads = " | ".join(senders)
    rule = "|---|---|---|" + "---|" * len(senders)
    lines = [f"| source | as seen | what | {heads} |", rule]
    logs: list[list[list[float]]] = []
    for found in results:
        counts = [
            [found.messages[who, one] / found.messages[senders[0], one] for one in THRESHOLDS_M]
            for who in senders
        ]
        p99 = [[found.errors[who, one].figures[2] for one in THRESHOLDS_M] for who in senders]
        logs.append([list(np.log(one)) for one in counts])
        cells = " | ".join(map(_cell, counts))
        lines.append(f"| {found.source} | {found.protocol} | messages | {cells} |")
        lines.append("| | | legacy p99 [m] | " + " | ".join(map(_cell, p99)) + " |")
    mean = np.exp(np.mean(logs, axis=0)).tolist()
    lines.append("| geometric mean | | messages | " + " | ".join(map(_cell, mean)) + " |")
    return lines


def main() -> int:
    """Count and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--sources", nargs="+", choices=tuple(SOURCES), default=tuple(SOURCES))
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    lines = table(judge(Path(os.environ["MODELCAST_DATA"]), given.sources))
    print("\n".join(lines))
    if given.write or given.check:
        return put({PAGE: {BLOCK: lines}}, check=given.check)
    return 0


if __name__ == "__main__":
    sys.exit(main())
