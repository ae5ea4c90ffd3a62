"""Basic safety messages of the connected-vehicle pilots (Tampa, Wyoming) as data.transportation.gov has them.

The pilots' JSON (`modelcast.io.ode_bsm`), flattened to tables: a column a member, its names joined by ``_``.
Columns are found by name, whatever their order and case; others are not read. A trip is a temporary id,
``<stem>/<coreData_id>``; who changes the id becomes two trips, and nothing was verified.

================================================  =======================  =================================
Column, or instead                                Wyoming / Tampa          Use
================================================  =======================  =================================
coreData_id                                       -                        the trip
coreData_secMark                                  ms                       time in the minute
metadata_generatedAt, else metadata_receivedAt    date and time            the minute
  (also recordGeneratedAt, odeReceivedAt)
coreData_position_lat, _long (also coreData_lat,  deg / 1e-7 deg           position
  _long, _position_latitude, _longitude)
coreData_elevation (_elev, _position_elevation)   m / 0.1 m                height
coreData_speed                                    m/s / 0.02 m/s           speed
coreData_heading                                  deg / 0.0125 deg         heading, clockwise from north
coreData_accelset_long (_accelLong)               m/s² / 0.01 m/s²         acceleration
coreData_accelset_accelYaw (_yaw)                 deg/s / 0.01 deg/s       yaw rate, clockwise positive
================================================  =======================  =================================

Tampa's values are the standard's whole numbers, Wyoming's were converted. The first latitude tells which: in
degrees none is over 90; the rest of the file has to agree, and codes have to be whole numbers. Both stamps
were cut to a date and time without a zone on the way (Wyoming's are of UTC, Tampa's of Florida), so trips
have no absolute time. How a message's instant comes of its mark and a stamp: as in `modelcast.io.ode_bsm`.
Some exports give stamps in whole seconds, which does no harm.

Cells may be quoted, with commas and doubled quotes inside (``coreData_size`` is JSON), but hold no line end.
Skipped, repaired and counted as in `modelcast.io.ode_bsm`; a cut last line is "partial last line".

References
----------
github.com/usdot-its-jpo-data-portal: sandbox_exporter, the flatteners of WYDOT and THEA (names of columns,
stamps, and that Tampa's units are not converted). data.transportation.gov: Tampa CV Pilot BSM Sample,
doi:10.21949/1504502; Wyoming CV Pilot BSM One Day Sample (descriptions of columns: "units changed to").
"""

import csv
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from io import TextIOWrapper
from pathlib import Path
from typing import ClassVar, TextIO

import numpy as np

from modelcast.core.exceptions import DataFormatError
from modelcast.core.rules import is_clean, shown
from modelcast.io.base import OnSkipped, ignore_skipped
from modelcast.io.bsm_trips import AbstractBsmLog, BsmRow, bsm_trips
from modelcast.io.bsm_values import CORE_COLUMNS
from modelcast.io.holding import AbstractHoldingReader
from modelcast.io.log_stamps import LogClock
from modelcast.io.packed import open_octets
from modelcast.io.rows import LARGEST
from modelcast.io.text_head import file_head, first_lines, split_fields
from modelcast.trips.trajectory import Trajectory

__all__ = ["CvPilotReader"]

_ID, _MARK, _GENERATED, _RECEIVED = "coreData_id", "coreData_secMark", "generated", "received"
_NAMES: Mapping[str, tuple[str, ...]] = {
    _ID: ("coredata_id",),
    _MARK: ("coredata_secmark",),
    _GENERATED: ("metadata_generatedat", "metadata_recordgeneratedat"),
    _RECEIVED: ("metadata_receivedat", "metadata_received_at", "metadata_odereceivedat"),
    "latitude_deg": ("coredata_position_lat", "coredata_lat", "coredata_position_latitude"),
    "longitude_deg": ("coredata_position_long", "coredata_long", "coredata_position_longitude"),
    "altitude_m": ("coredata_elevation", "coredata_elev", "coredata_position_elevation"),
    "speed_mps": ("coredata_speed",),
    "heading_rad": ("coredata_heading",),
    "acceleration_mps2": ("coredata_accelset_long", "coredata_accelset_accellong"),
    "yaw_rate_radps": ("coredata_accelset_accelyaw", "coredata_accelset_yaw"),
}
"""Names of the columns that are read, in small letters."""

_NEEDED = (_ID, _MARK, "latitude_deg", "longitude_deg")
_LONGEST_LINE = 1 << 20
_LONGEST_NAME = 64
_LARGEST_LATITUDE_DEG = 90.0000002
"""J2735's 90.0000001, which is unavailable, is one too."""


@dataclass(frozen=True, slots=True)
class CvPilotReader(AbstractHoldingReader):
    """Reads tables of the pilots; the module's docstring has the columns and the repairs."""

    name: ClassVar[str] = "cv-pilot"
    streams: ClassVar[bool] = True

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether the header names the columns of a pilot."""
        del path
        lines = first_lines(head)
        return bool(lines) and not _missing(_places(split_fields(lines[0])))

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per temporary id, in the order in which they appear."""
        yield from bsm_trips(_table(path), self.name, on_skipped, self.held_bytes)


def _places(header: list[str]) -> dict[str, int]:
    """Return where our columns are, by our names."""
    names = [name.lower() for name in header]
    found = {ours: next((name for name in theirs if name in names), None) for ours, theirs in _NAMES.items()}
    return {ours: names.index(name) for ours, name in found.items() if name is not None}


def _missing(place: Mapping[str, int]) -> list[str]:
    """Return what a header lacks, in words."""
    lacks = [" or ".join(_NAMES[name]) for name in _NEEDED if name not in place]
    if not {_GENERATED, _RECEIVED} & place.keys():
        lacks.append(" or ".join((*_NAMES[_GENERATED], *_NAMES[_RECEIVED])))
    return lacks


