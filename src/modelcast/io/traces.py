"""The trace of a run on disk: Parquet as it streams, and other formats from that.

``positions``, ``transmissions``, ``receptions`` and ``expired`` have the columns of
`modelcast.study.network.trace.TRACE`; in Parquet each column carries its unit and meaning as metadata. The
other formats are made of these files, some hundred thousand rows at a time:

=============  ==========================================================================================
Format         Files
=============  ==========================================================================================
`parquet`      ``<table>.parquet``
`csv`          ``<table>.csv``: a header, a comma, a point; empty where a value is not known
`ns2`          ``positions.ns_movements``, ``nodes.csv`` (`modelcast.io.trace_movements`)
`bonnmotion`   ``positions.movements.gz``, ``positions.params``, ``nodes.csv``
`omnetpp`      ``trace.vec`` (`modelcast.io.trace_vectors`)
=============  ==========================================================================================
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false, reportUnknownMemberType=false

from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq

from modelcast.core.exceptions import ConfigError
from modelcast.io.output import atomic_folder
from modelcast.io.trace_movements import write_bonnmotion, write_ns2
from modelcast.io.trace_vectors import write_vectors
from modelcast.study.network.trace import TRACE, TraceColumns

__all__ = ["TRACE_FORMATS", "read_trace", "trace_writer"]

_GROUP_ROWS = 200_000
"""Rows of a table that are gathered before they are written: what bounds the memory."""

_TYPES: Mapping[str, Any] = MappingProxyType(
    {"count": pa.int64(), "number": pa.float64(), "text": pa.string()}
)


def _write_csv(folder: Path) -> None:
    """Write every table as text."""
    for name in TRACE:
        pl.scan_parquet(folder / f"{name}.parquet").sink_csv(folder / f"{name}.csv")


_WRITERS: Mapping[str, Callable[[Path], None]] = MappingProxyType(
    {
        "csv": _write_csv,
        "ns2": write_ns2,
        "bonnmotion": write_bonnmotion,
        "omnetpp": write_vectors,
    }
)

TRACE_FORMATS = ("parquet", *_WRITERS)
"""Formats that a trace can be had in."""


class _Table:
    """A table that is written group by group."""

    def __init__(self, name: str, folder: Path, stack: ExitStack) -> None:
        fields = [
            pa.field(one.name, _TYPES[one.kind], metadata={"unit": one.unit, "meaning": one.description})
            for one in TRACE[name]
        ]
        self._schema = pa.schema(fields)
        self._file = stack.enter_context(
            pq.ParquetWriter(folder / f"{name}.parquet", self._schema, compression="zstd")
        )
        self._parts = list[TraceColumns]()
        self._rows = 0

    def take(self, columns: TraceColumns) -> None:
        """Gather rows, and write them where they are many."""
        self._parts.append(columns)
        self._rows += len(next(iter(columns.values())))
        if self._rows >= _GROUP_ROWS:
            self.write()

    def write(self) -> None:
        """Write what is gathered."""
        if not self._parts:
            return
        arrays = [
            pa.array(np.concatenate([part[field.name] for part in self._parts]), field.type, from_pandas=True)
            for field in self._schema
        ]
        self._file.write_table(pa.table(arrays, schema=self._schema))
        self._parts, self._rows = [], 0


@contextmanager
def trace_writer(
    folder: str | Path, formats: Sequence[str] = ("parquet",)
) -> Generator[Callable[[str, TraceColumns], None]]:
    r"""Yield what takes the rows of a trace, by its tables; the folder appears whole or not at all.

    Parameters
    ----------
    folder
        Where to; an older trace there is replaced.
    formats
        Of `TRACE_FORMATS`.

    Raises
    ------
    ConfigError
        Where a format is unknown, or the folder holds what is no trace.

    Examples
    --------
    >>> import tempfile
    >>> place = Path(tempfile.mkdtemp()) / "trace"
    >>> gone = {"t_s": np.array([0.1]), "origin": np.array([7]), "message": np.array([3])}
    >>> with trace_writer(place, ["csv"]) as take:
    ...     take("expired", gone)
    >>> (place / "expired.csv").read_text()
    't_s,origin,message\n0.1,7,3\n'
    """
    unknown = [name for name in formats if name not in TRACE_FORMATS]
    if unknown or not formats:
        raise ConfigError(
            f"formats of a trace are {', '.join(TRACE_FORMATS)}, got {', '.join(unknown) or 'none'}"
        )
    with atomic_folder(folder, command="trace") as at:
        with ExitStack() as stack:
            tables = {name: _Table(name, at, stack) for name in TRACE}
            yield lambda name, columns: tables[name].take(columns)
            for table in tables.values():
                table.write()
        for name in dict.fromkeys(formats):
            if name in _WRITERS:
                _WRITERS[name](at)
        if "parquet" not in formats:
            for name in TRACE:
                (at / f"{name}.parquet").unlink()


def read_trace(folder: str | Path) -> Mapping[str, pl.LazyFrame]:
    """Return the tables of a trace in Parquet, not read before they are asked.

    Parameters
    ----------
    folder
        As `trace_writer` wrote it.

    Raises
    ------
    ConfigError
        Where a table is missing.
    """
    return dict(_tables(Path(folder)))


def _tables(folder: Path) -> Iterator[tuple[str, pl.LazyFrame]]:
    for name in TRACE:
        path = folder / f"{name}.parquet"
        if not path.is_file():
            raise ConfigError(f"{folder} holds no trace in Parquet: {path.name} is missing")
        yield name, pl.scan_parquet(path)
