"""A sub-model that is sent as its predicted path: a few coefficients, whatever the model inside needs.

The weights of a Gaussian process belong to the samples of its window, and its hyper-parameters may be those
of one window alone; a receiver needs neither. The predicted path is smooth. So the sender fits the model,
looks where it predicts the vehicle over the next seconds, and sends the polynomial that follows best what
this path has beyond constant velocity, which Part I of the message carries already. Sender and receiver both
predict by the polynomial.
"""

import functools
from dataclasses import KW_ONLY, dataclass, replace
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import Each, Number, One, check_fields
from modelcast.models import predicted_path_kernels as kernels
from modelcast.models.address_kernels import TRACK_TYPES
from modelcast.models.base import AbstractSubModel, PointCall, PointFunctions
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.payload import CORE_PARAMETERS, STEP_AND_BITS, PayloadField, PayloadLayout
from modelcast.models.trusted import Trusted
from modelcast.models.wrapped import AbstractWrapped

__all__ = ["DEFAULT_CARRIED", "DEFAULT_SPAN_S", "PredictedPath", "carried_form", "carried_layout"]

DEFAULT_CARRIED = ((0.05, 5), (0.1, 8), (0.2, 10), (0.2, 9))
"""Step [m] and bits of the coefficients of each power (decision 018)."""

DEFAULT_SPAN_S = 4.0
"""Time over which a path is followed [s] (decision 018)."""

_INSTANTS_PER_S = 8
_WEIGHT_SHARE = 0.2
_MOST_POWERS = 7


