"""Gaussian processes in the vehicle's frame, with given hyper-parameters for along and across the course.

The window is turned into the course of its newest velocity. There, the process along the course and the one
across it have hyper-parameters of their own, and measured velocities may count beside positions. With given
hyper-parameters the prediction is a constant matrix times the window, one matrix for each noise level; the
window's own position noise chooses the level. What is sent is not the n weights of the process, but the few
coefficients of a polynomial that its predicted path follows over the next seconds.
"""

import functools
from dataclasses import KW_ONLY, dataclass, field
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.rules import Flag, Number, One, Text, Whole, check_fields
from modelcast.models.base import AbstractSubModel, PointFunctions
from modelcast.models.gp import vehicle_kernels as kernels
from modelcast.models.gp.conditional import AxisKernel, Conditional, condition_on
from modelcast.models.gp.time_grid import WINDOW_BOUNDS, TimeGrid
from modelcast.models.payload import PayloadField, PayloadLayout

__all__ = [
    "NOISE_LEVELS_M",
    "VehicleProcess",
    "linear_process",
    "measured",
    "noise_level",
    "noise_levels_m",
]

NOISE_LEVELS_M = (5e-4, 0.5)
"""Finest and coarsest position noise that a process is made ready for [m]."""

_LEVELS = 8
UNKNOWN_NOISE_M = 0.01
"""Taken where a window does not know its noise [m]."""
_GRID = 41
_AXIS = One((AxisKernel,), "the kernel of an axis")


