"""GPX 1.0 and 1.1: every track of a file is a trip, ``<stem>/track-<number>``.

=========================  ==============================================================================
Element of ``trkpt``       Use
=========================  ==============================================================================
attributes lat, lon        position [deg], WGS-84
ele                        height [m] as it stands: by the schema no datum is said, by custom sea level
time                       ISO 8601; with a zone, or UTC without one, as the schema says
fix                        ``none`` is no fix
speed                      speed [m/s]
course, cog                heading [deg], clockwise from true north
extensions                 speed, course and cog at any depth in it, whatever the name space
=========================  ==============================================================================

``speed`` and ``course`` are elements of GPX 1.0; 1.1 left them out, and loggers put them into ``extensions``
(``TrackPointExtension`` version 2 of Garmin, ``gpxdata`` of ClueTrust, OsmAnd) or leave them where they were:
both are read, and the point's own goes before the extension's. Their unit is the schemas', m/s: where a
logger writes km/h, `modelcast trips` tells that speed contradicts the positions. ``bearing``, of Garmin and
OsmAnd, is not read: it need not be the direction of motion.

A segment (``trkseg``) is a gap: a part of the trip begins with it, however short the time between. Tracks
without any time give no trip, and a file without any time is an error.

Skipped and counted: "no fix" (also latitude and longitude 0), "time missing", "duplicate time", "no first
value yet". Repaired and counted: "out of time order", "no time zone, UTC taken", missing speed or course
(held or left out as `rows` says). Way points and points of routes are reported. Rows in errors are lines. A
track is held, 72 octets a point; the file is not.

References
----------
https://www.topografix.com/GPX/1/1/ and https://www.topografix.com/GPX/1/0/gpx.xsd (2004, 2002);
https://www8.garmin.com/xmlschemas/TrackPointExtensionv2.xsd.
"""

import re
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import ClassVar

import numpy as np
import polars as pl

from modelcast.core.arrays import BoolArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin, wrap_angle_rad
from modelcast.io.base import OnSkipped, Tally, ignore_skipped
from modelcast.io.fcd_source import fcd_kind
from modelcast.io.gpx_points import CELLS, GpxPoint, GpxPoints
from modelcast.io.holding import AbstractHoldingReader
from modelcast.io.packed import recording_stem
from modelcast.io.reading_limits import require_fitting
from modelcast.io.rows import Rows, joined, located, make_trip, ordered, with_missing
from modelcast.io.spmd import valid_position
from modelcast.io.text_blocks import Block, number_column, text_column
from modelcast.io.time_column import TimeColumn, TimeUnit, holds_dates
from modelcast.trips.trajectory import Trajectory

__all__ = ["GpxReader"]

_ROOT = re.compile(rb"<([\w.-]+:)?gpx[\s>]")
_POINTS = 2**16
"""Points turned from text into numbers at a time."""

_TIME, _FIX = CELLS.index("time"), CELLS.index("fix")
_NUMBERS = {
    "latitude_deg": "lat",
    "longitude_deg": "lon",
    "altitude_m": "ele",
    "speed_mps": "speed",
    "heading_deg": "course",
}
_ROW_BYTES = 8 * (len(_NUMBERS) + 4)
"""Of a point: its numbers, line, time, segment and fix."""


class GpxReader(AbstractHoldingReader):
    """Reads GPX tracks; the module's docstring has the elements and the choices."""

    name: ClassVar[str] = "gpx"
    streams: ClassVar[bool] = True

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether this is XML whose root is ``gpx``."""
        del path
        return head.removeprefix(b"\xef\xbb\xbf").lstrip().startswith(b"<") and bool(_ROOT.search(head))

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip a track, in the file's order."""
        if fcd_kind(path) != "xml":
            raise DataFormatError(path, "is no XML", remedy="GPX begins with <?xml or <gpx.")
        stem = recording_stem(path)
        points = GpxPoints(path)
        origin: Origin | None = None
        timed = 0
        for number, of_track in groupby(points, lambda point: point.track):
            trip_id = f"{stem}/track-{number}"
            tally = Tally()
            rows, unit = _numbers(path, trip_id, of_track, self.held_bytes)
            count = len(rows)
            timed += int(np.isfinite(rows.columns["t_s"]).sum())
            rows = _usable(rows, unit, tally)
            trip = None
            if len(rows):
                origin = _first(rows) if origin is None else origin
                rows = located(ordered(rows, tally), origin)
                start_s = unit.start * unit.unit_s
                trip = make_trip(
                    path, trip_id, rows, tally, count=count, source=self.name, origin=origin,
                    unix_offset_s=start_s, clock_offset_s=start_s,
                )  # fmt: skip
            if trip is None:
                on_skipped(trip_id, tally.why_empty())
            else:
                yield trip
        if points.others:
            on_skipped(f"{stem}/points", f"{points.others} way points and points of routes are no recording")
        if not timed:
            beside = f" beside {points.others} way points and points of routes" if points.others else ""
            what = "no track point has a time" if points.tracks else f"no track (trk){beside}"
            raise DataFormatError(
                path, what, remedy="Export the track as recorded, with times; a planned route is no trip."
            )


