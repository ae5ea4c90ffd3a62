"""Claims about the lines a node writes of what happens."""

import io
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.node.journal import Journal

NAMES = st.from_regex(r"[a-z]{1,20}", fullmatch=True).filter(lambda name: name not in {"utc", "event"})


@given(st.dictionaries(NAMES, st.one_of(st.none(), st.floats(), st.integers(), st.text())))
def test_every_line_is_one_object_of_plain_json(what: dict[str, object]) -> None:
    file = io.StringIO()
    Journal(file, lambda: 1e9).note("event", what)
    (line,) = file.getvalue().splitlines()
    found = json.loads(line, parse_constant=pytest.fail)
    assert set(found) == {"utc", "event", *what}
    assert "\x1b" not in line


def test_a_flood_of_one_kind_is_counted_and_another_kind_is_written() -> None:
    file, now_s = io.StringIO(), 10.0
    journal = Journal(file, lambda: now_s, most_a_second=3)
    for _ in range(10):
        journal.note("flood", {})
    journal.note("rare", {})
    now_s = 11.2
    journal.note("flood", {})
    lines = [json.loads(line) for line in file.getvalue().splitlines()]
    assert [one["event"] for one in lines] == ["flood"] * 3 + ["rare", "flood"]
    assert lines[-1]["left_out_before"] == 7


def test_a_file_that_cannot_be_written_stops_nothing() -> None:
    file = io.StringIO()
    journal = Journal(file, lambda: 0.0)
    file.close()
    journal.note("event", {})
    assert journal.unwritten == 1
