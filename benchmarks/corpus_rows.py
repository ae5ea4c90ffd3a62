"""Make many DataWsu rows: the head of the published file, and motion of our own.

``python benchmarks/corpus_rows.py 8000000 --out FOLDER``: files of a million rows, vehicles with several
trips each, sorted by vehicle, trip and time as the published file is. What is not motion (HDOP, fix quality,
gear, lights) comes from the rows of the real head, and so do the numbers of digits; it is read from
``spmd/formats/two_month/DataWsu.csv`` in the folder that ``MODELCAST_DATA`` names. Motion: smoothed random
acceleration and yaw rate, a speed of 0 to 40 m/s. In one trip of ten the unit logs a fix twice and then jumps
200 ms, once in 500 rows. One seed gives the same octets.
"""

import argparse
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import polars as pl

__all__ = ["main", "write_rows"]

STEP_MS = 100
FILE_ROWS = 1_000_000
VEHICLES = 60
TYPICAL_TRIP_ROWS, SPREAD = 7000, 0.7
FIRST_DEVICE = 10_100
M_PER_DEG = 111_320.0
REPEATS_EVERY = 500


def head_rows() -> pl.DataFrame:
    """Return the head of the published file."""
    folder = os.environ.get("MODELCAST_DATA")
    if not folder:
        raise SystemExit("MODELCAST_DATA must name the folder with spmd/formats/two_month/DataWsu.csv")
    return pl.read_csv(Path(folder) / "spmd/formats/two_month/DataWsu.csv")


def trip_rows(
    head: pl.DataFrame, device: int, trip: int, rows: int, rng: np.random.Generator
) -> pl.DataFrame:
    """Return the rows of a trip."""
    step_s = STEP_MS / 1000.0
    at = np.arange(rows)
    acceleration = _smooth(rng.normal(0.0, 1.2, rows), 30)
    speed = np.clip(14.0 + np.cumsum(acceleration) * step_s, 0.0, 40.0)
    yaw_rate = _smooth(rng.normal(0.0, 0.15, rows), 40) * np.minimum(speed / 5.0, 1.0)
    heading = rng.uniform(0.0, 2.0 * np.pi) + np.cumsum(yaw_rate) * step_s
    first = head.row(0, named=True)
    north = np.cumsum(speed * np.cos(heading)) * step_s
    east = np.cumsum(speed * np.sin(heading)) * step_s
    latitude = first["LatitudeWsu"] + north / M_PER_DEG
    longitude = first["LongitudeWsu"] + east / (M_PER_DEG * np.cos(np.radians(first["LatitudeWsu"])))
    start_ms = first["GpsTimeWsu"] + int(rng.integers(0, 5_000_000)) * 1000
    fix = at.copy()
    if rng.random() < 0.1:
        fix[REPEATS_EVERY::REPEATS_EVERY] -= 1
    motion = {
        "Device": np.full(rows, device),
        "Trip": np.full(rows, trip),
        "Time": at * STEP_MS // 10,
        "GpsTimeWsu": start_ms + fix * STEP_MS,
        "LatitudeWsu": latitude[fix].round(6),
        "LongitudeWsu": longitude[fix].round(6),
        "AltitudeWsu": (first["AltitudeWsu"] + _smooth(rng.normal(0.0, 2.0, rows), 50)).round(2),
        "GpsHeadingWsu": np.degrees(heading % (2.0 * np.pi))[fix].round(5),
        "GpsSpeedWsu": speed[fix].round(5),
        "YawRateWsu": np.degrees(yaw_rate).round(8),
        "SpeedWsu": (3.6 * speed).round(4),
        "AxWsu": acceleration.round(8),
    }
    still = head.select(pl.exclude(motion))[at % head.height]
    return still.with_columns(**{name: pl.Series(values) for name, values in motion.items()}).select(
        head.columns
    )


def trips(rows: int, seed: int) -> Iterator[tuple[int, int, int, np.random.Generator]]:
    """Yield every trip's device, number, rows and random numbers."""
    lengths: list[int] = []
    rng = np.random.default_rng([seed, 0])
    while sum(lengths) < rows:
        lengths.append(
            int(np.clip(rng.lognormal(np.log(TYPICAL_TRIP_ROWS), SPREAD), 50, rows - sum(lengths) or 50))
        )
    for number, length in enumerate(lengths):
        device = FIRST_DEVICE + number * VEHICLES // len(lengths)
        yield device, number, length, np.random.default_rng([seed, 1, number])


def write_rows(rows: int, out: Path, *, seed: int = 0, file_rows: int = FILE_ROWS) -> list[Path]:
    """Write the rows and return the files."""
    head = head_rows()
    out.mkdir(parents=True, exist_ok=True)
    files: list[Path] = []
    left = 0
    for device, trip, length, rng in trips(rows, seed):
        if left <= 0:
            files.append(out / f"DataWsu_{len(files):04d}.csv")
            files[-1].write_bytes(b"")
            left = file_rows
        left -= length
        header = files[-1].stat().st_size == 0
        with files[-1].open("ab") as file:
            trip_rows(head, device, trip, length, rng).write_csv(file, include_header=header)
    return files


def _smooth(values: np.ndarray, window: int) -> np.ndarray:
    return np.convolve(values, np.ones(window) / np.sqrt(window), mode="same") / np.sqrt(window) * 3.0


def main() -> None:
    """Write them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("rows", type=int)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--file-rows", type=int, default=FILE_ROWS)
    asked = parser.parse_args()
    files = write_rows(asked.rows, asked.out, seed=asked.seed, file_rows=asked.file_rows)
    print(
        f"{asked.rows:,} rows in {len(files)} files, {sum(one.stat().st_size for one in files) / 1e6:,.0f} MB"
    )


if __name__ == "__main__":
    main()