def _numbers(path: str, trip_id: str, points: Iterator[GpxPoint], held_bytes: int) -> tuple[Rows, TimeUnit]:
    """Return a track's points as numbers, times from `TimeUnit.start`, NaN where there is none."""
    parts: list[Rows] = []
    count = 0
    times = TimeColumn(path, "time", 1.0, stated=True)
    batch: list[GpxPoint] = []
    for point in points:
        batch.append(point)
        if len(batch) == _POINTS:
            count += _POINTS
            require_fitting(path, trip_id, count, row_bytes=_ROW_BYTES, held_bytes=held_bytes)
            parts.append(_part(path, batch, times))
            batch = []
    if batch or not parts:
        parts.append(_part(path, batch, times))
    return joined(parts), times.unit


def _part(path: str, points: list[GpxPoint], times: TimeColumn) -> Rows:
    """Return points as numbers."""
    line = np.array([point.row for point in points], np.int64)
    cells = {
        name: pl.Series(name, [point.cells[at] for point in points], pl.String)
        for at, name in enumerate(CELLS)
    }
    block = Block(0, pl.DataFrame({str(at): cells[name] for at, name in enumerate(CELLS)}), line, 0)
    columns = {
        meaning: number_column(path, block, CELLS.index(name), name) for meaning, name in _NUMBERS.items()
    }
    for name, most in (("latitude_deg", 90.0), ("longitude_deg", 180.0)):
        wrong = ~(np.abs(columns[name]) <= most)
        if wrong.any():
            at = int(np.argmax(wrong))
            word = _NUMBERS[name]
            raise DataFormatError(
                path, f"{word} is {cells[word][at]!r}, not within {most:.0f} degrees", row=int(line[at]),
                remedy="Correct or remove the point.",
            )  # fmt: skip
    text = text_column(block, _TIME)
    _refuse_other_times(path, text, line)
    return Rows(
        line,
        {
            "t_s": times.read(text, line) if text.count() else np.full(len(line), np.nan),
            **columns,
            "piece": np.array([point.piece for point in points], np.float64),
            "no_fix": (cells["fix"] == "none").fill_null(value=False).cast(pl.Float64).to_numpy(),
        },
    )


def _refuse_other_times(path: str, text: pl.Series, line: np.ndarray) -> None:
    """Refuse a track whose first time is no date and time, as numbers alone would pass for one."""
    if text.count() and not holds_dates(text):
        at = int(text.is_not_null().arg_max() or 0)
        raise DataFormatError(
            path, f"time is {text[at]!r}, not a date and time as 2024-03-15T10:00:00Z", row=int(line[at]),
            remedy="Correct or remove the value.",
        )  # fmt: skip


def _usable(rows: Rows, unit: TimeUnit, tally: Tally) -> Rows:
    """Return the points with a fix and a time, in SI units, without what no point has."""
    columns = dict(rows.columns)
    columns["t_s"] = columns["t_s"] * unit.unit_s
    columns["speed_mps"] = with_missing(columns["speed_mps"], columns["speed_mps"] < 0.0)
    columns["heading_rad"] = wrap_angle_rad(np.radians(columns.pop("heading_deg")))
    for name in ("altitude_m", "speed_mps", "heading_rad"):
        if np.isnan(columns[name]).all():
            del columns[name]
    rows = Rows(rows.line, columns)
    rows = rows.without(_no_fix(rows), "no fix", tally)
    rows = rows.without(np.isnan(rows.columns["t_s"]), "time missing", tally)
    if not unit.unix:
        tally.repair("no time zone, UTC taken", len(rows))
    return Rows(rows.line, {name: column for name, column in rows.columns.items() if name != "no_fix"})


def _no_fix(rows: Rows) -> BoolArray:
    nowhere = ~valid_position(rows.columns["latitude_deg"], rows.columns["longitude_deg"])
    return (rows.columns["no_fix"] > 0.0) | nowhere


def _first(rows: Rows) -> Origin:
    """Return the first point as the origin of the file's frame."""
    columns = rows.columns
    altitude = float(columns["altitude_m"][0]) if "altitude_m" in columns else 0.0
    return Origin(
        float(columns["latitude_deg"][0]),
        float(columns["longitude_deg"][0]),
        altitude if np.isfinite(altitude) else 0.0,
    )
