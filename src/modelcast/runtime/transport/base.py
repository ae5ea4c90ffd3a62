"""What carries octets between stations: one interface for sockets, radios and tests."""

import abc
from dataclasses import dataclass

__all__ = ["MOST_OCTETS", "AbstractTransport", "Arrival"]

MOST_OCTETS = 2304
"""Octets of the longest frame that IEEE 802.11 carries (IEEE 802.11-2020, 9.2.4.8)."""


@dataclass(frozen=True, slots=True)
class Arrival:
    """One frame that reached a station.

    Parameters
    ----------
    octets
        As they were sent.
    received_s
        When [s].
    """

    octets: bytes
    received_s: float


class AbstractTransport(abc.ABC):
    """One station's way to all others. Time is an argument: no transport below `node` asks a clock."""

    @abc.abstractmethod
    def send(self, octets: bytes, *, sent_s: float) -> None:
        """Broadcast one frame.

        Parameters
        ----------
        octets
            The frame, 1 to 2,304 octets.
        sent_s
            When it leaves [s].

        Raises
        ------
        ValueError
            Where the frame is empty or too long, or the time is no number.
        """

    def fileno(self) -> int | None:
        """Number of a socket that frames arrive at, for an event loop to wait on; None without one."""
        return None

    def close(self) -> None:  # noqa: B027 - most have nothing to let go of
        """Let go of sockets and devices."""

    @abc.abstractmethod
    def receive(self, until_s: float) -> list[Arrival]:
        """Return what has arrived by a time and was not returned before, in order of arrival.

        Parameters
        ----------
        until_s
            Now [s].
        """
