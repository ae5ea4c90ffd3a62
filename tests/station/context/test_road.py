"""Claims about the road as driven before, by closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import Origin
from modelcast.models.context_columns import (
    CONTEXT_COLUMNS,
    CONTEXT_NAMES,
    ROAD_HEADING,
    ROAD_KNOWN,
    ROAD_TURN,
    ROAD_TURN_HORIZONS,
)
from modelcast.station.context.drive_kernels import HELD_M, HELD_S
from modelcast.station.context.road import (
    RoadCells,
    joined,
    road_cells,
    road_columns,
    roads,
    roads_of,
    stored,
)
from modelcast.station.context.road_kernels import CELL_M
from modelcast.station.context.survey import survey_roads
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.trips.trajectory import build_trajectory

TURNS = slice(ROAD_TURN, ROAD_TURN + ROAD_TURN_HORIZONS)
CELL_RAD = 1e-3
"""A polyline of marks a metre apart turns by this much less or more than its circle."""


def moving(t_s: FloatArray, position_m: FloatArray) -> FloatArray:
    """Samples of a path, with the velocity of its differences, (T, 7)."""
    return np.column_stack([position_m, np.gradient(position_m, t_s, axis=0), np.zeros((t_s.size, 3))])


def circle(laps: float, *, radius_m: float = 100.0, speed_mps: float = 10.0) -> tuple[FloatArray, FloatArray]:
    """Times and samples of a clockwise circle."""
    t_s = np.arange(0.0, laps * 2.0 * np.pi * radius_m / speed_mps, 0.1)
    angle = speed_mps * t_s / radius_m
    return t_s, moving(t_s, radius_m * np.stack([np.sin(angle), np.cos(angle)], axis=1))


def straight(
    length_m: float, speed_mps: float = 10.0, offset_m: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Times and samples of a straight road to the north."""
    t_s = np.arange(0.0, length_m / speed_mps, 0.1)
    return t_s, moving(t_s, np.stack([np.full(t_s.size, offset_m), speed_mps * t_s], axis=1))


def test_the_columns_have_names() -> None:
    assert len(CONTEXT_NAMES) == CONTEXT_COLUMNS == 13
    assert CONTEXT_NAMES[ROAD_TURN + 2] == "road_turn_3s_rad"
    assert CONTEXT_NAMES[ROAD_KNOWN] == "road_known"


@pytest.mark.parametrize("speed_mps", [5.0, 20.0])
@pytest.mark.parametrize("radius_m", [60.0, 200.0])
def test_on_the_second_lap_of_a_circle_the_road_turns_by_v_t_over_r(
    speed_mps: float, radius_m: float
) -> None:
    t_s, samples = circle(2.0, radius_m=radius_m, speed_mps=speed_mps)
    context = road_columns(t_s, samples)
    lap_s = 2.0 * np.pi * radius_m / speed_mps
    first, second = t_s < lap_s - 5.0, t_s > lap_s + 5.0
    # On the second lap the whole way ahead was driven on the first, up to where that began.
    second &= t_s < 2.0 * lap_s - 6.0 - max(HELD_S, HELD_M / speed_mps)
    assert not context[first].any()
    assert context[second, ROAD_KNOWN].all()
    expected = speed_mps * np.arange(1, ROAD_TURN_HORIZONS + 1) / radius_m
    np.testing.assert_allclose(context[second, TURNS], np.tile(expected, (second.sum(), 1)), atol=0.02)
    np.testing.assert_allclose(context[second, ROAD_HEADING], 0.0, atol=0.01)


def test_a_road_driven_the_other_way_is_not_remembered() -> None:
    t_s, samples = straight(600.0)
    back = moving(t_s, samples[::-1, :2])
    shared = roads_of(road_cells(t_s, samples))
    assert road_columns(t_s, samples, shared=shared)[:, ROAD_KNOWN].any()
    assert not road_columns(t_s, back, shared=shared).any()


def test_a_path_beside_counts_within_six_metres_and_its_heading_beside_the_course_is_told() -> None:
    t_s, samples = straight(600.0)
    shared = roads_of(road_cells(t_s, samples))
    for offset_m, known in ((5.0, True), (7.0, False)):
        _, beside = straight(600.0, offset_m=offset_m)
        assert road_columns(t_s, beside, shared=shared)[100, ROAD_KNOWN] == known
    slant = moving(t_s, np.stack([0.1 * (samples[:, 1] - 300.0), samples[:, 1]], axis=1))
    context = road_columns(t_s, slant, shared=shared)
    assert context[300, ROAD_HEADING] == pytest.approx(-np.arctan(0.1), abs=1e-6)


