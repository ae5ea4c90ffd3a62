"""New York City connected-vehicle pilot: the BSMs around one warning, as JSON, 10 Hz.

``bsmList`` holds the messages of the host and of the vehicles it heard. Every ``id`` is a vehicle:
``<stem>/<id>``. Positions are in the event's own frame, about the host at the warning, so a trip has no
origin; times count from the warning, on one clock for all vehicles.

=======================  ======  ===================================================================
Field of ``coreData``    Unit    Use
=======================  ======  ===================================================================
id                       -       the vehicle
T_s                      s       time
X_m, Y_m, Z_m            m       east, north, up in the event's frame
speed_mps                m/s     speed
heading_deg              deg     heading, clockwise from the frame's north
accelSet.long_mpss       m/s²    acceleration
accelSet.yaw_dps         deg/s   yaw rate, clockwise positive (it follows the heading's change)
=======================  ======  ===================================================================

That X is east and Y is north was checked: ``heading_deg`` is the direction of travel in that frame.

Skipped and counted: "duplicate time" (the first message of a time is kept), "time missing", "position
missing". Repaired and counted: "out of time order" (sorted); missing values of optional columns and J2735's
unavailable ones (speed 163.82, heading 360, acceleration 20.01, yaw rate 327.67), held or left out as `rows`
says. Lost messages are gaps. A speed that stays the same while the vehicle moves is data, and is kept.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, cast

import numpy as np

from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.io.base import AbstractTripReader, OnSkipped, Tally, ignore_skipped
from modelcast.io.bsm_values import available
from modelcast.io.packed import recording_stem
from modelcast.io.rows import LARGEST, Rows, make_trip, ordered
from modelcast.trips.trajectory import Trajectory

__all__ = ["MOST_BYTES", "Event", "NycCvpdReader", "event_number", "read_event"]

MOST_BYTES = 32 * 2**20
"""Octets of an event; published ones have half a million, and JSON takes ten times as much when read."""

_CORE = ("T_s", "X_m", "Y_m", "Z_m", "speed_mps", "heading_deg")
_ACCELERATION = ("long_mpss", "yaw_dps")


class NycCvpdReader(AbstractTripReader):
    """Reads NYC pilot events; the module's docstring has the fields and the repairs."""

    name: ClassVar[str] = "nyc-cvpd"

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether this is JSON that begins like an event."""
        del path
        start = head.lstrip()
        return start.startswith(b"{") and (b'"eventHeader"' in head or b'"bsmList"' in head)

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per vehicle, in order of first appearance; the file is held whole."""
        stem = recording_stem(path)
        for vehicle, (records, values) in _messages(path).items():
            tally = Tally()
            raw = np.asarray(values, dtype=np.float64)
            columns = {str(name): raw[:, at] for at, name in enumerate((*_CORE, *_ACCELERATION))}
            rows = _usable(Rows(np.asarray(records, dtype=np.int64), columns), tally)
            trip_id = f"{stem}/{vehicle}"
            trip = make_trip(
                path, trip_id, rows, tally, count=len(records), source=self.name, clock_offset_s=0.0
            )
            if trip is None:
                on_skipped(trip_id, tally.why_empty())
            else:
                yield trip


def _usable(rows: Rows, tally: Tally) -> Rows:
    """Return the messages in time order, in SI units."""
    rows = rows.without(np.isnan(rows.columns["T_s"]), "time missing", tally)
    unplaced = np.isnan(rows.columns["X_m"] + rows.columns["Y_m"])
    rows = rows.without(unplaced, "position missing", tally)
    raw = rows.columns
    columns = {
        "t_s": raw["T_s"],
        "east_m": raw["X_m"],
        "north_m": raw["Y_m"],
        "up_m": raw["Z_m"],
        "speed_mps": available("speed_mps", raw["speed_mps"]),
        "heading_rad": wrap_angle_rad(np.radians(available("heading_rad", raw["heading_deg"]))),
        "acceleration_mps2": available("acceleration_mps2", raw["long_mpss"]),
        "yaw_rate_radps": np.radians(available("yaw_rate_radps", raw["yaw_dps"])),
    }
    return ordered(Rows(rows.line, columns), tally)


