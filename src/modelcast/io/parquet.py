"""Parquet tables, by the names of their columns: the same columns and map as csv.

`modelcast.io.column_map` has the table of columns and units. Numbers may have any numeric type and are read
as float64; null is missing, NaN is an error. Rows are numbered from 1 in errors.

Skipped and counted: rows whose time or position is null. Repaired and counted: single missing values of
optional columns (the last value is held).
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

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.trajectory import Trajectory
from modelcast.io.base import AbstractTripReader, OnSkipped, ignore_skipped
from modelcast.io.column_map import ColumnMap, detected_map, user_map
from modelcast.io.rows import Rows, are_numbers
from modelcast.io.table_trips import table_trips

__all__ = ["ParquetReader"]

_MAGIC = b"PAR1"


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
                found = self._found(path, [str(name) for name in file.schema_arrow.names])
                for fills, (name, factor) in found.numbers.items():
                    scale = factor if fills != "t_s" else 1.0
                    columns[fills] = _numbers(path, name, file.read(columns=[name]).column(0)) * scale
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
        rows = Rows(np.arange(1, count + 1, dtype=np.int64), columns)
        yield from table_trips(path, self.name, found, rows, labels, partial=False, on_skipped=on_skipped)

    def _found(self, path: str, names: list[str]) -> ColumnMap:
        found = user_map(path, self.columns, names) if self.columns else detected_map(names)
        if found is None:
            raise DataFormatError(
                path,
                f"no known names of time and position among the columns {', '.join(names)}",
                remedy="Give a column map, for example t=time,east=x,north=y,speed=v.",
            )
        return found


def _text(column: Any) -> list[str | None]:
    """Return a column as text."""
    return cast("list[str | None]", column.cast(pa.string()).to_pylist())


def _numbers(path: str, name: str, column: Any) -> FloatArray:
    """Return a column as float64, NaN where it is null."""
    kind = column.type
    if not (pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_null(kind)):
        raise DataFormatError(path, f"column {name!r} holds {kind}, not numbers", remedy="Convert it first.")
    numbers = np.array(column.cast(pa.float64(), safe=False).to_numpy(), dtype=np.float64)
    null = np.asarray(column.is_null().to_numpy(), dtype=np.bool_)
    bad = ~are_numbers(numbers) & ~null
    if bad.any():
        at = int(np.argmax(bad))
        raise DataFormatError(
            path,
            f"{name} is {numbers[at]}, not a finite number",
            row=at + 1,
            remedy="Correct the value, or make it null where it is not known.",
        )
    return numbers
