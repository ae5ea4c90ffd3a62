"""What the guard costs and saves: messages of guarded and unguarded banks beside those of their guards.

``guard.py write FILE`` counts, over every trip of the data folder, recorded and as default sensors see it, at
four thresholds, the messages of constant velocity alone (``cv``), of the bank's plain sub-model alone
(``free``), and of two banks, the shipped one and ``ctra+cv``, with and without their guard.
``PYTHONPATH=OTHER/src`` counts by an older checkout. ``guard.py table FILE ...`` prints a line a source and
file: messages over those of the bank without a guard, of cv and of free, and at how many trips and
thresholds the bank sends more than max(1.02 cv, cv + 3) and than max(1.05 free, free + 5), with the most
messages beyond; first of all the bank without a guard, by the first file. ``--worst N`` adds the worst
trips of each file.
"""

import argparse
import json
import os
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trip_sources import folders

THRESHOLDS_M = (0.2, 0.3, 0.4, 0.5)
BANKS = ("default", "ctra+cv")
_SLACK = 1e-9


@dataclass(frozen=True)
class Count:
    """Messages over one trip at one threshold."""

    source: str
    trip: str
    bank: str
    threshold_m: float
    cv: int
    free: int
    unguarded: int
    guarded: int

    def beyond(self, sent: int) -> tuple[float, float]:
        """Return by how much a count exceeds what is allowed over cv and over free."""
        return sent - max(1.02 * self.cv, self.cv + 3), sent - max(1.05 * self.free, self.free + 5)


def counts(trip: Any, source: str, protocol: Any) -> Iterable[Count]:
    """Count the messages of all senders over one trip."""
    from modelcast.models.bank import Bank  # noqa: PLC0415 - of the checkout under test
    from modelcast.models.profile import default_profile  # noqa: PLC0415
    from modelcast.runtime.trip.runtime import TripRuntime, sense_trip  # noqa: PLC0415
    from modelcast.station.policy.error_driven import ErrorDriven  # noqa: PLC0415
    from modelcast.study.case import make_case  # noqa: PLC0415
    from modelcast.study.settings import EvaluationSettings  # noqa: PLC0415

    case = make_case(trip, EvaluationSettings(protocol=protocol))
    sensed = sense_trip(case.seen, case.estimator, quantised=True)
    shipped = default_profile().bank
    ctra, cv = (shipped.members[shipped.place_of(name)] for name in ("ctra", "cv"))

    def sent(bank: Bank, start: Any) -> list[int]:
        ready = TripRuntime(case.seen, bank, case.estimator, quantised=True, sensed=sensed)
        policies = [ErrorDriven(threshold_m, start, "never") for threshold_m in THRESHOLDS_M]
        return [int(messages.transmits.sum()) for messages in ready.run_each(policies)]

    alone, free = sent(Bank((cv,)), "order"), sent(Bank((ctra,)), "order")
    for name, bank in zip(BANKS, (shipped, Bank((ctra, cv))), strict=True):
        both = zip(THRESHOLDS_M, alone, free, sent(bank, "hindsight"), sent(bank, "guarded"), strict=True)
        for threshold_m, *own in both:
            yield Count(f"{source} {protocol}", trip.trip_id, name, threshold_m, *own)


def write(target: Path) -> None:
    """Write the counts of all trips."""
    import modelcast  # noqa: PLC0415 - of the checkout under test

    rows = [
        list(vars(count).values())
        for path in folders(Path(os.environ["MODELCAST_DATA"]))
        for trip in modelcast.read_trips(path)
        for protocol in ("recorded", "sensor")
        for count in counts(trip, path.stem, protocol)
    ]
    target.write_text(json.dumps(rows), encoding="utf-8")
    print(f"{len(rows)} counts written to {target}")


def _line(name: str, rows: list[Count], which: str) -> str:
    own = [int(getattr(row, which)) for row in rows]
    over = [row.beyond(sent) for row, sent in zip(rows, own, strict=True)]
    others = ("unguarded", "cv", "free")
    ratio = (sum(own) / max(sum(getattr(row, other) for row in rows), 1) for other in others)
    shares = " ".join(f"{one:6.3f}" for one in ratio)
    cells = (f"{sum(e[i] > _SLACK for e in over):4d} {max(e[i] for e in over):+6.1f}" for i in (0, 1))
    return f"{name:14s} {len(rows):5d}  {shares}  {'  '.join(cells)}"


def table(files: list[Path], worst: int) -> None:
    """Print what the files hold."""
    read = {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in files}
    held = {name: [Count(*row) for row in rows] for name, rows in read.items()}
    first = next(iter(held.values()))
    for bank in BANKS:
        sources: dict[str, None] = dict.fromkeys(row.source for row in first if row.bank == bank)
        for source in [*sources, "all"]:
            print(f"\n{bank}, {source}\n{'':14s} lists  /none   /cv   /free   over cv       over free")
            for name, rows in [("no guard", first), *held.items()]:
                own = [row for row in rows if row.bank == bank and source in (row.source, "all")]
                print(_line(name, own, "unguarded" if name == "no guard" else "guarded"))
    for name, rows in held.items() if worst else ():
        found: dict[str, list[Count]] = defaultdict(list)
        for row in rows:
            found[row.bank].append(row)
        for bank, own in found.items():
            print(f"\n{name}, {bank}: the worst")
            for row in sorted(own, key=lambda one: -max(one.beyond(one.guarded)))[:worst]:
                print(
                    f"{row.source}, {row.trip}, {row.threshold_m} m: {row.guarded}, "
                    f"unguarded {row.unguarded}, cv {row.cv}, free {row.free}"
                )


def main() -> None:
    """Write or print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("write").add_argument("file", type=Path)
    prints = commands.add_parser("table")
    prints.add_argument("files", type=Path, nargs="+")
    prints.add_argument("--worst", type=int, default=0)
    given = parser.parse_args()
    if given.command == "write":
        write(given.file)
    else:
        table(given.files, given.worst)


if __name__ == "__main__":
    main()
