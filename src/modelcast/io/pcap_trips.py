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

WSMP and IEEE 1609.2 data are opened and nothing is verified: whoever sent an id is in its trip. Time is
Unix time.

Skipped and counted: "time missing" (no secMark, or no time in the capture), "position unavailable",
"duplicate time". Repaired and counted: "out of time order"; unavailable values, held or left out as `rows`
says. Records without a basic safety message are told with their number under the name of the file.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar

import numpy as np

from modelcast.core.exceptions import CodecError, DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.io.base import AbstractTripReader, OnSkipped, Tally, ignore_skipped
from modelcast.io.pcap import CapturedFrame, frames_of, is_capture, short_message_of
from modelcast.io.rows import Rows, located, make_trip, ordered
from modelcast.io.spmd import valid_position
from modelcast.messages.bsm import BsmCore, decode_bsm
from modelcast.messages.ieee1609 import is_ieee1609_data, unsecured_payload
from modelcast.messages.security.signed import decode_signed
from modelcast.messages.sequence import begins_a_message
from modelcast.messages.wsmp import decode_wsm
from modelcast.trips.trajectory import Trajectory

__all__ = ["PcapReader", "core_of"]

_MINUTE_S = 60.0
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
        try:
            content = Path(path).read_bytes()
        except OSError as error:
            raise DataFormatError(
                path, f"cannot be read: {error.strerror}", remedy="Check the path."
            ) from error
        heard: dict[int, list[tuple[int, float, dict[str, float]]]] = {}
        others = 0
        for frame in frames_of(content, path):
            core = core_of(frame)
            if core is None:
                others += 1
                continue
            values = core.values()
            row = {name: _number(values[of]) for name, of in _COLUMNS.items()}
            mark_s = values["second_of_minute_s"]
            t_s = np.nan if mark_s is None or frame.t_ns is None else _instant(mark_s, frame.t_ns / 1e9)
            heard.setdefault(int(values["temporary_id"] or 0), []).append((frame.number, t_s, row))
        if others:
            on_skipped(Path(path).stem, f"{others} records without a basic safety message")
        for temporary_id, rows in heard.items():
            name = f"{Path(path).stem}/{temporary_id:08x}"
            tally = Tally()
            trip = _trip(path, name, rows, tally)
            if trip is None:
                on_skipped(name, tally.why_empty())
            else:
                yield trip


def core_of(frame: CapturedFrame) -> BsmCore | None:
    """Part I of the basic safety message in a record, nothing verified; None where there is none.

    Parameters
    ----------
    frame
        A record of a capture.
    """
    message = short_message_of(frame)
    if message is None or frame.cut:
        return None
    try:
        if not (is_ieee1609_data(message) or begins_a_message(message)):
            message = decode_wsm(message).payload
        if message[:2] == b"\x03\x81":
            message = decode_signed(message).payload
        elif is_ieee1609_data(message):
            message = unsecured_payload(message)
        return decode_bsm(message).core
    except CodecError:
        return None


def _number(value: float | None) -> float:
    return np.nan if value is None else value


def _instant(mark_s: float, heard_s: float) -> float:
    """The instant next to when it was heard that has this place in a minute of UTC."""
    return mark_s + _MINUTE_S * round((heard_s - mark_s) / _MINUTE_S)


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
