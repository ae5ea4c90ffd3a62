r"""NMEA 0183 logs: GGA and RMC sentences of any talker, any rate, one trip a receiver.

The trip is ``<stem>/receiver``; where a log holds several receivers (`modelcast.io.nmea_receivers`), the
first talker of each is added: ``<stem>/receiver-GP``. A GGA and an RMC of the same time are one epoch.

==========  ====================================  =====================================================
Sentence    Field                                 Use
==========  ====================================  =====================================================
GGA         1 hhmmss.sss                          time of day (UTC)
            2-5 latitude, N/S, longitude, E/W     position, degrees and minutes
            6 fix quality                         0 is no fix
            9 altitude, 11 geoid separation [m]   their sum: height above the ellipsoid
RMC         1 hhmmss.sss, 9 ddmmyy                time of day and date (UTC)
            2 status, 12 mode                     V, or mode N, is no fix
            3-6 latitude, N/S, longitude, E/W     position, where the epoch has no GGA
            7 speed [knots]                       speed
            8 course [deg]                        heading, clockwise from true north
==========  ====================================  =====================================================

Two-digit years are 1981-2079; 1980 is a date that the receiver does not know yet, and none. Times have the
date of the last RMC; where the time of day falls by over 12 hours it is midnight. Without any RMC date a trip
has no absolute time.

Lines end with LF, CRLF or CR alone. A sentence begins at ``$`` and ends at the next one: sentences glued
together are read, and one that the next cuts short is counted. Text before ``$`` (a tag block, a word of the
logger) and behind the checksum (a time stamp) is passed over. Sixty minutes are a degree.

Skipped and counted: "bad checksum", "no checksum" (also what is left of a cut sentence), "bad field" (under a
good checksum), "no fix", "no time", "position missing", "duplicate time" (the first epoch of a time is kept),
"partial last line"; "no first value yet". Other sentences are not counted. Repaired and counted: "out of time
order" (sorted); a missing speed or course (blank at standstill), held or left out as `rows` says. Rows are
epochs and faulty sentences; the latter count with the first receiver.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import numpy as np

from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin, wrap_angle_rad
from modelcast.io.base import AbstractTripReader, OnSkipped, Tally, ignore_skipped
from modelcast.io.nmea_epochs import Epoch, epochs_of, midnights, refuse_second_receiver, timed
from modelcast.io.nmea_receivers import Heard, receivers
from modelcast.io.nmea_sentences import Fix, parse_fix, sentence_body, sentences, talker_of
from modelcast.io.packed import recording_stem
from modelcast.io.reading_limits import require_fitting
from modelcast.io.rows import Rows, located, make_trip, ordered
from modelcast.io.text_head import file_head, first_lines
from modelcast.trips.trajectory import Trajectory

__all__ = ["MOST_BYTES", "NmeaReader"]

MOST_BYTES = 640 * 2**20
"""What the sentences of a log may take: they are held until all receivers are told apart."""

_SENTENCE_BYTES = 1200
_POSITION = re.compile(r"\$[A-Z]{2,3}(GGA|RMC),")


@dataclass(slots=True)
class _Log:
    """The GGA and RMC sentences of a log, the faulty ones by reason, and the first that was malformed."""

    heard: list[Heard] = field(default_factory=list[Heard])
    faults: dict[str, int] = field(default_factory=dict[str, int])
    malformed: tuple[int, str] | None = None

    def fix(self, number: int, sentence: str, body: str | None) -> Fix | None:
        """Return what a sentence says, None where it is another one or faulty, which is counted."""
        if body is None:
            self._fault(_why_faulty(sentence))
            return None
        try:
            return parse_fix(body)
        except ValueError as error:
            self.malformed = self.malformed or (number, str(error))
            self._fault("bad field")
            return None

    def cut(self, last_line: str) -> None:
        """Count the last sentence of a last line without a line end as cut, where it is faulty."""
        last = sentences(last_line)[-1:]
        if last and sentence_body(last[0]) is None:
            self.faults[_why_faulty(last[0])] -= 1
            self._fault("partial last line")

    def _fault(self, reason: str) -> None:
        self.faults[reason] = self.faults.get(reason, 0) + 1


def _why_faulty(sentence: str) -> str:
    """Return why a sentence without a good checksum is skipped."""
    return "bad checksum" if "*" in sentence else "no checksum"


class NmeaReader(AbstractTripReader):
    """Reads NMEA logs; the module's docstring has the sentences and the repairs."""

    name: ClassVar[str] = "nmea"

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether one of the first sentences has a good checksum, or begins like a GGA or RMC."""
        del path
        return any(
            sentence_body(sentence) is not None or _POSITION.match(sentence)
            for line in first_lines(head)
            for sentence in sentences(line)
        )

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per receiver; the epochs are held in memory."""
        log = _log(path)
        found = receivers(log.heard)
        log.heard.clear()
        faults = log.faults
        alone = len(found) == 1
        for name in list(found):
            heard = found.pop(name)
            receiver = "receiver" if alone else f"receiver-{name}"
            trip_id = f"{recording_stem(path)}/{receiver}"
            tally = Tally()
            for reason, count in faults.items():
                tally.skip(reason, count)
            trip = _trip(path, trip_id, heard, tally, faulty=sum(faults.values()))
            faults = {}
            if trip is None:
                on_skipped(trip_id, tally.why_empty())
            else:
                yield trip


