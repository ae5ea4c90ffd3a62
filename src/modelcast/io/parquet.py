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

from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import pyarrow as pa
import pyarrow.parquet as pq

from modelcast.core.exceptions import DataFormatError
from modelcast.io.arrow_trips import PART_ROWS, ArrowTable, is_text
from modelcast.io.base import OnSkipped, ignore_skipped
from modelcast.io.holding import AbstractHoldingReader
from modelcast.io.parquet_guard import require_modest_footer, require_modest_pages
from modelcast.io.table_trips import table_trips
from modelcast.trips.trajectory import Trajectory

__all__ = ["ParquetReader"]

_MAGIC = b"PAR1"
_BUFFER_BYTES = 2**20
"""Read of a column at a time, so that no row group is held whole."""


@dataclass(frozen=True, slots=True)
class ParquetReader(AbstractHoldingReader):
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
        """Yield a trip per vehicle, as `modelcast.io.gathering` gathers them."""
        with _told(path), Path(path).open("rb") as file:
            require_modest_footer(path, file)
            metadata: Any = pq.read_metadata(file)
            schema = metadata.schema.to_arrow_schema()
        checked: set[str] = set()

        def batches(wanted: Sequence[str], rows: int = PART_ROWS) -> Iterator[Any]:
            # pyarrow, because polars ends the whole process on some damaged files.
            words = [name for name in wanted if is_text(schema.field(name).type)]
            with _told(path), Path(path).open("rb") as file:
                if not checked.issuperset(wanted):
                    require_modest_pages(path, file, metadata, wanted)
                    checked.update(wanted)
                # Buffering ahead would hold a whole row group, packed.
                opened = pq.ParquetFile(
                    file, metadata=metadata, page_checksum_verification=True,
                    read_dictionary=words, buffer_size=_BUFFER_BYTES, pre_buffer=False,
                )  # fmt: skip
                yield from opened.iter_batches(batch_size=rows, columns=list(wanted))

        with _told(path):
            table = ArrowTable(path, self.columns, schema, metadata.num_rows, batches)
        yield from table_trips(table, self.name, on_skipped, held_bytes=self.held_bytes)


@contextmanager
def _told(path: str) -> Generator[None]:
    """Turn what pyarrow says of a file into the error of a reader."""
    try:
        yield
    except (pa.ArrowException, OSError, ValueError, MemoryError) as error:
        raise DataFormatError(
            path, f"is not readable as Parquet: {error}", remedy="Check that it is complete."
        ) from error
