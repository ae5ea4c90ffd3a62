"""A sub-model with a trusted horizon: beyond it, everybody predicts by a damped continuation.

A model fitted to one second may say anything about the tenth. Where messages are lost, the receiver asks it
all the same. Beyond its trusted horizon a model is therefore no longer asked: the car keeps the speed it had
there, follows the circle it was on for a while, and then goes straight on. Sender, host and replay predict
through one compiled function, `modelcast.models.trusted_kernels.predict_trusted`, so that the sender measures
its error against exactly what the host believes.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import Number, check_fields
from modelcast.models.base import PointFunctions
from modelcast.models.wrapped import AbstractWrapped

__all__ = ["LONGEST_TIME_S", "SHORTEST_HORIZON_S", "TURN_S", "Trusted"]

SHORTEST_HORIZON_S = 0.2
"""Shortest trusted horizon [s]: it must lie a few `trusted_kernels.STEP_S` after the last sample."""

TURN_S = 2.0
"""How long a car goes on turning beyond the trusted horizon, where nothing else is said [s]."""


LONGEST_TIME_S = 3600.0
"""Longest finite time that a sub-model may name [s]: nobody believes a message of an hour ago."""


@dataclass(frozen=True, slots=True)
class Trusted(AbstractWrapped):
    """A sub-model that is trusted up to a horizon; beyond it, speed holds and the turn ends.

    Parameters
    ----------
    model
        The sub-model; its name, parameters and payload stay as they are: a receiver knows the horizon as it
        knows the model.
    horizon_s
        Age up to which its predictions are taken [s]; infinite for ever.
    turn_s
        How long beyond it the car goes on along the circle it was on [s]; infinite for ever, 0 for straight
        on at once.

    Raises
    ------
    ValueError
        Where a time is out of its range, or the model has a trusted horizon already.

    Notes
    -----
    The covariance is the model's own at every horizon; calibration on damped errors makes it honest
    (`modelcast.models.calibration`).

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.models.base import Windows
    >>> from modelcast.models.kinematic import ConstantAcceleration
    >>> model = Trusted(ConstantAcceleration(), 1.0)
    >>> accelerating = np.array([[[0.0, 0.0, 10.0, 0.0, 2.0, 0.0, 0.0]]])
    >>> parameters = model.fit(Windows(accelerating, dt_s=0.1))
    >>> model.predict(parameters, np.array([1.0, 2.0, 3.0]), dt_s=0.1).round(6)
    array([[[11.,  0.],
            [23.,  0.],
            [35.,  0.]]])
    """

    horizon_s: Annotated[float, Number(SHORTEST_HORIZON_S, LONGEST_TIME_S, infinite=True)]
    turn_s: Annotated[float, Number(0.0, LONGEST_TIME_S, infinite=True)] = TURN_S

    def __post_init__(self) -> None:
        check_fields(self)
        if np.isfinite(self.model.trusted_horizon_s):
            raise ValueError(f"{self.model.name} has a trusted horizon already: wrap the model inside")

    @property
    def trusted_horizon_s(self) -> float:
        """As given."""
        return self.horizon_s

    @property
    def trusted_turn_s(self) -> float:
        """As given."""
        return self.turn_s

    def point_functions(self, dt_s: float) -> PointFunctions:
        """Return the model's functions: `predict_trusted` goes round them."""
        return self.model.point_functions(dt_s)

    def covariance(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Return the model's covariance."""
        return self.model.covariance(parameters, np.asarray(horizons_s), dt_s=dt_s)
