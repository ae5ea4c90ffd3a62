"""Positions on the grid of a map (UTM and the like), counted from a point near them.

Eastings and northings count from a point that may be thousands of kilometres away, farther than messages can
state a position (`modelcast.core.geodesy_kernels.FARTHEST_M`). A table of such positions is read from the
nearest point of a grid of `STEP_M`. Files of one area so have one origin, nearly always, and the distances
between their vehicles stay what they were; the first position of each file would put them all at one place.
"""

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy_kernels import FARTHEST_M
from modelcast.io.base import Tally
from modelcast.io.rows import Rows

__all__ = ["STEP_M", "counted_from", "near_origin_m", "refuse_earth_centred"]

STEP_M = 100_000.0
"""Distance of the points that positions are counted from, an axis [m]."""

_FARTHEST_M = 4e7
"""No grid of a map goes on farther, with the number of its zone in front [m]; what does is damage."""

_EARTH_M = (6.35e6, 6.39e6)
"""From the middle of the Earth to roads: the poles at sea level, and the equator at 10 km [m]."""
_HIGHEST_M = 20e3
"""A height is below this, and Earth-centred ``z`` is only within 20 km of the equator [m]."""


def near_origin_m(rows: Rows) -> FloatArray | None:
    """Return the point that positions are to be counted from, east and north, (2,) [m].

    None where they lie within half of what messages can state, or on no map: they are left as they are.

    Parameters
    ----------
    rows
        Rows of a table with ``east_m`` and ``north_m``, at least one of them finite.

    Examples
    --------
    >>> import numpy as np
    >>> line = np.arange(2)
    >>> near_origin_m(Rows(line, {"east_m": np.array([691e3, np.nan]), "north_m": np.array([5336e3, 0.0])}))
    array([ 700000., 5300000.])
    >>> near_origin_m(Rows(line, {"east_m": np.array([100.0, 0.0]), "north_m": np.zeros(2)})) is None
    True
    """
    position_m = np.stack([rows.columns["east_m"], rows.columns["north_m"]], axis=1)
    known = np.isfinite(position_m).all(axis=1)
    if not known.any():
        return None
    middle = np.median(position_m[known], axis=0)
    far = 0.5 * FARTHEST_M < np.hypot(*middle) < _FARTHEST_M
    return np.round(middle / STEP_M) * STEP_M if far else None


def counted_from(rows: Rows, origin_m: FloatArray, tally: Tally) -> Rows:
    """Return rows with positions from a point, each counted as repaired.

    Parameters
    ----------
    rows
        Rows with ``east_m`` and ``north_m``.
    origin_m
        East and north of the point, (2,) [m].
    tally
        Where they are counted.
    """
    east, north = origin_m
    tally.repair(f"position counted from ({east:.0f}, {north:.0f})", len(rows))
    return rows.having(east_m=rows.columns["east_m"] - east, north_m=rows.columns["north_m"] - north)


def refuse_earth_centred(path: str, rows: Rows, east: str) -> bool:
    """Return whether positions have a height, and so count from no middle of the Earth.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``east_m`` and ``north_m``; without ``up_m`` nothing is told.
    east
        Name of the column of east.

    Raises
    ------
    DataFormatError
        Where they count from the middle of the Earth.

    Notes
    -----
    Eastings and northings of a map may be as far from their zero as roads from the middle of the Earth; no
    height is.
    """
    if "up_m" not in rows.columns or not len(rows):
        return False
    place_m = np.stack([rows.columns[name] for name in ("east_m", "north_m", "up_m")])
    away_m = np.sqrt((place_m**2).sum(axis=0))
    nearest, farthest = _EARTH_M
    high = np.abs(rows.columns["up_m"]) > _HIGHEST_M
    if ((away_m > nearest) & (away_m < farthest) & high).all():
        raise DataFormatError(
            path,
            f"{east} with its two others counts from the middle of the Earth (ECEF, WGS-84)",
            row=int(rows.line[0]),
            remedy="Write latitude, longitude: pyproj.Transformer.from_crs(4978, 4979).transform(x, y, z).",
        )
    return not high.any()
