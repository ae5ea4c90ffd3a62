"""Whether headings of a table lie along the way of the positions in the unit and sense that it states.

A heading counted from east, or in degrees that are called radians, is a number like any other, and passes
every bound. It does not point where the vehicle goes: that tells.
"""

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.io.column_meanings import MEANINGS
from modelcast.io.rows import Rows
from modelcast.trips.heading_unit import ALONG, along_way

__all__ = ["heading_meaning", "heading_si", "refuse_other_heading"]

_WORDS = {
    "heading_deg": "degrees clockwise from north",
    "heading_rad": "radians clockwise from north",
    "yaw_deg": "degrees anticlockwise from east",
    "yaw_rad": "radians anticlockwise from east",
}
_FITS = 0.95
"""Mean cosine to the course of what is taken for the true unit and sense: 18 degrees."""
_FEWEST_STEPS = 20
_LEAST_WAY_M = 20.0


def heading_si(values: FloatArray, factor: float) -> FloatArray:
    """Return headings clockwise from north [rad] of a column's values and its factor.

    Parameters
    ----------
    values
        As the file has them.
    factor
        As in `modelcast.io.column_meanings.Meaning`.

    Examples
    --------
    >>> import numpy as np
    >>> heading_si(np.array([90.0]), -np.pi / 180)
    array([0.])
    """
    if factor < 0:
        return values * factor + 0.5 * np.pi
    return values if factor == 1.0 else values * factor


def heading_meaning(meaning: str, values: FloatArray, position_m: FloatArray) -> str | None:
    """Return the meaning in which headings lie along the way: the one stated, or else another.

    None where they lie along it in no meaning, or against it as stated, as of a vehicle that drives
    backwards, or the way is too short to tell. Zeros are left out: receivers write them where they have no
    course.

    Parameters
    ----------
    meaning
        What is stated.
    values
        The column as the file has it, (T,); NaN where missing.
    position_m
        East and north, (T, 2) [m].
    """
    known = np.isfinite(values) & (values != 0.0) & np.isfinite(position_m).all(axis=1)
    values, position_m = values[known], position_m[known]
    lengths_m = np.hypot(*np.diff(position_m, axis=0).T)
    if np.count_nonzero(lengths_m) < _FEWEST_STEPS or lengths_m.sum() < _LEAST_WAY_M:
        return None
    along = {word: along_way(heading_si(values, MEANINGS[word].factor), position_m) for word in _WORDS}
    if along[meaning] >= ALONG:
        return meaning
    best = max(along, key=lambda word: along[word])
    return best if along[meaning] > -ALONG and along[best] > _FITS else None


def refuse_other_heading(path: str, rows: Rows, values: FloatArray, meaning: str, name: str) -> bool:
    """Return whether headings lie along the way in the unit and sense that is stated.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``east_m`` and ``north_m``.
    values
        Its headings as the file has them, (R,); NaN where missing.
    meaning, name
        What the column is said to hold, and its name.

    Raises
    ------
    DataFormatError
        Where they do so in another one.
    """
    position_m = np.stack([rows.columns["east_m"], rows.columns["north_m"]], axis=1)
    told = heading_meaning(meaning, values, position_m)
    if told not in {None, meaning}:
        raise DataFormatError(
            path,
            f"{name} points where the vehicle goes as {_WORDS[str(told)]}, and not as {_WORDS[meaning]}",
            row=int(rows.line[0]),
            remedy=f"Map it so: --columns {told}={name}. Where it is as stated: --columns {meaning}={name}.",
        )
    return told == meaning
