"""Values off a vehicle's bus, by python-can in a thread of its own.

Any interface that python-can names: ``socketcan``, ``udp_multicast``, ``virtual``. A bus that fails is
closed and opened anew every half second. A frame is taken to be measured when it arrives: what python-can
dates it with is no clock of ours. Frames are only listened to; none is ever sent.
"""

import asyncio
from collections.abc import Callable, Mapping
from threading import Event, Thread
from typing import final

from modelcast.core.exceptions import ConfigError, MissingExtraError
from modelcast.node.inputs.base import AbstractSource, Mailbox
from modelcast.node.inputs.frames import FrameReader
from modelcast.node.inputs.samples import BusValue, Sample

try:
    import can
except ImportError as error:
    raise MissingExtraError("a vehicle's bus", "node") from error

__all__ = ["CanSource", "bus_by_name"]

_WAIT_S = 0.1
"""Longest wait for a frame: so soon a stop is noticed."""
_RETRY_S = 0.5
_MOST_WAITING = 2048
"""Values between two takes: a second of the fastest buses."""


@final
class CanSource(AbstractSource):
    """A vehicle's bus.

    Parameters
    ----------
    open_bus
        Opens it, as `bus_by_name` gives.
    reader
        What its frames mean.
    now_s
        The node's clock, asked from the thread [s].
    """

    def __init__(
        self, open_bus: Callable[[], can.BusABC], reader: FrameReader, *, now_s: Callable[[], float]
    ) -> None:
        self._open = open_bus
        self._reader = reader
        self._now_s = now_s
        self._box = Mailbox(most=_MOST_WAITING)
        self._ended = Event()
        self._thread: Thread | None = None

    async def start(self) -> None:
        """Begin to listen."""
        if self._thread is None:
            self._ended.clear()
            self._thread = Thread(target=self._run, name="bus", daemon=True)
            self._thread.start()

    async def stop(self) -> None:
        """Close the bus."""
        thread, self._thread = self._thread, None
        self._ended.set()
        if thread is not None:
            await asyncio.to_thread(thread.join)

    def take(self, now_s: float) -> list[Sample]:
        """Values since the last call."""
        return self._box.take(now_s)

    def counts(self) -> Mapping[str, int]:
        """Frames, values ("samples"), connections, and what was passed over by reason."""
        return self._box.counts()

    def hear(self, frame: can.Message) -> None:
        """Take in a frame.

        Parameters
        ----------
        frame
            As python-can gives it.
        """
        self._box.count("frames")
        if frame.is_error_frame or frame.is_remote_frame:
            self._box.count("error frame" if frame.is_error_frame else "remote frame")
            return
        read = self._reader.read(frame.arbitration_id, frame.data, extended=frame.is_extended_id)
        if read.fault:
            self._box.count(read.fault)
        now_s = self._now_s()
        self._box.put([BusValue(quantity, value, now_s, now_s) for quantity, value in read.values])

    def _run(self) -> None:
        while not self._ended.is_set():
            try:
                bus = self._open()
            except (can.CanError, OSError):
                self._box.count("not reached")
            else:
                self._box.count("connections")
                self._listen(bus)
            self._ended.wait(_RETRY_S)

    def _listen(self, bus: can.BusABC) -> None:
        try:
            while not self._ended.is_set():
                frame = bus.recv(_WAIT_S)
                if frame is not None:
                    self.hear(frame)
        except (can.CanError, OSError):
            self._box.count("closed")
        finally:
            bus.shutdown()


def bus_by_name(interface: str, channel: str) -> Callable[[], can.BusABC]:
    """How a bus is opened.

    Parameters
    ----------
    interface, channel
        As python-can names them.

    Raises
    ------
    ConfigError
        Where python-can knows no such interface.
    """
    if interface not in can.VALID_INTERFACES:
        raise ConfigError(
            f"no interface {interface!r}; python-can knows {', '.join(sorted(can.VALID_INTERFACES))}"
        )

    def opened() -> can.BusABC:
        return can.Bus(channel=channel or None, interface=interface)

    return opened
