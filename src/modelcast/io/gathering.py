"""Rows of many trips, in any order in a file of any size, gathered trip by trip in bounded memory.

What a file holds is taken in blocks, each row with the key of its trip. Where all rows fit into the limit,
one pass gathers them, and the trips come in order of their first rows. Else a pass notes, for every key, how
many rows it has and which blocks hold the first and the last of them; further passes gather rows, and a trip
comes as soon as its last block is read. Where the trips open at once would exceed the limit, the keys are
shared out over several such passes.

A single trip over the limit is an error that names it: nothing that is done with a trip works on parts of
one. So is a file of more than `MOST_TRIPS` trips, because each takes some memory in the first pass, and a
name of more than `MOST_NAME_BYTES`.
"""

from abc import ABC, abstractmethod
from array import array
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from heapq import heappop, heappush
from typing import ClassVar, Generic, TypeVar

import numpy as np
import polars as pl

from modelcast.core.arrays import IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.io.reading_limits import HELD_BYTES, MOST_NAME_BYTES, MOST_TRIPS, too_long
from modelcast.io.rows import Rows, joined

__all__ = ["AbstractKeyedRows", "Gathered", "KeyedBlock", "gathered", "numbered"]

_REMEDY = (
    "Give each drive of this vehicle a name of its own, write it into several files, or read it by modelcast "
    "ingest with more --memory."
)
_SHOWN = 40
_PART_BYTES = 200
_COLUMN_BYTES = 120
"""What a part of a trip takes beside its numbers: for itself, and for each column."""

Key = TypeVar("Key", bound=Hashable)


@dataclass(frozen=True, slots=True)
class KeyedBlock(Generic[Key]):
    """Consecutive rows of a file.

    Parameters
    ----------
    index
        Number of the block in the file, from 0, the same in every pass.
    keys
        The trips of its rows, in order of their first ones.
    number
        The trip of each row, by its place in `keys`, (R,).
    rows
        The rows, (R,); None in a pass that asks for keys alone.
    partial
        Whether a last row cut short was passed over; it counts with the trip of the row before it.
    """

    index: int
    keys: list[Key]
    number: IntArray
    rows: Rows | None
    partial: bool = False


class AbstractKeyedRows(ABC, Generic[Key]):
    """A file (or table) whose rows name their trips; it can be gone through again and again."""

    path: str
    """What errors call it."""

    needs_rows: ClassVar[bool] = True
    """Whether a file without any row is an error."""

    @property
    @abstractmethod
    def columns(self) -> int:
        """How many columns of numbers its rows have."""

    @property
    def rows_expected(self) -> int | None:
        """About how many rows it has, None where only reading tells."""
        return None

    @property
    def only(self) -> Key | None:
        """The key of all rows, where that and their exact number are known before any is read; else None."""
        return None

    @abstractmethod
    def blocks(self, *, rows: bool) -> Iterator[KeyedBlock[Key]]:
        """Yield all of it in blocks of bounded size.

        Parameters
        ----------
        rows
            Whether the rows are wanted, beside their keys.

        Raises
        ------
        DataFormatError
            Where it is not what its format says.
        """

    @abstractmethod
    def called(self, key: Key) -> str:
        """Return the identifier of a trip."""


@dataclass(frozen=True, slots=True)
class Gathered(Generic[Key]):
    """All rows of one trip.

    Parameters
    ----------
    key
        The trip.
    rows
        Its rows in the order of the file.
    partial
        Whether a last row cut short counts with it.
    """

    key: Key
    rows: Rows
    partial: bool


