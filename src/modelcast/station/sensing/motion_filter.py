"""A vehicle's own estimate of its motion: a causal Kalman filter over what its sensors show.

A basic safety message states the newest sample, with the sample's noise. A sender of models knows more: the
position of a centimetre's noise, seen ten times a second, tells its speed and course better than speed and
course are measured. The filter puts them together: position, velocity and acceleration on the ground, white
jerk along the course and across it, every column of a sample a measurement with a noise of its own.

It is the "local position estimate" of SAE J2945/1's tracking error, and the newest sample of the models.
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray

__all__ = ["HEADING_HOLD_MPS", "MotionFilter"]

HEADING_HOLD_MPS = 0.5
"""Under this speed a receiver holds its heading: the course of a slower antenna is noise."""


@dataclass(frozen=True, slots=True)
class MotionFilter:
    """Errors that a vehicle takes its sensors to have, and how unsteadily it takes itself to drive.

    `motion_filter_kernels.follow` filters by them.

    Parameters
    ----------
    position_m, speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps
        Standard deviations of the white noise of a sample [m], [m/s], [rad], [m/s²], [rad/s]; the defaults
        are those of `modelcast.world.sensors.SensorModel`.
    jerk_along, jerk_across
        Root of the spectral density of the jerk along the course and across it [m/s³ over √Hz].
    jump_ratio
        A position farther from the expected one than so many standard deviations is taken for a jump of the
        receiver, as recorded ones show: the place is followed at once, speed and course are kept.

    Raises
    ------
    ValueError
        Where a value is not positive.

    Examples
    --------
    >>> MotionFilter(0.02).constants()[:2].tolist()
    [0.02, 0.05]
    """

    position_m: float = 0.01
    speed_mps: float = 0.05
    _: KW_ONLY
    heading_rad: float = 0.2 * np.pi / 180.0
    acceleration_mps2: float = 0.05
    yaw_rate_radps: float = 0.1 * np.pi / 180.0
    jerk_along: float = 1.0
    jerk_across: float = 1.0
    jump_ratio: float = 4.0

    def __post_init__(self) -> None:
        for name in self.__slots__:
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise ValueError(f"{name} must be positive and finite, got {getattr(self, name)}")

    def constants(self) -> FloatArray:
        """Return the constants as the compiled filter takes them, (8,)."""
        return np.array([getattr(self, name) for name in self.__slots__])
