"""What the learned sub-model looks at: slopes of the last two seconds, in the vehicle's own frame.

Positions and velocities of the window are turned into the frame of the newest velocity (along the course and
to its left) and read off at every tenth of a second, whatever the sampling interval. Polynomials of several
degrees and lengths are fitted to them by least squares; their value and derivatives at the newest sample
are the inputs. All of it is linear, and one matrix each for positions and velocities. Beside them stand the
speed, the acceleration, the lateral acceleration ``v·yaw rate``; and, in logarithms, how noisy the sender is:
the roughness of its velocity along and to the left (root mean square of third differences, scaled to the
noise of one velocity), and the noise of its positions. A velocity made from positions of 1 cm and one of a
wheel sensor look alike but for that.

Mirroring the world changes the sign of every input that `FeatureMap.mirrors` marks, and of nothing else.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import Whole, check_fields

__all__ = ["LAGS", "LAG_STEP_S", "NOISES", "SHORTEST_SPAN", "FeatureMap"]

LAG_STEP_S = 0.1
"""Positions and velocities are read off at multiples of this time before the newest sample [s]."""

LAGS = Whole(10, 100)
"""Steps that a window may reach back: the shortest polynomials need 10, and ten seconds are long ago."""

SHORTEST_SPAN = 0.99
"""Share of the lags that a window must reach back: clocks run a little fast."""

_STEP_SLACK = 1e-5
"""Sampling intervals are measured: a tenth of a second may be a millionth longer or shorter."""

_POSITION_FITS = ((3, 2), (5, 2), (10, 2), (10, 3), (20, 2), (20, 3), (20, 4))
_VELOCITY_FITS = ((5, 1), (10, 1), (10, 2), (20, 1), (20, 2), (20, 3))

_ALONE = 3
"""Speed, acceleration, lateral acceleration come before the polynomials."""

NOISES = 3
"""The last inputs: logarithms of noise, which neither a mirror nor a larger road changes."""


@dataclass(frozen=True)
class FeatureMap:
    """The linear part of the inputs.

    Parameters
    ----------
    lags
        How many steps of `LAG_STEP_S` the window reaches back.

    Raises
    ------
    ValueError
        Where the shortest polynomial does not fit in, or the window would be longer than ten seconds.

    Examples
    --------
    >>> FeatureMap(20).inputs
    88
    """

    lags: Annotated[int, LAGS] = 20

    def __post_init__(self) -> None:
        check_fields(self)

    @cached_property
    def positions(self) -> FloatArray:
        """Rows that turn positions at lags 0..lags, less constant velocity, into inputs, (P, lags + 1)."""
        return _rows(_POSITION_FITS, self.lags)

    @cached_property
    def velocities(self) -> FloatArray:
        """The same for velocities less the newest, (V, lags + 1)."""
        return _rows(_VELOCITY_FITS, self.lags)

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
        return _ALONE + 2 * (self.positions.shape[0] + self.velocities.shape[0]) + NOISES

    @cached_property
    def mirrors(self) -> FloatArray:
        """-1 for an input that changes its sign in the mirror, 1 for the others, (inputs,)."""
        signs = np.ones(self.inputs)
        signs[2] = -1.0
        signs[_ALONE + 1 : -NOISES : 2] = -1.0
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
    return np.stack(rows)
