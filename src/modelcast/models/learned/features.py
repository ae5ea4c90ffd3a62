"""What the learned sub-model looks at: slopes of the last two seconds, in the vehicle's own frame.

Positions and velocities of the window are turned into the frame of the newest velocity (along the course and
to its left) and read off at every tenth of a second, whatever the sampling interval. Polynomials of several
degrees and lengths are fitted to them by least squares; their value and derivatives at the newest sample
are the inputs. All of it is linear, and one matrix each for positions and velocities. Beside them stand the
speed, the acceleration, the lateral acceleration ``v·yaw rate``; and, in logarithms, how noisy the sender is:
the roughness of its velocity along and to the left (root mean square of third differences, scaled to the
noise of one velocity), and the noise of its positions. A velocity made from positions of 1 cm and one of a
wheel sensor look alike but for that. A map may also take the reported speed, as polynomials and with its
roughness, and the context: the vehicle ahead and the road (`modelcast.models.context_columns`).

Mirroring the world changes the sign of every input that `FeatureMap.mirrors` marks, and of nothing else.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import Each, FieldError, Fixed, Whole, check_fields
from modelcast.models.context_columns import ROAD_TURN_HORIZONS

__all__ = [
    "ALONE",
    "LAGS",
    "LAG_STEP_S",
    "LEADER_INPUTS",
    "REPORTED",
    "ROAD_INPUTS",
    "SHORTEST_SPAN",
    "FeatureMap",
    "Fit",
]

LAG_STEP_S = 0.1
"""Positions and velocities are read off at multiples of this time before the newest sample [s]."""

LAGS = Whole(10, 100)
"""Steps that a window may reach back: the shortest polynomials need 10, and ten seconds are long ago."""

SHORTEST_SPAN = 0.99
"""Share of the lags that a window must reach back: clocks run a little fast."""

_STEP_SLACK = 1e-5
"""Sampling intervals are measured: a tenth of a second may be a millionth longer or shorter."""

Fit = tuple[int, int]
"""Length in lags and degree of a polynomial."""

_FITS = Each(Fixed((Whole(1, 100), Whole(0, 4))), 0, 64)

_POSITION_FITS = ((3, 2), (5, 2), (10, 2), (10, 3), (20, 2), (20, 3), (20, 4))
_VELOCITY_FITS = ((5, 1), (10, 1), (10, 2), (20, 1), (20, 2), (20, 3))

ALONE = 3
"""Speed, acceleration, lateral acceleration come before the polynomials."""

_NOISES = 3
"""The last inputs: logarithms of noise, which neither a mirror nor a larger road changes."""

REPORTED = 4
"""Values that a vehicle may report: speed, heading, acceleration and yaw rate."""

LEADER_INPUTS, ROAD_INPUTS = 4, ROAD_TURN_HORIZONS + 1
"""Gap, relative speed, acceleration now and before; lateral accelerations of the road, and how fast the
course leaves it."""


@dataclass(frozen=True)
class FeatureMap:
    """The linear part of the inputs.

    Parameters
    ----------
    lags
        How many steps of `LAG_STEP_S` the window reaches back.
    position_fits, velocity_fits
        Polynomials of positions and velocities; longer ones than the window are left out.
    speed_fits
        Polynomials of the reported speed less that of the newest velocity; where there is one, its value
        now, its roughness and what is reported are inputs too.
    context
        Whether the vehicle ahead and the road are inputs.

    Raises
    ------
    ValueError
        Where a polynomial has more coefficients than samples, or the window would be longer than ten seconds.

    Examples
    --------
    >>> FeatureMap(20).inputs
    88
    >>> FeatureMap(20, speed_fits=((5, 1),), context=True).inputs
    109
    """

    lags: Annotated[int, LAGS] = 20
    position_fits: Annotated[tuple[Fit, ...], _FITS] = _POSITION_FITS
    velocity_fits: Annotated[tuple[Fit, ...], _FITS] = _VELOCITY_FITS
    speed_fits: Annotated[tuple[Fit, ...], _FITS] = ()
    context: bool = False

    def __post_init__(self) -> None:
        check_fields(self)
        for name in ("position_fits", "velocity_fits", "speed_fits"):
            for length, degree in getattr(self, name):
                if degree > length:
                    raise FieldError(name, (length, degree), "polynomials with a sample for each coefficient")

    @cached_property
    def positions(self) -> FloatArray:
        """Rows that turn positions at lags 0..lags, less constant velocity, into inputs, (P, lags + 1)."""
        return _rows(self.position_fits, self.lags)

    @cached_property
    def velocities(self) -> FloatArray:
        """The same for velocities less the newest, (V, lags + 1)."""
        return _rows(self.velocity_fits, self.lags)

    @cached_property
    def speeds(self) -> FloatArray:
        """The same for reported speeds less that of the newest velocity, (S, lags + 1)."""
        return _rows(self.speed_fits, self.lags)

    def window_at(self, dt_s: float) -> int:
        """Samples that span the lags.

        Parameters
        ----------
        dt_s
            Sampling interval [s].
        """
        return int(np.ceil(self.lags * LAG_STEP_S / dt_s - _STEP_SLACK)) + 1

    @property
    def inputs(self) -> int:
        """How many inputs there are."""
        return self._after_velocities + self._speed_inputs + self._context_inputs + self.fixed

    @property
    def fixed(self) -> int:
        """How many of the last inputs no mirror and no larger road changes: what is known, and noise."""
        return _NOISES + (REPORTED + 1 if self.speed_fits else 0) + (2 if self.context else 0)

    @property
    def _after_velocities(self) -> int:
        return ALONE + 2 * (self.positions.shape[0] + self.velocities.shape[0])

    @property
    def _speed_inputs(self) -> int:
        return self.speeds.shape[0] + 1 if self.speed_fits else 0

    @property
    def _context_inputs(self) -> int:
        return LEADER_INPUTS + ROAD_INPUTS if self.context else 0

    @property
    def fits(self) -> dict[str, tuple[Fit, ...]]:
        """Polynomials by what they are fitted to: ``position``, ``velocity`` and ``speed``."""
        return {"position": self.position_fits, "velocity": self.velocity_fits, "speed": self.speed_fits}

    def place_of(self, column: str, fit: Fit, derivative: int) -> int:
        """Index of an input; of positions and velocities the part along, that to the left stands behind it.

        Parameters
        ----------
        column
            One of `fits`.
        fit
            One of its polynomials.
        derivative
            0 for the value at the newest sample, 1 for its slope, and so on.

        Raises
        ------
        ValueError
            Where the map has no such input.
        """
        if column not in self.fits:
            raise ValueError(f"column must be position, velocity or speed, got {column!r}")
        known = [one for one in self.fits[column] if one[0] <= self.lags]
        if fit not in known or not 0 <= derivative <= fit[1]:
            raise ValueError(f"the map has no derivative {derivative} of {column} by a polynomial of {fit}")
        row = sum(one[1] + 1 for one in known[: known.index(fit)]) + derivative
        if column == "position":
            return ALONE + 2 * row
        if column == "velocity":
            return ALONE + 2 * (self.positions.shape[0] + row)
        return self._after_velocities + row

    @cached_property
    def mirrors(self) -> FloatArray:
        """-1 for an input that changes its sign in the mirror, 1 for the others, (inputs,)."""
        signs = np.ones(self.inputs)
        signs[2] = -1.0
        signs[ALONE + 1 : self._after_velocities : 2] = -1.0
        if self.context:
            road = self.inputs - self.fixed - ROAD_INPUTS
            signs[road : road + ROAD_INPUTS] = -1.0
        return signs


def _rows(fits: tuple[tuple[int, int], ...], lags: int) -> FloatArray:
    """Value and derivatives at lag 0 of least-squares polynomials, one row each."""
    rows: list[FloatArray] = []
    for length, degree in fits:
        if length > lags:
            continue
        t_s = -LAG_STEP_S * np.arange(length + 1)
        solved = np.linalg.pinv(np.vander(t_s, degree + 1, increasing=True))
        for power in range(degree + 1):
            row = np.zeros(lags + 1)
            row[: length + 1] = solved[power] * float(np.prod(np.arange(1, power + 1)))
            rows.append(row)
    return np.stack(rows) if rows else np.zeros((0, lags + 1))
