"""Claims about tables of results: what a row may hold, and that every column says what it is."""

import copy
import importlib
import pkgutil
import re
import subprocess
import sys
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from made_rows import filled
from modelcast.study.table import Table, TableSchema, count, flag, quantity, ratio, text

SCHEMA = TableSchema(
    "heard",
    "One receiver.",
    (
        text("radio", "Its radio."),
        text("bank", "Its bank.", missing="it has none"),
        count("frames", "Frames heard."),
        flag("stable", "Whether it was."),
        ratio("busy_ratio", "Busy."),
        quantity("age_s", "s", "Age.", missing="nothing was heard"),
        quantity("power_dbm", "dBm", "Power."),
    ),
)
ROW: dict[str, Any] = {
    "radio": "dsrc",
    "bank": None,
    "frames": 3,
    "stable": True,
    "busy_ratio": 0.25,
    "age_s": None,
    "power_dbm": nan,
}
UNITS = {
    "_m": "m",
    "_s": "s",
    "_hz": "1/s",
    "_ratio": "1",
    "_dbm": "dBm",
    "_bytes": "byte",
    "_per_km": "1/km",
    "_per_s": ("byte/s", "s/s", "1/s"),
    "_per_hour": "1/h",
}


def schemas() -> dict[str, TableSchema]:
    """Every table that the package declares, by module and name."""
    found: dict[str, TableSchema] = {}
    for package in ("study", "io"):
        root = importlib.import_module(f"modelcast.{package}")
        for module in pkgutil.walk_packages(root.__path__, f"{root.__name__}."):
            held = vars(importlib.import_module(module.name))
            own = {name: one for name, one in held.items() if isinstance(one, TableSchema)}
            found |= {f"{one.name} ({name})": one for name, one in own.items()}
    return found


SCHEMAS = schemas()


def test_a_row_holds_its_values_under_their_names() -> None:
    row = SCHEMA.row(**ROW)
    assert (row.radio, row.frames, row.age_s) == ("dsrc", 3, None)
    assert dict(row.items()).keys() == ROW.keys()
    assert row == SCHEMA.row(**ROW)
    assert row.replaced(frames=4).frames == 4
    assert copy.deepcopy(row) == row.replaced(radio="dsrc")
    with pytest.raises(AttributeError, match="no column 'frame'"):
        _ = row.frame


@pytest.mark.parametrize(
    "wrong",
    [
        {"frames": 2.5},
        {"frames": True},
        {"frames": None},
        {"radio": 3},
        {"radio": None},
        {"busy_ratio": "much"},
        {"stable": 1},
        {"power_dbm": None},
    ],
)
def test_a_value_of_another_kind_is_named(wrong: dict[str, Any]) -> None:
    with pytest.raises(TypeError, match=rf"heard\.{next(iter(wrong))} is a"):
        SCHEMA.row(**{**ROW, **wrong})


def test_a_row_has_a_value_for_every_column_and_no_other() -> None:
    with pytest.raises(TypeError, match="check speed"):
        SCHEMA.row(**ROW, speed=1.0)
    with pytest.raises(TypeError, match="check frames"):
        SCHEMA.row(**{name: value for name, value in ROW.items() if name != "frames"})
    with pytest.raises(ValueError, match="two columns of one name"):
        TableSchema("twice", "", (text("radio", ""), text("radio", "")))


def test_numbers_of_numpy_are_plain_in_rows() -> None:
    row = SCHEMA.row(**{**ROW, "frames": np.int64(7), "power_dbm": np.float32(0.5), "stable": np.bool_(0)})
    assert [type(value) for value in (row.frames, row.power_dbm, row.stable)] == [int, float, bool]


def test_a_column_is_an_array_of_its_kind() -> None:
    table = SCHEMA.table([SCHEMA.row(**ROW), SCHEMA.row(**{**ROW, "age_s": 0.5})])
    assert (table["frames"].dtype, table["stable"].dtype) == (np.int64, np.bool_)
    np.testing.assert_array_equal(table["age_s"], [nan, 0.5])
    assert table["bank"].tolist() == [None, None]
    assert isinstance(table[1:], Table)
    assert table[1:][0].age_s == 0.5
    assert not SCHEMA.table()
    with pytest.raises(TypeError, match="no rows of 'other'"):
        TableSchema("other", "", SCHEMA.columns).table([]).__class__(
            SCHEMA, (TableSchema("other", "", ()).row(),)
        )


def test_people_read_headings_with_units_and_shares_in_percent() -> None:
    cells = SCHEMA.table([SCHEMA.row(**ROW)]).cells()
    assert cells.heads == ["radio", "bank", "frames", "stable", "busy [%]", "age [s]", "power dbm [dBm]"]
    assert cells.rows == [["dsrc", "-", "3", "yes", "25.0", "-", "-"]]
    assert cells.text_columns == 2
    assert SCHEMA.table([SCHEMA.row(**ROW)]).cells(["frames", "radio"]).rows == [["3", "dsrc"]]


def test_a_notebook_shows_the_first_rows_and_nothing_in_them_is_markup() -> None:
    table = SCHEMA.table([SCHEMA.row(**{**ROW, "radio": "<b>"})] * 25)
    shown = table._repr_html_()
    assert "&lt;b&gt;" in shown
    assert shown.count("<tr>") == 21
    assert "5 rows more" in shown
    assert repr(table).startswith("<heard: 25 rows of radio, bank")


@pytest.mark.parametrize("name", SCHEMAS)
def test_every_column_says_what_it_is(name: str) -> None:
    schema = SCHEMAS[name]
    assert schema.description
    for column in schema.columns:
        assert column.description.endswith("."), column.name
        assert re.fullmatch(r"[a-z][a-z0-9_]*", column.name)
        for end, unit in UNITS.items():
            per = re.search(r"_per_[a-z]+$", column.name)
            if column.name.endswith(end) and (per is None or per[0] == end):
                allowed = {"1", *((unit,) if isinstance(unit, str) else unit)}
                own = column.unit in (allowed if end != "_ratio" else {"1"})
                assert own, (column.name, column.unit)


@pytest.mark.parametrize("name", SCHEMAS)
def test_every_table_can_be_made_and_read(name: str) -> None:
    schema = SCHEMAS[name]
    table = schema.table([filled(schema, 1.0)])
    assert table.plain()[0].keys() == set(schema.names)
    assert len(table.cells().rows[0]) == len(schema.columns)


ROOT = Path(__file__).parents[2]


def test_the_page_of_columns_is_what_its_script_writes_and_leaves_no_table_out() -> None:
    script = str(ROOT / "validation" / "result_columns.py")
    done = subprocess.run([sys.executable, script, "--check"], check=False)  # noqa: S603 - our own script
    assert done.returncode == 0
    text = (ROOT / "docs" / "columns.md").read_text(encoding="utf-8")
    told = {one.name for one in SCHEMAS.values() if f"### {one.name}\n" in text}
    assert {one.name for one in SCHEMAS.values()} - told == {"drive"}, "drive is part of runs of cruise"


def test_the_tables_of_every_result_are_declared() -> None:
    assert {one.name for one in SCHEMAS.values()} >= {
        "rates",
        "tracking",
        "messages",
        "coverage",
        "times",
        "runs",
        "people",
        "roadside",
        "warnings",
        "pooled",
        "events",
        "traffic",
        "capacity",
        "film",
        "ranking",
    }
