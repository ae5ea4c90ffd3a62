"""What the three Safety Pilot (SPMD) formats share: keys, layout, and how a file becomes trips.

Published files reach many gigabytes and are not in order of vehicle and time throughout:
`modelcast.io.gathering` gathers their trips in bounded memory.
"""

import abc
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.io.base import OnSkipped, Tally, ignore_skipped
from modelcast.io.gathering import AbstractKeyedRows, Gathered, KeyedBlock, gathered
from modelcast.io.holding import AbstractHoldingReader
from modelcast.io.keyed_text import block_keys
from modelcast.io.packed import recording_stem
from modelcast.io.rows import Rows, located, make_trip, ordered, with_missing
from modelcast.io.text_blocks import Block, number_column, read_blocks
from modelcast.io.text_head import file_head, first_lines, rows_expected, split_fields
from modelcast.trips.trajectory import Trajectory

__all__ = [
    "AbstractSpmdReader",
    "Key",
    "SpmdFile",
    "SpmdLayout",
    "open_spmd",
    "valid_position",
]

Key = tuple[str, ...]
"""Values of the columns that name a trip."""

_NUMBER_CHARACTERS = frozenset("0123456789+-.eE ")


@dataclass(frozen=True, slots=True)
class SpmdLayout:
    """What tells one SPMD format from another.

    Parameters
    ----------
    source
        Name of the format.
    header
        All column names in the order of files without a header row.
    counts
        Numbers of fields a row may have.
    keys
        Columns whose values name a trip.
    numbers
        Columns to read as numbers.
    trip_name
        The vehicle part of a trip's identifier, from its key.
    usable
        Turns raw rows into SI columns and takes out the unusable ones, counting them.
    time
        The column of times, counted from the trip's first when `usable` sees it: a Unix time in float64
        seconds would lose a quarter of a microsecond.
    time_unit_s
        Its unit.
    duplicate
        Reason counted for rows that repeat a time.
    vehicle
        Which of the keys names the vehicle.
    start_unix
        Whether times are Unix times.
    """

    source: str
    header: tuple[str, ...]
    counts: frozenset[int]
    keys: tuple[str, ...]
    numbers: tuple[str, ...]
    time: str
    time_unit_s: float
    trip_name: Callable[[Key], str]
    usable: Callable[[Rows, Tally], Rows]
    duplicate: str = "duplicate time"
    vehicle: int = 0
    start_unix: bool = False


@dataclass(frozen=True, slots=True)
class SpmdFile:
    """Where a file's columns are.

    Parameters
    ----------
    path, layout
        The file and its format.
    at
        Number of each column, from 0.
    counts
        Numbers of fields a row may have.
    skip_lines
        Lines before the first row.
    """

    path: str
    layout: SpmdLayout
    at: Mapping[str, int]
    counts: frozenset[int]
    skip_lines: int

    def blocks(self, names: tuple[str, ...]) -> Iterator[Block]:
        """Yield the file in blocks.

        Parameters
        ----------
        names
            Columns wanted.
        """
        width = max(*self.counts, len(self.layout.header))
        wanted = [self.at[name] for name in names]
        numbers = [self.at[name] for name in names if name not in self.layout.keys]
        return read_blocks(
            self.path,
            counts=self.counts,
            fields=wanted,
            skip_lines=self.skip_lines,
            numbers=numbers,
            width=width,
        )

    def block_keys(self, block: Block) -> tuple[list[Key], IntArray]:
        """Return the keys of a block as `modelcast.io.keyed_text.block_keys` does.

        Parameters
        ----------
        block
            One that has the columns of the keys.

        Raises
        ------
        DataFormatError
            Where one of them is blank.
        """
        return block_keys(self.path, block, {name: self.at[name] for name in self.layout.keys})


def _is_number(text: str) -> bool:
    return set(text) <= _NUMBER_CHARACTERS or text == "NULL"


def _is_header(fields: list[str]) -> bool:
    return not _is_number(fields[0])


def open_spmd(path: str, layout: SpmdLayout) -> SpmdFile:
    """Return where the columns are, by the header row or, without one, by the format's order.

    Parameters
    ----------
    path
        The file.
    layout
        Its format.

    Raises
    ------
    DataFormatError
        Where the file is empty, or its header lacks a column.
    """
    lines = first_lines(file_head(path))
    if not lines or not any(line.strip() for line in lines):
        raise DataFormatError(path, "the file is empty", remedy="Check that it was downloaded completely.")
    fields = split_fields(lines[0])
    if not _is_header(fields):
        at = {name: number for number, name in enumerate(layout.header)}
        return SpmdFile(path, layout, at, layout.counts, 0)
    found = {name.lower(): number for number, name in enumerate(fields)}
    missing = [name for name in (*layout.keys, *layout.numbers) if name.lower() not in found]
    if missing:
        raise DataFormatError(
            path,
            f"the header has no column {missing[0]!r}",
            row=1,
            remedy=f"{layout.source} needs the columns {', '.join((*layout.keys, *layout.numbers))}.",
        )
    at = {name: found[name.lower()] for name in (*layout.keys, *layout.numbers)}
    return SpmdFile(path, layout, at, layout.counts | {len(fields)}, 1)


