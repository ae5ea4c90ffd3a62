"""Claims about the tables that hosts keep of what they hear: sizes, bounds and edges, one by one."""

import numpy as np
import pytest

from modelcast.station.policy import neighbours_kernels as k
from modelcast.station.policy.neighbours import Neighbours, neighbour_tables
from modelcast.station.policy.neighbours_kernels import NeighbourTables


def told(
    tables: NeighbourTables, remote: int, heard_s: float, message_count: int = 0, east_m: float = 0.0
) -> int:
    """Host 0 hears a message, at sub-intervals of 1 s; the slot."""
    return int(k.hear(*tables, 0, remote, message_count, heard_s, east_m, 0.0, 1.0))


def counted(tables: NeighbourTables, now_s: float) -> list[int]:
    """Remotes within 100 m of the origin, by both ways to count them."""
    return [
        int(k.count(tables.hosts, tables.slots, 0, now_s, 0.0, 0.0, 1.0, 100.0)),
        int(k.survey(tables.hosts, tables.slots, 0, now_s, 0.0, 0.0, 1.0, 100.0)[0]),
    ]


def test_a_slot_fills_one_cache_line_with_room_for_ten_sub_intervals() -> None:
    assert (k.SLOT_TYPE.itemsize, k.SLOT_TYPE["received"].shape) == (64, (10,))


def test_up_to_nine_sub_intervals_and_32767_remotes_can_be_asked_for() -> None:
    tables = neighbour_tables(1, 2, sub_intervals=9)
    assert tables.hosts["kept"].tolist() == [10]
    for at in range(13):
        told(tables, 7, at + 0.5, message_count=at)
    assert tables.slots[0, 0]["received"].tolist() == [1] * 10
    assert tables.slots[0, 0]["last"].tolist() == [10, 11, 12, 3, 4, 5, 6, 7, 8, 9]
    with pytest.raises(ValueError, match="sub_intervals must be below 10, got 10"):
        neighbour_tables(1, 2, sub_intervals=10)
    assert neighbour_tables(1, 32767).slots.shape == (1, 32767)
    with pytest.raises(ValueError, match="capacity must be below 32768, got 32768"):
        neighbour_tables(1, 32768)


@pytest.mark.parametrize(("capacity", "length"), [(1, 2), (2, 4), (3, 8), (4, 8), (5, 16), (8, 16), (9, 32)])
def test_the_index_is_the_least_power_of_two_twice_as_long_as_the_slots(capacity: int, length: int) -> None:
    tables = neighbour_tables(3, capacity)
    assert tables.lookup.shape == (3, length)
    assert (tables.lookup == -1).all()
    assert (tables.slots["remote"] == -1).all()


@pytest.mark.parametrize(
    ("host", "remote", "message_count", "named"),
    [
        ([0, 0], [0, 2**31], [0, 0], "remote must lie in 0..2147483647, got 0..2147483648"),
        ([0, 0], [-1, 3], [0, 0], "remote must lie in"),
        ([0, 0], [0, 0], [0, 128], "message_count must lie in 0..127, got 0..128"),
        ([0, 1], [0, 0], [0, 0], "host must lie in 0..0, got 0..1"),
    ],
)
def test_one_impossible_reception_among_others_is_refused(
    host: list[int], remote: list[int], message_count: list[int], named: str
) -> None:
    with pytest.raises(ValueError, match=named):
        Neighbours(neighbour_tables(1, 4)).heard(
            np.array(host),
            np.array(remote),
            message_count=np.array(message_count),
            heard_s=np.zeros(2),
            position_m=np.zeros((2, 2)),
        )


def test_the_largest_id_and_count_are_heard() -> None:
    after = Neighbours(neighbour_tables(1, 4)).heard(
        np.zeros(1, dtype=np.int64),
        np.array([2**31 - 1]),
        message_count=np.array([127]),
        heard_s=np.zeros(1),
        position_m=np.zeros((1, 2)),
    )
    slot = after.tables.slots[0, 0]
    assert (int(slot["remote"]), int(slot["first"][0]), int(slot["last"][0])) == (2**31 - 1, 127, 127)


