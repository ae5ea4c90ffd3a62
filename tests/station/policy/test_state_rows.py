"""Rows of a policy's state: taken out and put back, whatever the state is made of."""

import re
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import PolicyError
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
    assert repr(put_rows(state, rows, take_rows(state, rows), "It")) == before
    assert type(take_rows(state, rows)) is type(state)


def test_only_the_rows_that_are_put_change_and_the_given_state_is_left_alone() -> None:
    state, rows = held(4), np.array([2, 0])
    after = put_rows(state, rows, held(2, 100.0), "It")
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


SINGLES = np.zeros(4, dtype=np.float32)
WHOLE, TEXT = np.zeros(4, dtype=np.int64), np.array(["ab"] * 4)


@pytest.mark.parametrize(
    ("state", "some", "told"),
    [
        (WHOLE, np.array([0.5, 1.0]), "It: state began as int64 and cannot hold float64: let init give"),
        ((None, WHOLE), (None, np.array([0.5, 1.0])), "It: state[1] began as int64"),
        (held(4), Held(held(2).a, Named(held(2).a[:, 0], held(2).a[:, 1])), "It: state.b.b began as int64"),  # type: ignore[arg-type]
        (WHOLE.astype(np.int8), np.array([1, 300]), "state began as int8 and cannot hold int64"),
        (WHOLE.astype(np.uint8), np.array([1, -1]), "state began as uint8 and cannot hold int64: let init"),
        (SINGLES, np.array([1.0, 1e300]), "It: state began as float32 and cannot hold float64 (1e+300): let"),
        (SINGLES, np.array([-1e39, 1.0]), "cannot hold float64 (-1e+39): let init give an array of float64"),
        (SINGLES, np.array([2**24 + 1, 1]), "began as float32 and cannot hold int64 (16777217)"),
        (SINGLES.astype(np.float16), np.array([1, 70_000]), "began as float16 and cannot hold int64 (70000)"),
        (np.zeros(4), np.array([1, 2**53 + 1]), "began as float64 and cannot hold int64 (9007199254740993)"),
        (
            np.zeros(4),
            np.array([1, 2**63 - 1]),
            "began as float64 and cannot hold int64 (9223372036854775807)",
        ),
        (
            np.zeros(4),
            np.array([2**64 - 1], np.uint64).repeat(2),
            "cannot hold uint64 (18446744073709551615)",
        ),
        (TEXT, np.array(["ab", "abc"]), "state began as <U2 and cannot hold <U3"),
        (WHOLE > 0, np.array([1, 2]), "state began as bool and cannot hold int64"),
        (held(4).a, np.zeros(2), "state must have shape (2, 2), as init gave it, got (2,)"),
        (held(4).a, np.zeros((2, 1)), "state must have shape (2, 2), as init gave it, got (2, 1)"),
        (WHOLE, None, "It: state must be an array, as init gave it, got NoneType"),
        (None, WHOLE[:2], "It: state must be nothing, as init gave it, got ndarray"),
        ((WHOLE,), (WHOLE[:2], None), "It: state must have 1 parts, as init gave it, got 2"),
    ],
)
def test_a_state_that_would_be_cut_or_stretched_is_refused(state: Any, some: Any, told: str) -> None:
    with pytest.raises(PolicyError, match=f"^.*{re.escape(told)}"):
        put_rows(state, np.array([3, 1]), some, "It")


def test_a_state_of_other_numbers_that_loses_nothing_but_digits_is_kept() -> None:
    rows = np.array([3, 1])
    for state, some in ((SINGLES, np.array([1.5, 0.1])), (np.zeros(4), np.array([1, 2]))):
        after = put_rows(state, rows, some, "It")
        assert after.dtype == state.dtype
        assert after[rows] == pytest.approx(some, rel=1e-6)
    assert put_rows(WHOLE.astype(np.int8), rows, np.array([1, 127]), "It").tolist() == [0, 127, 0, 1]


@pytest.mark.parametrize(
    ("state", "some"),
    [
        (SINGLES, np.array([np.inf, np.nan])),
        (SINGLES, np.array([-np.inf, 3e38])),
        (SINGLES, np.array([2**24, -(2**24)])),
        (np.zeros(4), np.array([2**53, -(2**63)])),
        (np.zeros(4), np.array([True, False])),
    ],
)
def test_what_a_float_holds_to_the_last_digit_is_kept(state: FloatArray, some: Any) -> None:
    rows = np.array([3, 1])
    after = put_rows(state, rows, some, "It")
    assert after.dtype == state.dtype
    np.testing.assert_array_equal(after[rows], some.astype(state.dtype))
