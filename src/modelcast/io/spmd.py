"""What the three Safety Pilot (SPMD) formats share: keys, layout, and reading in bounded memory.

Published files reach many gigabytes and are not in order of vehicle and time throughout. Readers go through
a file twice or more, in blocks of `BLOCK_BYTES`. The first pass only notes, for every key, how many rows it
has and in which block it begins and ends. The next gathers rows as numbers and yields a trip as soon as the
last block that holds its key has been read. Where the trips open at once would exceed `OPEN_ROWS` rows, the
keys are shared out over several such passes.

Memory: a few times one block, plus about 300 bytes for each of `OPEN_ROWS` rows (or of the largest single
trip, if that is more), plus about 300 bytes a key.
"""

import abc
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from heapq import heappop, heappush
from pathlib import Path

import numpy as np
import polars as pl

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.io.base import AbstractTripReader, OnSkipped, Tally, ignore_skipped
from modelcast.io.rows import Rows, joined, located, make_trip, ordered, with_missing
from modelcast.io.text_blocks import Block, number_column, read_blocks, text_column
from modelcast.io.text_head import file_head, first_lines, split_fields
from modelcast.trips.trajectory import Trajectory

__all__ = [
    "OPEN_ROWS",
    "AbstractSpmdReader",
    "Key",
    "SpmdFile",
    "SpmdLayout",
    "open_spmd",
    "valid_position",
]

OPEN_ROWS = 4_000_000
"""Rows gathered at a time, unless a single trip has more."""

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


@dataclass(slots=True)
class _Extent:
    """Rows of a key and the blocks that hold the first and the last of them."""

    first: int
    last: int
    rows: int = 0


@dataclass(slots=True)
class _Gathered:
    parts: list[Rows] = field(default_factory=list[Rows])
    partial: int = 0


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
        return read_blocks(
            self.path, counts=self.counts, fields=wanted, skip_lines=self.skip_lines, width=width
        )

    def block_keys(self, block: Block) -> tuple[list[Key], IntArray]:
        """Return the keys of a block in order of appearance, and each row's key by number, (R,).

        Parameters
        ----------
        block
            One that has the columns of the keys.

        Raises
        ------
        DataFormatError
            Where one of them is blank.
        """
        columns = [text_column(block, self.at[name]).alias(name) for name in self.layout.keys]
        for column in columns:
            if column.null_count():
                at = int(column.is_null().arg_true()[0])
                raise DataFormatError(
                    self.path,
                    f"{column.name} is blank",
                    row=int(block.line[at]),
                    remedy="Every row needs it: it names the trip.",
                )
        frame = pl.DataFrame(columns)
        unique = frame.unique(maintain_order=True).with_row_index("number")
        number = frame.join(unique, on=list(self.layout.keys), how="left", maintain_order="left")["number"]
        return [tuple(row[1:]) for row in unique.iter_rows()], number.to_numpy().astype(np.int64)


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


class AbstractSpmdReader(AbstractTripReader):
    """Reads files of one layout, in bounded memory; see the module's docstring."""

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
        """Yield a trip per key of the layout, each as soon as its last block is read."""
        file = open_spmd(path, self.layout)
        extents = _extents(file)
        if not extents:
            raise DataFormatError(path, "no rows after the header", remedy="The file is empty.")
        origin: Origin | None = None
        for keys in _shared_out(extents):
            for key, gathered, seen in _complete(file, extents, keys, origin):
                origin = seen
                trip = _trip(file, key, gathered, origin, on_skipped)
                if trip is not None:
                    yield trip


def _extents(file: SpmdFile) -> dict[Key, _Extent]:
    """Return where every key's rows are (the first pass)."""
    extents: dict[Key, _Extent] = {}
    last: Key | None = None
    for block in file.blocks(file.layout.keys):
        keys, number = file.block_keys(block)
        for key, rows in zip(keys, np.bincount(number, minlength=len(keys)), strict=True):
            extent = extents.setdefault(key, _Extent(block.index, block.index))
            extent.last = block.index
            extent.rows += int(rows)
        last = keys[int(number[-1])] if keys else last
        if block.partial and last is not None:
            extents[last].last = block.index
    return extents


def _shared_out(extents: Mapping[Key, _Extent]) -> Iterator[set[Key]]:
    """Yield sets of keys whose open trips stay within `OPEN_ROWS` rows, or of one key."""
    waiting = sorted(extents, key=lambda key: extents[key].first)
    while waiting:
        chosen: set[Key] = set()
        left: list[Key] = []
        running: list[tuple[int, int]] = []
        open_rows = 0
        for key in waiting:
            extent = extents[key]
            while running and running[0][0] < extent.first:
                open_rows -= heappop(running)[1]
            if running and open_rows + extent.rows > OPEN_ROWS:
                left.append(key)
                continue
            chosen.add(key)
            heappush(running, (extent.last, extent.rows))
            open_rows += extent.rows
        yield chosen
        waiting = left


def _complete(
    file: SpmdFile, extents: Mapping[Key, _Extent], wanted: set[Key], origin: Origin | None
) -> Iterator[tuple[Key, _Gathered, Origin | None]]:
    """Yield each wanted key with its rows once its last block is read, and the file's origin."""
    layout = file.layout
    open_trips: dict[Key, _Gathered] = {}
    last: Key = ()
    for block in file.blocks((*layout.keys, *layout.numbers)):
        keys, number = file.block_keys(block)
        rows = Rows(
            block.line,
            {name: number_column(file.path, block, file.at[name], name) for name in layout.numbers},
        )
        origin = _first_position(layout, rows) if origin is None else origin
        order = np.argsort(number, kind="stable")
        bounds = np.searchsorted(number[order], np.arange(len(keys) + 1))
        for at, key in enumerate(keys):
            if key in wanted:
                part = rows.taken(order[bounds[at] : bounds[at + 1]])
                open_trips.setdefault(key, _Gathered()).parts.append(part)
        last = keys[int(number[-1])] if keys else last
        if block.partial and last in open_trips:
            open_trips[last].partial = 1
        for key in [key for key in open_trips if extents[key].last == block.index]:
            yield key, open_trips.pop(key), origin


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


def _trip(
    file: SpmdFile, key: Key, gathered: _Gathered, origin: Origin | None, on_skipped: OnSkipped
) -> Trajectory | None:
    """Return the trip of one key's rows, or None after reporting why there is none."""
    layout = file.layout
    tally = Tally()
    raw = joined(gathered.parts)
    count = len(raw) + gathered.partial
    tally.skip("partial last line", gathered.partial)
    trip_id = f"{Path(file.path).stem}/{layout.trip_name(key)}"
    timed, start = _timed(layout, raw)
    rows = layout.usable(timed, tally)
    trip = None
    if len(rows) and origin is not None:
        rows = located(ordered(rows, tally, duplicate=layout.duplicate), origin)
        trip = make_trip(
            file.path, trip_id, rows, tally,
            count=count, source=layout.source, origin=origin,
            vehicle=key[layout.vehicle],
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
