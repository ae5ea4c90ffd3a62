"""Constant acceleration, constant turn rate, and both: the kinematic models beside constant velocity.

Velocity, acceleration along the course and yaw rate are those that the trip's named causal estimators give at
the window's last sample (`modelcast.station.sensing.velocity`, `modelcast.station.sensing.rates`).

References
----------
R. Schubert, E. Richter, G. Wanielik, "Comparison and Evaluation of Advanced Motion Models for Vehicle
Tracking", 11th International Conference on Information Fusion, 2008.
"""

from dataclasses import KW_ONLY, dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models import kinematic_kernels
from modelcast.models.core_model import SPREAD_MPS2, SPREAD_MPS3, SPREAD_RADPS2, AbstractCoreModel

__all__ = ["ConstantAcceleration", "ConstantTurnRateAcceleration", "ConstantTurnRateVelocity", "along_course"]

_VELOCITY = ("velocity_east_mps", "velocity_north_mps")


@dataclass(frozen=True, slots=True)
class ConstantAcceleration(AbstractCoreModel):
    """Go straight on at constant acceleration along the course; a braking car stops and stays.

    Parameters
    ----------
    jerk_spread_mps3
        Standard deviation of the unmodelled jerk along the course [m/s³], for the covariance: a displacement
        spread of ``j·t³/6``.
    lateral_spread_mps2
        Standard deviation of the unmodelled acceleration across it [m/s²]: ``½·a·t²``.

    Raises
    ------
    ValueError
        Where a spread is out of its range.

    Notes
    -----
    A car that stands has no course and stays, whatever its acceleration.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.models.base import Windows
    >>> model = ConstantAcceleration()
    >>> braking = np.array([[[0.0, 0.0, 10.0, 0.0, -5.0, 0.0, 0.0]]])
    >>> parameters = model.fit(Windows(braking, dt_s=0.1))
    >>> model.predict(parameters, np.array([1.0, 2.0, 9.0]), dt_s=0.1)
    array([[[ 7.5,  0. ],
            [10. ,  0. ],
            [10. ,  0. ]]])
    """

    short_name: ClassVar[str] = "ca"
    numbers: ClassVar[tuple[str, ...]] = (*_VELOCITY, "acceleration_mps2")
    functions: ClassVar[tuple[Any, Any]] = (
        kinematic_kernels.fit_acceleration,
        kinematic_kernels.predict_acceleration,
    )
    _: KW_ONLY
    jerk_spread_mps3: Annotated[float, SPREAD_MPS3] = 1.0
    lateral_spread_mps2: Annotated[float, SPREAD_MPS2] = 1.0

    def spread_m2(self, parameters: FloatArray, horizons_s: FloatArray) -> FloatArray:
        """Spread of an unmodelled jerk along the course and acceleration across it."""
        along_m = np.broadcast_to(self.jerk_spread_mps3 * horizons_s**3 / 6.0, _shape(parameters, horizons_s))
        across_m = np.broadcast_to(0.5 * self.lateral_spread_mps2 * horizons_s**2, along_m.shape)
        return along_course(parameters[:, :2], np.zeros(along_m.shape), along_m, across_m)


@dataclass(frozen=True, slots=True)
class ConstantTurnRateVelocity(AbstractCoreModel):
    """Follow a circle at constant speed and yaw rate.

    Parameters
    ----------
    acceleration_spread_mps2
        Standard deviation of the unmodelled acceleration along the course [m/s²], for the covariance: a
        displacement spread of ``½·a·t²``.
    yaw_acceleration_spread_radps2
        Standard deviation of the unmodelled yaw acceleration [rad/s²]: ``v·c·t³/6`` across the course.

    Raises
    ------
    ValueError
        Where a spread is out of its range.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.models.base import Windows
    >>> model = ConstantTurnRateVelocity()
    >>> right_turn = np.array([[[0.0, 0.0, 0.0, 10.0, 0.0, np.pi / 2, 0.0]]])
    >>> parameters = model.fit(Windows(right_turn, dt_s=0.1))
    >>> model.predict(parameters, np.array([1.0, 2.0]), dt_s=0.1).round(3) + 0.0
    array([[[ 6.366,  6.366],
            [12.732,  0.   ]]])
    """

    short_name: ClassVar[str] = "ctrv"
    numbers: ClassVar[tuple[str, ...]] = (*_VELOCITY, "yaw_rate_radps")
    functions: ClassVar[tuple[Any, Any]] = (kinematic_kernels.fit_turn, kinematic_kernels.predict_turn)
    _: KW_ONLY
    acceleration_spread_mps2: Annotated[float, SPREAD_MPS2] = 1.0
    yaw_acceleration_spread_radps2: Annotated[float, SPREAD_RADPS2] = 0.1

    def spread_m2(self, parameters: FloatArray, horizons_s: FloatArray) -> FloatArray:
        """Spread of an unmodelled acceleration along the course and yaw acceleration across it."""
        along_m = np.broadcast_to(
            0.5 * self.acceleration_spread_mps2 * horizons_s**2, _shape(parameters, horizons_s)
        )
        across_m = _swerve_m(parameters, horizons_s, self.yaw_acceleration_spread_radps2)
        return along_course(parameters[:, :2], np.outer(parameters[:, 2], horizons_s), along_m, across_m)


