"""What a node tells whoever records it."""

import abc
from collections.abc import Sequence
from typing import TYPE_CHECKING

from modelcast.runtime.transport.base import Arrival

if TYPE_CHECKING:
    from modelcast.node.node import NodeState

__all__ = ["AbstractRecord"]


class AbstractRecord(abc.ABC):
    """Takes what a node did, in the order in which it did it. Returns at once and raises nothing."""

    @abc.abstractmethod
    def heard(self, now_s: float, arrived: Sequence[Arrival], outcomes: Sequence[str]) -> None:
        """Take what one call of `modelcast.node.node.Node.hear` brought.

        Parameters
        ----------
        now_s
            Of the call [s].
        arrived
            Frames, in order.
        outcomes
            What became of each, in words.
        """

    @abc.abstractmethod
    def sent(self, now_s: float, message: bytes, frame: bytes) -> None:
        """Take a frame that was handed to the transport.

        Parameters
        ----------
        now_s
            Of the call of `modelcast.node.node.Node.send` [s].
        message
            What the station said.
        frame
            The same in its envelope.
        """

    @abc.abstractmethod
    def stepped(self, state: "NodeState") -> None:
        """Take what a step made.

        Parameters
        ----------
        state
            As the step returns it.
        """
