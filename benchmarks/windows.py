"""Windows of real trips for the benchmarks."""

import os
from pathlib import Path

import numpy as np
import numpy.typing as npt

from modelcast.io.trips import read_trips

__all__ = ["real_windows"]


def real_windows(count: int, seed: int, *, samples: int = 10) -> npt.NDArray[np.float64]:
    """Return gapless windows of the OpenACC trips, drawn at random with equal odds, (count, n, 2) [m].

    Parameters
    ----------
    count
        How many windows.
    seed
        Seed of the draw.
    samples
        Samples in a window, at 10 Hz.
    """
    parts: list[npt.NDArray[np.float64]] = []
    for trip in read_trips(Path(os.environ["MODELCAST_DATA"]) / "openacc_zalazone"):
        for first, end in zip(trip.segments[:-1], trip.segments[1:], strict=True):
            if end - first >= samples:
                part = trip.position_m[first:end]
                parts.append(
                    np.lib.stride_tricks.sliding_window_view(part, samples, axis=0).transpose(0, 2, 1)
                )
    every = np.concatenate(parts)
    chosen = np.random.default_rng(seed).choice(len(every), size=count, replace=False)
    return np.ascontiguousarray(every[chosen])
