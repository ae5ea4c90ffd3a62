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
from typing import Any, ClassVar

import pyarrow as pa
import pyarrow.parquet as pq

from modelcast.core.exceptions import DataFormatError
from modelcast.io.arrow_trips import arrow_rows
from modelcast.io.base import AbstractTripReader, OnSkipped, ignore_skipped
from modelcast.trips.trajectory import Trajectory

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
        try:
            # pyarrow, because polars ends the whole process on some damaged files.
            with pq.ParquetFile(path, page_checksum_verification=True) as file:
                names = [str(name) for name in file.schema_arrow.names]

                def column(name: str) -> Any:
                    return file.read(columns=[name]).column(0)

                found = arrow_rows(path, self.columns, names, column)
        except (pa.ArrowException, OSError, ValueError, MemoryError) as error:
            raise DataFormatError(
                path, f"is not readable as Parquet: {error}", remedy="Check that it is complete."
            ) from error
        yield from found.trips(path, self.name, on_skipped)
