"""Errors of frames by their size, and where they are certain: what the loops of modes 4 and 2 look up."""

from typing import NamedTuple

import numpy as np

from modelcast.channel.error_models import HAZARD_MIN_DB, HAZARD_PER_DB, AbstractErrorModel, safe_ratio
from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.kernel_types import FloatVector

__all__ = ["FrameErrors", "frame_errors"]

HOPELESS = 40.0
"""Units of hazard beyond any luck: chance has 53 bits."""


class FrameErrors(NamedTuple):
    """The error model, and what it says of messages of 0, 1, 2, ... bytes.

    ``hazard`` (HAZARD_SIZE,) is that of the SINR over ``needed_ratio``; ``units`` of hazard a message has.
    Such a ratio below ``hopeless_ratio`` is lost, one from ``safe_ratio`` on received, whatever the luck.
    """

    hazard: FloatVector
    units: FloatVector
    needed_ratio: FloatVector
    hopeless_ratio: FloatVector
    safe_ratio: float


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
    return FrameErrors(hazard, units, needed_ratio, 10.0 ** (0.1 * hopeless_db), safe_ratio(hazard))