class AbstractSpmdReader(AbstractHoldingReader):
    """Reads files of one layout, in bounded memory; see the module's docstring."""

    streams = True

    @property
    @abc.abstractmethod
    def layout(self) -> SpmdLayout:
        """What tells its format from the others."""

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether the first line is the format's header, or its data without one."""
        del path
        lines = [split_fields(line) for line in first_lines(head) if line.strip()]
        if not lines:
            return False
        found = {name.lower() for name in lines[0]}
        if _is_header(lines[0]):
            return {name.lower() for name in (*self.layout.keys, *self.layout.numbers)} <= found
        return all(
            len(line) in self.layout.counts
            and all(map(_is_number, (*line[: len(self.layout.keys)], line[-1])))
            for line in lines
        )

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per key of the layout, as `modelcast.io.gathering` gathers them."""
        rows = _SpmdRows(open_spmd(path, self.layout))
        for found in gathered(rows, self.held_bytes):
            trip = _trip(rows, found, on_skipped)
            if trip is not None:
                yield trip


class _SpmdRows(AbstractKeyedRows[Key]):
    """The rows of a file; `origin` is its first usable position once a block with one was read."""

    def __init__(self, file: SpmdFile) -> None:
        self.file = file
        self.path = file.path
        self.origin: Origin | None = None

    @property
    def columns(self) -> int:
        """Those of the layout."""
        return len(self.file.layout.numbers)

    @property
    def rows_expected(self) -> int | None:
        """By the size of the file."""
        return rows_expected(self.path)

    def called(self, key: Key) -> str:
        """``<stem>/<vehicle>``."""
        return f"{recording_stem(self.path)}/{self.file.layout.trip_name(key)}"

    def blocks(self, *, rows: bool) -> Iterator[KeyedBlock[Key]]:
        """Yield the file's blocks; blocks of text."""
        layout = self.file.layout
        for block in self.file.blocks((*layout.keys, *layout.numbers) if rows else layout.keys):
            keys, number = self.file.block_keys(block)
            found = self._rows(block) if rows else None
            if found is not None and self.origin is None:
                self.origin = _first_position(layout, found)
            yield KeyedBlock(block.index, keys, number, found, partial=block.partial > 0)

    def _rows(self, block: Block) -> Rows:
        return Rows(
            block.line,
            {
                name: number_column(self.path, block, self.file.at[name], name)
                for name in self.file.layout.numbers
            },
        )


def _first_position(layout: SpmdLayout, rows: Rows) -> Origin | None:
    """Return the first usable position of these rows."""
    usable = layout.usable(_timed(layout, rows)[0], Tally())
    if not len(usable):
        return None
    first = int(np.argmin(usable.line))
    columns = {name: float(column[first]) for name, column in usable.columns.items()}
    altitude = columns["altitude_m"]
    return Origin(
        columns["latitude_deg"], columns["longitude_deg"], altitude if np.isfinite(altitude) else 0.0
    )


def _trip(file: _SpmdRows, found: Gathered[Key], on_skipped: OnSkipped) -> Trajectory | None:
    """Return the trip of one key's rows, or None after reporting why there is none."""
    layout, origin = file.file.layout, file.origin
    tally = Tally()
    count = len(found.rows) + int(found.partial)
    tally.skip("partial last line", int(found.partial))
    trip_id = file.called(found.key)
    timed, start = _timed(layout, found.rows)
    rows = layout.usable(timed, tally)
    trip = None
    if len(rows) and origin is not None:
        rows = located(ordered(rows, tally, duplicate=layout.duplicate), origin)
        trip = make_trip(
            file.path, trip_id, rows, tally,
            count=count, source=layout.source, origin=origin,
            vehicle=found.key[layout.vehicle],
            unix_offset_s=start * layout.time_unit_s if layout.start_unix else None,
        )  # fmt: skip
    if trip is None:
        on_skipped(trip_id, tally.why_empty())
    return trip


def _timed(layout: SpmdLayout, rows: Rows) -> tuple[Rows, float]:
    """Return the rows with times from the first, NaN where there is none, and that first time."""
    raw = rows.columns[layout.time]
    times = with_missing(raw, raw <= 0.0)
    known = times[np.isfinite(times)]
    start = float(known[0]) if known.size else 0.0
    return rows.having(**{layout.time: times - start}), start


def valid_position(latitude_deg: FloatArray, longitude_deg: FloatArray) -> BoolArray:
    """Return where a position is one: not missing, not J2735's unavailable (90, 180), not (0, 0).

    Examples
    --------
    >>> import numpy as np
    >>> valid_position(np.array([42.0, 90.0000001, 0.0]), np.array([-83.0, -83.0, 0.0]))
    array([ True, False, False])
    """
    inside = (np.abs(latitude_deg) < 90.0) & (np.abs(longitude_deg) < 180.0)
    return inside & ~((latitude_deg == 0.0) & (longitude_deg == 0.0))
