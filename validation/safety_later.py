"""Missed warnings at equal false ones: a table of docs/safety.md, made from ``modelcast safety --later``.

``safety_later.py FOLDER [--write | --check]``: a folder that holds, for every METRES of `LATER`, what

    modelcast safety --streams 4 SHARED --later METRES --out FOLDER/sMETRES
    modelcast safety FILES SHARED --later METRES --out FOLDER/rMETRES

wrote, with SHARED ``--sensors default --burst 0 --per 0.4 --threshold 0.2 --basis airtime``, and FILES the
folder ``openacc_zalazone`` and the file ``roads/tampa_dev.parquet`` of what ``MODELCAST_DATA`` names. Hosts
that warn later miss more and warn wrongly less. What a sender misses where its hosts warn wrongly as often
as the baseline's do is read off its own curve, linear between two calls.

``--write`` puts the table into the page, ``--check`` tells by its exit code whether the page has it.
"""

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "safety.md"
LATER = ("0", "0.5", "1", "2", "4")
SOURCES = {"s": "hard braking", "r": "recorded"}
AGAINST = "cv"

Found = Mapping[tuple[str, str, str], Mapping[str, Any]]
"""Pooled rows by source, metres and sender."""


def read(folder: Path) -> Found:
    """All pooled rows."""
    found: dict[tuple[str, str, str], Mapping[str, Any]] = {}
    for source in SOURCES:
        for later in LATER:
            text = (folder / f"{source}{later}" / "summary.json").read_text(encoding="utf-8")
            for row in json.loads(text)["pooled"]:
                found[source, later, row["candidate"]] = row
    return found


def at_equal_false(found: Found, source: str, sender: str) -> float:
    """Share missed where hosts of a sender warn wrongly as often as the baseline's; NaN off its curve."""
    wanted = found[source, "0", AGAINST]["false_ratio"]
    own = sorted(
        (found[source, later, sender]["false_ratio"], found[source, later, sender]["missed_ratio"])
        for later in LATER
    )
    return float(np.interp(wanted, *zip(*own, strict=True), left=np.nan, right=np.nan))


def table(found: Found) -> list[str]:
    """Rows of every sender, and what each misses at the baseline's false warnings."""
    senders = list(dict.fromkeys(sender for _, _, sender in found))
    heads = [
        "source",
        "sender",
        *(f"{later} m" for later in LATER),
        "at the baseline's false ones",
        "over cv",
    ]
    lines = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for source, name in SOURCES.items():
        rival = found[source, "0", AGAINST]["missed_ratio"]
        for sender in senders:
            cells = [name, sender]
            for later in LATER:
                row = found[source, later, sender]
                cells.append(f"{100 * row['missed_ratio']:.1f} / {100 * row['false_ratio']:.2f} %")
            missed = at_equal_false(found, source, sender)
            cells += [f"{100 * missed:.1f} %", f"{missed / rival:.2f}"]
            lines.append(f"| {' | '.join(cells)} |")
    return lines


def main() -> int:
    """Print the table, and write or check it where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    lines = table(read(given.folder))
    print(*lines, sep="\n")
    if given.write or given.check:
        return put({PAGE: {"later": lines}}, check=given.check)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
