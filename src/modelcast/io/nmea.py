r"""NMEA 0183 logs: GGA and RMC sentences of any talker, one receiver a file, any rate.

The trip is ``<stem>/receiver``. GGA and RMC with the same time of day, one after the other, are one epoch.

==========  ====================================  =====================================================
Sentence    Field                                 Use
==========  ====================================  =====================================================
GGA         1 hhmmss.sss                          time of day (UTC)
            2-5 latitude, N/S, longitude, E/W     position, degrees and minutes
            6 fix quality                         0 is no fix
            9 altitude, 11 geoid separation [m]   their sum: height above the ellipsoid
RMC         1 hhmmss.sss, 9 ddmmyy                time of day and date (UTC)
            2 status                              V is no fix
            3-6 latitude, N/S, longitude, E/W     position, where the epoch has no GGA
            7 speed [knots]                       speed
            8 course [deg]                        heading, clockwise from true north
==========  ====================================  =====================================================

Two-digit years are 1980-2079. Times have the date of the last RMC; where the time of day falls by over 12
hours it is midnight. Without any RMC date a trip has no absolute time. A tag block (``\...\``) or text
before ``$`` is passed over.

Skipped and counted: "bad checksum" (sentences without one too), "no fix", "position missing", "duplicate
time", "partial last line"; "no first value yet". Other sentences are not counted. Repaired and counted:
"out of time order" (sorted); a missing speed or course (blank at standstill), held or left out as `rows`
says. A sentence with a good checksum and a bad field is an error. Rows are epochs and bad sentences.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, date, datetime
from pathlib import Path
from typing import ClassVar

import numpy as np

from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin, wrap_angle_rad
from modelcast.core.trajectory import Trajectory
from modelcast.io.base import AbstractTripReader, OnSkipped, Tally, ignore_skipped
from modelcast.io.nmea_sentences import Fix, parse_fix, sentence_body
from modelcast.io.rows import Rows, located, make_trip, ordered
from modelcast.io.text_head import first_lines

__all__ = ["NmeaReader"]

_DAY_S = 86400.0


@dataclass(frozen=True, slots=True)
class _Epoch:
    """All that is known about one instant."""

    line: int
    t_s: float
    fix: Fix


class NmeaReader(AbstractTripReader):
    """Reads NMEA logs; the module's docstring has the sentences and the repairs."""

    name: ClassVar[str] = "nmea"

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether one of the first lines is a sentence with a good checksum."""
        del path
        return any(sentence_body(line) is not None for line in first_lines(head)[:50])

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield the receiver's one trip; the epochs are held in memory."""
        tally = Tally()
        trip_id = f"{Path(path).stem}/receiver"
        fixes, faulty = _fixes(path, tally)
        epochs, start_unix_s = _epochs(fixes)
        if not epochs:
            raise DataFormatError(
                path,
                "no GGA or RMC sentence with a good checksum",
                remedy="Other sentences hold no position.",
            )
        count = len(epochs) + faulty
        rows = _rows(epochs, tally)
        trip = None
        if len(rows):
            first = {name: float(column[0]) for name, column in rows.columns.items()}
            altitude = first["altitude_m"]
            origin = Origin(
                first["latitude_deg"], first["longitude_deg"], altitude if np.isfinite(altitude) else 0.0
            )
            rows = located(ordered(rows, tally), origin)
            trip = make_trip(
                path, trip_id, rows, tally,
                count=count, source=self.name, origin=origin, unix_offset_s=start_unix_s,
            )  # fmt: skip
        if trip is None:
            on_skipped(trip_id, tally.why_empty())
        else:
            yield trip


