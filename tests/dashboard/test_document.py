"""Claims: a snapshot survives its text to the rounding, and no text but such a one is taken."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.rules import FieldError
from modelcast.dashboard.document import MOST_REMOTES, read_road, read_snapshot, road_text, snapshot_text
from modelcast.dashboard.snapshot import Snapshot

MakeSnapshot = Callable[..., Snapshot]

HALF_A_CENTIMETRE = 0.005 + 1e-9


def test_a_snapshot_is_read_back_as_it_was_to_the_rounding(make_snapshot: MakeSnapshot) -> None:
    shown = make_snapshot(2.345, 5)
    found = read_snapshot(snapshot_text(shown))
    assert (found.t_s, found.warnings, found.counters) == (shown.t_s, shown.warnings, shown.counters)
    for name in ("vehicle", "model", "messages"):
        np.testing.assert_array_equal(getattr(found.remotes, name), getattr(shown.remotes, name))
    for name in ("position_m", "semi_axes_m", "path_m", "speed_mps", "error_m", "loss_ratio", "silent_s"):
        np.testing.assert_allclose(
            getattr(found.remotes, name), getattr(shown.remotes, name), atol=2 * HALF_A_CENTIMETRE, rtol=0.0
        )
    assert found.remotes.names == shown.remotes.names


def test_a_text_is_the_same_after_reading(make_snapshot: MakeSnapshot) -> None:
    text = snapshot_text(make_snapshot())
    assert snapshot_text(read_snapshot(text)) == text
    assert text.startswith('{"kind":"snapshot","t_s":1.0,')


def test_a_place_beyond_the_format_is_taken_to_its_edge(make_snapshot: MakeSnapshot) -> None:
    shown = make_snapshot(count=1, warned=False)
    far = replace(shown, remotes=replace(shown.remotes, semi_axes_m=np.array([[1e300, np.inf]])))
    assert read_snapshot(snapshot_text(far)).remotes.semi_axes_m.tolist() == [[2**31 / 100.0] * 2]


def test_a_road_is_read_back_to_the_decimetre() -> None:
    line = np.array([[0.04, 1.0], [-3.0, 7.26]])
    np.testing.assert_allclose(read_road(road_text([line]))[0], line, atol=0.05 + 1e-9)


CHANGES: dict[str, tuple[list[Any], Any]] = {
    "another kind": (["kind"], "road"),
    "another schema": (["schema"], 2),
    "no time": (["t_s"], None),
    "a time that is a text": (["t_s"], "1"),
    "a host without a place": (["host", "east_cm"], None),
    "a heading that is a text": (["host", "heading_mrad"], "north"),
    "a column too short": (["remotes", "speed_cmps"], [1]),
    "a column that is none": (["remotes", "age_ms"], 3),
    "a fraction": (["remotes", "east_cm"], [1.5, 2, 3]),
    "a missing place": (["remotes", "north_cm"], [None, 2, 3]),
    "an axis below zero": (["remotes", "minor_cm"], [-1, 2, 3]),
    "a model without a name": (["remotes", "model"], [0, 1, 3]),
    "an id twice": (["remotes", "id"], [1, 1, 3]),
    "an id too great": (["remotes", "id"], [1, 2, 2**32]),
    "a path too short": (["remotes", "path_cm", 0], [[0, 0]]),
    "a path of texts": (["remotes", "path_cm", 0, 0], ["a", "b"]),
    "times ahead that fall": (["remotes", "ahead_ms"], [400, 800, 700, 1600, 2000]),
    "a level that is none": (["warnings", 0, "level"], 3),
    "a share over one": (["counters", "loss_ratio"], 1.5),
    "a count below zero": (["counters", "rejected"], {"a": -1}),
    "a control character": (["host", "inputs"], "a\x1b[31m"),
    "another key": (["extra"], 1),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_text_with_one_thing_wrong_is_refused_where_it_is(name: str, make_snapshot: MakeSnapshot) -> None:
    document: Any = json.loads(snapshot_text(make_snapshot()))
    way, value = CHANGES[name]
    place = document
    for key in way[:-1]:
        place = place[key]
    place[way[-1]] = value
    with pytest.raises(ValueError, match=str(way[0]).replace("extra", "unknown fields")):
        read_snapshot(json.dumps(document))


@given(st.text(max_size=200))
def test_any_text_is_refused_by_a_value_error(text: str) -> None:
    for read in (read_snapshot, read_road):
        with pytest.raises(ValueError):  # noqa: PT011 - any reason
            read(text)


def test_more_remotes_than_the_format_has_are_refused(make_snapshot: MakeSnapshot) -> None:
    document = json.loads(snapshot_text(make_snapshot()))
    document["remotes"]["id"] = list(range(MOST_REMOTES + 1))
    with pytest.raises(FieldError, match=r"remotes\.id"):
        read_snapshot(json.dumps(document))


def test_half_a_place_of_a_road_is_refused() -> None:
    with pytest.raises(FieldError, match=r"lines_dm\[0\]"):
        read_road('{"kind":"road","schema":1,"lines_dm":[[1,2,3,4,5]]}')
