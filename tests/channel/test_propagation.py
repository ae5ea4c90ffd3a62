"""Claims about path loss, shadowing, fading and their compiled tables."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from modelcast.channel.dsrc_link_kernels import heard_within_m
from modelcast.channel.path_loss import (
    AbstractPathLoss,
    DualSlope,
    LogDistance,
    ManhattanNlos,
    Tr37885,
    TwoRay,
    WinnerB1,
)
from modelcast.channel.propagation import NakagamiFading, Propagation, Shadowing, StreetGrid
from modelcast.channel.random_kernels import uniform

MODELS: tuple[AbstractPathLoss, ...] = (
    WinnerB1(),
    Tr37885.highway(),
    Tr37885.urban(),
    Tr37885.nlos(),
    DualSlope.highway_los(),
    DualSlope.urban_los(),
    DualSlope.urban_obstructed(),
    LogDistance(2.4),
)
TABLE_DB = 0.4
"""Straight lines between points half a metre apart miss the logarithm by this at most, from 2 m on."""


def words(seed: int) -> np.ndarray:
    return np.array([seed], dtype=np.uint64)


@pytest.mark.parametrize("model", MODELS, ids=lambda model: type(model).__name__)
def test_loss_never_falls_by_more_than_the_step_at_a_break_point(model: AbstractPathLoss) -> None:
    loss_db = model.loss_db(np.arange(1.0, 2000.0))
    assert np.diff(loss_db).min() > -0.15
    assert loss_db[-1] > loss_db[0] + 40


@given(st.floats(1.0, 6.0), st.floats(1.0, 6.0))
def test_two_rays_become_the_fourth_power_of_distance_far_out(one_m: float, other_m: float) -> None:
    at = np.array([2e4, 4e4])
    far_db = 40 * np.log10(at) - 20 * np.log10(one_m * other_m)
    loss_db = TwoRay(antenna_m=one_m, other_antenna_m=other_m).loss_db(at)
    assert loss_db == pytest.approx(far_db, abs=0.15)
    assert TwoRay(antenna_m=other_m, other_antenna_m=one_m).loss_db(at) == pytest.approx(loss_db)


def test_two_rays_swing_around_free_space_near_by_at_most_6_db_above() -> None:
    at = np.arange(5.0, 100.0, 0.1)
    above_db = LogDistance(2.0).loss_db(at) - TwoRay().loss_db(at)
    assert above_db.max() < 6.02
    assert above_db.max() > 3.0
    assert above_db.min() < -6.0


@given(st.floats(-90.0, -60.0))
def test_the_reach_of_two_rays_is_where_the_last_of_their_peaks_falls_below(gain_db: float) -> None:
    """The gain swings near the sender: a search by halves needs a table that never rises."""
    tables = Propagation(TwoRay(), None, None).tables(3000.0)
    assert np.all(np.diff(tables.reach_ln) <= 0.0)
    last_m = np.flatnonzero(tables.los_ln >= gain_db * np.log(10.0) / 10.0)[-1] / tables.per_m
    found_m = heard_within_m(0.0, tables, 10.0 ** (0.1 * gain_db), 3000.0)
    assert found_m == pytest.approx(last_m, abs=1.0 / tables.per_m)


def test_the_formulas_give_their_values_by_hand() -> None:
    at = np.array([10.0, 100.0, 300.0])
    log_f = np.log10(5.9)
    near_db = 22.7 + 27 + 20 * log_f
    far_db = 40 * np.log10(at[1:]) + 7.56 - 34.6 * np.log10(0.5) + 2.7 * log_f
    assert WinnerB1().loss_db(at) == pytest.approx([near_db, *far_db])
    assert Tr37885.highway().loss_db(at)[1] == pytest.approx(32.4 + 40 + 20 * log_f)
    assert DualSlope.highway_los().loss_db(at)[1] == pytest.approx(66.1 + 16.6)
    beyond_db = 66.1 + 16.6 * np.log10(10.4) + 28.8 * np.log10(300 / 104)
    assert DualSlope.highway_los().loss_db(at)[2] == pytest.approx(beyond_db)


@given(first=st.floats(1, 500), second=st.floats(1, 500))
def test_a_corner_costs_the_same_both_ways(first: float, second: float) -> None:
    corner = ManhattanNlos()
    one = corner.loss_db(np.array([first]), np.array([second]))
    other = corner.loss_db(np.array([second]), np.array([first]))
    assert one == other


def test_buildings_hide_whoever_is_not_on_the_same_street() -> None:
    town = Propagation(streets=StreetGrid(200.0, 20.0), nlos=ManhattanNlos())
    here = np.zeros((4, 2))
    there = np.array([[150.0, 5.0], [5.0, 150.0], [200.0, 150.0], [100.0, 100.0]])
    assert town.line_of_sight(here, there).tolist() == [True, True, False, False]
    assert town.gain_db(here, there)[2] < town.gain_db(here, there)[0] - 10


@pytest.mark.parametrize(
    "town",
    [
        Propagation(),
        Propagation(streets=StreetGrid(200.0, 20.0), nlos=ManhattanNlos()),
        Propagation(streets=StreetGrid(200.0, 20.0), nlos=Tr37885.nlos()),
    ],
    ids=["open", "manhattan", "nlos"],
)
def test_compiled_median_gain_equals_the_formulas(town: Propagation) -> None:
    rng = np.random.default_rng(3)
    median = Propagation(town.path_loss, None, None, streets=town.streets, nlos=town.nlos)
    place_m = rng.uniform(0.0, 600.0, (200, 2))
    place_m[::2, 1] = np.round(place_m[::2, 1] / 200.0) * 200.0
    one, other = rng.integers(0, 200, 500), rng.integers(0, 200, 500)
    apart = np.hypot(*(place_m[one] - place_m[other]).T) > 2.0
    one, other = one[apart], other[apart]
    gains = 10.0 * np.log10(median.draw_gains(place_m, (one, other), rng))
    assert gains == pytest.approx(median.gain_db(place_m[one], place_m[other]), abs=TABLE_DB)


def test_received_power_is_the_same_in_both_directions_and_bounded() -> None:
    """Shadowing belongs to the pair; without fading both directions agree. Nothing is ever amplified."""
    rng = np.random.default_rng(4)
    place_m = rng.uniform(0.0, 500.0, (60, 2))
    one, other = rng.integers(0, 60, 400), rng.integers(0, 60, 400)
    gains = Propagation(fading=None).draw_gains(
        place_m, (np.concatenate([one, other]), np.concatenate([other, one])), rng
    )
    assert gains[:400] == pytest.approx(gains[400:])
    quiet = Propagation(shadowing=None, fading=None).draw_gains(place_m, (one, other), rng)
    assert quiet.max() <= 1.0


@pytest.mark.parametrize("row", [0, 1, 2])
def test_fading_has_unit_mean_and_the_gamma_law(row: int) -> None:
    fading = NakagamiFading()
    cells = fading.cells()[row]
    assert cells.mean() == pytest.approx(1.0, abs=1e-12)
    shape = fading.shapes[row]
    assert np.median(cells) == pytest.approx(stats.gamma(shape, scale=1 / shape).median(), rel=1e-3)
    assert cells.var() == pytest.approx(1 / shape, rel=2e-3)  # what is lost is the spread inside a cell


def test_fading_drawn_in_batches_has_unit_mean_at_every_distance() -> None:
    """Within four standard errors."""
    rng = np.random.default_rng(5)
    for distance_m, shape in ((20.0, 3.0), (100.0, 1.5), (400.0, 1.0)):
        drawn = NakagamiFading().draw(np.full(40_000, distance_m), rng)
        assert drawn.mean() == pytest.approx(1.0, abs=4 / np.sqrt(shape * drawn.size))


def test_uniform_numbers_are_uniform() -> None:
    random = words(2)
    drawn = [uniform(random) for _ in range(5000)]
    assert stats.kstest(drawn, "uniform").pvalue > 0.001


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: LogDistance(0.0),
        lambda: WinnerB1(antenna_m=1.0),
        lambda: DualSlope(2.0, 3.0, reference_loss_db=60.0, break_m=5.0),
        lambda: Shadowing(-1.0),
        lambda: Shadowing(decorrelation_m=0.0),
        lambda: NakagamiFading((0.4, 1.0, 1.0)),
        lambda: NakagamiFading(edges_m=(150.0, 50.0)),
        lambda: StreetGrid(10.0, 20.0),
        lambda: Propagation(streets=StreetGrid()),
    ],
)
def test_impossible_settings_are_refused(wrong: object) -> None:
    with pytest.raises(ValueError, match=r"must|go together"):
        wrong()  # type: ignore[operator]
