"""What goes round a message on the air, and how it is taken off again."""

import abc
from dataclasses import dataclass

__all__ = ["AbstractEnvelope", "Bare", "Opened"]


@dataclass(frozen=True, slots=True)
class Opened:
    """A frame without its envelope.

    Parameters
    ----------
    octets
        The message; None where the frame is refused.
    why
        What became of it, in a word or two for counters: ``accepted``, or why not.
    """

    octets: bytes | None
    why: str


class AbstractEnvelope(abc.ABC):
    """One station's way to wrap what it sends and to open what it hears."""

    @abc.abstractmethod
    def wrap(self, octets: bytes, *, sent_s: float) -> bytes:
        """Return a message as it goes on the air.

        Parameters
        ----------
        octets
            The message.
        sent_s
            When it leaves [s].
        """

    @abc.abstractmethod
    def open(self, frame: bytes, *, received_s: float) -> Opened:
        """Return what a frame holds. Nothing in it is trusted, and nothing is raised.

        Parameters
        ----------
        frame
            Whatever arrived.
        received_s
            When [s].
        """

    @abc.abstractmethod
    def rename(self) -> None:
        """Take other credentials, as the station takes another temporary id."""


class Bare(AbstractEnvelope):
    """No envelope: messages are frames as they are, as between the virtual transport's stations."""

    def wrap(self, octets: bytes, *, sent_s: float) -> bytes:  # noqa: ARG002 - nothing is dated
        """Return the message."""
        return octets

    def open(self, frame: bytes, *, received_s: float) -> Opened:  # noqa: ARG002 - nothing is checked
        """Return the frame."""
        return Opened(frame, "accepted")

    def rename(self) -> None:
        """Change nothing: there is nothing to change."""
