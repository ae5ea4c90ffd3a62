"""Claims about decentralised congestion control."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.station.policy import dcc_kernels as k
from modelcast.station.policy.dcc import AdaptiveDcc, ReactiveDcc

DCC = AdaptiveDcc()

SETTLED = 1e-9
"""Left of a gap that shrinks by 1 - alpha - N·beta an update, at least 0.4 %, over the updates below."""


@pytest.mark.parametrize(
    ("before", "share", "measures", "after"),
    [
        # CBR := 0.5·0.60 + 0.5·(0.60 + 0.80)/2 = 0.65; offset 0.0012·0.03 = 3.6e-5; 0.984·0.01 + 3.6e-5.
        (0.60, 0.01, (0.60, 0.80), (0.65, 0.009876)),
        # CBR := 0.1; 0.0012·0.58 = 6.96e-4, held at 5e-4; 0.00984 + 0.0005.
        (0.10, 0.01, (0.10, 0.10), (0.10, 0.01034)),
        # CBR := 1.0; 0.0012·(-0.32) = -3.84e-4, held at -2.5e-4; 0.00984 - 0.00025.
        (1.00, 0.01, (1.00, 1.00), (1.00, 0.00959)),
        # Bounds: 0.984·0.03 + 0.0005 = 0.03002 -> 0.03; 0.984·0.0006 - 0.00025 = 0.00034 -> 0.0006.
        (0.00, 0.03, (0.00, 0.00), (0.00, 0.03)),
        (1.00, 0.0006, (1.00, 1.00), (1.00, 0.0006)),
    ],
)
def test_one_update_as_worked_by_hand(
    before: float, share: float, measures: tuple[float, float], after: tuple[float, float]
) -> None:
    row = np.array([share, before, measures[0], 1.0, 0.0])
    k.adapt(row, measures[1], DCC.constants())
    assert (row[k.BUSY_RATIO], row[k.SHARE]) == pytest.approx(after)


def test_the_share_moves_at_every_second_measure() -> None:
    row = DCC.rows(1, np.zeros(1))[0]
    shares = []
    for measure in range(6):
        k.step(row, k.ADAPTIVE, 0.1 * measure, 1.0, 4e-4, DCC.constants())
        shares.append(row[k.SHARE])
    assert shares[0] == 0.03
    assert [b != a for a, b in itertools.pairwise(shares)] == [True, False, True, False, True]


def test_measures_are_taken_every_100_ms_however_often_it_is_asked() -> None:
    fine, coarse = DCC.rows(2, np.zeros(2))
    for step in range(401):
        k.step(fine, k.ADAPTIVE, 0.01 * step, 0.9, 4e-4, DCC.constants())
    for step in range(41):
        k.step(coarse, k.ADAPTIVE, 0.1 * step, 0.9, 4e-4, DCC.constants())
    assert fine[k.SHARE] == coarse[k.SHARE]


@settings(max_examples=15)
@given(stations=st.integers(20, 300), seed=st.integers(0, 1000))
def test_stations_that_hear_each_other_settle_at_the_fixed_point(stations: int, seed: int) -> None:
    """Their shares add up to the channel busy ratio; at N = 20 the fixed point lies just below delta_max."""
    rows = DCC.rows(stations, np.zeros(stations))
    rows[:, k.SHARE] = np.random.default_rng(seed).uniform(0.0006, 0.03, stations)
    constants = DCC.constants()
    for _ in range(3000):
        busy = rows[:, k.SHARE].sum()
        for row in rows[:3]:
            k.adapt(row, busy, constants)
        # The others do alike: all rows follow the same rule, whose differences shrink by 1 - alpha an update.
        rows[3:, k.SHARE] = rows[np.arange(3, stations) % 3, k.SHARE]
    expected = DCC.fixed_share(stations)
    assert expected == pytest.approx(0.0012 * 0.68 / (0.016 + stations * 0.0012))
    assert 0.0006 < expected < 0.03
    assert rows[:, k.SHARE] == pytest.approx(expected, abs=SETTLED)


@pytest.mark.parametrize(
    ("share", "interval_s"),
    # 400 us / 0.004 = 100 ms; / 0.03 = 13 ms, held at 25 ms; / 0.0003 = 1.33 s, held at 1 s.
    [(0.004, 0.1), (0.03, 0.025), (0.0003, 1.0)],
)
def test_the_time_between_messages_is_airtime_over_share_within_bounds(
    share: float, interval_s: float
) -> None:
    row = np.array([share, 0.0, 0.0, 0.0, 0.0])
    assert k.adaptive_interval(row, 4e-4, DCC.constants()) == pytest.approx(interval_s)


@pytest.mark.parametrize(
    ("busy", "interval_s"),
    [
        (0.0, 0.1),
        (0.29, 0.1),
        (0.30, 0.2),
        (0.39, 0.2),
        (0.40, 0.4),
        (0.49, 0.4),
        (0.5, 0.5),
        (0.6, 1.0),
        (1.0, 1.0),
    ],
)
def test_the_reactive_table(busy: float, interval_s: float) -> None:
    table = ReactiveDcc()
    row = table.rows(1, np.zeros(1))[0]
    assert k.step(row, k.REACTIVE, 0.0, busy, 4e-4, table.constants()) == interval_s
    assert table.interval_s(busy) == interval_s


def test_neighbouring_states_only_takes_one_step_a_measure() -> None:
    table = ReactiveDcc(neighbouring_only=True)
    row = table.rows(1, np.zeros(1))[0]
    up = [k.step(row, k.REACTIVE, 0.1 * m, 0.99, 4e-4, table.constants()) for m in range(6)]
    down = [k.step(row, k.REACTIVE, 0.1 * m, 0.0, 4e-4, table.constants()) for m in range(6, 9)]
    assert up == [0.2, 0.4, 0.5, 1.0, 1.0, 1.0]
    assert down == [0.5, 0.4, 0.2]


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"relaxation": 0.0}, "relaxation"),
        ({"target_busy_ratio": 1.1}, "target_busy_ratio"),
        ({"min_share": 0.5}, "shares"),
        ({"max_fall": 0.1}, "max_fall"),
        ({"shortest_s": 2.0}, "times"),
        ({"measures_an_update": 0}, "measures_an_update"),
        ({"start_share": 0.5}, "start_share"),
    ],
)
def test_impossible_adaptive_constants_are_refused(wrong: dict[str, float], named: str) -> None:
    with pytest.raises(ValueError, match=named):
        AdaptiveDcc(**wrong)


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"bounds_ratio": (0.3,)}, "intervals_s"),
        ({"bounds_ratio": (0.4, 0.3, 0.5, 0.6)}, "bounds_ratio"),
        ({"measuring_interval_s": 0.0}, "measuring_interval_s"),
    ],
)
def test_impossible_tables_are_refused(wrong: dict[str, object], named: str) -> None:
    with pytest.raises(ValueError, match=named):
        ReactiveDcc(**wrong)
