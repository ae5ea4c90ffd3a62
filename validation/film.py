"""The table of docs/roadside.md on a meeting at an occluded crossing, from the film that ``network`` wrote.

``film.py FOLDER [--write | --check]``: a folder that holds the output of

    modelcast network --scenario crossing --density 25 --blocks 3 --pedestrians 20 --cyclists 40 --policy mbc
        --duration 40 --warm-up 2 --seeds 1 --certificates always --roadside crossings --relay --film
        --out FOLDER

``--write`` puts the table into the page, ``--check`` tells by its exit code whether the page has it.
"""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq

from modelcast.report.figures.meeting import FRAMES_S
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "roadside.md"


def _told(row: Mapping[str, Any]) -> str:
    if row["error_m"] is None:
        return "not known"
    return f"{row['error_m']:.2f} m off, {row['age_s']:.1f} s old"


def film_table(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """A row an instant of the pictures, a column a run."""
    runs = list(dict.fromkeys(row["run"] for row in rows))
    lines = [
        "| before they are nearest | apart | " + " | ".join(runs) + " |",
        "|---|---|" + "---|" * len(runs),
    ]
    for wanted_s in FRAMES_S:
        own = [
            min((row for row in rows if row["run"] == run), key=lambda row: abs(row["t_s"] - wanted_s))
            for run in runs
        ]
        sight = "in sight" if own[0]["in_sight"] else "hidden"
        told = " | ".join(map(_told, own))
        lines.append(f"| {abs(own[0]['t_s']):.0f} s, {sight} | {own[0]['distance_m']:.0f} m | {told} |")
    return lines


def main() -> int:
    """Print the table, and write or check it where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    lines = film_table(pq.read_table(given.folder / "film.parquet").to_pylist())
    print(*lines, sep="\n")
    if given.write or given.check:
        return put({PAGE: {"crossing-film": lines}}, check=given.check)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
