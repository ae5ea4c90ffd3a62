"""Calibrated covariance: what training trips say about how far a sub-model's predictions really are off.

A sub-model's own covariance is nominal: a stated guess, or what a Gaussian process believes. A `Calibration`
widens and shrinks it along and across the predicted course, by horizon, until the 90 % ellipse holds 90 % of
the training errors. Errors have heavier tails than a Gaussian, so one covariance cannot make every level
right: `Calibration.radius` gives the radius of the ellipse for any other level, learnt too.
`modelcast.study.training.calibration` fits them.
"""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import (
    Anything,
    Each,
    FieldError,
    Fixed,
    Keys,
    Number,
    Numbers,
    Text,
    Whole,
    check,
    check_fields,
)
from modelcast.models.base import AbstractSubModel

__all__ = ["LEVELS", "Calibration", "course_axes", "gaussian_radius", "widened"]

LEVELS = (0.5, 0.9, 0.95)
"""Levels whose ellipses are learnt; the covariance itself is made right at the middle one."""

SMALLEST_M = 1e-3
"""Standard deviation that is always added: a nominal covariance may be zero [m]."""

UNMODELLED_M, UNMODELLED_MPS = 0.02, 0.05
"""Error in position and velocity that no nominal covariance has; `unmodelled` is a share of it."""

_STANDS_M = 1e-9

_MOST_HORIZONS = 1000
_HORIZON_S = Number(1e-3, 3600.0)
_FACTOR = Number(1e-6, 1e6)
_ROW = {"factors": Fixed((_FACTOR,) * 2), "radii": Fixed((_FACTOR,) * len(LEVELS))}
_PLAIN = Keys(
    {
        "sub_model": Anything(),
        "horizons_s": Each(_HORIZON_S, 1, _MOST_HORIZONS),
        "unmodelled": Anything(),
        **{name: Each(row, 1, _MOST_HORIZONS) for name, row in _ROW.items()},
        "instants": Anything(),
    }
)


def gaussian_radius(level: npt.ArrayLike) -> FloatArray:
    """Mahalanobis radius of a two-dimensional Gaussian's ellipse of that level.

    Parameters
    ----------
    level
        Share inside, from 0 to under 1.

    Examples
    --------
    >>> gaussian_radius([0.5, 0.9, 0.95]).round(3).tolist()
    [1.177, 2.146, 2.448]
    """
    return np.sqrt(-2.0 * np.log1p(-np.asarray(level, dtype=np.float64)))


def course_axes(moved_m: FloatArray) -> FloatArray:
    """Unit vectors along and across the way to the predicted place, as rows, (..., 2, 2).

    Parameters
    ----------
    moved_m
        Predicted displacements, (..., 2) [m]. One that stays has no course: its axes are east and north.
    """
    length = np.hypot(moved_m[..., 0], moved_m[..., 1])[..., None]
    along = np.where(length > _STANDS_M, moved_m / np.maximum(length, _STANDS_M), np.array([1.0, 0.0]))
    across = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    return np.stack([along, across], axis=-2)


def widened(covariance_m2: FloatArray, horizons_s: FloatArray, unmodelled: float) -> FloatArray:
    """Nominal covariances plus a round error that no model has, (..., H, 2, 2) [m²].

    Parameters
    ----------
    covariance_m2
        Nominal, (..., H, 2, 2) [m²].
    horizons_s
        Horizons, (H,) [s].
    unmodelled
        Share of `UNMODELLED_M` + `UNMODELLED_MPS`·h that is added to the spread.
    """
    spread_m = unmodelled * (UNMODELLED_M + UNMODELLED_MPS * horizons_s)
    return covariance_m2 + (SMALLEST_M**2 + spread_m**2)[:, None, None] * np.eye(2)