def _log(path: str) -> _Log:
    """Return what a file holds.

    Raises
    ------
    DataFormatError
        Where it is empty or has no GGA or RMC sentence that can be read.
    """
    file_head(path)
    log = _Log()
    name = f"{recording_stem(path)}/receiver"
    empty = True
    line = ""
    days, last_s = 0, float("nan")
    with Path(path).open(encoding="ascii", errors="replace", newline=None) as file:
        for number, line in enumerate(file, start=1):
            empty = empty and not line.strip()
            for sentence in sentences(line):
                body = sentence_body(sentence)
                fix = log.fix(number, sentence, body)
                if body is None or fix is None:
                    continue
                if fix.valid and np.isfinite(fix.time_of_day_s):
                    days += midnights(last_s, fix.time_of_day_s)
                    last_s = fix.time_of_day_s
                require_fitting(path, name, len(log.heard), row_bytes=_SENTENCE_BYTES, held_bytes=MOST_BYTES)
                log.heard.append(Heard(len(log.heard), number, talker_of(body), days, fix))
        if not line.endswith("\n"):
            log.cut(line)
    if empty:
        raise DataFormatError(path, "the file is empty", remedy="Check that it is complete.")
    if not log.heard:
        _refuse(path, log)
    return log


def _refuse(path: str, log: _Log) -> None:
    """Raise what is wrong with a log without a GGA or RMC sentence that can be read."""
    if log.malformed is not None:
        row, problem = log.malformed
        raise DataFormatError(
            path, f"{problem} in a sentence with a good checksum", row=row, remedy="Remove the sentence."
        )
    counts = ", ".join(f"{count} with {reason}" for reason, count in log.faults.items())
    raise DataFormatError(
        path,
        "no GGA or RMC sentence with a good checksum" + (f" ({counts})" if counts else ""),
        remedy="Position is read from GGA and RMC with their checksums, and from no other sentence.",
    )


def _trip(path: str, trip_id: str, heard: list[Heard], tally: Tally, *, faulty: int) -> Trajectory | None:
    """Return one receiver's trip, or None where no epoch is usable."""
    epochs = epochs_of(heard)
    heard.clear()
    refuse_second_receiver(path, epochs)
    epochs, start_unix_s = timed(epochs)
    rows = _rows(epochs, tally)
    if not len(rows):
        return None
    first = {name: float(column[0]) for name, column in rows.columns.items()}
    altitude = first["altitude_m"]
    origin = Origin(first["latitude_deg"], first["longitude_deg"], altitude if np.isfinite(altitude) else 0.0)
    rows = located(ordered(rows, tally), origin)
    return make_trip(
        path, trip_id, rows, tally,
        count=len(epochs) + faulty, source=NmeaReader.name, origin=origin, unix_offset_s=start_unix_s,
    )  # fmt: skip


def _rows(epochs: list[Epoch], tally: Tally) -> Rows:
    """Return the epochs with a fix, a time and a position, in SI units."""
    fixes = [epoch.heard.fix for epoch in epochs]
    rows = Rows(
        np.array([epoch.heard.line for epoch in epochs], dtype=np.int64),
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
    rows = rows.without(np.isnan(rows.columns["t_s"]), "no time", tally)
    unplaced = np.isnan(rows.columns["latitude_deg"] + rows.columns["longitude_deg"])
    return rows.without(unplaced, "position missing", tally)
