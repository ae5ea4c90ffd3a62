"""Windows of real trips for the benchmarks."""

import csv
import os
import re
from pathlib import Path

import numpy as np
import numpy.typing as npt

__all__ = ["data_folder", "real_windows"]

METADATA_LINES = 5


def data_folder() -> Path:
    """Return the folder that ``MODELCAST_DATA`` names."""
    return Path(os.environ["MODELCAST_DATA"])


def real_windows(count: int, seed: int, *, samples: int = 10) -> npt.NDArray[np.float64]:
    """Return windows of the OpenACC trips, drawn at random with equal odds, (count, n, 2) [m].

    Parameters
    ----------
    count
        How many windows.
    seed
        Seed of the draw.
    samples
        Samples in a window, at 10 Hz.
    """
    # Stands in for modelcast.io.read_trips, which knows these files properly.
    parts: list[npt.NDArray[np.float64]] = []
    for path in sorted((data_folder() / "openacc_zalazone").glob("*.csv")):
        with path.open(newline="") as lines:
            rows = list(csv.reader(lines))[METADATA_LINES:]
        header, body = rows[0], rows[1:]
        for vehicle in (name[1:] for name in header if re.fullmatch(r"E\d+", name)):
            columns = [header.index(f"{axis}{vehicle}") for axis in "EN"]
            track = np.array([[float(row[c]) if row[c].strip() else np.nan for c in columns] for row in body])
            views = np.lib.stride_tricks.sliding_window_view(track, samples, axis=0).transpose(0, 2, 1)
            parts.append(views[np.isfinite(views).all(axis=(1, 2))])
    every = np.concatenate(parts)
    chosen = np.random.default_rng(seed).choice(len(every), size=count, replace=False)
    return np.ascontiguousarray(every[chosen])
