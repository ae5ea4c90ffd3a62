"""A TOML file into frozen dataclasses: one a table, checked by the rules of its fields, wrong lines named."""

import json
import re
import tomllib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar, cast

from modelcast.core.exceptions import DataFormatError
from modelcast.core.rules import FieldError, shown

__all__ = ["lines_of", "read_tables", "tables_of"]

_LARGEST_BYTES = 1 << 20
_LINE = re.compile(r"line (\d+)")

Kind = TypeVar("Kind")


def read_tables(path: str | Path, kind: type[Kind]) -> Kind:
    """Read a file.

    Parameters
    ----------
    path
        The file.
    kind
        A frozen dataclass whose fields are such dataclasses, one a table; a table that is left out has its
        defaults. A dataclass refuses values in ``__post_init__`` by `modelcast.core.rules.check_fields`.

    Raises
    ------
    DataFormatError
        Where it cannot be read, is no TOML, or holds what is not known or not allowed; it names the line.
    """
    place = Path(path)
    try:
        if place.stat().st_size > _LARGEST_BYTES:
            raise DataFormatError(
                str(path), f"is larger than {_LARGEST_BYTES} bytes", remedy="Name a TOML file."
            )
        text = place.read_text(encoding="utf-8")
    except OSError as error:
        raise DataFormatError(str(path), error.strerror or str(error), remedy="Check the path.") from error
    except UnicodeDecodeError as error:
        raise DataFormatError(str(path), "is not UTF-8 text", remedy="Name a TOML file.") from error
    return tables_of(text, kind, str(path))


def tables_of(text: str, kind: type[Kind], path: str = "<text>") -> Kind:
    """As `read_tables`, of a text.

    Parameters
    ----------
    text
        TOML.
    kind
        As for `read_tables`.
    path
        How errors name it.

    Raises
    ------
    DataFormatError
        As for `read_tables`.
    """
    try:
        document = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        found = _LINE.search(str(error))
        row = int(found.group(1)) if found else None
        raise DataFormatError(path, f"is no TOML ({error})", row=row, remedy="Mend that line.") from error
    tables = _kinds(kind)
    values: dict[str, Any] = {}
    for name, table in document.items():
        row = _row(text, name, None)
        if name not in tables:
            known = ", ".join(f"[{one}]" for one in tables)
            raise DataFormatError(path, f"[{name}] is not known", row=row, remedy=f"There are {known}.")
        if not isinstance(table, dict):
            problem = f"{name} must be a table, got {shown(table)}"
            raise DataFormatError(path, problem, row=row, remedy=f"Write [{name}] on a line of its own.")
        values[name] = _table(text, path, name, cast("Mapping[str, Any]", table), tables[name])
    try:
        return kind(**values)
    except ValueError as error:
        raise DataFormatError(path, str(error), remedy="Change one of the two.") from error


def lines_of(tables: Any) -> list[str]:
    r"""Lines of TOML from which `tables_of` makes the same again.

    Parameters
    ----------
    tables
        A frozen dataclass whose fields are such dataclasses, of texts, numbers, truth values and tuples of
        texts. None, which TOML has no word for, must be a default: it is left out.

    Examples
    --------
    >>> from modelcast.node.config import NodeConfig
    >>> lines_of(NodeConfig())[:2]
    ['[station]', 'kind = "vehicle"']
    >>> tables_of("\n".join(lines_of(NodeConfig())), NodeConfig) == NodeConfig()
    True
    """
    lines: list[str] = []
    for table in fields(tables):
        own = getattr(tables, table.name)
        lines.append(f"[{table.name}]")
        values = {one.name: getattr(own, one.name) for one in fields(own)}
        lines += [f"{name} = {_toml(value)}" for name, value in values.items() if value is not None]
    return lines


def _toml(value: object) -> str:
    """A value; texts hold no control characters (`modelcast.core.rules.Text`), so JSON's are TOML's."""
    if isinstance(value, tuple):
        return "[" + ", ".join(_toml(one) for one in cast("tuple[object, ...]", value)) + "]"
    return json.dumps(value, ensure_ascii=False)


def _kinds(kind: Any) -> dict[str, Any]:
    """The dataclass of each table."""
    found = {field.name: field.type for field in fields(kind)}
    for name, one in found.items():
        if not is_dataclass(one):
            raise TypeError(f"{kind.__name__}.{name} must be of a dataclass, whose annotations are no texts")
    return found


def _table(text: str, path: str, name: str, given: Mapping[str, Any], kind: Any) -> Any:
    known = {field.name: field for field in fields(kind)}
    values: dict[str, Any] = {}
    for key, value in given.items():
        if key not in known:
            keys = ", ".join(known)
            problem = f"[{name}] has no {key}"
            raise DataFormatError(path, problem, row=_row(text, name, key), remedy=f"It has {keys}.")
        values[key] = tuple(cast("list[Any]", value)) if isinstance(value, list) else value
    try:
        return kind(**values)
    except FieldError as error:
        key = re.split(r"[.\[]", error.place, maxsplit=1)[0]
        place = f"[{name}] {error.place}"
        problem = f"{place} must be {error.expected}, got {shown(error.value)}"
        raise DataFormatError(path, problem, row=_row(text, name, key)) from error
    except ValueError as error:
        raise DataFormatError(path, f"[{name}]: {error}", row=_row(text, name, None)) from error


def _row(text: str, table: str, key: str | None) -> int | None:
    """The line of a key, or of its table; None where TOML writes it in another way."""
    inside = False
    head = re.compile(rf"\s*\[\s*[\"']?{re.escape(table)}[\"']?\s*\]")
    one = re.compile(rf"\s*[\"']?{re.escape(table if key is None else key)}[\"']?\s*=")
    for number, line in enumerate(text.splitlines(), start=1):
        if head.match(line):
            inside = True
            if key is None:
                return number
        elif line.lstrip().startswith("["):
            inside = False
        elif (inside or key is None) and one.match(line):
            return number
    return None
