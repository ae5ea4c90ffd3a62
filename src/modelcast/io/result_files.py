"""The files of a result: one document for programs to read, and one Parquet file a table."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from modelcast.io.documents import document_text
from modelcast.io.table_files import write_table
from modelcast.study.table import Table

__all__ = ["write_result"]


def write_result(document: Mapping[str, Any], tables: Mapping[str, Table], folder: str | Path) -> list[Path]:
    """Write ``summary.json`` and the tables; return their paths, the document's first.

    Parameters
    ----------
    document
        Plain values.
    tables
        By the stem of their files.
    folder
        An existing folder.
    """
    summary = Path(folder) / "summary.json"
    summary.write_text(document_text(document), encoding="utf-8", newline="\n")
    paths = {Path(folder) / f"{name}.parquet": table for name, table in tables.items()}
    for path, table in paths.items():
        write_table(table, path)
    return [summary, *paths]
