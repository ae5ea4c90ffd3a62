"""Whether headings that go on over four circles are radians, or degrees that were called radians.

A heading that is not wrapped grows by 2 pi a circle; a car on a small roundabout or a test track is beyond
any bound after some minutes. Degrees show in two ways: they jump by 360 where they are wrapped, and as
radians they do not lie along the way that the positions take.
"""

import numpy as np

from modelcast.core.arrays import FloatArray

__all__ = ["ALONG", "LARGEST_RAD", "along_way", "degrees_at"]

LARGEST_RAD = 8.0 * np.pi
"""Headings up to four circles are taken as they are; of larger ones the unit is looked at."""

_CIRCLE_DEG, _ABOUT_DEG = 360.0, 20.0
ALONG = 0.7
"""Mean cosine, over the way, between headings and the course of positions that fit each other: 45 degrees."""
_LEAST_WAY_M = 1.0
_LONGEST_STEPS = 10.0
"""A step counts as this many median ones at most: one jump is not the whole way."""


def degrees_at(heading_rad: FloatArray, position_m: FloatArray) -> int | None:
    """Return the first sample whose heading is too large for radians, None where they can be radians.

    Parameters
    ----------
    heading_rad
        Headings, clockwise from north, in radians as somebody says, (T,); NaN where missing.
    position_m
        East and north, (T, 2) [m].

    Examples
    --------
    >>> import numpy as np
    >>> heading = np.linspace(0.0, 12.0 * np.pi, 600)
    >>> position_m = 50.0 * np.stack([-np.cos(heading), np.sin(heading)], axis=1)
    >>> degrees_at(heading, position_m) is None
    True
    >>> degrees_at(np.degrees(heading) % 360.0, position_m)
    7
    """
    known = np.isfinite(heading_rad) & np.isfinite(position_m).all(axis=1)
    large = known & (np.abs(heading_rad) > LARGEST_RAD)
    if not large.any():
        return None
    heading = heading_rad[known]
    wrapped = np.abs(np.abs(np.diff(heading)) - _CIRCLE_DEG) < _ABOUT_DEG
    if not wrapped.any() and not _off_course(heading, position_m[known]):
        return None
    return int(np.argmax(large))


def along_way(heading_rad: FloatArray, position_m: FloatArray) -> float:
    """Return the mean cosine, over the way, between headings and the course of positions; NaN without a way.

    Parameters
    ----------
    heading_rad
        Headings, clockwise from north, (T,) [rad].
    position_m
        East and north, (T, 2) [m].

    Examples
    --------
    >>> import numpy as np
    >>> northwards = np.stack([np.zeros(9), np.arange(9.0)], axis=1)
    >>> round(along_way(np.full(9, np.pi / 3), northwards), 3)
    0.5
    """
    steps_m = np.diff(position_m, axis=0)
    lengths_m = np.hypot(*steps_m.T)
    if not lengths_m.sum() > _LEAST_WAY_M:
        return float("nan")
    weight = np.minimum(lengths_m, _LONGEST_STEPS * np.median(lengths_m[lengths_m > 0]))
    course_rad = np.arctan2(steps_m[:, 0], steps_m[:, 1])
    return float(np.average(np.cos(heading_rad[:-1] - course_rad), weights=weight))


def _off_course(heading: FloatArray, position_m: FloatArray) -> bool:
    """Return whether headings are not along the way in radians, or are more so in degrees."""
    in_radians = along_way(heading, position_m)
    return in_radians < ALONG or along_way(np.radians(heading), position_m) > in_radians