def _fixes(path: str, tally: Tally) -> tuple[list[tuple[int, Fix]], int]:
    """Return the GGA and RMC sentences with their lines, and the number of faulty sentences."""
    fixes: list[tuple[int, Fix]] = []
    faulty = 0
    empty = True
    with Path(path).open(encoding="ascii", errors="replace", newline="\n") as file:
        for number, line in enumerate(file, start=1):
            empty = empty and not line.strip()
            if "$" not in line:
                continue
            body = sentence_body(line)
            if body is None:
                faulty += 1
                tally.skip("bad checksum" if line.endswith("\n") else "partial last line", 1)
                continue
            try:
                fix = parse_fix(body)
            except ValueError as error:
                raise DataFormatError(
                    path, f"{error} in a sentence with a good checksum", row=number,
                    remedy="Remove the sentence.",
                ) from error  # fmt: skip
            if fix is not None:
                fixes.append((number, fix))
    if empty:
        raise DataFormatError(path, "the file is empty", remedy="Check that it is complete.")
    return fixes, faulty


def _epochs(fixes: list[tuple[int, Fix]]) -> tuple[list[_Epoch], float | None]:
    """Return the sentences joined by time of day, with times from the first day's midnight, and its date.

    Times are not Unix times yet, because in float64 those lose a quarter of a microsecond.
    """
    merged: list[tuple[int, Fix]] = []
    for line, fix in fixes:
        if merged and merged[-1][1].time_of_day_s == fix.time_of_day_s and merged[-1][1].kind != fix.kind:
            merged[-1] = (merged[-1][0], merged[-1][1].joined(fix))
        else:
            merged.append((line, fix))
    dates = [fix.day for _, fix in merged if fix.day is not None]
    first_s = _unix_day_s(dates[0]) if dates else 0.0
    day_s = 0.0
    first_dated = next((at for at, (_, fix) in enumerate(merged) if fix.day is not None), 0)
    # A midnight before the first date belongs to the day before it.
    day_s -= _DAY_S * sum(_midnight(merged[at - 1][1], merged[at][1]) for at in range(1, first_dated + 1))
    epochs: list[_Epoch] = []
    for at, (line, fix) in enumerate(merged):
        if at and fix.day is None:
            day_s += _DAY_S * _midnight(merged[at - 1][1], fix)
        elif fix.day is not None:
            day_s = _unix_day_s(fix.day) - first_s
        epochs.append(_Epoch(line, day_s + fix.time_of_day_s, fix))
    return epochs, first_s if dates else None


def _midnight(before: Fix, after: Fix) -> int:
    """Return 1 where midnight lies between two fixes, -1 where the later one is late from before it."""
    fall_s = before.time_of_day_s - after.time_of_day_s
    return int(fall_s > _DAY_S / 2) - int(fall_s < -_DAY_S / 2)


def _unix_day_s(day: date) -> float:
    return datetime(day.year, day.month, day.day, tzinfo=UTC).timestamp()


def _rows(epochs: list[_Epoch], tally: Tally) -> Rows:
    """Return the epochs with a fix and a position, in SI units."""
    fixes = [epoch.fix for epoch in epochs]
    rows = Rows(
        np.array([epoch.line for epoch in epochs], dtype=np.int64),
        {
            "t_s": np.array([epoch.t_s for epoch in epochs], dtype=np.float64),
            "latitude_deg": np.array([fix.latitude_deg for fix in fixes], dtype=np.float64),
            "longitude_deg": np.array([fix.longitude_deg for fix in fixes], dtype=np.float64),
            "altitude_m": np.array([fix.altitude_m for fix in fixes], dtype=np.float64),
            "speed_mps": np.array([fix.speed_mps for fix in fixes], dtype=np.float64),
            "heading_rad": wrap_angle_rad(
                np.radians(np.array([fix.course_deg for fix in fixes], dtype=np.float64))
            ),
        },
    )
    no_fix = np.array([not fix.valid for fix in fixes], dtype=np.bool_)
    rows = rows.without(no_fix, "no fix", tally)
    unplaced = np.isnan(rows.columns["latitude_deg"] + rows.columns["longitude_deg"])
    return rows.without(unplaced, "position missing", tally)
