"""Trips in captures (`pcap`): the basic safety messages of each temporary id.

=========================  ================================================================================
part of a message          use
=========================  ================================================================================
id                         the trip, ``<stem>/<id>``; a sender that changes its id becomes two trips
secMark                    time: the instant next to the capture's own that has this place in the minute
lat, long, elev            position, height
speed, heading             speed, heading
accelSet.long, .yaw        acceleration, yaw rate
=========================  ================================================================================

WSMP and IEEE 1609.2 data are opened and nothing is verified: whoever sent an id is in its trip. A payload
behind which certificates stand that are not read counts too (`captured`). Time is Unix time.

Skipped and counted: "time missing" (no secMark, or no time in the capture), "position unavailable",
"duplicate time". Repaired and counted: "out of time order"; unavailable values, held or left out as `rows`
says. Other records, and messages behind unread
certificates, are told with their numbers under the name of the file.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar

import numpy as np

from modelcast.core.geodesy import Origin
from modelcast.io.base import AbstractTripReader, OnSkipped, Tally, ignore_skipped
from modelcast.io.captured import Captured
from modelcast.io.packed import recording_stem
from modelcast.io.pcap import is_capture
from modelcast.io.rows import Rows, located, make_trip, ordered
from modelcast.io.spmd import valid_position
from modelcast.trips.trajectory import Trajectory

__all__ = ["PcapReader"]

_COLUMNS = {
    "latitude_deg": "latitude_deg",
    "longitude_deg": "longitude_deg",
    "altitude_m": "elevation_m",
    "speed_mps": "speed_mps",
    "heading_rad": "heading_rad",
    "acceleration_mps2": "acceleration_forward_mps2",
    "yaw_rate_radps": "yaw_rate_radps",
}


class PcapReader(AbstractTripReader):
    """Reads captures; the module's docstring has the fields and what is skipped."""

    name: ClassVar[str] = "pcap"

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether it begins as a capture."""
        del path
        return is_capture(head)

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per temporary id, in the order in which they were first heard."""
        capture = Captured(path)
        heard: dict[int, list[tuple[int, float, dict[str, float]]]] = {}
        for message in capture.messages():
            values = message.core.values()
            row = {name: _number(values[of]) for name, of in _COLUMNS.items()}
            heard.setdefault(message.temporary_id, []).append((message.number, _number(message.t_s), row))
        for told in capture.told():
            on_skipped(recording_stem(path), told)
        for temporary_id, rows in heard.items():
            name = f"{recording_stem(path)}/{temporary_id:08x}"
            tally = Tally()
            trip = _trip(path, name, rows, tally)
            if trip is None:
                on_skipped(name, tally.why_empty())
            else:
                yield trip


def _number(value: float | None) -> float:
    return np.nan if value is None else value


def _trip(
    path: str, name: str, heard: list[tuple[int, float, dict[str, float]]], tally: Tally
) -> Trajectory | None:
    times = np.array([t_s for _, t_s, _ in heard])
    known = times[np.isfinite(times)]
    start_s = float(known.min()) if known.size else 0.0
    columns = {column: np.array([row[column] for _, _, row in heard]) for column in _COLUMNS}
    rows = Rows(np.array([number for number, _, _ in heard]), {"t_s": times - start_s, **columns})
    rows = rows.without(np.isnan(rows.columns["t_s"]), "time missing", tally)
    placed = valid_position(rows.columns["latitude_deg"], rows.columns["longitude_deg"])
    rows = rows.without(~placed, "position unavailable", tally)
    if not len(rows):
        return None
    first = {
        column: float(rows.columns[column][0]) for column in ("latitude_deg", "longitude_deg", "altitude_m")
    }
    altitude_m = first["altitude_m"] if np.isfinite(first["altitude_m"]) else 0.0
    origin = Origin(first["latitude_deg"], first["longitude_deg"], altitude_m)
    rows = located(ordered(rows, tally), origin)
    return make_trip(
        path, name, rows, tally,
        count=len(heard), source=PcapReader.name, origin=origin, unix_offset_s=start_s,
    )  # fmt: skip
