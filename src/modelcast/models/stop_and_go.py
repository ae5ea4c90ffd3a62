"""The stop-and-go switch: how people on foot and on bicycles move, told by a plain message.

A person holds a pace, and changes it within a second: to a stand, or from one. What is measured of a person
are positions, whose noise and whose sway at every step hide the velocity. So the sender runs two Kalman
filters of constant velocity over them, a steady one and a quick one. The message states the velocity of the
steady one and, as the acceleration along the course, what the quick one has seen beyond it. A receiver lets
the pace change for a short time at most, never below a stand and, speeding up, never beyond a walking pace.

References
----------
Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with Applications to Tracking and Navigation", Wiley,
2001, section 6.2: the white-noise acceleration filter.
"""

from dataclasses import KW_ONLY, dataclass
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import FieldError, Number, Text, check_fields
from modelcast.models import stop_and_go_kernels as kernels
from modelcast.models.base import AbstractSubModel, PointFunctions, Stream
from modelcast.models.core_model import SPREAD_MPS2
from modelcast.models.payload import CORE_PARAMETERS

__all__ = ["StopAndGo"]

_DENSITY = Number(1e-4, 100.0)
_TIME_S = Number(0.0, 60.0)


@dataclass(frozen=True, slots=True)
class StopAndGo(AbstractSubModel):
    """Hold the steady velocity, and change the pace for a short time where the quick one says so.

    Parameters
    ----------
    steady, quick
        Roots of the spectral densities of the acceleration that the two filters expect, on each axis [m/s²
        over √Hz]; the quick one's is greater.
    gain_per_s
        Acceleration stated for each m/s by which the quick filter is ahead of the steady one along its course
        [1/s].
    least_change_mps2
        A smaller acceleration is not stated [m/s²].
    phase_s
        How long receivers let the pace change [s].
    pace_mps
        Speeding up ends at this speed; a faster person is not taken to speed up [m/s].
    noise_floor_m
        Noise that a position has at the least, of an axis [m]: steps sway a person.
    prior_mps
        Spread of the velocity of a first sample [m/s].
    velocity_noise_mps
        Noise of a velocity that the device reports, of an axis [m/s].
    acceleration_spread_mps2
        Standard deviation of the unmodelled acceleration on each axis [m/s²], for the covariance: a
        displacement spread of ``½·a·t²``.
    label
        Its name.

    Raises
    ------
    ValueError
        Where a number is out of its range, or the quick filter is not quicker than the steady one.

    Notes
    -----
    The filters are state that the station carries from sample to sample. Each has the place and the velocity
    of both axes and one covariance for both, with the measured noise of the positions or the floor. They see
    positions, and the velocity where the device reports one.

    The message is a plain one: velocity and acceleration stand in Part I. Receivers know phase and pace as
    they know the sub-model.

    The defaults were found on half of the tracks of three recordings of people (``docs/people.md``).

    Examples
    --------
    A person who walked at 1.4 m/s and was slower for the last half second:

    >>> from modelcast.models.base import Windows
    >>> speed = np.where(np.arange(60) < 50, 1.4, 1.0)
    >>> window = np.zeros((1, 60, 9))
    >>> window[0, :, 0] = 0.05 * np.cumsum(speed)
    >>> model = StopAndGo()
    >>> parameters = model.fit(Windows(window, dt_s=0.05))
    >>> parameters.round(1).tolist()
    [[1.1, 0.0, -0.3]]
    >>> model.predict(parameters, np.array([1.0, 2.0]), dt_s=0.05).round(1)
    array([[[1. , 0. ],
            [1.8, 0. ]]])
    """

    _: KW_ONLY
    steady: Annotated[float, _DENSITY] = 0.1
    quick: Annotated[float, _DENSITY] = 0.6
    gain_per_s: Annotated[float, Number(0.0, 100.0)] = 2.5
    least_change_mps2: Annotated[float, SPREAD_MPS2] = 0.2
    phase_s: Annotated[float, _TIME_S] = 1.0
    pace_mps: Annotated[float, Number(0.0, 100.0)] = 1.5
    noise_floor_m: Annotated[float, Number(1e-4, 10.0)] = 0.03
    prior_mps: Annotated[float, Number(1e-3, 100.0)] = 1.0
    velocity_noise_mps: Annotated[float, Number(1e-3, 100.0)] = 0.2
    acceleration_spread_mps2: Annotated[float, SPREAD_MPS2] = 0.5
    label: Annotated[str, Text(64)] = "stop-and-go"

    def __post_init__(self) -> None:
        check_fields(self)
        if not self.quick > self.steady:
            raise FieldError("quick", self.quick, f"more than steady, {self.steady:g}")

    @property
    def name(self) -> str:
        """The label."""
        return self.label

    @property
    def window(self) -> int:
        """One sample: what was before it is in the filters."""
        return 1

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Velocity, and acceleration along the course."""
        return CORE_PARAMETERS[:3]

    @property
    def payload_parameters(self) -> int:
        """None: Part I has them all."""
        return 0

    @property
    def states_own_values(self) -> bool:
        """Part I says what the filters found."""
        return True

    def point_functions(self, dt_s: float) -> PointFunctions:
        """Return the filters and the prediction."""
        own = (self.steady, self.quick, self.noise_floor_m, self.prior_mps, self.gain_per_s)
        told = (self.least_change_mps2, self.phase_s, self.pace_mps, self.velocity_noise_mps)
        constants = np.array([0.0, dt_s, *own, *told])
        stream = Stream(kernels.observe, columns=kernels.STATE, at=kernels.AT_COLUMN)
        return PointFunctions(kernels.fit, kernels.predict, constants, stream=stream)

    def covariance(
        self,
        parameters: FloatArray,
        horizons_s: FloatArray,
        *,
        dt_s: float,  # noqa: ARG002 - no table depends on it
    ) -> FloatArray:
        """Spread of an unmodelled constant acceleration, (B, H, 2, 2) [m²]."""
        parameters = self.checked(parameters)
        spread_m = 0.5 * self.acceleration_spread_mps2 * np.asarray(horizons_s, dtype=np.float64) ** 2
        one = spread_m[:, None, None] ** 2 * np.eye(2)
        return np.broadcast_to(one, (parameters.shape[0], *one.shape)).copy()
