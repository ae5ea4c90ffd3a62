"""Claims about what hosts count of the remotes they hear."""

from collections import defaultdict

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.station.policy import neighbours_kernels as k
from modelcast.station.policy.j2945_parameters import J2945Parameters
from modelcast.station.policy.neighbours import Neighbours, neighbour_tables

HERE = np.zeros((1, 2))


def heard(
    counts_at_s: dict[int, float], *, start: Neighbours | None = None, east_m: float = 0.0
) -> Neighbours:
    """One host after messages of remote 1, by their count, at these times."""
    times = np.array(list(counts_at_s.values()))
    many = times.size
    return (start or Neighbours(neighbour_tables(1, 4))).heard(
        np.zeros(many, dtype=np.int64),
        np.ones(many, dtype=np.int64),
        message_count=np.array(list(counts_at_s)),
        heard_s=times,
        position_m=np.tile([east_m, 0.0], (many, 1)),
    )


@pytest.mark.parametrize(
    ("counts_at_s", "now_s", "count", "ratio"),
    [
        # Expected 1 + (8 - 1) = 8, received 2: 6/8 missed.
        ({1: 0.5, 8: 4.5}, 5.0, 1, 0.75),
        # Expected 1 + (11 - 1) = 11, received 2: 9/11.
        ({1: 0.5, 11: 4.5}, 5.0, 1, 9 / 11),
        # All received.
        ({3: 0.1, 4: 0.2, 5: 0.3}, 1.0, 1, 0.0),
        # Counts wrap at 128: 126, 127, (0), 1: 4 expected, 3 received.
        ({126: 0.1, 127: 0.2, 1: 0.4}, 1.0, 1, 0.25),
        # One message leaves it undefined, but the remote counts.
        ({9: 0.5}, 1.0, 1, np.nan),
        # The last message is older than 1 s: not there.
        ({1: 0.5, 2: 0.6}, 1.7, 0, np.nan),
        # The window of 5 s: at 6.0 the messages before 1.0 are out; 20..23 expected 4, received 2.
        ({1: 0.2, 20: 1.2, 23: 5.5}, 6.0, 1, 0.5),
        # What was heard in the sub-interval that runs is not counted yet: of 1, 2, 9 only 1 and 2.
        ({1: 0.2, 2: 0.8, 9: 1.3}, 1.5, 1, 0.0),
    ],
)
def test_the_packet_error_ratio_of_one_remote(
    counts_at_s: dict[int, float], now_s: float, count: int, ratio: float
) -> None:
    counted, ratios = heard(counts_at_s).survey(np.array([now_s]), HERE)
    assert counted.tolist() == [count]
    assert ratios[0] == pytest.approx(ratio, nan_ok=True)


def test_remotes_count_up_to_100_m_from_the_place_they_state() -> None:
    for east_m, count in ((100.0, 1), (100.1, 0), (-99.0, 1)):
        assert heard({1: 0.5}, east_m=east_m).survey(np.ones(1), HERE)[0].tolist() == [count]


def test_the_mean_is_over_remotes_with_a_ratio() -> None:
    tables = neighbour_tables(1, 8)
    # Remote 1: 1 of 2 lost between 0 and 2 (1/3). Remote 2: none (0). Remote 3: one message. Remote 4: far.
    messages = [(1, 0, 0.0), (1, 2, 0.0), (2, 5, 0.0), (2, 6, 0.0), (3, 7, 0.0), (4, 0, 500.0), (4, 9, 500.0)]
    state = Neighbours(tables).heard(
        np.zeros(7, dtype=np.int64),
        np.array([m[0] for m in messages]),
        message_count=np.array([m[1] for m in messages]),
        heard_s=np.linspace(0.1, 0.9, 7),
        position_m=np.array([[m[2], 0.0] for m in messages]),
    )
    count, ratio = state.survey(np.ones(1), HERE)
    assert count.tolist() == [3]
    assert ratio[0] == pytest.approx(1 / 6)
    assert k.count(state.tables.hosts, state.tables.slots, 0, 1.0, 0.0, 0.0, 1.0, 100.0) == 3


def test_sub_intervals_start_at_the_hosts_own_phase() -> None:
    tables = neighbour_tables(1, 4, phase_s=np.array([0.4]))
    state = heard({1: 0.5, 4: 1.3}, start=Neighbours(tables))
    assert np.isnan(state.survey(np.array([1.35]), HERE)[1][0])
    assert state.survey(np.array([1.4]), HERE)[1][0] == pytest.approx(0.5)


def test_the_given_tables_are_left_alone() -> None:
    before = heard({1: 0.5})
    copies = [column.copy() for column in before.tables]
    heard({2: 0.7}, start=before)
    assert all(np.array_equal(a, b) for a, b in zip(copies, before.tables, strict=True))


def test_a_full_table_refuses_new_remotes_until_old_ones_have_been_silent() -> None:
    tables = neighbour_tables(1, 3)
    slots = [k.hear(*tables, 0, remote, 0, 0.1, 0.0, 0.0, 1.0) for remote in (10, 11, 12)]
    assert sorted(slots) == [0, 1, 2]
    assert k.hear(*tables, 0, 13, 0, 0.2, 0.0, 0.0, 1.0) == -1
    assert tables.hosts["refused"].tolist() == [1]
    k.hear(*tables, 0, 11, 1, 6.0, 0.0, 0.0, 1.0)
    # 10 and 12 have been silent for more than 6 s; 11 keeps its slot.
    assert k.hear(*tables, 0, 13, 0, 6.2, 0.0, 0.0, 1.0) in {slots[0], slots[2]}
    assert k.find(tables.slots, tables.lookup, 0, 11) == slots[1]
    assert k.find(tables.slots, tables.lookup, 0, 10) == -1