def _table(path: str) -> "_PilotTable":
    lines = first_lines(file_head(path))
    header = split_fields(lines[0]) if lines else []
    if not any(header):
        raise DataFormatError(path, "the file is empty", remedy="Check that it is complete.")
    place = _places(header)
    if lacks := _missing(place):
        raise DataFormatError(
            path, f"the header has no column {lacks[0]}", row=1,
            remedy="cv-pilot needs an id, a position, a mark in the minute and a stamp.",
        )  # fmt: skip
    return _PilotTable(path, place, len(header))


@dataclass(slots=True)
class _PilotTable(AbstractBsmLog):
    """The rows of a table."""

    path: str
    place: Mapping[str, int]
    width: int
    clock: LogClock = field(default_factory=LogClock)
    codes: bool | None = None
    _cut: bool = False

    @property
    def cut(self) -> bool:
        """Whether the last line was."""
        return self._cut

    @property
    def utc(self) -> bool:
        """As the stamps."""
        return bool(self.clock.utc)

    def messages(self, *, numbers: bool) -> Iterator[BsmRow]:
        """Yield a message a row."""
        for line, cells in self._rows():
            sender = self._cell(cells, _ID)
            if not sender:
                raise self._wrong(line, "coreData_id is blank", "Every row needs it: it names the trip.")
            if len(sender) > _LONGEST_NAME or not is_clean(sender):
                raise self._wrong(line, f"coreData_id is {shown(sender)}, not a name")
            if not numbers:
                yield BsmRow(line, sender, 0.0, 0.0, False, ())
                continue
            try:
                stamp_ms = self.clock.first_of(self._cell(cells, name) for name in (_GENERATED, _RECEIVED))
            except ValueError as error:
                raise self._wrong(line, f"the time of the message is {error}") from error
            values = tuple(self._number(line, cells, name) for name in CORE_COLUMNS)
            mark_ms = self._number(line, cells, _MARK)
            yield BsmRow(line, sender, stamp_ms, mark_ms, self._are_codes(line, values[0]), values)

    def _are_codes(self, line: int, latitude: float) -> bool:
        """Return whether the table holds codes, as the first latitude says and all others have to."""
        if latitude != latitude or latitude == 0.0:  # noqa: PLR0124 - NaN; 0 is the same in both
            return bool(self.codes)
        codes = abs(latitude) > _LARGEST_LATITUDE_DEG
        if self.codes is None:
            self.codes = codes
        elif codes and not self.codes:
            raise self._wrong(
                line, f"the latitude is {latitude}, over 90 degrees, unlike the first of the file"
            )
        return self.codes

    def _rows(self) -> Iterator[tuple[int, list[str]]]:
        """Yield line numbers and cells behind the header, blank lines passed over."""
        self._cut = False
        with open_octets(self.path) as octets, TextIOWrapper(octets, "utf-8-sig", newline=None) as file:
            lines = _Lines(self.path, file)
            reader = csv.reader(lines, strict=True)
            header = True
            try:
                for cells in reader:
                    lines.end_row()
                    if header or not any(cell.strip("\0 \t") for cell in cells):
                        header = header and not any(cells)
                        continue
                    if len(cells) != self.width:
                        if len(cells) < self.width and lines.unended:
                            self._cut = True
                            return
                        raise self._wrong(
                            lines.number, f"{len(cells)} fields where the header has {self.width}",
                            "Check that the line is whole.",
                        )  # fmt: skip
                    yield lines.number, cells
            except csv.Error as error:
                if lines.unended and lines.number - lines.begun == 1:
                    self._cut = True
                    return
                raise self._wrong(
                    lines.begun + 1, f"cannot be split into fields: {error}", "Check the quotes in this line."
                ) from error

    def _cell(self, cells: list[str], name: str) -> str | None:
        """Return a cell, None where the table has not the column."""
        if name not in self.place:
            return None
        text = cells[self.place[name]].strip()
        return "" if text == "NULL" else text

    def _number(self, line: int, cells: list[str], name: str) -> float:
        """Return a cell as a number, NaN where it is blank or the table has not the column."""
        text = self._cell(cells, name)
        if not text:
            return np.nan
        try:
            value = float(text)
        except ValueError:
            value = np.inf
        if not abs(value) <= LARGEST:
            raise self._wrong(line, f"{name} is {shown(text)}, not a finite number")
        return value

    def _wrong(self, line: int, problem: str, remedy: str = "Correct or remove the line.") -> DataFormatError:
        return DataFormatError(self.path, problem, row=line, remedy=remedy)


class _Lines(Iterator[str]):
    """The lines of a file, none of them longer than `_LONGEST_LINE`.

    `number` is the last one's, `begun` that of the last one that ended a row, `unended` whether the last one
    ended with the file instead of a line end.
    """

    def __init__(self, path: str, file: TextIO) -> None:
        self.number = self.begun = 0
        self.unended = False
        self._path, self._file = path, file

    def end_row(self) -> None:
        """Take note that the last line ended a row.

        Raises
        ------
        csv.Error
            Where the row began in another line.
        """
        if self.number - self.begun > 1:
            raise csv.Error("a quoted cell holds a line end")
        self.begun = self.number

    def __next__(self) -> str:
        line = self._file.readline(_LONGEST_LINE)
        if not line:
            raise StopIteration
        self.number += 1
        self.unended = not line.endswith("\n")
        if self.unended and len(line) == _LONGEST_LINE:
            raise DataFormatError(
                self._path, f"a line of over {_LONGEST_LINE} characters", row=self.number,
                remedy="A row is a line.",
            )  # fmt: skip
        return line