@dataclass(frozen=True, slots=True)
class PredictedPath(AbstractWrapped):
    """A sub-model's predicted path as a polynomial in time, beside constant velocity.

    Parameters
    ----------
    model
        The sub-model, which only the sender runs; the name and the window are its.
    span_s
        Time over which it follows the model's path [s]; from there on the path is straight at the last
        velocity.
    carried
        Step [m] and bits with which messages carry the coefficients of each power, from 0 on; 2 to 7 powers.

    Raises
    ------
    ValueError
        Where a field is outside its bounds, or the model has a trusted horizon, which goes round the path,
        or is a path itself.

    Notes
    -----
    The displacement is ``v·h + Σ c_i (h/T)^i`` on each axis, with the newest velocity v of the window and the
    span T. The coefficients are least squares over instants evenly spaced from 0 to T, an error at h weighted
    by ``1 / (0.2 + h/T)``: a message has to be right early to last.

    The covariance is the spread of an unmodelled jerk and yaw acceleration, as of
    `ConstantTurnRateAcceleration`: no message holds the hyper-parameters that the model's own needs.
    Calibration makes it honest.

    Examples
    --------
    >>> from modelcast.models.base import Windows
    >>> from modelcast.models.gp import GaussianProcess
    >>> t = np.arange(-9, 1) * 0.1
    >>> velocity = [10 * np.cos(0.3 * t), -10 * np.sin(0.3 * t)]
    >>> position = [33.3 * np.sin(0.3 * t), 33.3 * np.cos(0.3 * t)]
    >>> turn = np.stack([*position, *velocity, 0 * t, 0.3 + 0 * t, 0 * t], axis=1)
    >>> windows = Windows(turn[None], dt_s=0.1)
    >>> process = GaussianProcess(form="intercept")
    >>> sent = PredictedPath(process)
    >>> len(process.parameter_names), sent.payload_parameters
    (29, 8)
    >>> horizon_s = np.array([0.5])
    >>> [m.predict(m.fit(windows), horizon_s, dt_s=0.1)[0, 0].round(1).tolist() for m in (process, sent)]
    [[5.0, -0.4], [5.0, -0.4]]
    """

    _: KW_ONLY
    span_s: Annotated[float, Number(0.1, 60.0)] = DEFAULT_SPAN_S
    carried: Annotated[tuple[tuple[float, int], ...], Each(STEP_AND_BITS, 2, _MOST_POWERS)] = DEFAULT_CARRIED

    def __post_init__(self) -> None:
        check_fields(self)
        found = One((AbstractSubModel,), "a sub-model that is no path yet", but=(PredictedPath,)).fault(
            self.model
        )
        if found is not None:
            raise found.below("model")
        if np.isfinite(self.model.trusted_horizon_s):
            raise ValueError(f"{self.model.name} has a trusted horizon: it goes round the path, not inside")

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Velocity; then the coefficients east and north, lowest power first."""
        return (*CORE_PARAMETERS[:2], *self._coefficient_names)

    @property
    def payload_parameters(self) -> int:
        """The coefficients."""
        return 2 * len(self.carried)

    @property
    def payload_layout(self) -> PayloadLayout:
        """The coefficients."""
        fields = zip(self._coefficient_names, 2 * self.carried, strict=True)
        return PayloadLayout(tuple(PayloadField(name, step, bits=bits) for name, (step, bits) in fields))

    @property
    def _coefficient_names(self) -> tuple[str, ...]:
        return tuple(f"{axis}_{power}_m" for axis in ("east", "north") for power in range(len(self.carried)))

    def point_functions(self, dt_s: float) -> PointFunctions:
        """Return the functions round the model's, made once for an interval."""
        return _point_functions(self, dt_s)

    def covariance(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Spread of the kinematic model."""
        kinematic = ConstantTurnRateAcceleration()
        own = np.zeros((parameters.shape[0], len(kinematic.parameter_names)))
        own[:, :2] = parameters[:, :2]
        return kinematic.covariance(own, np.asarray(horizons_s, dtype=np.float64), dt_s=dt_s)


def carried_form(model: AbstractSubModel) -> AbstractSubModel:
    """The sub-model as messages carry it: itself where it has a layout, else its predicted path.

    Parameters
    ----------
    model
        Any sub-model.

    Examples
    --------
    >>> from modelcast.models.gp import GaussianProcess
    >>> carried_form(Trusted(GaussianProcess(), 2.0)).payload_layout.bits
    64
    >>> carried_form(ConstantTurnRateAcceleration()) == ConstantTurnRateAcceleration()
    True
    """
    if model.payload_layout is not None:
        return model
    path = _path_of(model)
    return replace(model, model=path) if isinstance(model, Trusted) else path


def carried_layout(model: AbstractSubModel) -> PayloadLayout:
    """Layout of a sub-model as messages carry it.

    Parameters
    ----------
    model
        Any sub-model.
    """
    own = model.payload_layout
    return _path_of(model).payload_layout if own is None else own


def _path_of(model: AbstractSubModel) -> PredictedPath:
    """The path of a model, without a trusted horizon round it."""
    return PredictedPath(model.model if isinstance(model, Trusted) else model)


@functools.lru_cache(maxsize=32)
def _point_functions(path: PredictedPath, dt_s: float) -> PointFunctions:
    ready = path.model.point_functions(dt_s)
    count = len(path.carried)
    instants = max(round(_INSTANTS_PER_S * path.span_s), 2 * count) + 1
    share = np.linspace(0.0, 1.0, instants)
    weights = 1.0 / (_WEIGHT_SHARE + share)
    powers = weights[:, None] * np.vander(share, count, increasing=True)
    header = np.zeros(kernels.HEADER)
    header[kernels.AT_COUNT] = len(path.model.parameter_names)
    header[kernels.AT_COEFFICIENTS] = count
    header[kernels.AT_NODES] = instants
    header[kernels.AT_SPAN] = path.span_s
    header[kernels.AT_TRACK] = kernels.NO_TRACK
    project = (np.linalg.pinv(powers) * weights).astype(np.float64).ravel()
    before = np.concatenate([header, project])
    calls = ready.called_from(before.size, kernels.AT_FIT, kernels.AT_PREDICT)
    if ready.track is not None:
        calls = (*calls, PointCall(kernels.AT_TRACK, ready.track, TRACK_TYPES))
    constants = np.concatenate([before, ready.constants])
    return PointFunctions(
        kernels.fit,
        kernels.predict,
        constants,
        calls,
        stream=ready.streamed_from(before.size),
        context_at=ready.context_from(before.size),
    )