def numbered(columns: Sequence[pl.Series]) -> tuple[list[tuple[str, ...]], IntArray]:
    """Return the different rows of some columns in order of appearance, and the one of each row, (R,).

    Parameters
    ----------
    columns
        Columns of text with different names and without blanks.

    Examples
    --------
    >>> import polars as pl
    >>> keys, number = numbered([pl.Series("vehicle", ["b", "a", "b"])])
    >>> keys, number.tolist()
    ([('b',), ('a',)], [0, 1, 0])
    """
    frame = pl.DataFrame(list(columns))
    begins = np.ones(frame.height, dtype=np.bool_)
    if frame.height:
        begins[1:] = np.any([(column[1:] != column[:-1]).to_numpy() for column in frame], axis=0)
    first = np.flatnonzero(begins)  # mostly rows follow others of the same keys: one of them is enough
    runs = frame[first]
    unique = runs.unique(maintain_order=True).with_row_index("number of the key")
    number = runs.join(unique, on=frame.columns, how="left", maintain_order="left")["number of the key"]
    lengths = np.diff(first, append=frame.height)
    return [tuple(row[1:]) for row in unique.iter_rows()], np.repeat(
        number.to_numpy().astype(np.int64), lengths
    )


def gathered(file: AbstractKeyedRows[Key], held_bytes: int = HELD_BYTES) -> Iterator[Gathered[Key]]:
    """Yield every trip of a file with all its rows.

    Parameters
    ----------
    file
        The file.
    held_bytes
        Octets of numbers that may be gathered at a time, and so those of the largest trip.

    Raises
    ------
    DataFormatError
        Where there is no row, a trip alone exceeds the limit, or there are too many trips.
    """
    expected = file.rows_expected
    whole = None
    if expected is not None and file.only is not None and expected * _row_bytes(file) > held_bytes:
        raise _too_long(file, file.only, held_bytes)
    if expected is None or expected * _row_bytes(file) <= held_bytes:
        whole = _in_one_pass(file, held_bytes)
    if whole is not None:
        yield from whole
        return
    extents = _extents(file, held_bytes)
    for places in _shared_out(extents, file, held_bytes):
        yield from _complete(file, extents, places)


def _row_bytes(file: AbstractKeyedRows[Key]) -> int:
    """Octets of a row's numbers, its line among them."""
    return 8 * (file.columns + 1)


def _part_bytes(file: AbstractKeyedRows[Key]) -> int:
    return _PART_BYTES + _COLUMN_BYTES * (file.columns + 1)


@dataclass(slots=True)
class _Extents(Generic[Key]):
    """For every key, by its place: the blocks of the first and the last of its rows, rows, and parts."""

    place: dict[Key, int] = field(default_factory=dict[Key, int])
    first: "array[int]" = field(default_factory=lambda: array("q"))
    last: "array[int]" = field(default_factory=lambda: array("q"))
    rows: "array[int]" = field(default_factory=lambda: array("q"))
    parts: "array[int]" = field(default_factory=lambda: array("q"))
    partial: Key | None = None

    def add(self, key: Key, block: int, rows: int) -> int:
        """Note rows of a key, and return its place."""
        at = self.place.setdefault(key, len(self.first))
        if at == len(self.first):
            self.first.append(block)
            for column in (self.last, self.rows, self.parts):
                column.append(0)
        self.last[at] = block
        self.rows[at] += rows
        self.parts[at] += 1
        return at


def _parts(block: KeyedBlock[Key], wanted: Sequence[int]) -> Iterator[tuple[Key, Rows]]:
    """Yield the rows of some keys of a block, by their places in it."""
    rows = block.rows
    if rows is None or not wanted:
        return
    if len(block.keys) == 1:
        yield block.keys[0], rows
        return
    order = np.argsort(block.number, kind="stable")
    bounds = np.searchsorted(block.number[order], np.arange(len(block.keys) + 1))
    for at in wanted:
        yield block.keys[at], rows.taken(order[bounds[at] : bounds[at + 1]])


def _in_one_pass(file: AbstractKeyedRows[Key], held_bytes: int) -> Iterator[Gathered[Key]] | None:
    """Return the trips of a file that fits into the limit, None where it does not.

    Raises
    ------
    DataFormatError
        Where there is no row.
    """
    held: dict[Key, list[Rows]] = {}
    left = held_bytes
    last: Key | None = None
    partial = False
    for block in file.blocks(rows=True):
        for key, rows in _parts(block, range(len(block.keys))):
            if key not in held:
                _require_short_name(file, key)
            held.setdefault(key, []).append(rows)
        left -= block.number.size * _row_bytes(file) + len(block.keys) * _part_bytes(file)
        if left < 0:
            return None
        last = block.keys[int(block.number[-1])] if block.keys else last
        partial = partial or block.partial
    if not held and file.needs_rows:
        raise _no_rows(file)
    return _released(held, last if partial else None)


