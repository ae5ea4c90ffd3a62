"""The learned sub-model."""

from dataclasses import KW_ONLY, dataclass
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import Each, FieldError, Fixed, Number, One, Text, Whole, check_fields
from modelcast.models.base import AbstractSubModel, PointFunctions
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.learned import learned_kernels
from modelcast.models.learned.features import LAGS, FeatureMap
from modelcast.models.learned.perceptron import Perceptron
from modelcast.models.payload import STEP_AND_BITS, PayloadField, PayloadLayout
from modelcast.models.trusted import LONGEST_TIME_S, SHORTEST_HORIZON_S

__all__ = ["DEFAULT_CARRIED", "LearnedTrajectory", "feature_constants", "require_sizes"]

DEFAULT_CARRIED = ((0.05, 6), (0.4, 8))
"""Step [m] and bits of the coefficients of power 0, and of all higher ones (decision 018)."""


@dataclass(frozen=True, slots=True)
class LearnedTrajectory(AbstractSubModel):
    """Constant turn rate and acceleration, corrected by what a network reads from the window.

    Parameters
    ----------
    networks
        Networks by rising noise: the first whose ``up_to_noise_m`` reaches the window's position noise
        serves, the last serves all others.
    coefficients
        Coefficients of the correction on each axis, k >= 1.
    time_scale_s
        The time the networks were trained to predict [s]: powers of ``t / time_scale_s``.
    lags
        How many tenths of a second the networks look back.
    horizon_s, turn_s
        Trusted horizon, and how long the car goes on turning beyond it [s].
    label
        Its name, where a bank holds several.
    carried
        Step [m] and bits with which messages carry the coefficients of power 0, and all higher ones.

    Raises
    ------
    ValueError
        Where a network does not fit the inputs or the coefficients, or the noises do not rise.

    Notes
    -----
    With course angle and speed v from the newest velocity, acceleration a and yaw rate ω, the displacement is
    that of `ConstantTurnRateAcceleration` plus ``Σ c_j (t/T)^j`` along the first course and ``Σ d_j (t/T)^j``
    to the left of it. The 2k coefficients are the payload: velocity, acceleration and yaw rate stand in the
    core message already. The network runs at the sender only.

    A window is `samples` long whatever the interval. Where it spans less than ``lags`` tenths of a second
    (an interval under 0.1 s), the correction is zero.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.models.base import Windows
    >>> from modelcast.models.learned import FeatureMap, Perceptron
    >>> inputs = FeatureMap(20).inputs
    >>> silent = Perceptron(
    ...     np.inf,
    ...     centre=np.zeros(inputs),
    ...     width=np.ones(inputs),
    ...     weights_1=np.zeros((inputs, 4)),
    ...     bias_1=np.zeros(4),
    ...     weights_2=np.zeros((4, 4)),
    ...     bias_2=np.zeros(4),
    ...     weights_3=np.zeros((4, 4)),
    ...     bias_3=np.array([0.0, 1.0, 0.0, 0.5]),
    ... )
    >>> model = LearnedTrajectory((silent,), coefficients=2)
    >>> window = np.zeros((1, 21, 7))
    >>> window[0, :, 0] = 10.0 * np.arange(-20, 1) * 0.1
    >>> window[0, :, 2] = 10.0
    >>> parameters = model.fit(Windows(window, dt_s=0.1))
    >>> model.predict(parameters, np.array([1.0]), dt_s=0.1).round(3)
    array([[[10.2,  0.1]]])
    """

    networks: Annotated[tuple[Perceptron, ...], Each(One((Perceptron,), "a network"), 1, 16)]
    coefficients: Annotated[int, Whole(1, 8)] = 4
    _: KW_ONLY
    time_scale_s: Annotated[float, Number(0.1, 60.0)] = 5.0
    lags: Annotated[int, LAGS] = 20
    horizon_s: Annotated[float, Number(SHORTEST_HORIZON_S, LONGEST_TIME_S, infinite=True)] = 3.0
    turn_s: Annotated[float, Number(0.0, LONGEST_TIME_S, infinite=True)] = 2.0
    label: Annotated[str, Text(64)] = "learned"
    carried: Annotated[tuple[tuple[float, int], tuple[float, int]], Fixed((STEP_AND_BITS, STEP_AND_BITS))] = (
        DEFAULT_CARRIED
    )

    def __post_init__(self) -> None:
        check_fields(self)
        require_sizes(self.networks, inputs=FeatureMap(self.lags).inputs, outputs=2 * self.coefficients)
        edges = [network.up_to_noise_m for network in self.networks]
        if sorted(set(edges)) != edges:
            raise FieldError("networks", edges, "networks whose up_to_noise_m rise")

    @property
    def name(self) -> str:
        """The label."""
        return self.label

    @property
    def window(self) -> int:
        """Samples that span the lags at 10 Hz."""
        return self.lags + 1

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Velocity, acceleration, yaw rate; then the coefficients along and to the left."""
        powers = range(self.coefficients)
        along = tuple(f"along_{power}_m" for power in powers)
        left = tuple(f"left_{power}_m" for power in powers)
        return (*ConstantTurnRateAcceleration().parameter_names, *along, *left)

    @property
    def payload_parameters(self) -> int:
        """The coefficients."""
        return 2 * self.coefficients

    @property
    def payload_layout(self) -> PayloadLayout:
        """The coefficients, along and to the left, lowest power first."""
        names = self.parameter_names[learned_kernels.KINEMATIC :]
        first, higher = self.carried
        sizes = 2 * [first, *[higher] * (self.coefficients - 1)]
        fields = zip(names, sizes, strict=True)
        return PayloadLayout(tuple(PayloadField(name, step, bits=bits) for name, (step, bits) in fields))

    @property
    def trusted_horizon_s(self) -> float:
        """As given."""
        return self.horizon_s

    @property
    def trusted_turn_s(self) -> float:
        """As given."""
        return self.turn_s

    def point_functions(self, dt_s: float) -> PointFunctions:
        """Return the compiled functions and all weights."""
        return PointFunctions(learned_kernels.fit, learned_kernels.predict, self.packed(dt_s))

    def packed(self, dt_s: float) -> FloatArray:
        """Feature map and networks as the compiled functions read them.

        Parameters
        ----------
        dt_s
            Sampling interval of the windows [s].
        """
        return np.concatenate(
            [
                feature_constants(
                    FeatureMap(self.lags), dt_s, self.coefficients, self.time_scale_s, len(self.networks)
                ),
                *(network.packed() for network in self.networks),
            ]
        )

    def covariance(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Spread of the kinematic model it corrects; calibration makes it honest."""
        kinematic = ConstantTurnRateAcceleration()
        own = parameters[:, : learned_kernels.KINEMATIC]
        return kinematic.covariance(own, np.asarray(horizons_s, dtype=np.float64), dt_s=dt_s)


