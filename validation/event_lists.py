"""Which messages are sent over every trip, by this checkout and by another: what a change does to them.

``event_lists.py write FILE`` runs the shipped bank and constant velocity at the default thresholds over every
trip of the data folder, rounded as messages are or not (``--plain``), and keeps counts and a digest of each
event list. Modules are found as in ``benchmarks/paired_scenarios.py``, so ``PYTHONPATH=OTHER/src`` runs an
older checkout. ``event_lists.py compare BEFORE AFTER`` prints a line a source, with ``--trips`` one a trip
too.
"""

import argparse
import hashlib
import json
import os
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))

from paired_scenarios import found
from trip_sources import folders

FEW = 20
"""Shares are told of trips with at least so many messages."""


def counted(trip: Any, *, plain: bool) -> dict[str, tuple[int, str]]:
    """Messages and digest of the event list of each sender and threshold over one trip."""
    import modelcast  # noqa: PLC0415 - of the checkout under test

    settings: Any = modelcast.EvaluationSettings()
    case = found("make_case")(trip, settings)
    bank_of, count_rates = found("TripRuntime", "TripBank"), found("count_rates")
    if hasattr(settings, "sent_bank"):  # rounding was once a wrapper of the bank
        banks = (
            (settings.bank, found("BASELINE_BANK")) if plain else (settings.sent_bank, settings.baseline_bank)
        )
        pair = [bank_of(case.seen, bank, case.estimator) for bank in banks]
    else:
        banks = (settings.bank, found("BASELINE_BANK"))
        pair = [bank_of(case.seen, bank, case.estimator, quantised=not plain) for bank in banks]
    told: dict[str, tuple[int, str]] = {}
    for count, events in count_rates(case, *pair, settings):
        digest = hashlib.sha256(events.kind.tobytes() + events.in_use.tobytes()).hexdigest()[:16]
        told[f"{count.policy} {count.threshold_m}"] = (count.updates + count.identifications, digest)
    return told


def write(target: Path, *, plain: bool) -> None:
    """Write the counts of all trips."""
    import modelcast  # noqa: PLC0415 - of the checkout under test

    every: dict[str, dict[str, tuple[int, str]]] = {}
    for path in folders(Path(os.environ["MODELCAST_DATA"])):
        for trip in modelcast.read_trips(path):
            every[f"{path.stem}: {trip.trip_id}"] = counted(trip, plain=plain)
    target.write_text(json.dumps(every), encoding="utf-8")
    print(f"{len(every)} trips written to {target}")


def compare(before: dict[str, Any], after: dict[str, Any], *, trips: bool) -> None:
    """Print what differs."""
    rows: dict[str, list[tuple[str, str, int, int, bool]]] = defaultdict(list)
    for name, lists in before.items():
        for key, (count, digest) in lists.items():
            own, other = after[name][key]
            rows[name.split(":")[0]].append((name, key, count, own, digest == other))
    print(
        f"{'source':28s} trips  lists  the same  more  fewer  messages before  after   change  most  "
        f"share of {FEW}+"
    )
    for source, each in rows.items():
        old, new = sum(row[2] for row in each), sum(row[3] for row in each)
        most = max(abs(row[3] - row[2]) for row in each)
        share = max((abs(row[3] / row[2] - 1.0) for row in each if row[2] >= FEW), default=0.0)
        more, fewer = sum(row[3] > row[2] for row in each), sum(row[3] < row[2] for row in each)
        same = sum(row[4] for row in each)
        print(
            f"{source:28s} {len({row[0] for row in each}):5d} {len(each):6d} {same:9d} {more:5d} {fewer:6d} "
            f"{old:16d} {new:6d} {new / old - 1.0:+8.2%} {most:5d} {share:9.1%}"
        )
    for source in rows if trips else ():
        for name, key, count, own, _ in rows[source]:
            print(f"{name}, {key}: {count} {own}")


def main() -> None:
    """Write or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    writes = commands.add_parser("write")
    writes.add_argument("file", type=Path)
    writes.add_argument("--plain", action="store_true", help="nothing rounded")
    compares = commands.add_parser("compare")
    compares.add_argument("before", type=Path)
    compares.add_argument("after", type=Path)
    compares.add_argument("--trips", action="store_true", help="a line a trip, sender and threshold too")
    given = parser.parse_args()
    if given.command == "write":
        write(given.file, plain=given.plain)
    else:
        both = (json.loads(path.read_text(encoding="utf-8")) for path in (given.before, given.after))
        compare(*both, trips=given.trips)


if __name__ == "__main__":
    main()
