"""The tables of docs/safety.md, from what ``modelcast safety`` wrote.

``safety.py FOLDER [--write | --check]``: a folder that holds the output of four calls, ``FILES`` being the
folder ``openacc_zalazone`` and the file ``roads/tampa_dev.parquet`` of what ``MODELCAST_DATA`` names:

    modelcast safety FILES --threshold 0.2 --out FOLDER/recorded
    modelcast safety FILES --threshold 0.2 --basis airtime --truth communication --sensors default --burst 0
        --per 0 0.4 --out FOLDER/communication
    modelcast safety FILES --threshold 0.01 --basis threshold --sensors default --burst 0 --per 0 --bank cv
        --out FOLDER/floor
    modelcast safety --streams 4 --sensors default --burst 0 --per 0 0.4 0.6 --threshold 0.2
        --out FOLDER/streams

``--write`` puts the tables into the page, ``--check`` tells by its exit code whether the page has them.
"""

import argparse
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "safety.md"
RATIOS = (0.0, 0.4)
CALLS = ("streams", "recorded", "communication", "floor")
HEADS = (
    "sensor", "losses", "loss", "sender", "messages/s", "missed", "over cv", "false", "over cv", "never",
    "late p50 / p90 [s]",
)  # fmt: skip


def _ratio(row: Mapping[str, Any], name: str) -> str:
    value, low, high = (row[f"{name}_over{end}"] for end in ("", "_low", "_high"))
    if value is None:
        return "-"
    return f"{value:.2f}" if low is None else f"{value:.2f} ({low:.2f}-{high:.2f})"


def _late(value: float | None) -> str:
    return "never" if value is None else f"{value:.1f}"


def _cells(row: Mapping[str, Any]) -> list[str]:
    burst = row["mean_burst_s"]
    return [
        row["sensor"],
        "one by one" if burst is None else f"bursts of {burst:g} s",
        f"{100 * row['packet_error_ratio']:.0f} %",
        row["candidate"],
        f"{row['message_rate_hz']:.2f}",
        f"{100 * row['missed_ratio']:.1f} %",
        _ratio(row, "missed"),
        f"{100 * row['false_ratio']:.2f} %",
        _ratio(row, "false"),
        f"{100 * row['missed_events']:.0f} %",
        f"{_late(row['delay_p50_s'])} / {_late(row['delay_p90_s'])}",
    ]


def table(summary: Mapping[str, Any], ratios: Iterable[float]) -> list[str]:
    """Rows at equal airtime, or whatever the last basis of the call is."""
    wanted = set(ratios)
    lines = [
        (
            f"{summary['events']} true warnings in {summary['pairs']} pairs; {summary['positives']} of "
            f"{summary['counted']} instants near the decision."
        ),
        "",
        f"| {' | '.join(HEADS)} |",
        "|" + "---|" * len(HEADS),
    ]
    lines += [
        f"| {' | '.join(_cells(row))} |"
        for row in summary["pooled"]
        if row["basis"] == summary["settings"]["basis"][-1] and row["packet_error_ratio"] in wanted
    ]
    return lines


def main() -> int:
    """Print the tables, and write or check them where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    found = {
        name: json.loads((given.folder / name / "summary.json").read_text(encoding="utf-8")) for name in CALLS
    }
    blocks = {name: table(summary, RATIOS) for name, summary in found.items()}
    for name, lines in blocks.items():
        print(f"{name}\n", *lines, sep="\n")
    if given.write or given.check:
        return put({PAGE: blocks}, check=given.check)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