@dataclass(frozen=True, slots=True)
class VehicleProcess(AbstractSubModel):
    """Gaussian process along and across the course, with given hyper-parameters.

    Parameters
    ----------
    label
        Name of the sub-model, as in tables and on the command line.
    along, across
        Hyper-parameters of the two axes.
    samples
        Window length n, 3 to 60.
    velocities
        Whether the window's velocities are measurements too (as derivatives of the process).
    degree
        Degree of the polynomial that is sent, 1 to 6.
    straight_after_s
        Time over which it follows the process [s]; from there on the path is straight at the last velocity.

    Raises
    ------
    ValueError
        Where a field is outside its bounds.

    Notes
    -----
    A vehicle whose predicted speed along its course falls to zero within the polynomial stops there and
    stays. A vehicle without a velocity has no course: its axes are east and north.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.models.base import Windows
    >>> t = np.arange(-9, 1) * 0.1
    >>> velocity = [10 * np.cos(t), -10 * np.sin(t)]
    >>> turn = np.stack([10 * np.sin(t), 10 * np.cos(t), *velocity, 0 * t, 1 + 0 * t, 0.001 + 0 * t], axis=1)
    >>> axis = AxisKernel(4.0, 100.0)
    >>> model = VehicleProcess("gp-vehicle", axis, across=axis)
    >>> parameters = model.fit(Windows(turn[None], dt_s=0.1))
    >>> model.predict(parameters, np.array([0.5]), dt_s=0.1).round(1)
    array([[[ 4.8, -1.3]]])
    """

    label: Annotated[str, Text(64)]
    along: Annotated[AxisKernel, _AXIS] = field(default_factory=AxisKernel)
    _: KW_ONLY
    across: Annotated[AxisKernel, _AXIS] = field(default_factory=AxisKernel)
    samples: Annotated[int, Whole(*WINDOW_BOUNDS)] = 10
    velocities: Annotated[bool, Flag()] = False
    degree: Annotated[int, Whole(1, 6)] = 4
    straight_after_s: Annotated[float, Number(0.1, 60.0)] = 3.0

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def name(self) -> str:
        """The label."""
        return self.label

    @property
    def window(self) -> int:
        """Window length n."""
        return self.samples

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Coefficients of the polynomial in time over its span, its end, and the noise level."""
        names = [f"coefficient_{i}_{axis}_m" for axis in ("east", "north") for i in range(self.degree + 1)]
        return (*names, "end_s", "noise_level")

    @property
    def payload_parameters(self) -> int:
        """All."""
        return len(self.parameter_names)

    @property
    def payload_layout(self) -> PayloadLayout:
        """The polynomial's coefficients; its end in 128ths of its span; the noise level."""
        sizes = [(0.05, 7), (0.1, 14)] + [(0.1, 12)] * (self.degree - 1)
        fields = [
            PayloadField(f"coefficient_{i}_{axis}_m", step, bits=bits)
            for axis in ("east", "north")
            for i, (step, bits) in enumerate(sizes)
        ]
        end = PayloadField("end_s", self.straight_after_s / 128, bits=8, signed=False)
        level = PayloadField("noise_level", 1.0, bits=(_LEVELS - 1).bit_length(), signed=False)
        return PayloadLayout((*fields, end, level))

    def point_functions(self, dt_s: float) -> PointFunctions:
        """Return the compiled functions and matrices; the interval counts to the microsecond."""
        return PointFunctions(kernels.fit, kernels.predict, _constants(self, round(dt_s, 6)))

    def covariance(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Covariance of the noise-free position of the process, by the noise level that was in use.

        Along and across are turned by the course at the polynomial's beginning. The polynomial's own distance
        from the process is not in it.
        """
        horizons_s = np.asarray(horizons_s, dtype=np.float64)
        tables = [_conditionals(self, round(dt_s, 6), noise_m, horizons_s) for noise_m in noise_levels_m()]
        level = parameters[:, -1].astype(np.int64)
        along, across = (np.stack([pair[axis].variance_m2 for pair in tables])[level] for axis in range(2))
        east, north = parameters[:, 1], parameters[:, self.degree + 2]
        speed = np.hypot(east, north)
        stands = speed == 0.0
        ahead_east = np.where(stands, 1.0, east / np.where(stands, 1.0, speed))[:, None]
        ahead_north = np.where(stands, 0.0, north / np.where(stands, 1.0, speed))[:, None]
        mixed = (along - across) * ahead_east * ahead_north
        rows = [
            along * ahead_east**2 + across * ahead_north**2,
            mixed,
            mixed,
            along * ahead_north**2 + across * ahead_east**2,
        ]
        return np.stack(rows, axis=-1).reshape(*along.shape, 2, 2)


def linear_process(samples: int = 10) -> VehicleProcess:
    """The linear kernel alone, ``gp-linear``: Bayesian linear regression of position on time.

    Two parameters an axis, intercept and slope, as in the predecessor of the hybrid system.

    Parameters
    ----------
    samples
        Window length n.
    """
    line = AxisKernel(deviation_m=0.0)
    return VehicleProcess("gp-linear", line, across=line, samples=samples, degree=1)


def noise_levels_m() -> FloatArray:
    """Return the position noise of every level, evenly spaced in the logarithm, (L,) [m]."""
    return np.geomspace(*NOISE_LEVELS_M, _LEVELS)


def noise_level(noise_m: FloatArray) -> IntArray:
    """Return the index of the level nearest to each position noise, (B,); 1 cm where it is not known.

    Parameters
    ----------
    noise_m
        Standard deviation on an axis, (B,) [m]; 0 where it is not known.
    """
    levels = noise_levels_m()
    known = np.where(noise_m > 0.0, noise_m, UNKNOWN_NOISE_M)
    nearest = np.floor(np.log(known / levels[0]) / np.log(levels[1] / levels[0]) + 0.5)
    return np.clip(nearest, 0, levels.size - 1).astype(np.int64)


def measured(samples: FloatArray, *, velocities: bool) -> FloatArray:
    """Return windows along and across the course of their newest velocity, (B, 2, n or 2n) [m, m/s].

    Parameters
    ----------
    samples
        Windows, (B, n, 9).
    velocities
        Whether velocities follow the positions.
    """
    east, north = samples[:, -1, 2, None], samples[:, -1, 3, None]
    speed = np.hypot(east, north)
    ahead_east = np.where(speed > 0.0, east / np.where(speed > 0.0, speed, 1.0), 1.0)
    ahead_north = np.where(speed > 0.0, north / np.where(speed > 0.0, speed, 1.0), 0.0)
    one, other = (samples[:, :, axis] - samples[:, -1:, axis] for axis in range(2))
    if velocities:
        one, other = (np.concatenate([a, samples[:, :, b]], axis=1) for a, b in ((one, 2), (other, 3)))
    along = ahead_east * one + ahead_north * other
    across = ahead_east * other - ahead_north * one
    return np.stack([along, across], axis=1)


def _conditionals(
    model: VehicleProcess, dt_s: float, noise_m: float, horizons_s: FloatArray
) -> tuple[Conditional, Conditional]:
    """Both axes' processes given a window with this position noise."""
    along, across = (
        condition_on(
            axis,
            TimeGrid(model.samples, dt_s).times_s,
            horizons_s,
            position_noise_m=noise_m,
            velocities=model.velocities,
        )
        for axis in (model.along, model.across)
    )
    return along, across


@functools.lru_cache(maxsize=32)
def _constants(model: VehicleProcess, dt_s: float) -> FloatArray:
    levels = noise_levels_m()
    step = float(np.log(levels[1] / levels[0]))
    share = np.linspace(0.0, 1.0, _GRID)
    project = np.linalg.pinv(np.vander(share, model.degree + 1, increasing=True))
    header = np.zeros(kernels.HEADER)
    header[kernels.AT_SAMPLES] = model.samples
    header[kernels.AT_MEASUREMENTS] = model.samples * (1 + model.velocities)
    header[kernels.AT_COEFFICIENTS] = model.degree + 1
    header[kernels.AT_LEVELS] = levels.size
    header[kernels.AT_STRAIGHT_AFTER] = model.straight_after_s
    header[kernels.AT_LOG_FINEST] = np.log(levels[0])
    header[kernels.AT_LOG_STEP] = step
    header[kernels.AT_UNKNOWN] = noise_level(np.zeros(1))[0]
    matrices = [
        (project @ axis.weights).ravel()
        for noise_m in levels
        for axis in _conditionals(model, dt_s, float(noise_m), share * model.straight_after_s)
    ]
    return np.concatenate([header, *matrices])
