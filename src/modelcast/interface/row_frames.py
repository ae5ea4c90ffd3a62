"""Rows of a result as a Polars data frame: the columns and their types are the fields of the rows."""

import types
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import polars as pl

__all__ = ["rows_frame"]

_TYPES: Mapping[type, type[pl.DataType]] = {
    str: pl.String,
    int: pl.Int64,
    float: pl.Float64,
    bool: pl.Boolean,
}


def rows_frame(rows: Sequence[Any], row_type: type[Any]) -> pl.DataFrame:
    """Return one row a row, with the same columns and types also where there is none.

    A pair of limits becomes two columns that end in ``_low`` and ``_high``, several names one text with
    commas, and what is kept by name the names alone.

    Parameters
    ----------
    rows
        All of one type.
    row_type
        A dataclass.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @dataclass
    ... class Row:
    ...     policy: str
    ...     rate_hz: float | None
    ...     members: tuple[str, ...]
    >>> rows_frame([Row("mbc", None, ("cv", "gp"))], Row).rows()
    [('mbc', None, 'cv, gp')]
    """
    hints = get_type_hints(row_type)
    columns: dict[str, list[Any]] = {}
    schema: dict[str, type[pl.DataType]] = {}
    for field in fields(row_type):
        kind = _kind(hints[field.name])
        values = [getattr(row, field.name) for row in rows]
        if kind is tuple:
            stem = field.name.removesuffix("_limits")
            for at, end in enumerate(("low", "high")):
                schema[f"{stem}_{end}"] = pl.Float64
                columns[f"{stem}_{end}"] = [None if value is None else value[at] for value in values]
            continue
        schema[field.name] = _TYPES[str if kind is list else kind]
        columns[field.name] = [", ".join(value) for value in values] if kind is list else values
    return pl.DataFrame(columns, schema=schema)


def _kind(hint: Any) -> type:
    """The type of a column: text, a number, a flag, ``tuple`` for limits, ``list`` for names."""
    origin = get_origin(hint)
    if origin in {Union, types.UnionType}:
        (hint,) = (one for one in get_args(hint) if one is not types.NoneType)
        return _kind(hint)
    if origin is Literal:
        return str
    if origin is tuple and get_args(hint) == (str, Ellipsis):
        return list
    if origin is tuple:
        return tuple
    return list if isinstance(origin, type) and issubclass(origin, Mapping) else hint
