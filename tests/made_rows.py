"""Rows for tests of which only some values matter."""

from typing import Any

from modelcast.study.table import Row, TableSchema


def filled(schema: TableSchema, value: float, **own: Any) -> Row:
    """A row with one number in every column, whole in columns of counts, and its own values in some."""
    kinds = {
        "text": str(value),
        "count": int(value),
        "flag": bool(value),
        "ratio": float(value),
        "number": float(value),
    }
    rest: dict[str, Any] = {column.name: kinds[column.kind] for column in schema.columns}
    return schema.row(**{**rest, **own})