def test_a_road_known_in_part_holds_its_last_turn_and_one_that_ends_is_unknown() -> None:
    t_s, samples = circle(0.9)
    shared = roads_of(road_cells(t_s, samples))
    context = road_columns(t_s, samples, shared=shared)
    known = np.flatnonzero(context[:, ROAD_KNOWN])
    assert known[-1] < t_s.size - 10  # within 2 s of its end the road is not known
    last = context[known[-1], TURNS]
    assert last[1] == pytest.approx(0.2, abs=0.03)
    np.testing.assert_allclose(last[2:], last[-1], atol=0.06)
    assert last[-1] < 0.3


def test_a_car_does_not_find_the_path_that_it_is_driving() -> None:
    t_s, samples = straight(2000.0)
    assert not road_columns(t_s, samples).any()
    standing = np.concatenate([samples, np.tile(samples[-1:], (900, 1))])
    standing[-900:, 2:4] = 0.0
    later_s = np.arange(standing.shape[0]) * 0.1
    assert not road_columns(later_s, standing).any()


def test_what_is_known_depends_on_the_past_alone() -> None:
    t_s, samples = circle(2.5)
    whole = road_columns(t_s, samples)
    cut = 1000
    np.testing.assert_array_equal(road_columns(t_s[:cut], samples[:cut]), whole[:cut])


def test_noise_and_a_bias_between_drives_bend_the_road_little() -> None:
    t_s, samples = circle(1.0)
    rng = np.random.default_rng(1)
    noisy = samples.copy()
    noisy[:, :2] += np.array([0.8, -0.8]) + 0.3 * rng.standard_normal((t_s.size, 2))
    context = road_columns(t_s, samples, shared=roads_of(road_cells(t_s, noisy)))
    known = context[:, ROAD_KNOWN] > 0.0
    assert known[100:400].all()
    off = context[known, ROAD_TURN + 2] - 0.3
    assert np.sqrt(np.mean(off[:300] ** 2)) < 0.04


def test_the_memory_is_bounded_and_the_oldest_give_way() -> None:
    t_s, samples = straight(3000.0)
    cells = road_cells(t_s, samples)
    assert len(cells) == pytest.approx(3000.0 / CELL_M, abs=8)
    held = roads_of(cells, 100)
    assert len(stored(held)) == 100
    np.testing.assert_allclose(stored(held).numbers, cells.numbers[-100:], atol=1e-3)
    context = road_columns(t_s, samples, shared=held)
    where = samples[context[:, ROAD_KNOWN] > 0.0, 1]
    assert where.min() >= cells.numbers[-100, 1] - 6.0
    assert sum(column.nbytes for column in roads(1, 20_000)) <= 28 * 20_000


def test_a_car_goes_on_along_the_pass_that_it_follows() -> None:
    """Where a side road leaves, a pass that goes on as the car does wins, and the turn is that pass's."""
    t_s, on = straight(800.0)
    turning = on.copy()
    away = turning[:, 1] > 400.0
    turning[away, 0] = turning[away, 1] - 400.0
    shared = roads_of(joined([road_cells(t_s, on), road_cells(t_s, moving(t_s, turning[:, :2]))]))
    context = road_columns(t_s, moving(t_s, turning[:, :2]), shared=shared)
    after = np.flatnonzero(turning[:, 1] > 415.0)[0]
    assert context[after + 50, ROAD_KNOWN] == 1.0
    assert context[after + 50, ROAD_HEADING] == pytest.approx(0.0, abs=0.02)


def test_cells_of_one_pass_follow_each_other() -> None:
    with pytest.raises(ValueError, match="follow each other"):
        RoadCells(np.zeros((3, 3)), np.array([0, 1, 0]))
    with pytest.raises(ValueError, match="finite"):
        RoadCells(np.full((1, 3), np.nan), np.array([0]))


def test_a_survey_serves_any_frame_on_earth_and_never_the_trip_it_was_made_of() -> None:
    t_s, samples = circle(1.0)
    at = Origin(48.0, 11.0)
    trip = build_trajectory("a/1", t_s, samples[:, :2], origin=at)
    survey = survey_roads([trip])
    sensed = sample_matrix(trip, velocity_estimator_for(trip))
    near = Origin(48.01, 11.01)
    cells, moved = survey.cells(at), survey.cells(near)
    assert cells is not None
    assert moved is not None
    np.testing.assert_allclose(cells.numbers, road_cells(t_s, sensed).numbers, atol=1e-3)
    assert np.hypot(*(moved.numbers - cells.numbers)[0, :2]) == pytest.approx(1338.0, rel=0.01)
    assert survey.cells(None) is None
    without = survey.cells(at, survey.fingerprints)
    assert without is not None
    assert len(without) == 0
    with pytest.raises(ValueError, match="local plane"):
        survey_roads([trip, replace(trip, trip_id="b/1", origin=None)])
