"""Tables of results as files: Parquet, CSV and JSON, one writer each.

What a column means goes with it. A Parquet file holds under the key ``modelcast.table`` of its metadata, and
a JSON document under ``table``, what `schema_document` returns: name and description of the table, and of
each column its name, kind, unit, description, and why a value may be absent. CSV holds names alone.

A number that does not exist is null in Parquet and JSON, and an empty cell in CSV; an infinite one is null
in JSON only, which has none.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq

from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.core.version import package_version
from modelcast.io.arrow import columns_table, plain_text, write_tables
from modelcast.io.documents import document_text
from modelcast.study.table import Table, TableSchema

__all__ = [
    "arrow_columns",
    "csv_text",
    "read_table",
    "read_table_schema",
    "schema_document",
    "table_document",
    "write_table",
]

_KEY = b"modelcast.table"


def schema_document(schema: TableSchema) -> dict[str, Any]:
    """Return what the columns are as plain values.

    Parameters
    ----------
    schema
        The columns.
    """
    return {
        "name": schema.name,
        "description": schema.description,
        "columns": [
            {
                "name": column.name,
                "kind": column.kind,
                "unit": column.unit,
                "description": column.description,
                "missing": column.missing,
            }
            for column in schema.columns
        ],
    }


def table_document(table: Table) -> dict[str, Any]:
    """Return a table as a JSON document: ``modelcast`` (version), ``table`` (what its columns are), ``rows``.

    Parameters
    ----------
    table
        Any.
    """
    return {"modelcast": package_version(), "table": schema_document(table.schema), "rows": table.plain()}


def arrow_columns(schema: TableSchema, columns: Mapping[str, Sequence[Any] | npt.NDArray[Any]]) -> Any:
    """Return a ``pyarrow.Table`` with what its columns are in its metadata.

    Parameters
    ----------
    schema
        The columns.
    columns
        Values of each, of equal length.
    """
    arrays = {column.name: np.array(columns[column.name], column.dtype) for column in schema.columns}
    described = json.dumps(schema_document(schema), sort_keys=True, ensure_ascii=False)
    return columns_table(arrays).replace_schema_metadata({_KEY: described.encode()})


def write_table(table: Table, out: Path | BinaryIO, form: str = "parquet") -> None:
    """Write a table; the same table gives the same bytes.

    Parameters
    ----------
    table
        Any.
    out
        The file, or one open for writing bytes.
    form
        ``parquet``, ``csv`` or ``json``.
    """
    found = arrow_columns(table.schema, {name: table[name] for name in table.schema.names})
    if form == "parquet":
        write_tables([found], found.schema, out)
        return
    written = document_text(table_document(table)) if form == "json" else csv_text(found)
    if isinstance(out, Path):
        out.write_text(written, encoding="utf-8", newline="\n")
    else:
        out.write(written.encode())


def read_table(schema: TableSchema, path: str | Path, *, remedy: str) -> Table:
    """Read a table that `write_table` wrote as Parquet.

    Parameters
    ----------
    schema
        Its columns.
    path
        The file.
    remedy
        What to do where it is no such table.

    Raises
    ------
    DataFormatError
        Where the file cannot be read, has no such columns, or holds a value of another kind.
    """
    try:
        found = pq.read_table(path, columns=list(schema.names)).select(list(schema.names)).to_pylist()
        absent = {column.name: None if column.missing else math.nan for column in schema.columns}
        rows = [
            schema.row(**{name: absent[name] if value is None else value for name, value in row.items()})
            for row in found
        ]
    except (OSError, KeyError, TypeError, pa.ArrowException) as error:
        raise DataFormatError(
            str(path), f"is no table of {schema.name!r} ({error})", remedy=remedy
        ) from error
    return schema.table(rows)


def read_table_schema(path: str | Path) -> dict[str, Any]:
    """Return what the columns of a Parquet file of results are, as `schema_document` gave it.

    Parameters
    ----------
    path
        A file that `write_table` wrote.

    Raises
    ------
    ConfigError
        Where the file says nothing of its columns.
    """
    held = pq.read_schema(path).metadata or {}
    try:
        found: dict[str, Any] = json.loads(held[_KEY])
    except (KeyError, ValueError) as error:
        raise ConfigError(
            f"{path} says nothing of its columns ({_KEY.decode()}): it is no table of results"
        ) from error
    return found


def csv_text(found: Any) -> str:
    """Return a ``pyarrow.Table`` as comma-separated text: names, then a line a row, null as an empty cell.

    Parameters
    ----------
    found
        Its text may be dictionary columns.
    """
    written = io.StringIO(newline="")
    writer = csv.writer(written, lineterminator="\n")
    writer.writerow(found.column_names)
    writer.writerows(zip(*(column.to_pylist() for column in plain_text(found).columns), strict=True))
    return written.getvalue()
