"""What a sender believes its remotes hold of it, and how far that is from what it measures.

The estimator is any motion model: `ConstantVelocity` with the velocity as parameters is the coasting of basic
safety messages, any other model or bank is model-based communication. Transmit policies take the error this
gives, and say by `Decisions.believed` when to renew the belief.
"""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.models.base import AbstractMotionModel
from modelcast.station.policy import belief_kernels as kernels
from modelcast.station.policy.j2945_parameters import J2945Parameters

__all__ = ["Belief"]


@dataclass(frozen=True, slots=True)
class Belief:
    """What the remotes of B vehicles are believed to hold of each.

    Parameters
    ----------
    fit_s
        Time of the position sent, minus infinity where they hold nothing, (B,) [s].
    position_m
        That position, (B, 2) [m].
    parameters
        The model's, (B, P).

    Examples
    --------
    A vehicle at 10 m/s that has braked by 5 m/s for 0.4 s is a metre short of where its remotes put it:

    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> model = ConstantVelocity()
    >>> belief = Belief.nothing(1, model).renewed(
    ...     np.array([True]),
    ...     fit_s=np.zeros(1),
    ...     position_m=np.zeros((1, 2)),
    ...     parameters=np.array([[10.0, 0.0]]),
    ... )
    >>> local = np.array([[0.4, 3.0, 0.0, 5.0, 0.0]])
    >>> belief.tracking_error_m(model, np.array([0.4]), local, dt_s=0.1).tolist()
    [1.0]
    """

    fit_s: FloatArray
    position_m: FloatArray
    parameters: FloatArray

    @classmethod
    def nothing(cls, vehicles: int, model: AbstractMotionModel) -> "Belief":
        """Nobody holds anything yet.

        Parameters
        ----------
        vehicles
            How many, B.
        model
            Whose parameters will be sent.
        """
        return cls(
            np.full(vehicles, -np.inf),
            np.zeros((vehicles, 2)),
            np.zeros((vehicles, len(model.parameter_names))),
        )

    def renewed(
        self, believed: BoolArray, *, fit_s: FloatArray, position_m: FloatArray, parameters: FloatArray
    ) -> "Belief":
        """The belief after messages, where they are believed received.

        Parameters
        ----------
        believed
            `Decisions.believed`, (B,).
        fit_s, position_m, parameters
            Content of the messages, (B,), (B, 2), (B, P); rows of other vehicles are not read.
        """
        return Belief(
            np.where(believed, fit_s, self.fit_s),
            np.where(believed[:, None], position_m, self.position_m),
            np.where(believed[:, None], parameters, self.parameters),
        )

    def tracking_error_m(
        self,
        model: AbstractMotionModel,
        t_s: FloatArray,
        local: FloatArray,
        *,
        dt_s: float,
        standard: J2945Parameters | None = None,
    ) -> FloatArray:
        """Tracking error of every vehicle, infinite where its remotes hold nothing, (B,) [m].

        Parameters
        ----------
        model
            What the remotes predict with.
        t_s
            Now, (B,) [s].
        local
            What each vehicle last measured: time, east, north, velocity east and north, (B, 5) [s], [m],
            [m/s].
        dt_s
            Sampling interval the models were fitted with [s].
        standard
            Whose rules of age apply; None for J2945/1's.
        """
        known = np.isfinite(self.fit_s)
        age_s = np.where(known, t_s - self.fit_s, 0.0)
        predicted_m = self.position_m + model.predict_at(self.parameters, age_s, dt_s=dt_s)
        out = np.empty(age_s.size)
        kernels.tracking_errors(
            np.ascontiguousarray(t_s, dtype=np.float64),
            np.ascontiguousarray(local, dtype=np.float64),
            self.fit_s,
            self.position_m,
            predicted_m,
            (J2945Parameters() if standard is None else standard).constants(),
            out,
        )
        return out
