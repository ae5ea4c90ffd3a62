"""An interacting multiple model at the receiver: plain messages, weighed by how the last ones went.

A rival of banks whose senders choose (`modelcast.models.bank`). The sender says nothing but Part I. The
receiver runs four kinematic modes, judges them whenever a message arrives by how well each foresaw the way
from the message before, and predicts by their mean. What it believes follows from the messages that it
received alone, so a sender that follows what it sent knows it too, losses apart.

References
----------
H. A. P. Blom, Y. Bar-Shalom, "The Interacting Multiple Model Algorithm for Systems with Markovian Switching
Coefficients", IEEE Transactions on Automatic Control 33(8), 780-783, 1988, doi:10.1109/9.1299.
"""

from dataclasses import KW_ONLY, dataclass, replace
from typing import Annotated, Any, ClassVar

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import FieldError, Fixed, Number, check_fields
from modelcast.models import interacting_kernels as kernels
from modelcast.models.base import PointFunctions
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.core_model import SPREAD_MPS2, SPREAD_MPS3, SPREAD_RADPS2, AbstractCoreModel
from modelcast.models.kinematic import (
    ConstantAcceleration,
    ConstantTurnRateAcceleration,
    ConstantTurnRateVelocity,
)
from modelcast.models.payload import CORE_PARAMETERS

__all__ = ["InteractingMultipleModel"]

_CHANCE = Number(1e-6, 1.0)
_CHANCES = ("chance_cv", "chance_ca", "chance_ctrv", "chance_ctra")
_TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True)
class InteractingMultipleModel(AbstractCoreModel):
    """Constant velocity, acceleration, turn rate and both, weighed at the receiver.

    Parameters
    ----------
    persistence_s
        Time in which the chain of modes forgets [s].
    noise_m
        Standard deviation of a stated place an axis [m].
    acceleration_spread_mps2, jerk_spread_mps3, yaw_acceleration_spread_radps2
        Standard deviations of what the modes leave out, as in the kinematic models: of acceleration [m/s²]
        where a mode holds speed or course, of jerk [m/s³] and yaw acceleration [rad/s²] where it does not.
    start
        Chances of the four modes for a receiver that held no message before; they sum to one.

    Raises
    ------
    ValueError
        Where a number is out of its range, or the chances do not sum to one.

    Notes
    -----
    A message states the whole motion, far better than any mode foresees it over the gap between messages. So
    the modes' filters are at what the message states, mixing changes nothing, and of the algorithm the
    chances remain: ``c_j' ∝ Λ_j Σ_i p_ij c_i`` with Λ the Gaussian density of the way that was moved, and the
    chain ``p_ij(t) = e^{-t/τ} δ_ij + (1 - e^{-t/τ}) π_j``. Predictions are means over the modes, with the
    chances that the chain leads to by then. After lost messages the gap is longer, and the chain has
    forgotten more; a new receiver starts from π.

    Examples
    --------
    >>> from modelcast.models.base import Windows
    >>> model = InteractingMultipleModel(start=(0.25, 0.25, 0.25, 0.25))
    >>> braking = np.array([[[0.0, 0.0, 10.0, 0.0, -2.0, 0.0, 0.0]]])
    >>> parameters = model.fit(Windows(braking, dt_s=0.1))
    >>> model.predict(parameters, np.array([1.0]), dt_s=0.1).round(6) + 0.0
    array([[[9.5, 0. ]]])
    """

    short_name: ClassVar[str] = "imm"
    numbers: ClassVar[tuple[str, ...]] = (*CORE_PARAMETERS, *_CHANCES)
    functions: ClassVar[tuple[Any, Any]] = (kernels.fit, kernels.predict)
    _: KW_ONLY
    persistence_s: Annotated[float, Number(0.1, 1000.0)] = 2.0
    noise_m: Annotated[float, Number(1e-4, 10.0)] = 0.1
    acceleration_spread_mps2: Annotated[float, SPREAD_MPS2] = 0.2
    jerk_spread_mps3: Annotated[float, SPREAD_MPS3] = 0.6
    yaw_acceleration_spread_radps2: Annotated[float, SPREAD_RADPS2] = 0.07
    start: Annotated[tuple[float, ...], Fixed((_CHANCE,) * kernels.MODES)] = (0.07, 0.02, 0.07, 0.84)

    def __post_init__(self) -> None:
        check_fields(self)
        if not abs(sum(self.start) - 1.0) < _TOLERANCE:
            raise FieldError("start", self.start, "chances that sum to one")

    @property
    def held_parameters(self) -> tuple[str, ...]:
        """The chances."""
        return _CHANCES

    @property
    def predicts_by_parameters(self) -> bool:
        """It predicts by its settings too."""
        return False

    def point_functions(self, dt_s: float) -> PointFunctions:
        """Return the compiled functions and the settings."""
        numbers = (self.persistence_s, self.noise_m, self.acceleration_spread_mps2)
        spreads = (self.jerk_spread_mps3, self.yaw_acceleration_spread_radps2)
        constants = np.array([*numbers, *spreads, *self.start])
        bare = AbstractCoreModel.point_functions(self, dt_s)
        return replace(bare, constants=constants, absorb=kernels.absorb)

    def spread_m2(self, parameters: FloatArray, horizons_s: FloatArray) -> FloatArray:
        """Spread of the modes, each its own, and of their means."""
        held = parameters[:, kernels.CHANCE :]
        start = np.array(self.start)
        known = held.sum(axis=1, keepdims=True) > 0.0
        fades = np.exp(-horizons_s / self.persistence_s)[None, :, None]
        chances = start + (np.where(known, held, start)[:, None] - start) * fades
        means = np.stack([one.predict(own, horizons_s, dt_s=0.1) for one, own in self._modes(parameters)], 2)
        spreads = np.stack([one.spread_m2(own, horizons_s) for one, own in self._modes(parameters)], 2)
        apart = means - (chances[..., None] * means).sum(axis=2, keepdims=True)
        mixed = spreads + apart[..., :, None] * apart[..., None, :]
        return (chances[..., None, None] * mixed).sum(axis=2)

    def _modes(self, parameters: FloatArray) -> list[tuple[AbstractCoreModel, FloatArray]]:
        """The modes as models of their own, with their parameters."""
        a, j, c = (
            self.acceleration_spread_mps2,
            self.jerk_spread_mps3,
            self.yaw_acceleration_spread_radps2,
        )
        straight = ConstantAcceleration(jerk_spread_mps3=j, lateral_spread_mps2=a)
        even = ConstantTurnRateVelocity(acceleration_spread_mps2=a, yaw_acceleration_spread_radps2=c)
        both = ConstantTurnRateAcceleration(jerk_spread_mps3=j, yaw_acceleration_spread_radps2=c)
        return [
            (ConstantVelocity(a), parameters[:, :2]),
            (straight, parameters[:, :3]),
            (even, parameters[:, [0, 1, 3]]),
            (both, parameters[:, :4]),
        ]