@dataclass(frozen=True, slots=True)
class Calibration:
    """How to correct one sub-model's covariance, by horizon.

    Parameters
    ----------
    sub_model
        Name of the sub-model.
    horizons_s
        Horizons of the table, rising, (H,) [s]; between them it is interpolated over the logarithm of the
        horizon, beyond them the nearest entry holds.
    unmodelled
        Share of a round error that is added first, as `widened` says.
    factors
        Multiples of the spread along and across the predicted course, (H, 2).
    radii
        Mahalanobis radius of the ellipses of `LEVELS` under the calibrated covariance, (H, 3).
    instants
        How many fits it was learnt from.

    Raises
    ------
    ValueError
        Where shapes disagree, horizons do not rise, radii fall with the level, or a number is out of its
        range.

    Examples
    --------
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> table = Calibration(
    ...     "cv",
    ...     np.array([1.0, 2.0]),
    ...     unmodelled=0.0,
    ...     factors=np.array([[2.0, 1.0], [2.0, 1.0]]),
    ...     radii=np.array([[1.0, 2.146, 2.8], [1.0, 2.146, 2.8]]),
    ...     instants=100,
    ... )
    >>> moving_east = np.array([[10.0, 0.0]])
    >>> table.covariance(ConstantVelocity(), moving_east, np.array([1.0]), dt_s=0.1).round(2)
    array([[[[1.  , 0.  ],
             [0.  , 0.25]]]])
    >>> table.radius(0.5, np.array([1.5])).tolist()
    [1.0]
    """

    sub_model: Annotated[str, Text(64)]
    horizons_s: Annotated[FloatArray, Numbers(1, _HORIZON_S, _MOST_HORIZONS)]
    _: KW_ONLY
    unmodelled: Annotated[float, Number(0.0, 1e6)]
    factors: Annotated[FloatArray, Numbers(2, _FACTOR, _MOST_HORIZONS)]
    radii: Annotated[FloatArray, Numbers(2, _FACTOR, _MOST_HORIZONS)]
    instants: Annotated[int, Whole(0, 2**53)]

    def __post_init__(self) -> None:
        check_fields(self)
        count = self.horizons_s.size
        if not (np.diff(self.horizons_s) > 0).all():
            raise FieldError("horizons_s", self.horizons_s, "horizons that rise")
        if self.factors.shape != (count, 2) or self.radii.shape != (count, len(LEVELS)):
            raise ValueError(
                f"factors must be ({count}, 2) and radii ({count}, {len(LEVELS)}), "
                f"got {self.factors.shape} and {self.radii.shape}"
            )
        if not (np.diff(self.radii, axis=1) >= 0).all():
            raise FieldError("radii", self.radii, "radii that do not fall with the level")

    def covariance(
        self, model: AbstractSubModel, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float
    ) -> FloatArray:
        """Calibrated covariance of the displacement, (B, H, 2, 2) [m²].

        Parameters
        ----------
        model
            The sub-model this was learnt for.
        parameters
            (B, P), as ``model.fit`` returned them.
        horizons_s
            Times after the window's last sample, (H,) [s].
        dt_s
            Sampling interval of the windows [s].

        Raises
        ------
        ValueError
            Where the model has another name.
        """
        if model.name != self.sub_model:
            raise ValueError(f"this calibration is for {self.sub_model}, not for {model.name}")
        horizons_s = np.ascontiguousarray(horizons_s, dtype=np.float64)
        axes = course_axes(model.predict(parameters, horizons_s, dt_s=dt_s))
        nominal = model.covariance(parameters, horizons_s, dt_s=dt_s)
        turned = axes @ nominal @ axes.swapaxes(-1, -2)
        back = axes.swapaxes(-1, -2) @ self.scaled(turned, horizons_s) @ axes
        return 0.5 * (back + back.swapaxes(-1, -2))

    def scaled(self, covariance_m2: FloatArray, horizons_s: FloatArray) -> FloatArray:
        """Calibrated covariances from nominal ones, both along and across the course, (..., H, 2, 2) [m²].

        Parameters
        ----------
        covariance_m2
            Nominal, with the axes of `course_axes`, (..., H, 2, 2) [m²].
        horizons_s
            Horizons, (H,) [s].
        """
        factors = np.exp(self._at(horizons_s, np.log(self.factors)))
        both = factors[:, :, None] * factors[:, None, :]
        return both * widened(covariance_m2, horizons_s, self.unmodelled)

    def radius(self, level: float, horizons_s: FloatArray) -> FloatArray:
        """Mahalanobis radius of the ellipse that holds this share of the errors, (H,).

        Parameters
        ----------
        level
            Share inside, from 0 to under 1. Between and beyond `LEVELS` the Gaussian's radius is scaled.
        horizons_s
            Horizons, (H,) [s].
        """
        known = np.concatenate([[0.0], gaussian_radius(LEVELS)])
        radii = self.level_radii(horizons_s)
        wanted = float(gaussian_radius(level))
        if wanted > known[-1]:
            return radii[:, -1] * wanted / known[-1]
        return np.array([np.interp(wanted, known, [0.0, *row]) for row in radii])

    def level_radii(self, horizons_s: FloatArray) -> FloatArray:
        """Radii of the ellipses of `LEVELS`, (H, 3).

        Parameters
        ----------
        horizons_s
            Horizons, (H,) [s].
        """
        return self._at(np.asarray(horizons_s, dtype=np.float64), self.radii)

    def as_plain(self) -> Mapping[str, Any]:
        """The calibration as plain values, for a profile."""
        return {
            "sub_model": self.sub_model,
            "horizons_s": self.horizons_s.tolist(),
            "unmodelled": self.unmodelled,
            "factors": self.factors.tolist(),
            "radii": self.radii.tolist(),
            "instants": self.instants,
        }

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "Calibration":
        """The calibration that `as_plain` described.

        Parameters
        ----------
        plain
            Plain values, as read from JSON.

        Raises
        ------
        FieldError
            Where they are none, or what they say is refused.
        """
        check(plain, _PLAIN)
        return cls(
            plain["sub_model"],
            np.array(plain["horizons_s"], dtype=np.float64),
            unmodelled=plain["unmodelled"],
            factors=np.array(plain["factors"], dtype=np.float64),
            radii=np.array(plain["radii"], dtype=np.float64),
            instants=plain["instants"],
        )

    def _at(self, horizons_s: FloatArray, table: FloatArray) -> FloatArray:
        """Columns of a table (H', C) at these horizons, (H, C)."""
        known = np.log(self.horizons_s)
        wanted = np.log(np.maximum(horizons_s, self.horizons_s[0]))
        columns: list[FloatArray] = [np.interp(wanted, known, table[:, k]) for k in range(table.shape[1])]
        return np.stack(columns, axis=1)
