"""The trips of a table of typed columns: what Parquet files and data frames share.

Numbers may have any numeric type and are read as float64; null is missing, NaN is an error. A column of Arrow
time stamps tells its own unit. Rows are numbered from 1 in errors.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np
import polars as pl
import pyarrow as pa

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.io.column_map import known_map
from modelcast.io.reading_limits import MOST_NAME_BYTES
from modelcast.io.rows import LARGEST, Rows, are_numbers
from modelcast.io.table_notes import FIRST_ROWS
from modelcast.io.table_trips import AbstractTable, TablePart
from modelcast.io.time_column import TimeColumn, TimeUnit, holds_times

__all__ = ["PART_ROWS", "ArrowTable", "Batches", "is_text"]

PART_ROWS = 131_072
"""Rows taken at a time."""

_LARGEST_TIME = 1e20
"""Unix nanoseconds are beyond `LARGEST`."""
_MOST_SHOWN = 40
"""Columns that are not read, but looked at for what they may mean."""
_ARROW_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


class Batches(Protocol):
    """Yields a table's record batches, from the first each time it is called."""

    def __call__(self, wanted: Sequence[str], rows: int = PART_ROWS) -> Iterable[Any]:
        """Yield batches of at most so many rows with the columns named."""
        ...


class ArrowTable(AbstractTable):
    """A table whose parts are Arrow record batches.

    Parameters
    ----------
    path
        What errors call the table.
    columns
        The user's map, if any.
    schema
        The table's ``pyarrow.Schema``.
    rows
        How many rows it has.
    batches
        Yields its record batches.

    Raises
    ------
    ConfigError, DataFormatError
        As for `modelcast.io.column_map.known_map`; where a column that is needed holds no numbers.
    """

    counts_rows = True

    def __init__(
        self,
        path: str,
        columns: Mapping[str, str] | None,
        schema: Any,
        rows: int,
        batches: Batches,
    ) -> None:
        names = [str(name) for name in schema.names]
        super().__init__(path, known_map(path, columns, names))
        self._kinds = {name: schema.types[names.index(name)] for name, _ in self.found.numbers.values()}
        self._rows = rows
        self._batches = batches
        self._plain = [str(name) for name, kind in zip(names, schema.types, strict=True) if _is_plain(kind)]
        time, unit_s = self.found.numbers["t_s"]
        kind = self._kinds[time]
        stamped = pa.types.is_timestamp(kind)
        self._times = TimeColumn(
            path, time, _ARROW_UNITS[kind.unit] if stamped else unit_s,
            stated=stamped or self.found.time_stated, day_first=self.found.day_first,
        )  # fmt: skip
        self._zoned = stamped and kind.tz is not None
        self._dated = False
        label = self.found.label
        if label is not None and not _may_name(schema.types[names.index(label)]):
            raise DataFormatError(
                path, f"column {label!r} holds {schema.types[names.index(label)]}, not names",
                remedy="Convert it to text first.",
            )  # fmt: skip
        for name, kind in self._kinds.items():
            if name != time or not (stamped or is_text(kind)):
                self._require_numbers(name, kind)

    @property
    def time(self) -> TimeUnit:
        """As the type of the column, or the first known value, tells."""
        unit = self._times.unit
        return replace(unit, unix=True) if self._zoned else unit

    @property
    def rows_expected(self) -> int | None:
        """As the table says."""
        return self._rows

    def first_cells(self) -> Mapping[str, Sequence[str]]:
        """Return the first rows of the columns that are read, and of others of numbers or text."""
        read = [*self.found.meanings.values()]
        wanted = [name for name in self._plain if name in {*read, *self.found.unused[:_MOST_SHOWN]}]
        try:
            batch = next(iter(self._batches(wanted, FIRST_ROWS)), None)
        except DataFormatError:  # a column that is not read may be of any size
            return {}
        if batch is None:
            return {}
        names = [str(name) for name in batch.schema.names]
        rows = batch.slice(0, FIRST_ROWS)
        return {
            name: ["" if cell is None else str(cell) for cell in _shown(rows.column(names.index(name)))]
            for name in wanted
        }

    def parts(self, *, whole: bool) -> Iterator[TablePart]:
        """Yield record batches."""
        if not self._rows:
            raise DataFormatError(self.path, "no rows", remedy="It is empty.")
        numbers = {fills: name for fills, (name, _) in self.found.numbers.items() if whole or fills == "t_s"}
        label = self.found.label
        wanted = [*numbers.values(), *([] if label is None else [label])]
        done = 0
        for index, batch in enumerate(self._batches(wanted)):
            names = [str(name) for name in batch.schema.names]
            line = np.arange(done + 1, done + len(batch) + 1, dtype=np.int64)
            done += len(batch)
            held = {name: batch.column(names.index(name)) for name in wanted}
            columns = {
                fills: self._numbers(name, held[name], line)
                for fills, name in numbers.items()
                if fills != "t_s"
            }
            columns["t_s"] = self._read_times(held[numbers["t_s"]], line)
            labels = None if label is None else self._text(label, held[label], line)
            yield TablePart(index, Rows(line, columns), labels)

    def _read_times(self, column: Any, line: IntArray) -> FloatArray:
        """Return times from their start, in units, NaN where null."""
        name = self.found.numbers["t_s"][0]
        kind = self._kinds[name]
        if is_text(kind):
            text = self._text(name, column, line)
            if not self._dated and text.null_count() < len(text):
                self._dated = self.found.day_first is not None or holds_times(text)
                if not self._dated:
                    self._require_numbers(name, kind)
            return self._times.read(text, line)
        if pa.types.is_timestamp(kind):
            whole = pl.Series(name, column.cast(pa.int64()))
            return self._times.numbers(whole, whole.cast(pl.Float64), whole, line)
        values = pl.Series(name, self._numbers(name, column, line, _LARGEST_TIME)).fill_nan(None)
        whole = pl.repeat(None, len(column), dtype=pl.Int64, eager=True)
        if pa.types.is_integer(kind):
            whole = pl.Series(name, column.cast(pa.int64()))
        return self._times.numbers(whole, values, values, line)

    def _require_numbers(self, name: str, kind: Any) -> None:
        if not (pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_null(kind)):
            raise DataFormatError(
                self.path, f"column {name!r} holds {kind}, not numbers", remedy="Convert it first."
            )

    def _text(self, name: str, column: Any, line: IntArray) -> pl.Series:
        """Return a column as text, one that is a dictionary only after a look at its words."""
        held = column.dictionary if pa.types.is_dictionary(column.type) else column
        try:
            words = pl.Series(name, held.cast(pa.large_string()), dtype=pl.String)
        except pa.ArrowException as error:
            raise DataFormatError(
                self.path, f"column {name!r} holds {held.type}, which is no text: {error}",
                row=int(line[0]), remedy="Convert it first.",
            ) from error  # fmt: skip
        if (words.str.len_bytes() > MOST_NAME_BYTES).any():
            raise DataFormatError(
                self.path, f"{name} has a text of over {MOST_NAME_BYTES} octets", row=int(line[0]),
                remedy="It holds names or times, which are shorter.",
            )  # fmt: skip
        if held is column:
            return words
        at = pl.Series(name, column.indices.cast(pa.int64()), dtype=pl.Int64)
        return words.gather(at)

    def _numbers(self, name: str, column: Any, line: IntArray, largest: float = LARGEST) -> FloatArray:
        """Return a column as float64, NaN where it is null."""
        numbers = np.array(
            column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False), dtype=np.float64
        )
        null = np.asarray(column.is_null().to_numpy(zero_copy_only=False), dtype=np.bool_)
        bad = ~are_numbers(numbers, largest) & ~null
        if bad.any():
            at = int(np.argmax(bad))
            raise DataFormatError(
                self.path,
                f"{name} is {numbers[at]}, not a finite number",
                row=int(line[at]),
                remedy="Correct the value, or make it null where it is not known.",
            )
        return numbers


