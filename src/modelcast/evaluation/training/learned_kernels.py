"""Compiled cutting of training rows: inputs of many windows of one trip."""

from typing import Any

import numba

from modelcast.models.learned.learned_kernels import window_features

__all__ = ["trip_features"]


@numba.njit(cache=True, nogil=True)
def trip_features(samples: Any, rows: Any, window: int, constants: Any, out: Any) -> None:
    """Inputs (B, I) of the windows that end at these rows of a trip's samples (T, 7)."""
    for at in range(rows.size):
        i = rows[at]
        window_features(samples[i - window + 1 : i + 1], constants, out[at])
