"""Errors of frames by their size, and where they are certain: what the loops of modes 4 and 2 look up."""

from typing import NamedTuple

import numpy as np

from modelcast.channel.error_models import (
    HAZARD_MIN_DB,
    HAZARD_PER_DB,
    SINR_DB,
    AbstractErrorModel,
    safe_ratio,
)
from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.kernel_types import FloatCube, FloatVector

__all__ = ["CELLS", "GROUP", "FrameErrors", "frame_errors"]

HOPELESS = 40.0
"""Units of hazard beyond any luck: chance has 53 bits."""

CELLS, GROUP = 32, 16
"""Cells of chance, and bytes of messages, that `FrameErrors.certain` has one row for."""


class FrameErrors(NamedTuple):
    """The error model, and what it says of messages of 0, 1, 2, ... bytes.

    ``hazard`` (HAZARD_SIZE,) is that of the SINR over ``needed_ratio``; ``units`` of hazard a message has.
    Such a ratio below ``hopeless_ratio`` is lost, one from ``safe_ratio`` on received, whatever the luck.
    With a chance in a cell, one from ``certain`` (groups, CELLS, 2) on is received, and one below its second
    is lost.
    """

    hazard: FloatVector
    units: FloatVector
    needed_ratio: FloatVector
    hopeless_ratio: FloatVector
    safe_ratio: float
    certain: FloatCube


def _certain(hazard: FloatArray, units: FloatArray) -> FloatArray:
    """Ratios that decide without a look at the luck itself, as `FrameErrors.certain` has them."""
    with np.errstate(divide="ignore"):
        luck = -np.log1p(-np.arange(CELLS + 1) / CELLS)
    starts = np.arange(0, units.size, GROUP)
    most, least = np.maximum.reduceat(units, starts), np.minimum.reduceat(units, starts)
    above = np.maximum.accumulate(hazard[::-1])[::-1]
    # One entry further than need be: what is between two is rounded.
    safe = np.searchsorted(-above, -luck[:-1] / most[:, None]) + 1
    lost = np.searchsorted(-np.minimum.accumulate(hazard), -luck[1:] / least[:, None]) - 2
    ratio = 10.0 ** (0.1 * SINR_DB)
    received = np.where(safe < ratio.size, ratio[np.minimum(safe, ratio.size - 1)], np.inf)
    return np.stack([received, np.where(lost >= 0, ratio[np.maximum(lost, 0)], 0.0)], axis=2)


def frame_errors(
    error_model: AbstractErrorModel, size_bytes: IntArray, needed_db: FloatArray | None = None
) -> FrameErrors:
    """Errors of messages by size.

    Parameters
    ----------
    error_model
        Packet error against SINR.
    size_bytes
        Sizes, at least 1; an index of the result is a size, (B,).
    needed_db
        What the SINR is set against before the model is asked, (B,) [dB]; None for 0.
    """
    hazard = np.ascontiguousarray(error_model.hazards(), dtype=np.float64)
    units = np.asarray(error_model.units(size_bytes.astype(np.float64)), dtype=np.float64)
    # Entries from the low end on that no luck survives.
    lost = np.searchsorted(-np.minimum.accumulate(hazard), -HOPELESS / units, side="right")
    hopeless_db = np.where(lost > 0, HAZARD_MIN_DB + (lost - 1) / HAZARD_PER_DB, -np.inf)
    needed_ratio = np.ones(size_bytes.size) if needed_db is None else 10.0 ** (0.1 * needed_db)
    return FrameErrors(
        hazard,
        units,
        needed_ratio,
        10.0 ** (0.1 * hopeless_db),
        safe_ratio(hazard),
        _certain(hazard, units),
    )
