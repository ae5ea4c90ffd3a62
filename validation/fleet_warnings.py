"""The tables of docs/safety.md with the radio in the loop, from what ``network`` and ``mixed`` wrote.

``fleet_warnings.py FOLDER [--write | --check]``: a folder that holds the output of four calls:

    modelcast network --scenario braking --application fcw eebl --density 60 --radio dsrc ideal POLICIES ROAD
        --out FOLDER/streams
    modelcast network --scenario crossing --application ima fcw --density 60 --blocks 4 POLICIES ROAD
        --out FOLDER/crossing
    modelcast mixed --scenario braking --application fcw --density 60 SPARSE --out FOLDER/mixed
    modelcast mixed --scenario braking --application fcw --density 60 SPARSE --legacy-threshold 0.5
        --out FOLDER/minded

with POLICIES ``--policy bsm-10hz baseline free mbc j2945 j2945-free j2945-mbc --against baseline``, ROAD
``--threshold 0.2 0.5 --length 1500 --duration 60 --warm-up 5 --seeds 3 --certificates always``, and SPARSE
``--policy baseline mbc --penetration 0 50 100 --threshold 0.5 --approach 0 --keep-alive 2 --length 1500
--duration 60 --warm-up 5 --seeds 3``.

``--write`` puts the tables into the page, ``--check`` tells by its exit code whether the page has them.
"""

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "safety.md"
FLEETS = ("streams", "crossing")
MIXED = ("mixed", "minded")
HEADS = (
    "application", "radio", "sender", "threshold", "messages/s", "busy", "missed", "over", "false", "over",
    "never", "late p50 / p90 [s]",
)  # fmt: skip
MIXED_HEADS = ("mbc senders", "legacy threshold", "messages/s", "legacy: missed", "false", "free", "false",
               "model", "false")  # fmt: skip
READINGS = ("legacy", "free", "model")


def _share(row: Mapping[str, Any], name: str, digits: int) -> str:
    value, low, high = (row[f"{name}_{part}"] for part in ("ratio", "low", "high"))
    if value is None:
        return "-"
    shown = f"{100 * value:.{digits}f} %"
    return shown if low is None else f"{shown} ({100 * low:.{digits}f}-{100 * high:.{digits}f})"


def _over(row: Mapping[str, Any], name: str) -> str:
    value, low, high = (row[f"{name}_over{part}"] for part in ("", "_low", "_high"))
    if value is None:
        return "-"
    return f"{value:.2f}" if low is None else f"{value:.2f} ({low:.2f}-{high:.2f})"


def _late(value: float | None) -> str:
    return "never" if value is None else f"{value:.1f}"


def _events(rows: Sequence[Mapping[str, Any]]) -> str:
    counts = {row["application"]: row["events"] for row in rows}
    return ", ".join(f"{name}: {count} true warnings" for name, count in sorted(counts.items())) + "."


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    lines = [f"| {' | '.join(cells)} |" for cells in (heads, *rows)]
    return [lines[0], "|" + "---|" * len(heads), *lines[1:]]


def fleet_table(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """A row an application, radio, sender and threshold."""
    cells = [
        (
            row["application"],
            row["radio"],
            row["policy"],
            "-" if row["threshold_m"] is None else f"{row['threshold_m']:g} m",
            f"{row['message_rate_hz']:.2f}",
            f"{100 * row['busy_ratio']:.0f} %",
            _share(row, "missed", 1),
            _over(row, "missed"),
            _share(row, "false", 2),
            _over(row, "false"),
            f"{100 * row['never_ratio']:.0f} %",
            f"{_late(row['delay_p50_s'])} / {_late(row['delay_p90_s'])}",
        )
        for row in sorted(rows, key=lambda row: (row["application"], row["radio"]))
    ]
    return [_events(rows), "", *_table(HEADS, cells)]


def mixed_table(found: Mapping[str, Sequence[Mapping[str, Any]]]) -> list[str]:
    """A row a share of new senders: what hosts of each reading miss and warn of wrongly."""
    whole = {name: [row for row in rows if row["sender"] == "all"] for name, rows in found.items()}
    cells: list[list[str]] = []
    for name, minds in zip(MIXED, ("none", "0.5 m"), strict=True):
        by_key = {(float(row["policy"].partition("@")[2]), row["reading"]): row for row in whole[name]}
        for share in sorted({share for share, _ in by_key}):
            own = [by_key[share, reading] for reading in READINGS]
            line = [f"{share:g} %", minds, f"{own[0]['message_rate_hz']:.2f}"]
            for row in own:
                line += [_share(row, "missed", 1), _share(row, "false", 2)]
            cells.append(line)
    return [_events(whole["mixed"]), "", *_table(MIXED_HEADS, cells)]


def main() -> int:
    """Print the tables, and write or check them where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    found: dict[str, list[dict[str, Any]]] = {
        name: json.loads((given.folder / name / "summary.json").read_text(encoding="utf-8"))["warnings"]
        for name in (*FLEETS, *MIXED)
    }
    blocks = {f"fleet-{name}": fleet_table(found[name]) for name in FLEETS}
    blocks["fleet-mixed"] = mixed_table(found)
    for name, lines in blocks.items():
        print(f"{name}\n", *lines, sep="\n")
    if given.write or given.check:
        return put({PAGE: blocks}, check=given.check)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
