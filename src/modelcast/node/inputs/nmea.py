"""Fixes from NMEA 0183 as it arrives: a serial device or a TCP peer.

Sentences are those of `modelcast.io.nmea` and are read by the same functions. A GGA and an RMC of one
instant are one fix, which leaves when the second has come; a receiver that sends only one kind is noticed
after three fixes, whose next ones leave at once. What waits for a partner leaves when a sentence of another
instant comes.

A fix has the date of the last RMC, or else the day that brings it nearest to the node's clock. NMEA states
no error here, so the ellipse is unavailable. A recorded file is replayed by `modelcast.node.inputs.replay`,
at its own times.
"""

import asyncio
import math
import os
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from typing import final

from modelcast.core.exceptions import MissingExtraError
from modelcast.io.nmea_sentences import Fix, parse_fix, sentence_body, sentences
from modelcast.node.inputs.base import AbstractSource, Mailbox
from modelcast.node.inputs.line_stream import Connect, LineStream, StreamRules
from modelcast.node.inputs.samples import GnssFix, Sample, measured_at

__all__ = ["EpochJoiner", "NmeaSource", "serial_device"]

_DAY_S = 86_400.0
_ALONE = 3
"""Fixes of one kind in a row after which no partner is waited for."""
_MOST_WAITING = 32
_RULES = StreamRules(silence_s=3.0, most_octets=1024)


class EpochJoiner:
    """Joins sentences of one instant as they come.

    Examples
    --------
    >>> joiner = EpochJoiner()
    >>> gga, rmc = Fix("GGA", True, 10.0), Fix("RMC", True, 10.0, speed_mps=3.0)
    >>> joiner.join(gga), [fix.kind for fix in joiner.join(rmc)]
    ([], ['GGA+RMC'])
    """

    def __init__(self) -> None:
        self._waiting: Fix | None = None
        self._alone = 0

    def join(self, fix: Fix) -> list[Fix]:
        """Fixes that a sentence completes, oldest first.

        Parameters
        ----------
        fix
            What the next sentence says.
        """
        waiting, self._waiting = self._waiting, None
        if waiting is not None and waiting.time_of_day_s == fix.time_of_day_s and waiting.kind != fix.kind:
            self._alone = 0
            return [waiting.joined(fix)]
        done = [] if waiting is None else [waiting]
        self._alone += len(done)
        if self._alone >= _ALONE:
            return [*done, fix]
        self._waiting = fix
        return done


@final
class NmeaSource(AbstractSource):
    """A receiver that speaks NMEA.

    Parameters
    ----------
    connect
        How it is reached: `serial_device`, or `modelcast.node.inputs.line_stream.tcp`.
    now_s
        The node's clock [s].
    utc_at_zero_s
        UTC at its 0 [s].
    rules
        How the connection is kept; the default allows 3 s of silence, so that 1 Hz is no silence.
    """

    def __init__(
        self,
        connect: Connect,
        *,
        now_s: Callable[[], float],
        utc_at_zero_s: float,
        rules: StreamRules | None = None,
    ) -> None:
        self._now_s = now_s
        self._utc_at_zero_s = utc_at_zero_s
        self._box = Mailbox(most=_MOST_WAITING)
        self._joiner = EpochJoiner()
        self._midnight: tuple[float, float] | None = (
            None  # UTC of the midnight last known, and of the last fix
        )
        kept = _RULES if rules is None else rules
        self._stream = LineStream(connect, self.hear, self._box, kept)
        self.newest_utc: tuple[float, float] | None = None
        """When the newest dated fix came, and the UTC it says [s], for whoever steers a clock."""

    async def start(self) -> None:
        """Begin to listen."""
        await self._stream.start()

    async def stop(self) -> None:
        """Close the device."""
        await self._stream.stop()

    def take(self, now_s: float) -> list[Sample]:
        """Fixes since the last call."""
        return self._box.take(now_s)

    def counts(self) -> Mapping[str, int]:
        """Fixes, connections, and what was passed over by reason."""
        return self._box.counts()

    def hear(self, line: bytes) -> None:
        """Take in a line.

        Parameters
        ----------
        line
            Without its end.

        Raises
        ------
        ValueError
            Where a sentence with a good checksum is not what it should be.
        """
        for sentence in sentences(line.decode("ascii", errors="replace")):
            body = sentence_body(sentence)
            if body is None:
                self._box.count("bad checksum")
                continue
            fix = parse_fix(body)
            for whole in [] if fix is None else self._joiner.join(fix):
                self._hear_fix(whole)

    def _hear_fix(self, fix: Fix) -> None:
        if not fix.valid:
            self._box.count("no fix")
            return
        if not math.isfinite(fix.latitude_deg + fix.longitude_deg):
            self._box.count("position missing")
            return
        received_s = self._now_s()
        utc_s = self._utc_s(fix, received_s)
        if math.isfinite(utc_s):
            self.newest_utc = (received_s, utc_s)
        try:
            measured_s = measured_at(received_s, utc_s, self._utc_at_zero_s)
        except ValueError:
            self._box.count("ahead")
            return
        found = GnssFix(
            received_s=received_s,
            measured_s=measured_s,
            latitude_deg=fix.latitude_deg,
            longitude_deg=fix.longitude_deg,
            utc_s=utc_s,
            altitude_m=fix.altitude_m,
            speed_mps=fix.speed_mps,
            heading_rad=math.radians(fix.course_deg),
        )
        self._box.put([found])

    def _utc_s(self, fix: Fix, received_s: float) -> float:
        """UTC of a fix, NaN where it has no time of day [s]."""
        if not math.isfinite(fix.time_of_day_s):
            return math.nan
        if fix.day is not None:
            midnight_s = datetime(fix.day.year, fix.day.month, fix.day.day, tzinfo=UTC).timestamp()
        else:
            near_s = self._utc_at_zero_s + received_s if self._midnight is None else self._midnight[1]
            midnight_s = _DAY_S * round((near_s - fix.time_of_day_s) / _DAY_S)
        utc_s = midnight_s + fix.time_of_day_s
        if fix.day is not None or self._midnight is not None:
            self._midnight = (midnight_s, utc_s)
        return utc_s


def serial_device(path: str, baud: int = 115_200) -> Connect:
    """How a receiver on a serial line is reached; a pseudo terminal does as well.

    Parameters
    ----------
    path
        Of the device.
    baud
        Its speed [1/s].

    Raises
    ------
    MissingExtraError
        Where pyserial is not installed.
    """
    try:
        import serial  # pyright: ignore[reportMissingTypeStubs] # noqa: PLC0415 - only who has one needs it
    except ImportError as error:
        raise MissingExtraError("a serial receiver", "node") from error

    async def connect() -> tuple[asyncio.StreamReader, Callable[[bytes], None], Callable[[], None]]:
        port = serial.Serial(path, baud, timeout=0, exclusive=True)
        reader = asyncio.StreamReader(limit=65_536)
        descriptor = os.fdopen(os.dup(port.fileno()), "rb", buffering=0)
        port.close()
        transport, _ = await asyncio.get_running_loop().connect_read_pipe(
            lambda: asyncio.StreamReaderProtocol(reader), descriptor
        )

        def send(octets: bytes) -> None:
            """Receivers are only listened to."""
            del octets

        return reader, send, transport.close

    return connect
