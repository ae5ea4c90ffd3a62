"""A trace as an OMNeT++ output vector file (``.vec``), which its analysis tools read.

A text file: ``version 2``, a ``run`` and its attributes; ``vector id module name TV`` declares a vector, with
its unit as an attribute; a line of data is the vector's number, a time and a value, parted by tabs. A vector
is a number column of a table of one station: module ``modelcast.station[17]``, name ``receptions:age_s``.
Columns that hold names or numbers of stations and messages have no vector.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, TextIO

import polars as pl
import pyarrow.parquet as pq

from modelcast.study.network.trace import TRACE
from modelcast.study.table import Column

__all__ = ["write_vectors"]

_STATION = {"positions": "vehicle", "transmissions": "sender", "receptions": "receiver"}
"""Whose vectors the rows of a table go into; a message that expired is nobody's measurement."""

_ROWS = 50_000


def write_vectors(folder: Path) -> None:
    """Write ``trace.vec`` of a trace's Parquet files.

    Parameters
    ----------
    folder
        The trace.
    """
    with (folder / "trace.vec").open("w", encoding="utf-8", newline="\n") as out:
        out.write("version 2\nrun modelcast-trace\nattr experiment modelcast\nattr network modelcast\n\n")
        first = 0
        for table, station in _STATION.items():
            first += _write_table(out, folder / f"{table}.parquet", table, station, first)


def vector_columns(table: str) -> tuple[Column, ...]:
    """Columns of a table that are vectors: numbers with a unit, but the time.

    Parameters
    ----------
    table
        Its name.
    """
    return tuple(one for one in TRACE[table] if one.kind != "text" and one.unit and one.name != "t_s")


def _write_table(out: TextIO, path: Path, table: str, station: str, first: int) -> int:
    """Write the vectors of a table, numbered from a first on; returns how many there are."""
    columns = vector_columns(table)
    stations = pl.scan_parquet(path).select(pl.col(station).unique().sort()).collect()[station].to_list()
    number = {one: first + at * len(columns) for at, one in enumerate(stations)}
    for one in stations:
        for at, column in enumerate(columns):
            out.write(f"vector {number[one] + at} modelcast.station[{one}] {table}:{column.name} TV\n")
            out.write(f'attr unit "{column.unit}"\nattr title "{column.description}"\n')
    out.write("\n")
    for rows in _rows(path, [station, "t_s", *(column.name for column in columns)]):
        for one, t_s, *values in rows:
            for at, value in enumerate(values):
                if value is not None:
                    out.write(f"{number[one] + at}\t{t_s:.9g}\t{value:.9g}\n")
    return len(stations) * len(columns)


def _rows(path: Path, columns: list[str]) -> Iterator[Iterator[tuple[Any, ...]]]:
    """Yield the rows of a Parquet file, some at a time."""
    file: Any = pq.ParquetFile(path)
    for batch in file.iter_batches(_ROWS, columns=columns):
        yield zip(*(batch.column(name).to_pylist() for name in columns), strict=True)
