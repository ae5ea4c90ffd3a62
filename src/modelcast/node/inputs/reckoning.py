"""Where a vehicle is some time after a fix, by its speed and yaw rate, and how sure that is.

With speed v(t) and clockwise yaw rate w(t) the course is h(t) = h + integral of w, the way the integral of
v (sin h, cos h). It is summed over the pieces between values, each by the values in its middle, which is
exact to second order in their length.

The error grows from the fix's own. With age a, driven way s and speed v, one standard deviation is

    along the course:  speed_ratio s + speed_mps a
    across it:         course_rad s + yaw_rate_radps s a / 2

the second by a course that was wrong at the begin and by a yaw rate that is wrong throughout.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray

__all__ = ["DEFAULT_AXIS_M", "Growth", "Way", "ellipse_covariance_m2", "ellipse_of", "way"]

DEFAULT_AXIS_M = 8.0 / math.sqrt(2.0 * math.log(20.0))
"""Standard deviation on each axis of a fix whose error is not stated, 3.3 m.

The GPS Standard Positioning Service Performance Standard (5th edition, 2020, position accuracy) has 8 m
horizontally, 95 %, as the global average, errors of atmosphere and receiver left out.
"""


@dataclass(frozen=True, slots=True)
class Way:
    """What was driven.

    Parameters
    ----------
    east_m, north_m
        From the begin to the end [m].
    heading_rad
        At the end, not wrapped [rad].
    driven_m
        Along the way, forwards and backwards [m].
    """

    east_m: float
    north_m: float
    heading_rad: float
    driven_m: float


def way(
    speed_at: Callable[[float], float],
    yaw_rate_at: Callable[[float], float],
    knots_s: Iterable[float],
    *,
    from_s: float,
    to_s: float,
    heading_rad: float,
) -> Way:
    """What is driven between two times.

    Parameters
    ----------
    speed_at, yaw_rate_at
        Speed [m/s] and clockwise yaw rate [rad/s] at a time [s].
    knots_s
        Times in between at which either bends, in any order [s].
    from_s, to_s
        Begin and end [s].
    heading_rad
        At the begin, clockwise from north [rad].

    Examples
    --------
    A quarter of a circle to the right, from north to east:

    >>> driven = way(
    ...     lambda t: 10.0, lambda t: 0.1, range(16), from_s=0.0, to_s=5 * math.pi, heading_rad=0.0
    ... )
    >>> round(driven.east_m, 1), round(driven.north_m, 1), round(driven.heading_rad, 3)
    (100.0, 100.0, 1.571)
    """
    east_m = north_m = driven_m = 0.0
    at_s = from_s
    for next_s in (*sorted({knot for knot in knots_s if from_s < knot < to_s}), to_s):
        step_s = next_s - at_s
        middle_s = at_s + step_s / 2.0
        speed_mps, yaw_rate_radps = speed_at(middle_s), yaw_rate_at(middle_s)
        course_rad = heading_rad + yaw_rate_radps * step_s / 2.0
        east_m += speed_mps * step_s * math.sin(course_rad)
        north_m += speed_mps * step_s * math.cos(course_rad)
        driven_m += abs(speed_mps) * step_s
        heading_rad += yaw_rate_radps * step_s
        at_s = next_s
    return Way(east_m, north_m, heading_rad, driven_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class Growth:
    """How the error grows; the module has the formula.

    The defaults cover real outages (``docs/node-inputs.md`` has the table).

    Parameters
    ----------
    speed_ratio
        Of the speed, its scale (tyres, calibration).
    speed_mps
        Of the speed, whatever it is [m/s].
    course_rad
        Of the course at the begin [rad].
    yaw_rate_radps
        Of the yaw rate, its bias [rad/s].

    Raises
    ------
    ValueError
        Where one is negative or not finite.
    """

    speed_ratio: float = 0.01
    speed_mps: float = 0.15
    course_rad: float = math.radians(1.0)
    yaw_rate_radps: float = math.radians(0.3)

    def __post_init__(self) -> None:
        for name in self.__slots__:
            if not 0.0 <= getattr(self, name) < math.inf:
                raise ValueError(f"{name} must not be negative, got {getattr(self, name)}")

    def covariance_m2(self, age_s: float, driven: Way) -> FloatArray:
        """What a way adds to the covariance of the place, east and north, (2, 2) [m²].

        Parameters
        ----------
        age_s
            How long it took [s].
        driven
            The way.
        """
        along_m = self.speed_ratio * driven.driven_m + self.speed_mps * age_s
        across_m = driven.driven_m * (self.course_rad + self.yaw_rate_radps * age_s / 2.0)
        toward_rad = (
            math.atan2(driven.east_m, driven.north_m) if driven.driven_m > 0.0 else driven.heading_rad
        )
        return ellipse_covariance_m2(along_m, across_m, toward_rad)


def ellipse_covariance_m2(along_m: float, across_m: float, heading_rad: float) -> FloatArray:
    """Covariance of an error ellipse, east and north, (2, 2) [m²].

    Parameters
    ----------
    along_m, across_m
        Standard deviations along a direction and across it [m].
    heading_rad
        The direction, clockwise from north [rad].
    """
    sine, cosine = math.sin(heading_rad), math.cos(heading_rad)
    axes = np.array([[sine, cosine], [cosine, -sine]])
    return axes @ np.diag([along_m**2, across_m**2]) @ axes.T


def ellipse_of(covariance_m2: FloatArray) -> tuple[float, float, float]:
    """Longer and shorter axis of one standard deviation [m], and the longer one's direction [rad].

    Parameters
    ----------
    covariance_m2
        East and north, (2, 2) [m²].

    Examples
    --------
    >>> [round(value, 6) for value in ellipse_of(ellipse_covariance_m2(3.0, 1.0, 0.5))]
    [3.0, 1.0, 0.5]
    """
    shares, axes = np.linalg.eigh(covariance_m2)
    east, north = axes[:, 1].tolist()
    minor_m, major_m = np.sqrt(np.maximum(shares, 0.0)).tolist()
    return major_m, minor_m, math.atan2(east, north) % math.pi