def _shown(column: Any) -> list[Any]:
    """Return the cells of a column, time stamps as they are counted: Python's end at the microsecond."""
    counted: list[Any] = (
        column.cast(pa.int64()) if pa.types.is_timestamp(column.type) else column
    ).to_pylist()
    return counted


def _is_plain(kind: Any) -> bool:
    """Return whether an Arrow type is a number, a time stamp or text; octets may be pictures."""
    if pa.types.is_dictionary(kind):
        return _is_plain(kind.value_type)
    number = pa.types.is_floating(kind) or pa.types.is_integer(kind)
    octets = pa.types.is_binary(kind) or pa.types.is_large_binary(kind)
    return bool(number or pa.types.is_timestamp(kind) or (is_text(kind) and not octets))


def _may_name(kind: Any) -> bool:
    """Return whether values of an Arrow type can be names of vehicles: text, numbers, dates."""
    if pa.types.is_dictionary(kind):
        return is_text(kind.value_type)
    fixed = pa.types.is_primitive(kind) or pa.types.is_decimal(kind)
    return bool(fixed or pa.types.is_null(kind) or is_text(kind))


def is_text(kind: Any) -> bool:
    """Return whether an Arrow type is text (or octets that may be)."""
    return any(
        is_kind(kind)
        for is_kind in (
            pa.types.is_string, pa.types.is_large_string, pa.types.is_binary, pa.types.is_large_binary,
        )
    )  # fmt: skip