@pytest.mark.parametrize("length", [2, 64, 256])
def test_ids_in_a_row_start_all_over_the_index(length: int) -> None:
    """Half as many as it has places: they start at a quarter of them at least, even and odd ones."""
    starts = {k.place(remote, length) for remote in range(max(length // 2, 2))}
    assert 4 * len(starts) >= length
    assert {start % 2 for start in starts} == {0, 1}
    assert 0 <= min(starts) <= max(starts) < length


@pytest.mark.parametrize("silent", [1, 2, 3])
def test_after_forgetting_the_index_has_those_held_and_no_other(silent: int) -> None:
    tables = neighbour_tables(1, 8)
    for remote in range(6):
        told(tables, 10 + remote, 0.0 if remote < silent else 5.0)
    assert k.forget(*tables, 0, 6.0, 2.0) == silent
    assert sorted(tables.lookup[tables.lookup >= 0].tolist()) == list(range(silent, 6))
    before = tables.lookup.copy()
    assert k.forget(*tables, 0, 6.0, 2.0) == 0
    np.testing.assert_array_equal(tables.lookup, before)


def test_a_slot_that_changes_hands_starts_at_the_new_remote_s_first_message() -> None:
    """Nothing of the remote before it is left, in whatever sub-interval the two spoke."""
    for second_s in (6.5, 7.5, 11.5, 12.5):
        tables = neighbour_tables(1, 1)
        for at in range(6):
            told(tables, 1, 0.5 + 0.1 * at, message_count=3 * at)
        told(tables, 2, second_s, message_count=40)
        assert tables.slots[0, 0]["remote"] == (2 if second_s > 7.0 else 1)
        told(tables, 2, second_s + 0.1, message_count=43)
        near, ratio = k.survey(tables.hosts, tables.slots, 0, second_s + 0.6, 0.0, 0.0, 1.0, 100.0)
        assert (near, ratio) == ((1, 0.5) if second_s > 7.0 else (0, pytest.approx(np.nan, nan_ok=True)))


def test_a_remote_counts_for_a_sub_interval_and_a_millionth_of_it() -> None:
    """The bound itself included; a hair more than that is not."""
    bound_s = 5.0 - 1.0 * (1.0 + 1e-6)
    for heard_s, near in (
        (4.0, 1),
        (bound_s, 1),
        (np.nextafter(bound_s, 0.0), 0),
        (5.0 - 1.0000015, 0),
    ):
        tables = neighbour_tables(1, 2)
        told(tables, 7, heard_s)
        assert counted(tables, 5.0) == [near, near]


def test_a_sub_interval_passed_over_in_silence_has_no_messages() -> None:
    """Now rounds up to 7, the last message was 1 s and a millionth before, in 5: 6 holds what 0 held."""
    tables = neighbour_tables(1, 2)
    for message_count, heard_s in ((1, 0.5), (30, 4.5), (31, 6.0 - 1.4e-6)):
        told(tables, 7, heard_s, message_count)
    assert tables.slots[0, 0]["newest"] == 5
    assert k.survey(tables.hosts, tables.slots, 0, 7.0 - 0.5e-6, 0.0, 0.0, 1.0, 100.0) == (1, 0.0)


@pytest.mark.parametrize("short_s", [0.9e-6, 1.5e-6])
def test_a_time_a_millionth_short_of_a_sub_interval_s_start_is_in_it(short_s: float) -> None:
    tables = neighbour_tables(1, 2)
    told(tables, 7, 3.0 - short_s)
    assert tables.slots[0, 0]["newest"] == (3 if short_s < 1e-6 else 2)


def test_each_host_is_surveyed_at_its_own_place() -> None:
    """Host 0 at 100 m east, host 1 at 100 m north: what is 190 m east is near host 0 alone."""
    state = Neighbours(neighbour_tables(2, 4)).heard(
        np.array([0, 0, 1, 1]),
        np.array([3, 4, 3, 4]),
        message_count=np.array([0, 0, 0, 0]),
        heard_s=np.full(4, 0.5),
        position_m=np.array([[190.0, 0.0], [60.0, 70.0], [190.0, 0.0], [60.0, 180.0]]),
    )
    places = np.array([[100.0, 0.0], [0.0, 100.0]])
    near, _ = state.survey(np.full(2, 1.0), places)
    assert near.tolist() == [2, 1]
    out = np.empty(2, dtype=np.int64)
    k.count_each(state.tables.hosts, state.tables.slots, np.full(2, 1.0), places, 1.0, 100.0, out)
    assert out.tolist() == [2, 1]