def _released(held: dict[Key, list[Rows]], partial: Key | None) -> Iterator[Gathered[Key]]:
    """Yield what is held trip by trip; what was yielded is not held any more."""
    for key in list(held):
        yield Gathered(key, joined(held.pop(key)), key == partial)


def _extents(file: AbstractKeyedRows[Key], held_bytes: int) -> _Extents[Key]:
    """Return where every key's rows are."""
    found: _Extents[Key] = _Extents()
    last: Key | None = None
    row_bytes = _row_bytes(file)
    for block in file.blocks(rows=False):
        for key, rows in zip(
            block.keys, np.bincount(block.number, minlength=len(block.keys)).tolist(), strict=True
        ):
            if key not in found.place:
                _require_short_name(file, key)
            at = found.add(key, block.index, rows)
            if found.rows[at] * row_bytes > held_bytes:
                raise _too_long(file, key, held_bytes)
        if len(found.first) > MOST_TRIPS:
            raise DataFormatError(
                file.path,
                f"holds over {MOST_TRIPS:,} trips, more than are read of one file",
                remedy="Write the vehicles into several files, or name another column as the vehicle.",
            )
        last = block.keys[int(block.number[-1])] if block.keys else last
        if block.partial:
            found.partial = last
    if not found.place and file.needs_rows:
        raise _no_rows(file)
    return found


def _too_long(file: AbstractKeyedRows[Key], key: Key, held_bytes: int) -> DataFormatError:
    return too_long(
        file.path, file.called(key), row_bytes=_row_bytes(file), held_bytes=held_bytes, remedy=_REMEDY
    )


def _require_short_name(file: AbstractKeyedRows[Key], key: Key) -> None:
    """Refuse a trip whose identifier is longer than any name."""
    name = file.called(key)
    if len(name.encode(errors="replace")) > MOST_NAME_BYTES:
        raise DataFormatError(
            file.path, f"the name of a trip has over {MOST_NAME_BYTES:,} octets: {name[:_SHOWN]}...",
            remedy="Check which column names the vehicle: names are shorter.",
        )  # fmt: skip


def _no_rows(file: AbstractKeyedRows[Key]) -> DataFormatError:
    return DataFormatError(file.path, "no rows after the header", remedy="Check that it is complete.")


def _shared_out(
    extents: _Extents[Key], file: AbstractKeyedRows[Key], held_bytes: int
) -> Iterator[frozenset[int]]:
    """Yield sets of places whose open trips stay within the limit, or of one trip."""
    sizes = np.array(extents.rows) * _row_bytes(file) + np.array(extents.parts) * _part_bytes(file)
    waiting: list[int] = np.argsort(np.array(extents.first), kind="stable").tolist()
    while waiting:
        chosen: list[int] = []
        left: list[int] = []
        running: list[tuple[int, int]] = []
        open_bytes = 0
        for at in waiting:
            while running and running[0][0] < extents.first[at]:
                open_bytes -= heappop(running)[1]
            size = int(sizes[at])
            if running and open_bytes + size > held_bytes:
                left.append(at)
                continue
            chosen.append(at)
            heappush(running, (extents.last[at], size))
            open_bytes += size
        yield frozenset(chosen)
        waiting = left


def _complete(
    file: AbstractKeyedRows[Key], extents: _Extents[Key], wanted: frozenset[int]
) -> Iterator[Gathered[Key]]:
    """Yield each wanted trip once its last block is read."""
    held: dict[Key, list[Rows]] = {}
    left = len(wanted)
    for block in file.blocks(rows=True):
        places = [extents.place[key] for key in block.keys]
        for key, rows in _parts(block, [at for at, place in enumerate(places) if place in wanted]):
            held.setdefault(key, []).append(rows)
        for key, place in zip(block.keys, places, strict=True):
            if place in wanted and extents.last[place] == block.index:
                yield Gathered(key, joined(held.pop(key)), key == extents.partial)
                left -= 1
        if not left:
            return
