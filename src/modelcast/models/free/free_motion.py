"""The free sub-model: what a plain message says, coasted by constant turn rate and acceleration."""

from dataclasses import KW_ONLY, dataclass, field
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import Each, FieldError, Number, One, Text, check_fields
from modelcast.models import kinematic_kernels
from modelcast.models.base import AbstractSubModel, PointFunctions
from modelcast.models.free import free_kernels
from modelcast.models.free.estimates import Estimates, levels_of
from modelcast.models.free.limits import Limits
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.learned.features import FeatureMap
from modelcast.models.learned.learned_kernels import CONTEXT_AT
from modelcast.models.learned.learned_trajectory import feature_constants, require_sizes
from modelcast.models.learned.perceptron import Perceptron
from modelcast.models.trusted import LONGEST_TIME_S, SHORTEST_HORIZON_S, Trusted

__all__ = ["FreeMotion"]

_KINEMATIC = ConstantTurnRateAcceleration()


@dataclass(frozen=True, slots=True)
class FreeMotion(AbstractSubModel):
    """Part I, estimated by windows that the vehicle's noise chooses, and moved by a network within limits.

    Parameters
    ----------
    estimates
        The first whose ``up_to_noise_m`` reaches the window's position noise, and all of whose ``reports``
        the vehicle reports, serves; the last serves all others.
    networks
        By rising noise likewise; none for the estimates as they are. A network's outputs are speed, angle of
        the course to the left, acceleration and yaw rate to the left, each in units of its limit and squashed
        by the hyperbolic tangent.
    limits
        How far a network may move an estimate; all 0 for not at all.
    features
        Inputs of the networks, with the polynomials of all estimates among them.
    horizon_s, turn_s
        Trusted horizon, and how long the vehicle goes on turning beyond it [s]: part of what a plain message
        means to its receivers.
    label
        Its name, where a bank holds several.

    Raises
    ------
    ValueError
        Where the networks' noises do not rise, a network has other inputs or outputs, or the map lacks an
        estimate.

    Notes
    -----
    A receiver needs neither windows nor networks. It predicts as `ConstantTurnRateAcceleration` does up to
    the trusted horizon; then the speed holds and the turn ends. So all free motions with the same horizons
    are one sub-model to a receiver, and a plain message says which values, not who chose them.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.models.base import Windows
    >>> from modelcast.models.free.estimates import map_of
    >>> steady = Estimates(np.inf, acceleration=("position", 10, 2), yaw_rate=("position", 10, 2))
    >>> model = FreeMotion((steady,), features=map_of((steady,), 10))
    >>> t = np.arange(-10, 1) * 0.1
    >>> window = np.zeros((1, 11, 7))
    >>> window[0, :, 0], window[0, :, 2] = 10.0 * t + t**2, 10.0 + 2.0 * t
    >>> model.fit(Windows(window, dt_s=0.1)).round(6)
    array([[10.,  0.,  2., -0.]])
    >>> model.payload_layout.bits
    0
    """

    estimates: Annotated[tuple[Estimates, ...], Each(One((Estimates,), "estimates"), 1, 64)]
    networks: Annotated[tuple[Perceptron, ...], Each(One((Perceptron,), "a network"), 0, 16)] = ()
    _: KW_ONLY
    limits: Annotated[Limits, One((Limits,), "limits")] = field(default_factory=Limits)
    features: Annotated[FeatureMap, One((FeatureMap,), "a map of inputs")]
    horizon_s: Annotated[float, Number(SHORTEST_HORIZON_S, LONGEST_TIME_S, infinite=True)] = 1.5
    turn_s: Annotated[float, Number(0.0, LONGEST_TIME_S, infinite=True)] = 1.0
    label: Annotated[str, Text(64)] = "free"

    def __post_init__(self) -> None:
        check_fields(self)
        edges = [network.up_to_noise_m for network in self.networks]
        if sorted(set(edges)) != edges:
            raise FieldError("networks", edges, "networks whose up_to_noise_m rise")
        require_sizes(self.networks, inputs=self.features.inputs, outputs=free_kernels.VALUES)
        for at, one in enumerate(self.estimates):
            try:
                one.places(self.features)
            except ValueError as error:
                raise FieldError(f"estimates[{at}]", one, f"polynomials of the map ({error})") from None

    @property
    def name(self) -> str:
        """The label."""
        return self.label

    @property
    def window(self) -> int:
        """Samples that span the lags at 10 Hz."""
        return self.features.lags + 1

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Velocity, acceleration and yaw rate."""
        return _KINEMATIC.parameter_names

    @property
    def payload_parameters(self) -> int:
        """None: Part I has them all."""
        return 0

    @property
    def trusted_horizon_s(self) -> float:
        """As given."""
        return self.horizon_s

    @property
    def trusted_turn_s(self) -> float:
        """As given."""
        return self.turn_s

    @property
    def states_own_values(self) -> bool:
        """Part I says what this sub-model's estimates and networks chose."""
        return True

    @property
    def starter(self) -> AbstractSubModel:
        """Constant turn rate and acceleration of the newest sample, with the same horizons."""
        return Trusted(_KINEMATIC, self.horizon_s, self.turn_s)

    @property
    def predicts_by_parameters(self) -> bool:
        """Windows, networks and limits are the sender's affair."""
        return True

    def point_functions(self, dt_s: float) -> PointFunctions:
        """Return the compiled functions, the places of the estimates and all weights."""
        levels = levels_of(self.estimates, self.features)
        constants = np.concatenate(
            [
                feature_constants(self.features, dt_s, networks=len(self.networks)),
                [len(self.estimates)],
                levels,
                self.limits.values,
                *(network.packed() for network in self.networks),
            ]
        )
        return PointFunctions(
            free_kernels.fit,
            kinematic_kernels.predict_acceleration_and_turn,
            constants,
            context_at=CONTEXT_AT if self.features.context else None,
        )

    def covariance(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Spread of constant turn rate and acceleration; calibration makes it honest."""
        return _KINEMATIC.covariance(parameters, np.asarray(horizons_s, dtype=np.float64), dt_s=dt_s)
