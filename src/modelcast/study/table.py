"""Results as data: tables whose columns say what they hold and in which unit.

A `TableSchema` declares the columns of one kind of table, once. Rows are made by it and checked against it;
a `Table` is any number of them. Every output is made from these declarations: the terminal, HTML and
Markdown (`modelcast.report`), Parquet, CSV and JSON (`modelcast.io.table_files`), and data frames
(`modelcast.report.tables`). There is no data-frame library here.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, Literal, overload

import numpy as np
import numpy.typing as npt

from modelcast.core.cells import Cells, number

__all__ = ["Column", "Kind", "Row", "Table", "TableSchema", "count", "flag", "quantity", "ratio", "text"]

Kind = Literal["text", "count", "flag", "ratio", "number"]
"""What a column holds: names; whole numbers, not negative; true or false; shares from 0 to 1; numbers."""

_TYPES: Mapping[Kind, tuple[type, ...]] = {
    "text": (str,),
    "count": (int,),
    "flag": (bool,),
    "ratio": (float, int),
    "number": (float, int),
}
_DTYPES: Mapping[Kind, npt.DTypeLike] = {
    "text": object,
    "count": np.int64,
    "flag": np.bool_,
    "ratio": np.float64,
    "number": np.float64,
}
_SHOWN_ROWS = 20


@dataclass(frozen=True, slots=True)
class Column:
    """One column of a table.

    Parameters
    ----------
    name
        Its key in files and frames; a quantity's name ends in its unit (``_m``, ``_s``, ``_hz``).
    kind
        What it holds.
    description
        What it means, in one phrase.
    unit
        As written, ``m``, ``1/s``, ``byte/s``; empty where it has none.
    missing
        Why a value may be absent, which is None in a row; empty where each row has one. A number that does
        not exist, a mean of nothing, is NaN in any column.
    heading
        What people read above it; empty for its name in words and its unit.
    """

    name: str
    kind: Kind
    description: str
    _: KW_ONLY
    unit: str = ""
    missing: str = ""
    heading: str = ""

    @property
    def shown_heading(self) -> str:
        """What people read above it.

        Examples
        --------
        >>> ratio("busy_ratio", "").shown_heading, quantity("age_p90_s", "s", "").shown_heading
        ('busy [%]', 'age p90 [s]')
        """
        unit = "%" if self.kind == "ratio" else self.unit
        words = self.name.removesuffix("_ratio" if self.kind == "ratio" else f"_{self.unit}")
        return self.heading or words.replace("_", " ") + (f" [{unit}]" if unit else "")

    @property
    def dtype(self) -> npt.DTypeLike:
        """Type of its array: text and what may be absent in it are objects."""
        return _DTYPES[self.kind]

    @property
    def factor(self) -> float:
        """What numbers are multiplied by to be shown: shares are shown in percent."""
        return 100.0 if self.kind == "ratio" else 1.0

    @property
    def is_text(self) -> bool:
        """Whether it is set to the left."""
        return self.kind in {"text", "flag"}

    def cell(self, value: Any) -> str:
        """Return a value as people read it.

        Parameters
        ----------
        value
            Of this column.

        Examples
        --------
        >>> ratio("busy_ratio", "").cell(0.125), flag("stable", "").cell(True), count("seeds", "").cell(3)
        ('12.5', 'yes', '3')
        """
        if value is None:
            return "-"
        if self.kind == "flag":
            return "yes" if value else "no"
        return str(value) if self.kind in {"text", "count"} else number(self.factor * value)

    def admits(self, value: object) -> bool:
        """Whether a row may hold the value here.

        Parameters
        ----------
        value
            Any.
        """
        if value is None:
            return bool(self.missing)
        if isinstance(value, bool) and self.kind != "flag":
            return False
        return isinstance(value, _TYPES[self.kind])


def text(name: str, description: str, *, missing: str = "", heading: str = "") -> Column:
    """Return a column of names."""
    return Column(name, "text", description, missing=missing, heading=heading)


def count(name: str, description: str, *, unit: str = "", heading: str = "") -> Column:
    """Return a column of whole numbers, none of them negative; things counted have no unit."""
    return Column(name, "count", description, unit=unit, heading=heading)


def flag(name: str, description: str) -> Column:
    """Return a column of what is true or not."""
    return Column(name, "flag", description)


def ratio(name: str, description: str, *, missing: str = "", heading: str = "") -> Column:
    """Return a column of shares from 0 to 1; people read them in percent."""
    return Column(name, "ratio", description, unit="1", missing=missing, heading=heading)


def quantity(name: str, unit: str, description: str, *, missing: str = "", heading: str = "") -> Column:
    """Return a column of numbers in a unit."""
    return Column(name, "number", description, unit=unit, missing=missing, heading=heading)


@dataclass(frozen=True, slots=True)
class TableSchema:
    """The columns of one kind of table.

    Parameters
    ----------
    name
        Of the table, as files are named.
    description
        What a row is.
    columns
        In order, no two of one name.

    Raises
    ------
    ValueError
        Where two columns have one name.

    Examples
    --------
    >>> heard = TableSchema("heard", "One receiver.", (text("radio", ""), count("frames", "")))
    >>> table = heard.table([heard.row(radio="dsrc", frames=3), heard.row(radio="nr", frames=4)])
    >>> table["frames"].sum().item(), table[1].radio
    (7, 'nr')
    """

    name: str
    description: str
    columns: tuple[Column, ...]
    places: Mapping[str, int] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Number the columns."""
        places = {column.name: at for at, column in enumerate(self.columns)}
        if len(places) != len(self.columns):
            raise ValueError(f"table {self.name!r} has two columns of one name")
        object.__setattr__(self, "places", places)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(self.places)

    def __getitem__(self, name: str) -> Column:
        """Return a column by its name."""
        return self.columns[self.places[name]]

    def row(self, **values: Any) -> "Row":
        """Return a row, checked.

        Parameters
        ----------
        **values
            One for each column, by name.

        Raises
        ------
        TypeError
            Where a column has no value, a value has no column, or a value is not of its column's kind.
        """
        if values.keys() != self.places.keys():
            wrong = sorted(values.keys() ^ self.places.keys())
            raise TypeError(f"a row of {self.name!r} has one value a column; check {', '.join(wrong)}")
        found = tuple(_bare(values[name]) for name in self.places)
        for column, value in zip(self.columns, found, strict=True):
            if not column.admits(value):
                raise TypeError(f"{self.name}.{column.name} is a {column.kind}, not {value!r}")
        return Row(self, found)

    def table(self, rows: Iterable["Row"] = ()) -> "Table":
        """Return a table of rows.

        Parameters
        ----------
        rows
            Made by this schema.
        """
        return Table(self, tuple(rows))


