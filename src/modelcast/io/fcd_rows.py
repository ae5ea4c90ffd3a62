"""Rows of floating-car data from CSV, Parquet and SUMO's XML, each with its number in the file.

`modelcast.io.fcd_columns` has the table of columns. CSV has a header row; its fields are parted by commas or,
as SUMO writes them, semicolons; blank optional fields are not known, blank lines are no rows. XML has
``timestep`` elements with a ``time`` and in them ``vehicle``, ``person`` and ``container`` elements. Every
line below the header, every record and every element in a time step is a row, and so is a time step of XML
without any, as in SUMO's tables.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

import csv
from collections.abc import Generator, Iterator, Mapping
from contextlib import contextmanager
from typing import Any
from xml.parsers import expat

import pyarrow as pa
import pyarrow.parquet as pq

from modelcast.core.exceptions import DataFormatError
from modelcast.io.fcd_columns import (
    EMPTY,
    OTHER,
    FcdColumns,
    FcdRow,
    fcd_columns,
    fcd_row,
    table_kind,
    xml_columns,
)
from modelcast.io.fcd_source import fcd_kind, seekable, text
from modelcast.io.text_head import split_fields
from modelcast.io.xml_stream import fed, require_shallow

__all__ = ["csv_names", "read_columns", "read_rows"]

_BATCH = 2**16
_XML_ROWS = frozenset({"vehicle", "person", "container"})


def read_columns(path: str) -> FcdColumns | None:
    """Return the columns of a table, None for SUMO's XML.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    DataFormatError
        Where it cannot be read, or a needed column is missing.
    """
    kind = fcd_kind(path)
    if kind == "xml":
        return None
    if kind == "csv":
        return fcd_columns(path, _csv_header(path)[0])
    with _parquet(path) as file:
        return fcd_columns(path, [str(name) for name in file.schema_arrow.names])


def read_rows(path: str, *, people: bool = False) -> Iterator[FcdRow]:
    """Yield a file's rows, those that are no vehicles among them.

    Parameters
    ----------
    path
        The file; its content says which of the three formats it is.
    people
        Whether persons are wanted: else they are no vehicles.

    Raises
    ------
    DataFormatError
        Where a needed column is missing or a value is not a finite number, with file, row and value.
    """
    columns = read_columns(path)
    if columns is None:
        yield from _xml_rows(path, people=people)
    elif fcd_kind(path) == "csv":
        yield from _csv_rows(path, columns, people=people)
    else:
        yield from _parquet_rows(path, columns, people=people)


def _csv_header(path: str) -> tuple[list[str], str]:
    """Return the column names and what parts them."""
    with text(path) as file:
        return csv_names(file.readline(2**20))


def csv_names(line: str) -> tuple[list[str], str]:
    """Return the column names in a header, and what parts them.

    Parameters
    ----------
    line
        The first line of a table.

    Examples
    --------
    >>> csv_names("timestep_time;vehicle_id")
    (['timestep_time', 'vehicle_id'], ';')
    """
    mark = ";" if line.count(";") > line.count(",") else ","
    return split_fields(line, mark), mark


def _csv_rows(path: str, columns: FcdColumns, *, people: bool) -> Iterator[FcdRow]:
    names, mark = _csv_header(path)
    field = {meaning: names.index(name) for meaning, name in columns.found.items()}
    kind = table_kind(columns)
    with text(path) as file:
        reader = csv.reader(file, delimiter=mark)
        try:
            next(reader)
            for cells in reader:
                if not cells:
                    continue
                if len(cells) != len(names):
                    raise DataFormatError(
                        path,
                        f"{len(cells)} fields where the header has {len(names)}",
                        row=reader.line_num,
                        remedy="Check that the line is whole.",
                    )
                values = {meaning: cells[at].strip() for meaning, at in field.items()}
                yield _table_row(path, reader.line_num, values, kind(values), people=people)
        except csv.Error as error:
            raise DataFormatError(path, str(error), row=reader.line_num) from error


def _table_row(path: str, number: int, values: Mapping[str, Any], kind: str, *, people: bool) -> FcdRow:
    """Return a row of a table; SUMO writes a time step without vehicles as a row with a time alone."""
    if not kind and all(values[name] in {None, ""} for name in ("vehicle", "east", "north")):
        kind = EMPTY
    return fcd_row(path, number, values, kind, people=people)


@contextmanager
def _parquet(path: str) -> Generator[pq.ParquetFile]:
    """Yield a Parquet file, also one inside gzip; what is wrong with it is a `DataFormatError`."""
    with seekable(path) as source:
        try:
            with pq.ParquetFile(source, page_checksum_verification=True) as file:
                yield file
        except (pa.ArrowException, OSError, ValueError, OverflowError, MemoryError) as error:
            raise DataFormatError(
                path, f"is not readable as Parquet: {error}", remedy="Check that it is complete."
            ) from error


def _parquet_rows(path: str, columns: FcdColumns, *, people: bool) -> Iterator[FcdRow]:
    found, kind = columns.found, table_kind(columns)
    number = 0
    with _parquet(path) as file:
        for batch in file.iter_batches(_BATCH, columns=list(found.values())):
            lists = [batch.column(name).to_pylist() for name in found.values()]
            for cells in zip(*lists, strict=True):
                number += 1
                values = dict(zip(found, cells, strict=True))
                yield _table_row(path, number, values, kind(values), people=people)


class _XmlRows:
    """Handlers of the parser: gathers the rows of the elements that begin."""

    def __init__(self, path: str, *, people: bool) -> None:
        self._people = people
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self._begin
        self.parser.EndElementHandler = self._end
        self.root = ""
        self.rows: list[FcdRow] = []
        self._path = path
        self._depth = self._inside = 0
        self._time: str | None = None
        self._names: dict[tuple[str, ...], dict[str, str]] = {}

    def _begin(self, name: str, attributes: dict[str, str]) -> None:
        self._depth += 1
        line = self.parser.CurrentLineNumber
        require_shallow(self._path, self._depth, line)
        if self._depth == 1:
            self.root = name
        elif name == "timestep":
            self._time, self._inside = attributes.get("time"), 0
        elif name in _XML_ROWS or (self._depth == 3 and self._time is not None):
            self._inside += 1
            known = tuple(attributes)
            if known not in self._names:
                self._names[known] = xml_columns(known)
            values: dict[str, Any] = {meaning: attributes[at] for meaning, at in self._names[known].items()}
            values["time"] = self._time
            kind = "" if name == "vehicle" else name if name in _XML_ROWS else OTHER
            self.rows.append(fcd_row(self._path, line, values, kind, people=self._people))

    def _end(self, name: str) -> None:
        self._depth -= 1
        if name == "timestep" and self._time is not None:
            if not self._inside:
                line = self.parser.CurrentLineNumber
                self.rows.append(fcd_row(self._path, line, {"time": self._time}, EMPTY))
            self._time = None


def _xml_rows(path: str, *, people: bool) -> Iterator[FcdRow]:
    """Yield the rows of SUMO's FCD output; their numbers are lines."""
    found = _XmlRows(path, people=people)
    for _ in fed(path, found.parser):
        yield from found.rows
        found.rows.clear()
    if found.root != "fcd-export":
        raise DataFormatError(
            path, f"the root is {found.root!r}, not fcd-export", row=1, remedy="Give SUMO's --fcd-output."
        )
