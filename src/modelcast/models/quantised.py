"""A sub-model as its receiver holds it: what its fit returns has gone through the codes of the wire.

The sender measures its error on the decoded copy of what it sent. So quantisation belongs to the fit, and
policy, walk, replay and host need not know of it: they fit and predict as ever. The steps of Part I are
arguments, since models know no messages; `modelcast.messages.quantisation` has those of SAE J2735.
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models import quantised_kernels as kernels
from modelcast.models.base import PointFunctions
from modelcast.models.payload import CORE_PARAMETERS
from modelcast.models.wrapped import AbstractWrapped

__all__ = ["REMAINDERS", "CoreSteps", "Quantised"]

REMAINDERS = ("remainder_east_m", "remainder_north_m")
"""What the position that was sent is off from the window's last sample: no payload."""


@dataclass(frozen=True, slots=True)
class CoreSteps:
    """Steps of the fields of Part I that a prediction is made of.

    Parameters
    ----------
    speed_mps, acceleration_mps2, heading_rad, yaw_rate_radps
        Steps [m/s], [m/s²], [rad], [rad/s].
    last_speed, last_acceleration, last_yaw_rate
        Highest codes; those of acceleration and yaw rate hold for both signs.
    position_m
        Step of the position on each axis [m]; 0 for none.

    Raises
    ------
    ValueError
        Where a step or a code is out of its range.
    """

    speed_mps: float
    acceleration_mps2: float
    _: KW_ONLY
    heading_rad: float
    yaw_rate_radps: float
    last_speed: int
    last_acceleration: int
    last_yaw_rate: int
    position_m: float

    def __post_init__(self) -> None:
        for name in ("speed_mps", "acceleration_mps2", "heading_rad", "yaw_rate_radps"):
            step: float = getattr(self, name)
            if not (np.isfinite(step) and step > 0.0):
                raise ValueError(f"{name} must be positive and finite, got {step}")
        for name in ("last_speed", "last_acceleration", "last_yaw_rate"):
            if not getattr(self, name) >= 1:
                raise ValueError(f"{name} must be at least 1, got {getattr(self, name)}")
        if not (np.isfinite(self.position_m) and self.position_m >= 0.0):
            raise ValueError(f"position_m must be 0 or positive, and finite, got {self.position_m}")


@dataclass(frozen=True, slots=True)
class Quantised(AbstractWrapped):
    """A sub-model with quantised parameters, that predicts from the position that was sent.

    Parameters
    ----------
    model
        The sub-model; its name, payload and trusted horizon stay as they are.
    steps
        Those of Part I.

    Raises
    ------
    ValueError
        Where the model is quantised already, has no layout, or has a velocity of one axis alone.

    Notes
    -----
    Two parameters more than the model's: `REMAINDERS`. A position is sent on a grid, so the prediction begins
    up to half a step beside the last sample on each axis. A receiver has the sent position itself and a
    remainder of zero. A model without a layout, as a Gaussian process with its weights, is wrapped in its
    predicted path first (`modelcast.models.predicted_path`).

    Examples
    --------
    >>> from modelcast.models.base import Windows
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> coarse = CoreSteps(
    ...     0.5,
    ...     0.1,
    ...     heading_rad=np.pi / 2,
    ...     yaw_rate_radps=0.1,
    ...     last_speed=100,
    ...     last_acceleration=200,
    ...     last_yaw_rate=10,
    ...     position_m=1.0,
    ... )
    >>> model = Quantised(ConstantVelocity(), coarse)
    >>> window = np.array([[[7.25, 3.0, 10.2, 1.0, 0.0, 0.0, 0.0]]])
    >>> parameters = model.fit(Windows(window, dt_s=0.1))
    >>> parameters.round(6) + 0.0
    array([[10.  ,  0.  , -0.25,  0.  ]])
    >>> model.predict(parameters, np.array([1.0]), dt_s=0.1).round(6)
    array([[[9.75, 0.  ]]])
    """

    steps: CoreSteps

    def __post_init__(self) -> None:
        if isinstance(self.model, Quantised):
            raise ValueError(f"{self.model.name} is quantised already")  # noqa: TRY004 - a value, not a type
        if self.model.payload_layout is None:
            raise ValueError(f"{self.model.name} has no payload layout: wrap it in a PredictedPath first")
        names = self.model.parameter_names
        east, north = (names.index(name) if name in names else -1 for name in CORE_PARAMETERS[:2])
        if (east < 0) != (north < 0) or (east >= 0 and north != east + 1):
            raise ValueError(f"{self.model.name}: velocity must be east, then north, got {', '.join(names)}")

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """The model's, then `REMAINDERS`."""
        return (*self.model.parameter_names, *REMAINDERS)

    def point_functions(self, dt_s: float) -> PointFunctions:
        """Return the functions round the model's."""
        ready = self.model.point_functions(dt_s)
        names = self.model.parameter_names
        header = np.zeros(kernels.HEADER)
        header[kernels.AT_COUNT] = len(names)
        velocity = CORE_PARAMETERS[0]
        header[kernels.AT_VELOCITY] = names.index(velocity) if velocity in names else -1
        header[kernels.AT_SPEED] = self.steps.speed_mps
        header[kernels.AT_FASTEST] = self.steps.last_speed
        header[kernels.AT_HEADING] = self.steps.heading_rad
        header[kernels.AT_POSITION] = self.steps.position_m
        rows = [row for name in names for row in self._row(name)]
        before = np.concatenate([header, np.array(rows)])
        calls = ready.called_from(before.size, kernels.AT_FIT, kernels.AT_PREDICT)
        return PointFunctions(kernels.fit, kernels.predict, np.concatenate([before, ready.constants]), calls)

    def _row(self, name: str) -> tuple[float, float, float]:
        """Step, lowest and highest code of a parameter; step 0 where it has none of its own."""
        steps, layout = self.steps, self.payload_layout
        if name == "acceleration_mps2":
            return steps.acceleration_mps2, -float(steps.last_acceleration), float(steps.last_acceleration)
        if name == "yaw_rate_radps":
            return steps.yaw_rate_radps, -float(steps.last_yaw_rate), float(steps.last_yaw_rate)
        if layout is not None and name in layout.names:
            step, low, high = layout.table[layout.names.index(name)].tolist()
            return step, low, high
        return 0.0, 0.0, 0.0

    def covariance(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Return the model's covariance, and what rounding the position adds on each axis."""
        own = parameters[:, : len(self.model.parameter_names)]
        rounded = self.steps.position_m**2 / 12.0 * np.eye(2)
        return self.model.covariance(own, np.asarray(horizons_s), dt_s=dt_s) + rounded
