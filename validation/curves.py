"""Learning curves and ablations of the free sub-models, and what knowing the future would save.

``curves.py count FOLDER`` takes the profiles that ``judged.py train FOLDER`` made, trains the free sub-models
on parts of each half of the data too, and on all of a half with something left out, and counts messages on
the other half. Trainings that are done are kept. ``curves.py table FOLDER`` prints a row a variant; with
``--write`` it puts the table into ``docs/curves.md``, with ``--check`` it tells by its exit code whether that
page has it.
"""

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np

import judged
from modelcast.io.profile import read_profile
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.trusted import Trusted
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.study.case import make_case
from modelcast.study.clairvoyant import clairvoyant
from modelcast.study.settings import EvaluationSettings
from modelcast.study.training.free_members import (
    FREE_NAMES,
    FreeMembers,
    FreeMembersSettings,
    train_free_members,
)
from modelcast.study.training.views import SenderView
from modelcast.trips.trajectory import Trajectory
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "curves.md"
THRESHOLDS_M = (0.2, 0.5)
PROTOCOLS = ("recorded", "sensor")
NEWEST = Trusted(ConstantTurnRateAcceleration(), 1.5, 1.0)


def _every(count: int) -> Callable[[Sequence[Trajectory]], list[Trajectory]]:
    return lambda trips: list(trips[::count])


def _one_kind(settings: FreeMembersSettings) -> FreeMembersSettings:
    return replace(settings, views=((SenderView("recorded"), 1.0),))


def _same(settings: FreeMembersSettings) -> FreeMembersSettings:
    return settings


ALL = "all the trips"

VARIANTS = {
    "an eighth of the trips": (_every(8), _same),
    "a quarter": (_every(4), _same),
    "recorded senders alone": (_every(1), _one_kind),
}
"""Which trips of a half, and how the settings differ from those of `modelcast train`."""


def _quiet(_: str, __: int, ___: int) -> None:
    pass


def _messages(
    trips: Sequence[tuple[str, Trajectory]], members: Sequence[AbstractSubModel]
) -> dict[str, list[float]]:
    """Messages of a bank by source and protocol, at every threshold."""
    bank = Bank(tuple(members)).complete()
    policies = [ErrorDriven(threshold_m, "order", "never") for threshold_m in THRESHOLDS_M]
    found: dict[str, list[float]] = {}
    for name, trip in trips:
        for protocol in PROTOCOLS:
            case = make_case(trip, EvaluationSettings(protocol=protocol))
            runs = TripRuntime(case.seen, bank, case.estimator, quantised=True).run_each(policies)
            key = f"{name} {protocol}"
            before = found.get(key, [0.0] * len(THRESHOLDS_M))
            found[key] = [one + run.updates for one, run in zip(before, runs, strict=True)]
    return found


def _bounds(trips: Sequence[tuple[str, Trajectory]], degree: int) -> dict[str, list[float]]:
    """Messages of senders that know the future and send polynomials."""
    found: dict[str, list[float]] = {}
    for name, trip in trips:
        for protocol in PROTOCOLS:
            case = make_case(trip, EvaluationSettings(protocol=protocol))
            key = f"{name} {protocol}"
            before = found.get(key, [0.0] * len(THRESHOLDS_M))
            sent = [clairvoyant(case.seen, degree, one).starts.size for one in THRESHOLDS_M]
            found[key] = [one + other for one, other in zip(before, sent, strict=True)]
    return found


def _trained(which: str, variant: str, data: Path) -> FreeMembers:
    chosen, changed = VARIANTS[variant]
    trips = [trip for _, trip in judged.halved(which, data, training=True)]
    return train_free_members(chosen(trips), changed(FreeMembersSettings()), progress=_quiet)


def _count(which: str, folder: Path, data: Path) -> None:
    """Everything about one half."""
    path = folder / f"{which}.curves.json"
    rows: dict[str, dict[str, list[float]]] = json.loads(path.read_text()) if path.exists() else {}
    trips = list(judged.halved(which, data, training=False))

    def keep(name: str, made: Callable[[], dict[str, list[float]]]) -> None:
        if name not in rows:
            rows[name] = made()
            path.write_text(json.dumps(rows), encoding="utf-8")
            print(f"{which}: {name}", flush=True)

    keep("cv", lambda: _messages(trips, [ConstantVelocity()]))
    keep("newest values", lambda: _messages(trips, [NEWEST]))
    for degree in (1, 2, 3):
        keep(f"clairvoyant-{degree}", lambda degree=degree: _bounds(trips, degree))
    whole = read_profile(folder / f"{which}.json")
    free, predictive = (whole.bank.members[whole.bank.place_of(name)] for name in FREE_NAMES[:2])
    keep(f"{ALL}: free", lambda: _messages(trips, [free]))
    keep(f"{ALL}: free-predictive", lambda: _messages(trips, [predictive, free]))
    for variant in VARIANTS:
        names = (f"{variant}: free", f"{variant}: free-predictive")
        if not all(name in rows for name in names):
            found = _trained(which, variant, data)
            keep(names[0], lambda found=found: _messages(trips, [found.free]))
            keep(names[1], lambda found=found: _messages(trips, [found.predictive, found.free]))


def count(folder: Path, data: Path) -> None:
    """Both halves, one a core."""
    folder.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(2) as pool:
        for running in [pool.submit(_count, which, folder, data) for which in "ab"]:
            running.result()


def table(folder: Path) -> Iterator[str]:
    """Messages over constant velocity's, a row a variant and a column a source; the mean over both last."""
    held: dict[str, dict[str, list[float]]] = {}
    for which in "ab":
        for name, row in json.loads((folder / f"{which}.curves.json").read_text(encoding="utf-8")).items():
            for key, sent in row.items():
                known = held.setdefault(name, {}).get(key, [0.0] * len(sent))
                held[name][key] = [one + other for one, other in zip(known, sent, strict=True)]
    sources = [name for name in judged.SOURCES if any(key.startswith(f"{name} ") for key in held["cv"])]
    yield "| | " + " | ".join(sources) + " | mean |"
    yield "|---|" + "---|" * (len(sources) + 1)
    for name, row in held.items():
        if name == "cv":
            continue
        cells: list[np.ndarray] = []
        for source in sources:
            keys = [f"{source} {protocol}" for protocol in PROTOCOLS]
            each = [np.array(row[key]) / np.array(held["cv"][key]) for key in keys if key in row]
            cells.append(np.mean(each, axis=0))
        shown = (f"{one[0]:.2f} / {one[-1]:.2f}" for one in (*cells, np.mean(cells, axis=0)))
        yield f"| {name} | {' | '.join(shown)} |"


def main() -> int:
    """Count or print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=("count", "table"))
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    if given.what == "count":
        count(given.folder, Path(os.environ.get("MODELCAST_DATA", "")))
        return 0
    lines = list(table(given.folder))
    print("\n".join(lines))
    if given.write or given.check:
        return put({PAGE: {"curves": lines}}, check=given.check)
    return 0


if __name__ == "__main__":
    sys.exit(main())