def test_forgetting_frees_slots_and_keeps_the_others_in_place() -> None:
    tables = neighbour_tables(1, 64)
    for remote in range(60):
        k.hear(*tables, 0, remote, 0, 0.01 * remote, 0.0, 0.0, 1.0)
    slots = {remote: k.find(tables.slots, tables.lookup, 0, remote) for remote in range(60)}
    assert k.forget(*tables, 0, 1.3, 1.0) == 30
    assert [k.find(tables.slots, tables.lookup, 0, remote) for remote in range(30)] == [-1] * 30
    assert all(k.find(tables.slots, tables.lookup, 0, remote) == slots[remote] for remote in range(30, 60))


def plain_survey(
    log: list[tuple[float, int, float]], now_s: float, where_m: FloatArray, parameters: J2945Parameters
) -> tuple[int, float]:
    """The rule from its words, over (time, message count, east) of each remote by list comprehension."""
    by_remote = defaultdict(list)
    for time_s, code, east_m in log:
        by_remote[code // 1000].append((time_s, code % 1000, east_m))
    end_s = np.floor(now_s + 1e-9)
    ratios, near = [], 0
    for entries in by_remote.values():
        last = entries[-1]
        if (
            now_s - last[0] > parameters.per_sub_interval_s
            or abs(last[2] - where_m[0]) > parameters.per_range_m
        ):
            continue
        near += 1
        window = [entry for entry in entries if end_s - 5.0 <= entry[0] < end_s]
        if len(window) >= 2:
            expected = 1 + (window[-1][1] - window[0][1]) % 128
            ratios.append((expected - len(window)) / expected)
    return near, float(np.mean(ratios)) if ratios else np.nan


@settings(max_examples=40)
@given(seed=st.integers(0, 2**31), remotes=st.integers(1, 12), loss=st.floats(0.0, 0.95))
def test_random_traffic_is_counted_as_the_words_say(seed: int, remotes: int, loss: float) -> None:
    rng = np.random.default_rng(seed)
    parameters = J2945Parameters()
    tables = neighbour_tables(1, 12)
    log: list[tuple[float, int, float]] = []
    count = rng.integers(0, 128, remotes)
    place = rng.uniform(-150.0, 150.0, remotes)
    for step in range(1, 90):
        now = 0.1 * step + 0.003
        for remote in range(remotes):
            count[remote] = (count[remote] + 1) % 128
            if rng.random() < loss:
                continue
            log.append((now, remote * 1000 + int(count[remote]), float(place[remote])))
            k.hear(*tables, 0, remote, count[remote], now, place[remote], 0.0, 1.0)
        if step % 7 == 0:
            # A little later, so that no message is exactly as old as a bound.
            asked_s = now + 0.0011
            near, ratio = k.survey(tables.hosts, tables.slots, 0, asked_s, 0.0, 0.0, 1.0, 100.0)
            expected = plain_survey(log, asked_s, np.zeros(2), parameters)
            assert (near, ratio) == pytest.approx(expected, nan_ok=True)


def test_hosts_do_not_mix() -> None:
    rng = np.random.default_rng(1)
    receptions = 4000
    host = rng.integers(0, 20, receptions)
    remote = rng.integers(0, 200, receptions)
    message_count = rng.integers(0, 128, receptions)
    at_s = np.sort(rng.uniform(0.0, 3.0, receptions))
    place = rng.uniform(-120.0, 120.0, (receptions, 2))
    together = Neighbours(neighbour_tables(20, 200)).heard(
        host, remote, message_count=message_count, heard_s=at_s, position_m=place
    )
    count, ratio = together.survey(np.full(20, 3.0), np.zeros((20, 2)))
    for one in range(20):
        mine = host == one
        alone = Neighbours(neighbour_tables(1, 200)).heard(
            np.zeros(mine.sum(), dtype=np.int64),
            remote[mine],
            message_count=message_count[mine],
            heard_s=at_s[mine],
            position_m=place[mine],
        )
        counted, ratios = alone.survey(np.full(1, 3.0), HERE)
        assert (counted[0], ratios[0]) == (count[one], pytest.approx(ratio[one], nan_ok=True))


@pytest.mark.parametrize(
    ("host", "remote", "message_count", "named"),
    [(1, 0, 0, "host"), (-1, 0, 0, "host"), (0, -1, 0, "remote"), (0, 0, 128, "message_count")],
)
def test_impossible_receptions_are_refused(host: int, remote: int, message_count: int, named: str) -> None:
    with pytest.raises(ValueError, match=named):
        Neighbours(neighbour_tables(1, 4)).heard(
            np.array([host]),
            np.array([remote]),
            message_count=np.array([message_count]),
            heard_s=np.zeros(1),
            position_m=HERE,
        )


def test_impossible_tables_are_refused() -> None:
    with pytest.raises(ValueError, match="capacity"):
        neighbour_tables(1, 0)
    with pytest.raises(ValueError, match="phase_s"):
        neighbour_tables(2, 4, phase_s=np.zeros(3))
