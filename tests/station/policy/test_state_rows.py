"""Rows of a policy's state: taken out and put back, whatever the state is made of."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.station.policy.state_rows import check_state, put_rows, take_rows


class Named(NamedTuple):
    """Two columns."""

    a: FloatArray
    b: IntArray


@dataclass(frozen=True)
class Held:
    """A column, two more, and nothing."""

    a: FloatArray
    b: Named
    c: None = None


def held(rows: int, start: float = 0.0) -> Held:
    a = start + np.arange(float(2 * rows)).reshape(rows, 2)
    return Held(a, Named(a[:, 0], (10.0 * a[:, 1]).astype(np.int64)))


STATES: tuple[Any, ...] = (None, held(4).a, (held(4).a, None), held(4).b, held(4))


@pytest.mark.parametrize("state", STATES, ids=["none", "array", "tuple", "named", "dataclass"])
def test_rows_put_back_are_those_taken_out(state: Any) -> None:
    check_state(state, 4, "It")
    rows = np.array([3, 1])
    before = repr(state)
    assert repr(put_rows(state, rows, take_rows(state, rows))) == before
    assert type(take_rows(state, rows)) is type(state)


def test_only_the_rows_that_are_put_change_and_the_given_state_is_left_alone() -> None:
    state, rows = held(4), np.array([2, 0])
    after = put_rows(state, rows, held(2, 100.0))
    np.testing.assert_array_equal(after.a[:, 0], [102.0, 2.0, 100.0, 6.0])
    np.testing.assert_array_equal(after.b.b, [1030, 30, 1010, 70])
    np.testing.assert_array_equal(state.a, held(4).a)


@pytest.mark.parametrize(
    ("state", "told"),
    [
        (np.zeros(3), "It: an array of the state must have 4 rows, got shape (3,)"),
        (np.zeros(()), "got shape ()"),
        ((np.zeros(4), np.zeros((5, 2))), "got shape (5, 2)"),
        ([np.zeros(4)], "It: a state is None, an array, or a tuple or dataclass of arrays"),
        (3.0, "got float"),
    ],
)
def test_a_state_without_a_row_a_vehicle_is_refused(state: Any, told: str) -> None:
    with pytest.raises(ValueError) as refused:  # noqa: PT011 - the text is compared
        check_state(state, 4, "It")
    assert told in str(refused.value)
