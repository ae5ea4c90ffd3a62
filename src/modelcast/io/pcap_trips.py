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

from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import ClassVar

import numpy as np

from modelcast.core.geodesy import Origin
from modelcast.io.base import OnSkipped, Tally, ignore_skipped
from modelcast.io.bsm_values import CORE_COLUMNS
from modelcast.io.captured import Captured, CapturedMessage
from modelcast.io.gathering import AbstractKeyedRows, KeyedBlock, gathered
from modelcast.io.holding import AbstractHoldingReader
from modelcast.io.packed import recording_stem
from modelcast.io.pcap import is_capture
from modelcast.io.rows import Rows, located, make_trip, ordered
from modelcast.io.spmd import valid_position
from modelcast.trips.trajectory import Trajectory

__all__ = ["PcapReader"]

_BLOCK_MESSAGES = 20_000


class PcapReader(AbstractHoldingReader):
    """Reads captures; the module's docstring has the fields and what is skipped."""

    name: ClassVar[str] = "pcap"

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether it begins as a capture."""
        del path
        return is_capture(head)

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per temporary id, as `modelcast.io.gathering` gathers them."""
        capture = _CapturedRows(path)
        trips = gathered(capture, self.held_bytes)
        found = next(trips, None)
        for told in capture.told:
            on_skipped(recording_stem(path), told)
        while found is not None:
            name, tally = capture.called(found.key), Tally()
            trip = _trip(path, name, found.rows, tally)
            if trip is None:
                on_skipped(name, tally.why_empty())
            else:
                yield trip
            found = next(trips, None)


class _CapturedRows(AbstractKeyedRows[int]):
    """The messages of a capture; `told` is what is to be said of other records, once all were read."""

    needs_rows: ClassVar[bool] = False

    def __init__(self, path: str) -> None:
        self.path = path
        self.told: list[str] = []

    @property
    def columns(self) -> int:
        """Time and what a trip takes."""
        return 1 + len(CORE_COLUMNS)

    def called(self, key: int) -> str:
        """``<stem>/<id>``."""
        return f"{recording_stem(self.path)}/{key:08x}"

    def blocks(self, *, rows: bool) -> Iterator[KeyedBlock[int]]:
        """Yield messages some at a time."""
        capture = Captured(self.path)
        messages = capture.messages()
        index = 0
        while several := list(islice(messages, _BLOCK_MESSAGES)):
            ids = [message.temporary_id for message in several]
            place = {key: at for at, key in enumerate(dict.fromkeys(ids))}
            number = np.array([place[key] for key in ids], dtype=np.int64)
            yield KeyedBlock(index, list(place), number, _rows(several) if rows else None)
            index += 1
        self.told = capture.told()


def _rows(messages: Sequence[CapturedMessage]) -> Rows:
    values = [message.core.values() for message in messages]
    columns = {name: np.array([_number(one[of]) for one in values]) for name, of in CORE_COLUMNS.items()}
    t_s = np.array([_number(message.t_s) for message in messages])
    return Rows(np.array([message.number for message in messages], dtype=np.int64), {"t_s": t_s, **columns})


def _number(value: float | None) -> float:
    return np.nan if value is None else value


def _trip(path: str, name: str, heard: Rows, tally: Tally) -> Trajectory | None:
    times = heard.columns["t_s"]
    known = times[np.isfinite(times)]
    start_s = float(known.min()) if known.size else 0.0
    rows = heard.having(t_s=times - start_s)
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
