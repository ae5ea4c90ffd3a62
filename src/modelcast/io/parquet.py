"""Parquet tables, by the names of their columns: the same columns and map as csv.

`modelcast.io.column_map` has the table of columns and units, `modelcast.io.time_column` the times that are
read; a column of Arrow time stamps tells its own unit. Numbers may have any numeric type and are read as
float64; null is missing, NaN is an error. Rows are numbered from 1 in errors.

Skipped and counted: rows whose time or position is null, rows off the road (`modelcast.io.table_trips`).
Repaired and counted: single missing values of optional columns (the last value is held), Unix times whose
unit only their size tells.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, cast

import numpy as np
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.io.base import AbstractTripReader, OnSkipped, ignore_skipped
from modelcast.io.column_map import ColumnMap, known_map
from modelcast.io.rows import LARGEST, Rows, are_numbers
from modelcast.io.table_trips import table_trips
from modelcast.io.time_column import TimeColumn, TimeUnit, holds_dates
from modelcast.trips.trajectory import Trajectory

__all__ = ["ParquetReader"]

_MAGIC = b"PAR1"
_LARGEST_TIME = 1e20
"""Unix nanoseconds are beyond `LARGEST`."""
_ARROW_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


@dataclass(frozen=True, slots=True)
class ParquetReader(AbstractTripReader):
    """Reads Parquet tables.

    Parameters
    ----------
    columns
        Column names by meaning; names are detected where it is None.
    """

    columns: Mapping[str, str] | None = None
    name: ClassVar[str] = "parquet"

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether the file begins as Parquet files do."""
        del path
        return head.startswith(_MAGIC)

    def with_columns(self, columns: Mapping[str, str]) -> "ParquetReader":
        """Return the reader with the user's column names."""
        return replace(self, columns=dict(columns))

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per vehicle; the mapped columns are held in memory."""
        columns: dict[str, FloatArray] = {}
        labels: pl.Series | None = None
        try:
            # pyarrow, because polars ends the whole process on some damaged files.
            with pq.ParquetFile(path, page_checksum_verification=True) as file:
                found = known_map(path, self.columns, [str(name) for name in file.schema_arrow.names])
                time_column = file.read(columns=[found.numbers["t_s"][0]]).column(0)
                columns["t_s"], time = _times(path, found, time_column)
                for fills, (name, _) in found.numbers.items():
                    if fills != "t_s":
                        columns[fills] = _numbers(path, name, file.read(columns=[name]).column(0))
                if found.label is not None:
                    names = _text(file.read(columns=[found.label]).column(0))
                    labels = pl.Series(found.label, names, dtype=pl.String)
        except (pa.ArrowException, OSError, ValueError, MemoryError) as error:
            raise DataFormatError(
                path, f"is not readable as Parquet: {error}", remedy="Check that it is complete."
            ) from error
        count = columns["t_s"].size
        if not count:
            raise DataFormatError(path, "no rows", remedy="The file is empty.")
        sizes = {column.size for column in columns.values()} | (
            {len(labels)} if labels is not None else set()
        )
        if sizes != {count}:
            raise DataFormatError(path, f"columns of different lengths: {sorted(sizes)}")
        rows = Rows(_row_numbers(count), columns)
        yield from table_trips(
            path, self.name, found, rows, labels, time=time, partial=False, on_skipped=on_skipped
        )


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
