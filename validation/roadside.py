"""The tables of docs/roadside.md, from what ``network`` wrote.

``roadside.py FOLDER [--write | --check]``: a folder that holds the output of three calls:

    modelcast network CROSSING --out FOLDER/none
    modelcast network CROSSING --roadside crossings --out FOLDER/hears
    modelcast network CROSSING --roadside crossings --relay --out FOLDER/relay

with CROSSING ``--scenario crossing --application ima --density 60 --blocks 3 --policy bsm-10hz baseline mbc
--threshold 0.5 --duration 45 --warm-up 5 --seeds 3 --certificates always --against bsm-10hz``.

``--write`` puts the tables into the page, ``--check`` tells by its exit code whether the page has them.
"""

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq

from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "roadside.md"
ARMS = {"none": "none", "hears": "hears", "relay": "relays"}
WARNED_HEADS = (
    "sender", "units", "messages/s a vehicle", "repeated/s a unit", "busy", "true warnings", "missed",
    "false", "false/h", "never", "late p50 / p90 [s]", "tracked 50-150 m",
)  # fmt: skip
UNIT_HEADS = (
    "sender",
    "distance [m]",
    "received",
    "tracked",
    "age p50 / p90 [s]",
    "error p50 / p90 / p99 [m]",
)
RELAY_HEADS = (
    "sender", "repeated/s", "bytes/s", "of these unsent", "newer came/s", "by another/s", "too old/s",
    "too far/s",
)  # fmt: skip


def _share(row: Mapping[str, Any], name: str, digits: int) -> str:
    value, low, high = (row[f"{name}_{part}"] for part in ("ratio", "low", "high"))
    if value is None:
        return "-"
    shown = f"{100 * value:.{digits}f} %"
    return shown if low is None else f"{shown} ({100 * low:.{digits}f}-{100 * high:.{digits}f})"


def _late(value: float | None) -> str:
    return "never" if value is None else f"{value:.1f}"


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    lines = [f"| {' | '.join(cells)} |" for cells in (heads, *rows)]
    return [lines[0], "|" + "---|" * len(heads), *lines[1:]]


def _mean(rows: Sequence[Mapping[str, Any]], name: str) -> float:
    values = np.array([np.nan if row[name] is None else row[name] for row in rows], dtype=np.float64)
    return float(np.nanmean(values)) if np.isfinite(values).any() else np.nan


def warned_table(found: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """A row a sender and what units do."""
    cells: list[Sequence[str]] = []
    for policy in dict.fromkeys(row["policy"] for row in found["none"]["runs"]):
        for arm, told in ARMS.items():
            runs = [row for row in found[arm]["runs"] if row["policy"] == policy]
            units = [row for row in found[arm]["roadside"] if row["policy"] == policy]
            row = next(row for row in found[arm]["warnings"] if row["policy"] == policy)
            cells.append(
                (
                    policy,
                    told,
                    f"{_mean(runs, 'message_rate_hz'):.2f}",
                    f"{_mean(units, 'repeated_rate_hz'):.0f}" if units else "-",
                    f"{100 * _mean(runs, 'busy_ratio'):.1f} %",
                    str(row["events"]),
                    _share(row, "missed", 1),
                    _share(row, "false", 2),
                    f"{row['false_per_hour']:.1f}" if row.get("false_per_hour") is not None else "-",
                    f"{100 * row['never_ratio']:.0f} %",
                    f"{_late(row['delay_p50_s'])} / {_late(row['delay_p90_s'])}",
                    f"{100 * _mean(runs, 'held_ratio'):.1f} %",
                )
            )
    return _table(WARNED_HEADS, cells)


def unit_table(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """A row a sender and distance of 50 m: what units hear and hold; means over seeds."""
    cells: list[Sequence[str]] = []
    for policy in dict.fromkeys(row["policy"] for row in rows):
        for low_m in range(0, 300, 50):
            own = [row for row in rows if row["policy"] == policy and low_m <= row["low_m"] < low_m + 50]
            cells.append(
                (
                    policy,
                    f"{low_m}-{low_m + 50}",
                    f"{100 * _mean(own, 'delivery_ratio'):.0f} %",
                    f"{100 * _mean(own, 'held_ratio'):.0f} %",
                    " / ".join(f"{_mean(own, f'age_{p}_s'):.2f}" for p in ("p50", "p90")),
                    " / ".join(f"{_mean(own, f'pte_{p}_m'):.2f}" for p in ("p50", "p90", "p99")),
                )
            )
    return _table(UNIT_HEADS, cells)


def relay_table(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """A row a sender: what a unit repeats, and what it does not."""
    cells: list[Sequence[str]] = []
    for policy in dict.fromkeys(row["policy"] for row in rows):
        own = [row for row in rows if row["policy"] == policy]
        cells.append(
            (
                policy,
                f"{_mean(own, 'repeated_rate_hz'):.1f}",
                f"{_mean(own, 'repeated_bytes_per_s'):.0f}",
                f"{100 * _mean(own, 'unsent_ratio'):.1f} %",
                *(
                    f"{_mean(own, f'{why}_rate_hz'):.1f}"
                    for why in ("replaced", "by_another", "too_old", "too_far")
                ),
            )
        )
    return _table(RELAY_HEADS, cells)


def main() -> int:
    """Print the tables, and write or check them where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    found: dict[str, dict[str, Any]] = {
        arm: json.loads((given.folder / arm / "summary.json").read_text(encoding="utf-8")) for arm in ARMS
    }
    distances = pq.read_table(given.folder / "hears" / "roadside_distances.parquet").to_pylist()
    blocks = {
        "roadside-warned": warned_table(found),
        "roadside-units": unit_table(distances),
        "roadside-relayed": relay_table(found["relay"]["roadside"]),
    }
    for name, lines in blocks.items():
        print(f"{name}\n", *lines, sep="\n")
    if given.write or given.check:
        return put({PAGE: blocks}, check=given.check)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
