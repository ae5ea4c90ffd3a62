"""Messages and tracking-error samples of an evaluation, written as they come: memory holds one row group.

Row groups hold the same number of rows however the rows come, so the same rows give the same bytes whether
they are written trip by trip or from a result that kept them.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from pathlib import Path
from types import TracebackType
from typing import Any, Self

import pyarrow as pa

from modelcast.io.arrow import (
    EVENTS_SCHEMA,
    SAMPLES_SCHEMA,
    columns_table,
    plain_text,
    sample_tables,
    table_writer,
)
from modelcast.study.recording import AbstractRecordSink
from modelcast.study.result import Columns, SampleBlock

__all__ = ["EVENTS_FILE", "GROUP_ROWS", "SAMPLES_FILE", "RecordFiles", "RowGroups"]

EVENTS_FILE = "events.parquet"
SAMPLES_FILE = "samples.parquet"

GROUP_ROWS = 250_000
"""Rows of a row group: what is held in memory at most, beside one block of samples."""


class RowGroups:
    """A Parquet file that grows by row groups of one size.

    Parameters
    ----------
    schema
        Of its tables; dictionary columns are written as plain strings.
    path
        The file; it is whole once closed.
    """

    def __init__(self, schema: Any, path: Path) -> None:
        names = pa.string()
        plain = [
            pa.field(one.name, names if pa.types.is_dictionary(one.type) else one.type) for one in schema
        ]
        self._writer = table_writer(pa.schema(plain), path)
        self._held: list[Any] = []
        self._rows = 0

    @property
    def held_rows(self) -> int:
        """Rows that wait for their row group."""
        return self._rows

    def add(self, table: Any) -> None:
        """Add rows.

        Parameters
        ----------
        table
            A ``pyarrow.Table`` of the schema.
        """
        self._held.append(plain_text(table))
        self._rows += table.num_rows
        if self._rows < GROUP_ROWS:
            return
        held = pa.concat_tables(self._held)
        whole = self._rows // GROUP_ROWS * GROUP_ROWS
        for first in range(0, whole, GROUP_ROWS):
            self._write(held.slice(first, GROUP_ROWS))
        self._held, self._rows = [held.slice(whole)], self._rows - whole

    def close(self) -> None:
        """Write what waits, and end the file."""
        if self._rows:
            self._write(pa.concat_tables(self._held))
        self._writer.close()

    def _write(self, rows: Any) -> None:
        self._writer.write_table(rows.combine_chunks(), row_group_size=GROUP_ROWS)


class RecordFiles(AbstractRecordSink):
    """``events.parquet`` and ``samples.parquet`` of a folder, for a ``with`` block.

    Parameters
    ----------
    folder
        An existing folder.
    """

    def __init__(self, folder: Path) -> None:
        self._events = RowGroups(EVENTS_SCHEMA, folder / EVENTS_FILE)
        self._samples = RowGroups(SAMPLES_SCHEMA, folder / SAMPLES_FILE)

    @property
    def held_rows(self) -> int:
        """Rows in memory."""
        return self._events.held_rows + self._samples.held_rows

    def add_events(self, columns: Columns) -> None:
        """Write the messages of a walk, or of many."""
        self._events.add(columns_table(columns).select(EVENTS_SCHEMA.names))

    def add_samples(self, block: SampleBlock) -> None:
        """Write the samples of one contender over one trip."""
        for table in sample_tables([block]):
            self._samples.add(table)

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End both files."""
        self._events.close()
        self._samples.close()
