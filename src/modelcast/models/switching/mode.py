"""One linear mode: how acceleration along the course and yaw rate go on from one step to the next."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import FieldError, Fixed, Number, check_fields

__all__ = ["LinearMode", "ModeArrays", "advanced", "as_arrays"]

_DYNAMICS = Number(-1000.0, 1000.0)
_OFFSET = Number(-100.0, 100.0)
_COVARIANCE = Number(-1e4, 1e4)
_LEAST_VARIANCE = 1e-10
_LEAST_DETERMINANT = 1e-8
"""Of a covariance over the product of its variances, one less the square of the correlation."""
_GROWTH = 1.0 + 1e-9


def _square(of: Number) -> Fixed:
    return Fixed((Fixed((of, of)), Fixed((of, of))))


@dataclass(frozen=True, slots=True)
class LinearMode:
    """Linear dynamics of ``x = (acceleration along the course, yaw rate)`` over one step.

    Parameters
    ----------
    dynamics
        A, rows first: ``x' = A x + b + w``.
    offset
        b [m/s², rad/s].
    covariance
        Of the white noise w, Q, in the units of x squared.

    Raises
    ------
    ValueError
        Where a number is out of its range, the covariance is not symmetric and positive definite or so near
        to singular that its inverse would be rounding, or an eigenvalue of the dynamics is larger than 1:
        such a mode would run away.

    Examples
    --------
    >>> mode = LinearMode(((0.9, 0.0), (0.0, 0.8)), (0.1, 0.0), ((0.04, 0.0), (0.0, 0.0001)))
    >>> mode.offset
    (0.1, 0.0)
    """

    dynamics: Annotated[tuple[tuple[float, float], tuple[float, float]], _square(_DYNAMICS)]
    offset: Annotated[tuple[float, float], Fixed((_OFFSET, _OFFSET))]
    covariance: Annotated[tuple[tuple[float, float], tuple[float, float]], _square(_COVARIANCE)]

    def __post_init__(self) -> None:
        check_fields(self)
        for name in ("dynamics", "covariance"):
            object.__setattr__(self, name, tuple(tuple(row) for row in getattr(self, name)))
        object.__setattr__(self, "offset", tuple(self.offset))
        if np.abs(np.linalg.eigvals(np.array(self.dynamics))).max() > _GROWTH:
            raise FieldError("dynamics", self.dynamics, "a matrix whose eigenvalues are at most 1 in size")
        (first, one), (other, second) = self.covariance
        determinant, product = first * second - one * one, first * second
        if (
            one != other
            or min(first, second) < _LEAST_VARIANCE
            or determinant <= _LEAST_DETERMINANT * product
        ):
            raise FieldError("covariance", self.covariance, "symmetric and positive definite")


class ModeArrays(NamedTuple):
    """M modes and their chain over one step.

    ``chain`` (M, M) from row to column, ``dynamics`` (M, 2, 2), ``offset`` (M, 2), ``covariance`` (M, 2, 2).
    """

    chain: FloatArray
    dynamics: FloatArray
    offset: FloatArray
    covariance: FloatArray


def as_arrays(modes: Sequence[LinearMode], transition: Sequence[Sequence[float]]) -> ModeArrays:
    """Return modes and the rows of their chain as arrays, the rows summing to one exactly as rounding allows.

    Parameters
    ----------
    modes
        M of them.
    transition
        M rows of M chances.
    """
    chain = np.array(transition, dtype=np.float64)
    return ModeArrays(
        chain / chain.sum(axis=1, keepdims=True),
        np.array([mode.dynamics for mode in modes]),
        np.array([mode.offset for mode in modes]),
        np.array([mode.covariance for mode in modes]),
    )


def advanced(modes: ModeArrays, steps: float) -> ModeArrays:
    """Return what modes and chain do over a number of steps, within which a mode holds.

    Whole steps are exact; of the rest, between no step and one, everything is interpolated linearly, so that
    chances stay chances and what is stable stays stable.

    Parameters
    ----------
    modes
        Over one step.
    steps
        How many, above 0, whole or not.
    """
    whole, rest = int(steps), steps - int(steps)
    unit = np.broadcast_to(np.eye(2), modes.dynamics.shape)
    chain, dynamics = np.eye(len(modes.chain)), unit
    offset, covariance = np.zeros_like(modes.offset), np.zeros_like(modes.covariance)
    for share in [1.0] * whole + ([rest] if rest > 0.0 else []):
        once = (1.0 - share) * unit + share * modes.dynamics
        chain = chain @ ((1.0 - share) * np.eye(len(chain)) + share * modes.chain)
        dynamics = once @ dynamics
        offset = np.einsum("mij,mj->mi", once, offset) + share * modes.offset
        covariance = once @ covariance @ np.swapaxes(once, 1, 2) + share * modes.covariance
    return ModeArrays(chain, dynamics, offset, covariance)
