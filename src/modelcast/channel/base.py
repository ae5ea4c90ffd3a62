"""What a channel does to the messages of one vehicle."""

import abc

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray

__all__ = ["AbstractChannel"]


class AbstractChannel(abc.ABC):
    """Loses messages. A loss is an absent reception, not an error."""

    @property
    @abc.abstractmethod
    def packet_error_ratio(self) -> float:
        """Mean share of messages lost, 0..1."""

    @abc.abstractmethod
    def losses(self, t_s: FloatArray, rng: np.random.Generator) -> BoolArray:
        """Which instants lose the message sent at them, (T,).

        The answer covers every instant, whether a message is sent there or not, so that policies compared
        over the same generator meet the same channel.

        Parameters
        ----------
        t_s
            Instants at which a message may be sent, (T,) rising [s].
        rng
            The generator of this vehicle and channel in this run.
        """
