"""Whether yaw rates and accelerations of a table fit how the positions turn and speed up.

A yaw rate to the left that is called one to the right, in degrees that are called radians, or an acceleration
in g, is a number like any other. Positions tell where a vehicle turned, and how hard it braked.
"""

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.io.column_meanings import MEANINGS
from modelcast.io.rows import Rows

__all__ = ["fitting_meaning", "refuse_other_motion"]

_WORDS = {
    "yaw_rate_radps": {
        "yaw_rate_radps": "rad/s clockwise",
        "yaw_rate_degps": "deg/s clockwise",
        "yaw_rate_left_radps": "rad/s anticlockwise",
        "yaw_rate_left_degps": "deg/s anticlockwise",
    },
    "acceleration_mps2": {
        "acceleration": "m/s²",
        "acceleration_ftps2": "ft/s²",
        "acceleration_g": "g",
    },
}
"""Meanings of each quantity, and what they are in words."""

_SPAN_S = 1.0
"""Motion is told over a second: noise of positions counts less."""
_LEAST = {"yaw_rate_radps": 0.05, "acceleration_mps2": 0.5}
"""Motion that is enough to tell by [rad/s; m/s²]."""
_MOVING_M = 2.0
_FEWEST = 20
_ALIKE = 0.9
"""Cosine between a column and the motion, as vectors of samples, from which they are one quantity."""
_FITS = (0.7, 1.4)
"""The column over the motion, in the true unit; others are 3 times off, or turned round."""


def fitting_meaning(meaning: str, values: FloatArray, rows: Rows) -> str | None:
    """Return the meaning in which a column fits the motion, where it does not in the one stated.

    None where it fits as stated, or in none, or the vehicle hardly turned (or sped up).

    Parameters
    ----------
    meaning
        What is stated.
    values
        The column as the file has it, (R,); NaN where missing.
    rows
        One vehicle's rows with ``t_s``, ``east_m`` and ``north_m``.
    """
    quantity = MEANINGS[meaning].fills
    at, motion = _motion(rows, quantity)
    told = (np.abs(motion) > _LEAST[quantity]) & np.isfinite(values[at])
    own, motion = values[at][told], motion[told]
    if motion.size < _FEWEST or not own.any():
        return None
    product = float(own @ motion)
    if abs(product) < _ALIKE * float(np.linalg.norm(own) * np.linalg.norm(motion)):
        return None
    low, high = _FITS
    ratio = product / float(motion @ motion)
    fitting = [word for word in _WORDS[quantity] if low <= ratio * MEANINGS[word].factor <= high]
    return fitting[0] if fitting and meaning not in fitting else None


def refuse_other_motion(path: str, rows: Rows, meaning: str, name: str) -> None:
    """Raise `DataFormatError` where a yaw rate or acceleration fits the motion in another unit or sense.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``t_s``, ``east_m``, ``north_m`` and what the column fills, in SI units.
    meaning, name
        What the column is said to hold, and its name.
    """
    known = MEANINGS[meaning]
    better = fitting_meaning(meaning, rows.columns[known.fills] / known.factor, rows)
    if better is not None:
        words = _WORDS[known.fills]
        raise DataFormatError(
            path,
            f"{name} fits how the vehicle moves in {words[better]}, and not in {words[meaning]}",
            row=int(rows.line[0]),
            remedy=f"Map it so: --columns {better}={name}.",
        )


def _motion(rows: Rows, quantity: str) -> tuple[IntArray, FloatArray]:
    """Return rows, and what the positions say of a quantity there, over a second before and behind."""
    t_s = rows.columns["t_s"]
    position_m = np.stack([rows.columns["east_m"], rows.columns["north_m"]], axis=1)
    steps_s = np.diff(t_s)
    none = np.zeros(0, dtype=np.int64), np.zeros(0)
    if t_s.size < _FEWEST or not (steps_s > 0).all():
        return none
    lag = max(1, round(_SPAN_S / float(np.median(steps_s))))
    if t_s.size <= 2 * lag:
        return none
    way_m = position_m[lag:] - position_m[:-lag]
    before, behind = way_m[:-lag], way_m[lag:]
    at = np.arange(lag, t_s.size - lag)
    over_s = 0.5 * (t_s[2 * lag :] - t_s[: -2 * lag])
    moved_m = np.minimum(np.hypot(*before.T), np.hypot(*behind.T))
    even = (moved_m > _MOVING_M) & (np.abs(over_s / (lag * np.median(steps_s)) - 1.0) < 0.1)
    if quantity == "yaw_rate_radps":
        across = before[:, 1] * behind[:, 0] - before[:, 0] * behind[:, 1]
        motion = np.arctan2(across, (before * behind).sum(axis=1)) / over_s
    else:
        motion = (np.hypot(*behind.T) - np.hypot(*before.T)) / over_s**2
    return at[even], motion[even]