@dataclass(frozen=True, slots=True)
class ConstantTurnRateAcceleration(AbstractCoreModel):
    """Turn at constant yaw rate while accelerating along the course; a braking car stops and stays.

    Parameters
    ----------
    jerk_spread_mps3
        Standard deviation of the unmodelled jerk along the course [m/s³], for the covariance: a displacement
        spread of ``j·t³/6``.
    yaw_acceleration_spread_radps2
        Standard deviation of the unmodelled yaw acceleration [rad/s²]: ``v·c·t³/6`` across the course.

    Raises
    ------
    ValueError
        Where a spread is out of its range.

    Notes
    -----
    The closed form of Schubert et al. divides by the yaw rate squared. Here it is written in the turned
    angle, by series where that is under `kinematic_kernels.SERIES_BELOW_RAD`, so that it passes smoothly
    into constant acceleration.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.models.base import Windows
    >>> model = ConstantTurnRateAcceleration()
    >>> window = np.array([[[0.0, 0.0, 0.0, 10.0, -2.0, 0.2, 0.0]]])
    >>> parameters = model.fit(Windows(window, dt_s=0.1))
    >>> model.predict(parameters, np.array([1.0, 5.0, 9.0]), dt_s=0.1).round(3)
    array([[[ 0.864,  8.943],
            [ 7.926, 22.985],
            [ 7.926, 22.985]]])
    """

    short_name: ClassVar[str] = "ctra"
    numbers: ClassVar[tuple[str, ...]] = (*_VELOCITY, "acceleration_mps2", "yaw_rate_radps")
    functions: ClassVar[tuple[Any, Any]] = (
        kinematic_kernels.fit_acceleration_and_turn,
        kinematic_kernels.predict_acceleration_and_turn,
    )
    _: KW_ONLY
    jerk_spread_mps3: Annotated[float, SPREAD_MPS3] = 1.0
    yaw_acceleration_spread_radps2: Annotated[float, SPREAD_RADPS2] = 0.1

    def spread_m2(self, parameters: FloatArray, horizons_s: FloatArray) -> FloatArray:
        """Spread of an unmodelled jerk along the course and yaw acceleration across it."""
        along_m = np.broadcast_to(self.jerk_spread_mps3 * horizons_s**3 / 6.0, _shape(parameters, horizons_s))
        across_m = _swerve_m(parameters, horizons_s, self.yaw_acceleration_spread_radps2)
        return along_course(parameters[:, :2], np.outer(parameters[:, 3], horizons_s), along_m, across_m)


def _shape(parameters: FloatArray, horizons_s: FloatArray) -> tuple[int, int]:
    return parameters.shape[0], horizons_s.size


def _swerve_m(parameters: FloatArray, horizons_s: FloatArray, spread_radps2: float) -> FloatArray:
    """Spread across the course of an unmodelled yaw acceleration at the first speed, (B, H) [m]."""
    speed_mps = np.hypot(parameters[:, 0], parameters[:, 1])
    return np.outer(speed_mps, spread_radps2 * horizons_s**3 / 6.0)


def along_course(
    velocity_mps: FloatArray, turned_rad: FloatArray, along_m: FloatArray, across_m: FloatArray
) -> FloatArray:
    """Covariance with these spreads along and across the chord of the turn, (B, H, 2, 2) [m²].

    The chord of a circle lies half the turned angle off its first course. A car that stands has no course:
    it takes the larger spread on both axes.
    """
    course_rad = np.arctan2(velocity_mps[:, 0], velocity_mps[:, 1])[:, None] + 0.5 * turned_rad
    east, north = np.sin(course_rad), np.cos(course_rad)
    stands = np.hypot(velocity_mps[:, 0], velocity_mps[:, 1])[:, None] <= kinematic_kernels.SLOWEST_MPS
    largest = np.maximum(along_m, across_m)
    along = np.where(stands, largest, along_m) ** 2
    across = np.where(stands, largest, across_m) ** 2
    mixed = (along - across) * east * north
    rows = [along * east**2 + across * north**2, mixed, mixed, along * north**2 + across * east**2]
    return np.stack(rows, axis=-1).reshape(*along.shape, 2, 2)