@dataclass(frozen=True, slots=True, repr=False)
class Row:
    """One row of a table; its values are attributes under the names of the columns.

    Parameters
    ----------
    schema
        The columns.
    values
        One a column.
    """

    schema: TableSchema
    values: tuple[Any, ...]

    def __getattr__(self, name: str) -> Any:
        """Return the value of a column."""
        if name.startswith("__") or name not in self.schema.places:
            raise AttributeError(f"a row of {self.schema.name!r} has no column {name!r}")
        return self.values[self.schema.places[name]]

    def __dir__(self) -> list[str]:
        """Names of the columns, for whoever completes them."""
        return [*self.schema.names, *object.__dir__(self)]

    def __repr__(self) -> str:
        """Return the row with its names."""
        return f"{self.schema.name}({', '.join(f'{name}={value!r}' for name, value in self.items())})"

    def items(self) -> Iterator[tuple[str, Any]]:
        """Name and value of each column."""
        return zip(self.schema.names, self.values, strict=True)

    def picked(self, names: Iterable[str]) -> dict[str, Any]:
        """Return some of the values by name.

        Parameters
        ----------
        names
            Of columns.
        """
        return {name: self.values[self.schema.places[name]] for name in names}

    def plain(self) -> dict[str, Any]:
        """Return the values by name as JSON holds them: a number that is not finite is None."""
        return {
            name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in self.items()
        }

    def replaced(self, **values: Any) -> "Row":
        """Return the row with other values, checked as `TableSchema.row` checks them.

        Parameters
        ----------
        **values
            By name of the column.
        """
        return self.schema.row(**{**dict(self.items()), **values})


@dataclass(frozen=True, slots=True, repr=False)
class Table(Sequence[Row]):
    """Rows of one schema.

    A table is a sequence of its rows; by a name it gives a column as an array.

    Parameters
    ----------
    schema
        The columns.
    rows
        Made by this schema.

    Raises
    ------
    TypeError
        Where a row is of another schema.
    """

    schema: TableSchema
    rows: tuple[Row, ...]

    def __post_init__(self) -> None:
        """Check whose the rows are."""
        for row in self.rows:
            if row.schema is not self.schema and row.schema != self.schema:
                raise TypeError(f"a table of {self.schema.name!r} has no rows of {row.schema.name!r}")

    def __len__(self) -> int:
        """Return how many rows there are."""
        return len(self.rows)

    def __iter__(self) -> Iterator[Row]:
        """Yield the rows."""
        return iter(self.rows)

    @overload
    def __getitem__(self, index: int) -> Row: ...
    @overload
    def __getitem__(self, index: slice) -> "Table": ...
    @overload
    def __getitem__(self, index: str) -> npt.NDArray[Any]: ...
    def __getitem__(self, index: int | slice | str) -> "Row | Table | npt.NDArray[Any]":
        """Return a row by its number, some rows by a slice, or a column by its name.

        A column is an array of floats (NaN where there is no number), whole numbers, booleans, or objects
        (text, None where there is none).
        """
        if isinstance(index, str):
            place = self.schema.places[index]
            return np.array([row.values[place] for row in self.rows], self.schema[index].dtype)
        return self.rows[index] if isinstance(index, int) else Table(self.schema, self.rows[index])

    def __repr__(self) -> str:
        """Return what it is and how large, in a line."""
        return f"<{self.schema.name}: {len(self.rows)} rows of {', '.join(self.schema.names)}>"

    def _repr_html_(self) -> str:
        """Return the first rows as notebooks show them."""
        shown = self[:_SHOWN_ROWS].cells().html()
        left = len(self.rows) - _SHOWN_ROWS
        return shown + (f"<p>... and {left} rows more</p>" if left > 0 else "")

    def cells(self, names: Iterable[str] | None = None) -> Cells:
        """Return columns as people read them, with their headings.

        Parameters
        ----------
        names
            Of the columns; None for all.
        """
        columns = [self.schema[name] for name in names or self.schema.names]
        texts = next((at for at, column in enumerate(columns) if not column.is_text), len(columns))
        rows = [[column.cell(getattr(row, column.name)) for column in columns] for row in self.rows]
        return Cells([column.shown_heading for column in columns], rows, texts)

    def plain(self) -> list[dict[str, Any]]:
        """Return the rows as `Row.plain` gives them."""
        return [row.plain() for row in self.rows]


def _bare(value: Any) -> Any:
    """Return a value without NumPy's type."""
    return value.item() if issubclass(type(value), np.generic) else value
