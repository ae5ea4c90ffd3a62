"""The hybrid against the baseline in traffic, on disk.

``traffic.parquet``
    One row a figure, density, radio, bank, threshold and distance: the fields of
    `modelcast.study.network.pairs.PairedRow`, bounds empty where there was one seed.
"""

from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from modelcast.core.exceptions import DataFormatError
from modelcast.io.arrow import columns_table, write_tables
from modelcast.study.network.pairs import PairedRow

__all__ = ["read_traffic", "write_traffic"]

_KINDS: dict[object, Any] = {int: np.int64, bool: np.bool_, str: object}
_TEXT = frozenset({"verdict"})


def write_traffic(rows: Sequence[PairedRow], folder: str | Path) -> Path:
    """Write ``traffic.parquet``; return its path.

    Parameters
    ----------
    rows
        As `modelcast.study.network.pairs.traffic_rows` gives them.
    folder
        An existing folder.
    """
    columns: dict[str, Any] = {}
    for field in fields(PairedRow):
        values = [getattr(row, field.name) for row in rows]
        kind = object if field.name in _TEXT else _KINDS.get(field.type, np.float64)
        columns[field.name] = np.array(values, dtype=kind)
    table = columns_table(columns)
    path = Path(folder) / "traffic.parquet"
    write_tables([table], table.schema, path)
    return path


def read_traffic(path: str | Path) -> tuple[PairedRow, ...]:
    """Read what `write_traffic` wrote.

    Parameters
    ----------
    path
        ``traffic.parquet``.

    Raises
    ------
    DataFormatError
        Where it is no such file.
    """
    names = [field.name for field in fields(PairedRow)]
    try:
        found = pl.read_parquet(path).select(names).to_dicts()
    except (OSError, pl.exceptions.PolarsError) as error:
        raise DataFormatError(
            str(path), f"is no traffic.parquet ({error})", remedy="Name the file of a run with --traffic."
        ) from error
    return tuple(PairedRow(**{name: _value(name, value) for name, value in row.items()}) for row in found)


def _value(name: str, value: Any) -> Any:
    """A bound that does not exist is NaN in the file."""
    bound = name.startswith(("hybrid_", "baseline_", "difference_"))
    return None if bound and value is not None and np.isnan(value) else value
