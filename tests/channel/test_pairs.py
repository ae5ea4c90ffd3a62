"""The store of pairs: shadowing that both ends share, kept while they are in range."""

import numpy as np
import pytest

from modelcast.channel.pair_kernels import (
    OTHER,
    VALUE,
    empty_pairs,
    find_pairs,
    grow_pairs,
    pair_owner,
    pair_shadowing,
    pair_slot,
)
from modelcast.channel.propagation import Propagation, Shadowing
from modelcast.channel.random_kernels import next_word

NORMAL = Propagation().tables(100.0).normal


def words(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 2**63, size=1).astype(np.uint64)


def drawn(pairs: np.ndarray, pair: tuple[int, int], slot: int, east_m: float, random: np.ndarray) -> float:
    word = np.uint64(next_word(random))
    return float(pair_shadowing(*pair, slot, east_m, 0.0, word, NORMAL, 25.0, pairs))


@pytest.mark.parametrize("moved_m", [5.0, 25.0, 60.0])
def test_shadowing_decorrelates_with_the_relative_way(moved_m: float) -> None:
    """Correlation exp(-way/25 m) and deviation, within four standard errors; compiled and batch agree."""
    number = 20_000
    pairs, count = empty_pairs(number, 16)
    random = words(9)
    values = np.empty((2, number))
    for turn, at_m in enumerate((0.0, moved_m)):
        for one in range(number):
            other = (one + 1) % number
            slot = pair_slot(one, other, pairs, count)
            sign = 1.0 if one < other else -1.0
            values[turn, one] = drawn(pairs, (one, other), slot, sign * at_m, random)
    before, after = values
    expected = np.exp(-moved_m / 25.0)
    assert count.sum() == number
    assert np.corrcoef(before, after)[0, 1] == pytest.approx(expected, abs=4 / np.sqrt(number))
    assert after.std() == pytest.approx(1.0, abs=4 / np.sqrt(2 * number))
    rng = np.random.default_rng(6)
    start_db = 3.0 * rng.standard_normal(number)
    next_db = Shadowing().next_db(
        start_db, np.full(number, moved_m), rng, los=np.ones(number, dtype=np.bool_)
    )
    assert np.corrcoef(start_db, next_db)[0, 1] == pytest.approx(expected, abs=4 / np.sqrt(number))
    assert next_db.std() == pytest.approx(3.0, rel=4 / np.sqrt(2 * number))


def test_both_ends_of_a_pair_that_does_not_move_share_its_shadowing() -> None:
    pairs, count = empty_pairs(2, 16)
    random = words(3)
    slot = pair_slot(0, 1, pairs, count)
    assert pair_slot(1, 0, pairs, count) == slot
    there = drawn(pairs, (0, 1), slot, 33.3, random)
    assert drawn(pairs, (1, 0), slot, -33.3, random) == there


def test_every_pair_has_one_owner_and_a_vehicle_owns_half_of_its_pairs() -> None:
    owners = np.array([[pair_owner(one, other) for other in range(40)] for one in range(40)])
    assert np.array_equal(owners, owners.T)
    owned = (owners == np.arange(40)[:, None]).sum(axis=1) - 1
    assert owned.min() >= 19
    assert owned.max() <= 20


def test_the_store_of_pairs_keeps_who_is_in_range_and_forgets_the_others() -> None:
    """Growing until everybody has room, as the radios do."""
    vehicles = 100
    place_m = np.column_stack([10.0 * np.arange(vehicles), np.zeros(vehicles)])
    pairs, count = empty_pairs(vehicles, 16)
    order = np.arange(vehicles)
    random = words(1)
    kept = {}
    for one in range(vehicles):
        near = np.stack([np.delete(order, one), np.zeros(vehicles - 1, dtype=np.int64)], axis=1)
        while not find_pairs(one, order, near, vehicles - 1, pairs, count):
            pairs, count = grow_pairs(pairs, place_m, np.inf)
        for other, slot in near:
            kept[min(one, other), max(one, other)] = drawn(pairs, (one, other), slot, 1.0, random)
    assert count.sum() == vehicles * (vehicles - 1) // 2
    grown, live = grow_pairs(pairs, place_m, 300.0)
    in_range = {pair: value for pair, value in kept.items() if pair[1] - pair[0] <= 30}
    assert live.sum() == len(in_range)
    assert (grown[:, :, OTHER] >= 0.0).sum() == len(in_range)
    for (one, other), value in in_range.items():
        assert grown[pair_owner(one, other), pair_slot(one, other, grown, live), VALUE] == value
    assert live.sum() == len(in_range)
