"""INTERACTION: tracks of vehicles and people at junctions, seen by drones and fixed cameras, 10 Hz.

``vehicle_tracks_000.csv`` and ``pedestrian_tracks_000.csv`` of a scenario. A trip is a track,
``<stem>/<track_id>``; in files of the prediction challenge, which hold cases of a few seconds, it is
``<stem>/<case_id>-<track_id>``. Columns are found by name, in any order; others are not read.

====================  ====  ================================================================================
Column                Unit  Use
====================  ====  ================================================================================
track_id              -     the trip; those of people begin with ``P``
case_id               -     the trip too, where the file has it
timestamp_ms          ms    time since the video began, one clock for all tracks of a file, or of a case
x, y                  m     position of the middle of the box, taken as east and north
vx, vy                m/s   speed is their size
psi_rad               rad   heading: 0 along x, anticlockwise; blank for people
frame_id              -     not used: timestamp_ms says the same
agent_type            -     not used: ``car``, or ``pedestrian/bicycle``
length, width         m     not used
====================  ====  ================================================================================

The plane is that of the scenario's map, about a point of its own: trips have no origin. The box's middle
stays where it was measured, also where it is not what turns.

Skipped and counted: "time missing", "position missing", "duplicate time" (the first is kept), a cut last line
("partial last line"). Repaired and counted: "out of time order"; single missing speeds and headings, held or
left out as `rows` says. A blank track_id is an error.

References
----------
W. Zhan et al., INTERACTION Dataset, arXiv:1910.03088; github.com/interaction-dataset/interaction-dataset, the
format's README (columns, units) and the viewer (one clock a file).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.io.base import OnSkipped, Tally, ignore_skipped
from modelcast.io.gathered_trips import TripRows, UsableRows, trips_of
from modelcast.io.gathering import gathered
from modelcast.io.holding import AbstractHoldingReader
from modelcast.io.keyed_text import KeyedText
from modelcast.io.rows import Rows
from modelcast.io.text_head import file_head, first_lines, split_fields
from modelcast.trips.trajectory import Trajectory

__all__ = ["InteractionReader"]

_NEEDED = ("track_id", "frame_id", "timestamp_ms", "agent_type", "x", "y", "vx", "vy")
_NUMBERS = ("timestamp_ms", "x", "y", "vx", "vy")
_CASE, _YAW = "case_id", "psi_rad"


@dataclass(frozen=True, slots=True)
class InteractionReader(AbstractHoldingReader):
    """Reads INTERACTION tracks; the module's docstring has the columns and the repairs."""

    name: ClassVar[str] = "interaction"
    streams: ClassVar[bool] = True

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether the header names the format's columns."""
        del path
        lines = first_lines(head)
        return bool(lines) and set(_NEEDED) <= set(split_fields(lines[0]))

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per track."""
        table = _table(path)
        one_clock = _CASE not in table.keys

        def usable(rows: Rows, tally: Tally) -> UsableRows:
            return UsableRows(_in_si(rows, tally), clock_offset_s=0.0 if one_clock else None)

        found = (
            TripRows(table.name_of(one.key), one.rows, one.partial)
            for one in gathered(table, self.held_bytes)
        )
        yield from trips_of(path, self.name, found, usable, on_skipped)


def _table(path: str) -> KeyedText:
    lines = first_lines(file_head(path))
    header = split_fields(lines[0]) if lines else []
    missing = [name for name in _NEEDED if name not in header]
    if not any(header):
        raise DataFormatError(path, "the file is empty", remedy="Check that it is complete.")
    if missing:
        raise DataFormatError(
            path, f"the header has no column {missing[0]!r}", row=1,
            remedy=f"interaction needs the columns {', '.join(_NEEDED)}.",
        )  # fmt: skip
    keys = (_CASE, "track_id") if _CASE in header else ("track_id",)
    numbers = (*_NUMBERS, _YAW) if _YAW in header else _NUMBERS
    return KeyedText(
        path, place={name: header.index(name) for name in (*keys, *numbers)}, keys=keys, numbers=numbers,
        counts=(len(header),), skip_lines=1, name_of="-".join,
    )  # fmt: skip


def _in_si(rows: Rows, tally: Tally) -> Rows:
    """Return the rows with a time and a position, in SI units."""
    rows = rows.without(np.isnan(rows.columns["timestamp_ms"]), "time missing", tally)
    rows = rows.without(np.isnan(rows.columns["x"] + rows.columns["y"]), "position missing", tally)
    raw = rows.columns
    columns = {
        "t_s": raw["timestamp_ms"] / 1000.0,
        "east_m": raw["x"],
        "north_m": raw["y"],
        "speed_mps": np.hypot(raw["vx"], raw["vy"]),
    }
    if _YAW in raw:
        columns["heading_rad"] = wrap_angle_rad(0.5 * np.pi - raw[_YAW])
    return Rows(rows.line, columns)
