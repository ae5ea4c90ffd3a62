"""Measure how much memory reading, `modelcast convert` and `modelcast trips` take on files of any order.

``python benchmarks/reading_memory.py --rows 6000000 --tasks read convert``: makes one table of generated
drives, of 1,000 rows each, in several forms, does each task on each in a process of its own, and prints the
table of docs/formats.md: seconds, and the largest resident memory of the process, as the operating system
counts it. Results are kept in ``--folder`` file by file: a run that was stopped goes on.
"""

import argparse
import gzip
import json
import os
import shutil
import sys
import time
import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import polars as pl

from measured import record

TRIP_ROWS = 1000
COLUMNS = ("east_m", "north_m", "speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps")
FORMS = {
    "drives.csv": "csv, a drive behind the other",
    "mixed.csv": "csv, all drives at once",
    "drives.csv.gz": "the first, packed by gzip",
    "drives.zip": "the first in a zip archive",
    "drives.parquet": "Parquet, one row group, a drive behind the other",
    "mixed.parquet": "Parquet, one row group, all drives at once",
}
TASKS = {
    "read": ("-c", "import sys, modelcast\nfor trip in modelcast.read_trips(sys.argv[1]): pass", "{file}"),
    "convert": ("-m", "modelcast", "convert", "{file}", "--out", "{folder}/out.parquet", "--quiet"),
    "trips": ("-m", "modelcast", "trips", "{file}", "--json"),
}


def table(rows: int, seed: int = 1) -> pl.DataFrame:
    """Return generated drives, a drive behind the other."""
    rng = np.random.default_rng(seed)
    trips = rows // TRIP_ROWS
    turn = rng.normal(0.0, 0.02, (trips, TRIP_ROWS)).cumsum(axis=1) * 0.1
    speed = np.clip(15.0 + rng.normal(0.0, 0.3, (trips, TRIP_ROWS)).cumsum(axis=1) * 0.1, 0.0, 40.0)
    heading = rng.uniform(-np.pi, np.pi, (trips, 1)) + turn.cumsum(axis=1) * 0.1
    heading = (heading + np.pi) % (2.0 * np.pi) - np.pi
    columns = {
        "east_m": np.cumsum(speed * np.sin(heading), axis=1) * 0.1,
        "north_m": np.cumsum(speed * np.cos(heading), axis=1) * 0.1,
        "speed_mps": speed,
        "heading_rad": heading,
        "acceleration_mps2": np.gradient(speed, 0.1, axis=1),
        "yaw_rate_radps": turn,
    }
    return pl.DataFrame(
        {
            "vehicle": pl.Series([f"v{at}" for at in range(trips)]).gather(
                np.repeat(np.arange(trips), TRIP_ROWS)
            ),
            "t_s": np.tile(0.1 * np.arange(TRIP_ROWS), trips).round(1),
            **{name: values.ravel().round(4) for name, values in columns.items()},
        }
    )


def make(folder: Path, rows: int) -> None:
    """Write the table in all its forms, as far as they are not there."""
    made = folder / "made"
    if made.exists() and made.read_text() == str(rows):
        return
    whole = table(rows)
    mixed = whole.sort("t_s", maintain_order=True)
    for name, frame in (("drives", whole), ("mixed", mixed)):
        frame.write_csv(folder / f"{name}.csv")
        frame.write_parquet(folder / f"{name}.parquet", row_group_size=rows)
    with (folder / "drives.csv").open("rb") as read, gzip.open(folder / "drives.csv.gz", "wb", 6) as packed:
        shutil.copyfileobj(read, packed)
    with zipfile.ZipFile(folder / "drives.zip", "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.write(folder / "drives.csv", "drives.csv")
    made.write_text(str(rows))  # last: what was stopped before is made anew


def measured(arguments: Sequence[str], out: Path) -> dict[str, float]:
    """Run a command in a process of its own; return seconds and its largest resident memory [MiB]."""
    begun = time.perf_counter()
    with out.open("wb") as file:
        process = os.posix_spawn(
            sys.executable,
            [sys.executable, *arguments],
            os.environ,
            file_actions=[(os.POSIX_SPAWN_DUP2, file.fileno(), 1)],
        )
        _, status, usage = os.wait4(process, 0)
    if status:
        raise SystemExit(f"{' '.join(arguments)} ended with {os.waitstatus_to_exitcode(status)}")
    return {"s": time.perf_counter() - begun, "mib": usage.ru_maxrss / 1024.0}


def run(folder: Path, name: str, task: str) -> dict[str, float]:
    """Return what a task took on a file, measured now or before."""
    kept = folder / f"{name}.{task}.json"
    if not kept.exists():
        arguments = [word.format(file=folder / name, folder=folder) for word in TASKS[task]]
        kept.write_text(json.dumps(measured(arguments, folder / "said.json")))
    found: dict[str, float] = json.loads(kept.read_text())
    return found


def lines(folder: Path, rows: int, tasks: Sequence[str]) -> list[str]:
    """Return the table as Markdown."""
    heads = " | ".join(f"{one} | most memory" for one in tasks)
    made = [f"| file | MB | {heads} |", "|---" * (2 + 2 * len(tasks)) + "|"]
    for name, words in FORMS.items():
        size = (folder / name).stat().st_size / 1e6
        cells: list[str] = []
        for task in tasks:
            found = run(folder, name, task)
            record(f"{task}: {words}", found["mib"], "MiB", sizes={"rows": rows})
            record(f"{task}: {words}, time", found["s"], "s", sizes={"rows": rows})
            cells.append(f"{found['s']:.0f} s | {found['mib']:.0f} MiB")
        made.append(f"| {words} | {size:,.0f} | {' | '.join(cells)} |")
    machine = "2-core virtual machine, shared with other work, 2026-11-30"
    told = f"{rows:,} rows of {rows // TRIP_ROWS:,} drives ({machine}; `benchmarks/reading_memory.py`):"
    return [told, "", *made]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--rows", type=int, default=6_000_000)
    parser.add_argument("--folder", type=Path, default=Path("out/reading_memory"))
    parser.add_argument("--tasks", nargs="+", choices=TASKS, default=list(TASKS))
    asked = parser.parse_args()
    folder: Path = asked.folder
    folder.mkdir(parents=True, exist_ok=True)
    make(folder, asked.rows)
    print("\n".join(lines(folder, asked.rows, asked.tasks)))


if __name__ == "__main__":
    main()
