"""True warnings as events, counted by hand."""

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.study.safety.events import delays_s, false_warnings, true_warnings

T_S: FloatArray = np.arange(40, dtype=np.float64) * 0.1


def flags(*ranges: tuple[int, int]) -> BoolArray:
    """Instants within ranges, the ends not included."""
    found: BoolArray = np.zeros(40, dtype=np.bool_)
    for a, b in ranges:
        found[a:b] = True
    return found


ALL: BoolArray = np.ones(40, dtype=np.bool_)


def test_short_pauses_join_and_uncounted_warnings_are_no_events() -> None:
    warned = flags((2, 4), (6, 8), (20, 25), (36, 38))
    true = true_warnings(warned, ~flags((36, 38)), T_S, merge_s=0.35)
    assert true.first.tolist() == [2, 20]
    assert true.last.tolist() == [7, 24]
    assert np.flatnonzero(true.event == 0).tolist() == [2, 3, 4, 5, 6, 7]
    assert not (true.event[30:] >= 0).any()


def test_nothing_warned_is_no_event() -> None:
    true = true_warnings(flags(), ALL, T_S, merge_s=1.0)
    assert true.first.size == 0
    assert delays_s(true, np.ones((2, 40), dtype=bool), T_S, grace_s=1.0).shape == (0, 2)


def test_delays_count_from_the_onset_and_end_with_the_grace() -> None:
    true = true_warnings(flags((10, 15)), ALL, T_S, merge_s=0.3)
    runs = np.stack([flags((5, 12)), flags((13, 14)), flags((19, 25)), flags((26, 30)), flags((0, 10))])
    late = delays_s(true, runs, T_S, grace_s=1.0)[0]
    assert late[:3].round(6).tolist() == [0.0, 0.3, 0.9]
    assert np.isinf(late[3:]).all()


def test_false_warnings_are_those_far_from_any_true_one() -> None:
    truly = flags((20, 25))
    runs = np.stack([flags((18, 30)), flags((27, 29)), flags((5, 8)), flags((5, 8), (9, 10), (35, 38))])
    assert false_warnings(runs, truly, ALL, T_S, merge_s=0.3).tolist() == [0, 0, 1, 2]
    assert false_warnings(runs, truly, ~flags((5, 10)), T_S, merge_s=0.3).tolist() == [0, 0, 0, 1]