def require_sizes(networks: tuple[Perceptron, ...], *, inputs: int, outputs: int) -> None:
    """Refuse networks of other sizes: a compiled one would read past the end.

    Parameters
    ----------
    networks
        The networks.
    inputs, outputs
        What they must have.

    Raises
    ------
    FieldError
        Where one has others.
    """
    for at, network in enumerate(networks):
        if (network.inputs, network.outputs) != (inputs, outputs):
            raise FieldError(
                f"networks[{at}]",
                (network.inputs, network.outputs),
                f"a network with {inputs} inputs and {outputs} outputs",
            )


def feature_constants(
    features: FeatureMap, dt_s: float, coefficients: int = 1, time_scale_s: float = 1.0, networks: int = 0
) -> FloatArray:
    """Header and feature map as `learned_kernels.window_features` reads them.

    Parameters
    ----------
    features
        The map.
    dt_s
        Sampling interval [s].
    coefficients, time_scale_s, networks
        What follows; training, which has no network yet, leaves them out.
    """
    rows = (features.positions, features.velocities, features.speeds)
    header = [
        dt_s,
        features.lags,
        rows[0].shape[0],
        rows[1].shape[0],
        features.inputs,
        coefficients,
        time_scale_s,
        networks,
        rows[2].shape[0],
        features.context,
        0,
    ]
    return np.concatenate([np.array(header, dtype=np.float64), *(one.ravel() for one in rows)])