def _messages(path: str) -> dict[str, tuple[list[int], list[list[float]]]]:
    """Return every vehicle's record numbers, from 1, and numbers."""
    vehicles: dict[str, tuple[list[int], list[list[float]]]] = {}
    for record, vehicle, core in read_event(path).messages:
        acceleration = core.get("accelSet", {})
        numbers = [event_number(path, record, core, name) for name in _CORE]
        numbers += [event_number(path, record, acceleration, name) for name in _ACCELERATION]
        records, values = vehicles.setdefault(vehicle, ([], []))
        records.append(record)
        values.append(numbers)
    return vehicles


@dataclass(frozen=True, slots=True)
class Event:
    """An event as it is in its file.

    Parameters
    ----------
    host
        The vehicle that logged it; None where the file does not say.
    messages
        Each with its number, from 1, the vehicle and the core data.
    """

    host: str | None
    messages: list[tuple[int, str, Mapping[str, object]]]


def read_event(path: str) -> Event:
    """Return the messages of an event, every one with a vehicle.

    Parameters
    ----------
    path
        The file; it is held whole.

    Raises
    ------
    DataFormatError
        Where it is not JSON, holds no messages, or one has no core data or names no vehicle.
    """
    octets = Path(path).stat().st_size
    if octets > MOST_BYTES:
        raise DataFormatError(
            path, f"has {octets:,} octets: an event is held whole, up to {MOST_BYTES:,}",
            remedy="Write its messages into several events, or as csv.",
        )  # fmt: skip
    try:
        event = cast("object", json.loads(Path(path).read_text(encoding="utf-8-sig")))
    except (ValueError, RecursionError) as error:
        raise DataFormatError(path, f"is not JSON: {error}", remedy="Check that it is complete.") from error
    whole: Mapping[str, object] = cast("Mapping[str, object]", event) if isinstance(event, dict) else {}
    messages = whole.get("bsmList")
    if not isinstance(messages, list) or not messages:
        raise DataFormatError(path, "no bsmList with messages", remedy="Only events with BSMs hold trips.")
    found: list[tuple[int, str, Mapping[str, object]]] = []
    for record, message in enumerate(cast("list[object]", messages), start=1):
        core = message
        for name in ("bsmRecord", "bsmMsg", "coreData"):
            core = _member(path, record, core, name)
        vehicle = _member(path, record, core, "id")
        if not isinstance(vehicle, str) or not vehicle:
            raise DataFormatError(path, f"id is {vehicle!r}, not a name", row=record)
        found.append((record, vehicle, cast("Mapping[str, object]", core)))
    header = whole.get("eventHeader")
    host = cast("Mapping[str, object]", header).get("hostVehID") if isinstance(header, dict) else None
    return Event(host if isinstance(host, str) and host else None, found)


def _member(path: str, record: int, holder: object, name: str) -> object:
    """Return a member that has to be there."""
    if not isinstance(holder, dict) or name not in holder:
        raise DataFormatError(
            path, f"the message has no {name}", row=record, remedy="Rows count the messages of bsmList."
        )
    return cast("Mapping[str, object]", holder)[name]


def event_number(path: str, record: int, holder: object, name: str) -> float:
    """Return a member as a number, NaN where it is absent or null.

    Parameters
    ----------
    path, record
        Which message of which file, for errors.
    holder, name
        The member.

    Raises
    ------
    DataFormatError
        Where it is anything else.
    """
    value = cast("Mapping[str, object]", holder).get(name) if isinstance(holder, dict) else holder
    if value is None:
        return float("nan")
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= LARGEST:
        raise DataFormatError(
            path, f"{name} is {value!r}, not a finite number", row=record,
            remedy="Rows count the messages of bsmList.",
        )  # fmt: skip
    return float(value)
