"""Results as JSON: rows as mappings, numbers that do not exist as null, one line a row."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import PurePath
from typing import Any, cast

import numpy as np

__all__ = ["document_text", "plain_value", "row_document"]


def row_document(row: Any) -> dict[str, Any]:
    """Return a row, any dataclass of plain values, as a mapping of its fields.

    Parameters
    ----------
    row
        As in `modelcast.study.result`.
    """
    return {field.name: plain_value(getattr(row, field.name)) for field in fields(row)}


def plain_value(value: Any) -> Any:
    """Return the value in terms of JSON; NaN and infinities are null, a path is its last part.

    Parameters
    ----------
    value
        Text, numbers, arrays, paths, and mappings and sequences of these.

    Raises
    ------
    TypeError
        Where the value is anything else.

    Examples
    --------
    >>> plain_value({"a": (1.5, float("nan"))})
    {'a': [1.5, None]}
    """
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, Mapping):
        items = cast("Mapping[object, object]", value).items()
        return {str(key): plain_value(item) for key, item in items}
    if isinstance(value, np.ndarray | np.generic):
        return plain_value(value.tolist())
    if isinstance(value, Sequence):
        return [plain_value(item) for item in cast("Sequence[object]", value)]
    if isinstance(value, PurePath):
        return value.name
    raise TypeError(f"cannot write {type(value).__name__} as JSON: {value!r}")


def document_text(document: Mapping[str, Any]) -> str:
    """Return the document as JSON with one line a row: it diffs well, and the fast encoder does the rows.

    Parameters
    ----------
    document
        Plain values; its lists are written one item a line.
    """

    def dump(value: object) -> str:
        return json.dumps(value, sort_keys=True, allow_nan=False, ensure_ascii=False)

    parts: list[str] = []
    for key in sorted(document):
        value = document[key]
        rows = cast("list[object]", value) if isinstance(value, list) else []
        if rows:
            parts.append(f'"{key}": [\n  ' + ",\n  ".join(dump(row) for row in rows) + "\n ]")
        else:
            parts.append(f'"{key}": {dump(cast("object", value))}')
    return "{\n " + ",\n ".join(parts) + "\n}\n"
