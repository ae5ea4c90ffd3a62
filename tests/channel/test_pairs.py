"""Shadowing of pairs: both ends share it, it is kept while they are in range, however it is worked out."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from modelcast.channel.pair_kernels import (
    OTHER,
    VALUE,
    Pairs,
    empty_pairs,
    first_slot,
    grow_pairs,
    kept_share,
    mixed,
    pair_owner,
    pair_slot,
)
from modelcast.channel.propagation import Propagation, Shadowing
from modelcast.channel.shadow_sweep import renew_pairs
from modelcast.channel.shadowing_kernels import SILENT, lay_out
from modelcast.core.parts import WHOLE, Parts

RANGE_M = 300.0
TABLES = Propagation().tables(RANGE_M)
SEED = np.uint64(7)


def swept(
    place_m: np.ndarray, sends: np.ndarray, pairs: Pairs, parts: Parts = WHOLE
) -> tuple[np.ndarray, Pairs]:
    """Return the shadowing from each sender (V,) to everybody within range, else NaN, (V, V)."""
    reach_m2 = np.where(sends, RANGE_M**2, SILENT)[:, None].repeat(2, axis=1)
    sweep = lay_out(reach_m2, place_m, np.zeros(sends.size, dtype=np.bool_), RANGE_M)
    pairs = renew_pairs(sweep, pairs, SEED, TABLES, parts)
    cells, rows = sweep.cells, sweep.rows
    values = np.full((sends.size, sends.size), np.nan)
    for k, j in enumerate(cells.order):
        row = int((place_m[j, 1] - cells.corner_north_m) / cells.cell_m)
        for v in np.flatnonzero(sends):
            if j != v and np.sum((place_m[j] - place_m[v]) ** 2) <= RANGE_M**2:
                values[v, j] = rows.value[rows.start[rows.first[v] + row] + k]
    return values, pairs


def places(vehicles: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0.0, 700.0, (vehicles, 2))


def senders(vehicles: int, number: int) -> np.ndarray:
    """Return which vehicles send, (V,): ``number`` of them, at random."""
    return np.isin(np.arange(vehicles), np.random.default_rng(1).permutation(vehicles)[:number])


@pytest.mark.slow
@pytest.mark.parametrize("moved_m", [5.0, 25.0, 60.0])
def test_shadowing_decorrelates_with_the_relative_way(moved_m: float) -> None:
    """Correlation exp(-way/25 m) and deviation, within four standard errors; compiled and batch agree."""
    vehicles = 200
    place_m = np.column_stack([np.zeros(vehicles), np.linspace(0.0, 200.0, vehicles)])
    side = np.arange(vehicles) % 2 == 0
    sends = np.ones(vehicles, dtype=np.bool_)
    first, pairs = swept(place_m, sends, empty_pairs(vehicles, 16))
    place_m[side, 0] += moved_m
    second, _ = swept(place_m, sends, pairs)
    moving = np.triu(side[:, None] != side[None, :])
    before, after = first[moving], second[moving]
    number = before.size
    expected = np.exp(-moved_m / 25.0)
    assert number == vehicles**2 // 4
    assert np.corrcoef(before, after)[0, 1] == pytest.approx(expected, abs=4 / np.sqrt(number))
    assert after.std() == pytest.approx(1.0, abs=4 / np.sqrt(2 * number))
    assert after.mean() == pytest.approx(0.0, abs=4 / np.sqrt(number))
    rng = np.random.default_rng(6)
    start_db = 3.0 * rng.standard_normal(number)
    next_db = Shadowing().next_db(
        start_db, np.full(number, moved_m), rng, los=np.ones(number, dtype=np.bool_)
    )
    assert np.corrcoef(start_db, next_db)[0, 1] == pytest.approx(expected, abs=4 / np.sqrt(number))
    assert next_db.std() == pytest.approx(3.0, rel=4 / np.sqrt(2 * number))


@pytest.mark.slow
def test_shadowing_follows_the_normal_law() -> None:
    """Quantiles of what was drawn after ten moves, within four standard errors."""
    place_m, pairs = places(200), empty_pairs(200, 16)
    values = np.empty(0)
    for k in range(10):
        values, pairs = swept(place_m + k * np.linspace(-9.0, 9.0, 200)[:, None], np.full(200, True), pairs)
    drawn = values[np.triu(np.isfinite(values))]
    for quantile, value in ((0.05, -1.645), (0.25, -0.674), (0.5, 0.0), (0.75, 0.674), (0.95, 1.645)):
        error = np.sqrt(quantile * (1.0 - quantile) / drawn.size)
        assert (drawn < value).mean() == pytest.approx(quantile, abs=4 * error)


@pytest.mark.parametrize("number", [60, 20, 1])
def test_both_ends_of_a_pair_share_its_shadowing(number: int) -> None:
    """Whether all send, some, or so few that they look up their pairs one by one."""
    sends = senders(60, number)
    values, _ = swept(places(60), sends, empty_pairs(60, 16))
    both = values[sends][:, sends]
    assert np.array_equal(both, both.T, equal_nan=True)
    assert np.isfinite(values[sends]).sum() > 10 * number


@pytest.mark.parametrize("number", [20, 1])
def test_shadowing_does_not_depend_on_who_else_sends(number: int) -> None:
    """Nor on how often it was asked for while nobody moved: first few send, then all."""
    place_m, sends = places(60), senders(60, number)
    few, pairs = swept(place_m, sends, empty_pairs(60, 16))
    later, _ = swept(place_m, np.full(60, True), pairs)
    at_once, _ = swept(place_m, np.full(60, True), empty_pairs(60, 16))
    assert np.array_equal(few[sends], at_once[sends], equal_nan=True)
    assert np.array_equal(later, at_once, equal_nan=True)


def test_a_pair_that_is_as_before_draws_the_same_however_it_is_looked_up() -> None:
    """After a move, in one sweep, and by one sender after the other."""
    place_m, moved_m = places(60), places(60) + np.linspace(-20.0, 20.0, 60)[:, None]
    _, pairs = swept(place_m, np.full(60, True), empty_pairs(60, 16))
    copy = Pairs(pairs.held.copy(), pairs.owned.copy())
    whole, _ = swept(moved_m, np.full(60, True), pairs)
    for v in range(60):
        single, copy = swept(moved_m, np.arange(60) == v, copy)
        assert np.array_equal(single[v], whole[v], equal_nan=True)


@pytest.mark.parametrize("number", [60, 20, 1])
@pytest.mark.parametrize("threads", [1, 2])
def test_shadowing_does_not_depend_on_its_parts(number: int, threads: int) -> None:
    """Nor do later steps: the store grows at the same time, though some parts have room and others none."""
    sends = senders(60, number)
    with ThreadPoolExecutor(threads) as pool:
        whole, shared = empty_pairs(60, 16), empty_pairs(60, 16)
        for k in range(4):
            place_m = places(60) + k * np.linspace(-200.0, 200.0, 60)[:, None]
            wanted, whole = swept(place_m, sends, whole)
            values, shared = swept(place_m, sends, shared, Parts(7, pool))
            assert np.array_equal(values, wanted, equal_nan=True)
            assert whole.held.shape == shared.held.shape
            assert np.array_equal(whole.owned, shared.owned)


def test_a_share_is_kept_and_the_rest_drawn() -> None:
    assert kept_share(0.0, 25.0) == 1.0
    assert kept_share(np.inf, 25.0) == 0.0
    assert mixed(0.7, 1.0, np.uint64(5), TABLES.normal) == 0.7


def test_every_pair_has_one_owner_and_a_vehicle_owns_half_of_its_pairs() -> None:
    owners = np.array([[pair_owner(one, other) for other in range(40)] for one in range(40)])
    assert np.array_equal(owners, owners.T)
    owned = (owners == np.arange(40)[:, None]).sum(axis=1) - 1
    assert owned.min() >= 19
    assert owned.max() <= 20


def test_the_store_of_pairs_keeps_who_is_in_range_and_forgets_the_others() -> None:
    """A hundred in a row; it grew until everybody had room."""
    vehicles = 100
    place_m = np.column_stack([2.0 * np.arange(vehicles), np.zeros(vehicles)])
    values, pairs = swept(place_m, np.full(vehicles, True), empty_pairs(vehicles, 16))
    assert pairs.owned.sum() == vehicles * (vehicles - 1) // 2
    grown = grow_pairs(pairs, place_m, 60.0)
    in_range = [(one, other) for one in range(vehicles) for other in range(one + 1, min(one + 31, vehicles))]
    assert grown.owned.sum() == len(in_range)
    assert (grown.held[:, :, OTHER] >= 0.0).sum() == len(in_range)
    for one, other in in_range:
        owner = pair_owner(one, other)
        assert grown.held[owner, pair_slot(owner, one + other - owner, grown), VALUE] == values[one, other]
    assert grown.owned.sum() == len(in_range)


def test_a_pair_is_found_at_once_or_by_the_search() -> None:
    """The quick look and the search never differ; where the first finds nothing the pair lies farther on."""
    pairs = empty_pairs(1, 64)
    others = np.random.default_rng(0).permutation(np.arange(1, 400))[:48]
    slots = [pair_slot(0, int(other), pairs) for other in others]
    quick = [first_slot(0, int(other), pairs.held) for other in others]
    assert all(one in (-1, slot) for one, slot in zip(quick, slots, strict=True))
    assert 0 < quick.count(-1) < len(quick)
    assert first_slot(0, 500, pairs.held) == -1
