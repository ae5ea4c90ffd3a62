"""A gpsd that tells of a drive, and fails as it is asked to.

It speaks protocol 3 of gpsd_json(5) as far as a client of fixes needs: VERSION at once, DEVICES and WATCH
when it is asked to watch, then a TPV ten times and a SKY once a second, the SKY before the TPV.
"""

import asyncio
import json
import math
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from typing import Literal, final

from modelcast.node.trials.drive import Drive
from modelcast.node.trials.pacing import at_every

__all__ = ["Gives", "GpsdPlayer"]

Gives = Literal["fixes", "no fix", "same fix", "nothing"]
"""Fixes; reports that have none; the place and speed of before with new times; not an octet, as where the
other end of a connection is gone without a word."""

_PERIOD_S = 0.1
_LATE_S = 0.05
"""A fix is measured so long before it is told: a receiver's own time."""
_SKY_EACH = 10
_ERROR_M = 1.0
_DEVICE = "/dev/trial"
_VERSION = {"class": "VERSION", "release": "trial", "rev": "trial", "proto_major": 3, "proto_minor": 14}
_MOST_WAITING = 65_536


@final
class GpsdPlayer:
    """A gpsd on this machine.

    Parameters
    ----------
    drive
        What it tells of.
    utc_s
        Gives UTC, since 1970 [s].

    Notes
    -----
    `gives` and `splits` may be set at any time.
    """

    def __init__(self, drive: Drive, utc_s: Callable[[], float]) -> None:
        self._drive, self._utc_s = drive, utc_s
        self.gives: Gives = "fixes"
        """What clients get."""
        self.splits = False
        """Whether every report arrives in two pieces, the second with the next."""
        self.port = 0
        """Where it listens, the same after a stop; 0 before the first `start`."""
        self.connections = 0
        """Clients that came so far."""
        self.last_connection_utc_s = math.nan
        """When the last of them came [s]."""
        self._writers: set[asyncio.StreamWriter] = set()
        self._server: asyncio.Server | None = None
        self._telling: asyncio.Task[None] | None = None
        self._frozen_s, self._held, self._told = math.nan, b"", 0

    async def start(self) -> None:
        """Listen, and tell whoever watches.

        Raises
        ------
        OSError
            Where the port has been taken in the meantime.
        """
        if self._server is None:
            self._server = await asyncio.start_server(self._meet, "127.0.0.1", self.port)
            self.port = int(self._server.sockets[0].getsockname()[1])
            self._telling = asyncio.create_task(at_every(_PERIOD_S, self._utc_s, self._tell))

    async def stop(self) -> None:
        """End as a daemon that is stopped: connections are closed, nobody listens."""
        server, self._server = self._server, None
        if server is None:
            return
        if self._telling is not None:
            self._telling.cancel()
            await asyncio.gather(self._telling, return_exceptions=True)
        server.close()
        for writer in tuple(self._writers):
            writer.transport.abort()
        self._writers.clear()
        await server.wait_closed()

    async def _meet(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.connections += 1
        self.last_connection_utc_s = self._utc_s()
        try:
            self._answer(writer, _VERSION)
            while line := await reader.readline():
                if line.startswith(b"?WATCH"):
                    self._answer(writer, {"class": "DEVICES", "devices": [{"path": _DEVICE}]})
                    self._answer(writer, {"class": "WATCH", "enable": True, "json": True})
                    self._writers.add(writer)
                elif line.startswith(b"?VERSION"):
                    self._answer(writer, _VERSION)
        except (OSError, ValueError):
            pass
        finally:
            self._writers.discard(writer)
            writer.transport.abort()

    def _answer(self, writer: asyncio.StreamWriter, report: Mapping[str, object]) -> None:
        if self.gives != "nothing":
            writer.write(_line(report))

    def _tell(self, now_s: float) -> None:
        measured_s = now_s - _LATE_S
        self._frozen_s = math.nan if self.gives != "same fix" else self._frozen_s
        if self.gives == "nothing":
            return
        if self.gives == "same fix" and math.isnan(self._frozen_s):
            self._frozen_s = measured_s
        driven = self._drive.at(measured_s if math.isnan(self._frozen_s) else self._frozen_s)
        report: dict[str, object] = {
            "class": "TPV",
            "device": _DEVICE,
            "mode": 1 if self.gives == "no fix" else 3,
            "time": datetime.fromtimestamp(measured_s, UTC).isoformat(timespec="milliseconds"),
        }
        if self.gives != "no fix":
            report |= {
                "lat": round(driven.latitude_deg, 9),
                "lon": round(driven.longitude_deg, 9),
                "altHAE": 520.0,
                "speed": round(driven.speed_mps, 3),
                "track": round(math.degrees(driven.heading_rad), 4),
                "epx": _ERROR_M,
                "epy": _ERROR_M,
            }
        octets = _line(report)
        if self._told % _SKY_EACH == 0:
            octets = _line({"class": "SKY", "device": _DEVICE, "uSat": 9, "hdop": 0.9}) + octets
        self._told += 1
        cut = len(octets) // 2 if self.splits else len(octets)
        octets, self._held = self._held + octets[:cut], octets[cut:]
        for writer in tuple(self._writers):
            if writer.transport.get_write_buffer_size() < _MOST_WAITING:
                writer.write(octets)


def _line(report: Mapping[str, object]) -> bytes:
    return json.dumps(report, separators=(",", ":")).encode() + b"\r\n"
