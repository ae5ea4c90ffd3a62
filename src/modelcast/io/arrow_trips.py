"""The trips of a table of typed columns: what Parquet files and data frames share.

Numbers may have any numeric type and are read as float64; null is missing, NaN is an error. A column of Arrow
time stamps tells its own unit. Rows are numbered from 1 in errors.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
import polars as pl
import pyarrow as pa

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.io.base import OnSkipped
from modelcast.io.column_map import ColumnMap, known_map
from modelcast.io.rows import LARGEST, Rows, are_numbers
from modelcast.io.table_trips import table_trips
from modelcast.io.time_column import TimeColumn, TimeUnit, holds_dates
from modelcast.trips.trajectory import Trajectory

__all__ = ["ArrowRows", "arrow_rows"]

_LARGEST_TIME = 1e20
"""Unix nanoseconds are beyond `LARGEST`."""
_ARROW_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


@dataclass(frozen=True, slots=True)
class ArrowRows:
    """The columns of a table that say where its vehicles were.

    Parameters
    ----------
    found
        What they mean.
    rows
        All rows.
    labels
        The vehicle (or trip) of each row, where the table names it.
    time
        What the times mean.
    """

    found: ColumnMap
    rows: Rows
    labels: pl.Series | None
    time: TimeUnit

    def trips(self, path: str, source: str, on_skipped: OnSkipped) -> Iterator[Trajectory]:
        """Yield a trip per vehicle.

        Parameters
        ----------
        path, source, on_skipped
            As for `modelcast.io.table_trips.table_trips`.
        """
        yield from table_trips(
            path, source, self.found, self.rows, self.labels,
            time=self.time, partial=False, on_skipped=on_skipped,
        )  # fmt: skip


def arrow_rows(
    path: str, columns: Mapping[str, str] | None, names: Sequence[str], column: Callable[[str], Any]
) -> ArrowRows:
    """Return the rows of a table by its names or by the user's map.

    Parameters
    ----------
    path
        What errors call the table.
    columns
        The user's map, if any.
    names
        Names of the table's columns.
    column
        Gives the Arrow column of a name; it is asked for those that are needed, one at a time.

    Raises
    ------
    ConfigError, DataFormatError
        As for `modelcast.io.column_map.known_map`; where a column holds no numbers, a number is not finite,
        there is no row, or columns differ in length.
    """
    found = known_map(path, columns, names)
    numbers: dict[str, FloatArray] = {}
    numbers["t_s"], time = _times(path, found, column(found.numbers["t_s"][0]))
    for fills, (name, _) in found.numbers.items():
        if fills != "t_s":
            numbers[fills] = _numbers(path, name, column(name))
    labels: pl.Series | None = None
    if found.label is not None:
        labels = pl.Series(found.label, _text(column(found.label)), dtype=pl.String)
    count = numbers["t_s"].size
    if not count:
        raise DataFormatError(path, "no rows", remedy="It is empty.")
    sizes = {values.size for values in numbers.values()} | ({len(labels)} if labels is not None else set())
    if sizes != {count}:
        raise DataFormatError(path, f"columns of different lengths: {sorted(sizes)}")
    return ArrowRows(found, Rows(_row_numbers(count), numbers), labels, time)


def _row_numbers(count: int) -> IntArray:
    return np.arange(1, count + 1, dtype=np.int64)


def _times(path: str, found: ColumnMap, column: Any) -> tuple[FloatArray, TimeUnit]:
    """Return the times from their start, in units, NaN where null, and what they mean."""
    name, unit_s = found.numbers["t_s"]
    kind = column.type
    line = _row_numbers(len(column))
    if pa.types.is_string(kind) or pa.types.is_large_string(kind):
        text = pl.Series(name, _text(column), dtype=pl.String)
        if holds_dates(text):
            dated = TimeColumn(path, name, unit_s, stated=found.time_stated)
            return dated.read(text, line), dated.unit
    if pa.types.is_timestamp(kind):
        times = TimeColumn(path, name, _ARROW_UNITS[kind.unit], stated=True)
        whole = pl.Series(name, column.cast(pa.int64()))
        read = times.numbers(whole, whole.cast(pl.Float64), whole, line)
        return read, replace(times.unit, unix=kind.tz is not None)
    times = TimeColumn(path, name, unit_s, stated=found.time_stated)
    values = pl.Series(name, _numbers(path, name, column, _LARGEST_TIME)).fill_nan(None)
    whole = pl.repeat(None, len(column), dtype=pl.Int64, eager=True)
    if pa.types.is_integer(kind):
        whole = pl.Series(name, column.cast(pa.int64()))
    return times.numbers(whole, values, values, line), times.unit


def _text(column: Any) -> list[str | None]:
    """Return a column as text."""
    return cast("list[str | None]", column.cast(pa.string()).to_pylist())


def _numbers(path: str, name: str, column: Any, largest: float = LARGEST) -> FloatArray:
    """Return a column as float64, NaN where it is null."""
    kind = column.type
    if not (pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_null(kind)):
        raise DataFormatError(path, f"column {name!r} holds {kind}, not numbers", remedy="Convert it first.")
    numbers = np.array(column.cast(pa.float64(), safe=False).to_numpy(), dtype=np.float64)
    null = np.asarray(column.is_null().to_numpy(), dtype=np.bool_)
    bad = ~are_numbers(numbers, largest) & ~null
    if bad.any():
        at = int(np.argmax(bad))
        raise DataFormatError(
            path,
            f"{name} is {numbers[at]}, not a finite number",
            row=at + 1,
            remedy="Correct the value, or make it null where it is not known.",
        )
    return numbers
