"""Claims about sensors as time goes on: closed forms of their errors, and one implementation for all."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.scenario.base import FleetFrame
from modelcast.world.scenario.sensed import sensed
from modelcast.world.sensor_kernels import DRAWS, NEW, PART, Samples
from modelcast.world.sensors import IDEAL, SensorModel, Sensors, sense, with_motion

MANY = 40_000


class Told(np.random.Generator):
    """Gives the numbers of a table (kind, instant, vehicle), instant after instant."""

    def __init__(self, table: FloatArray) -> None:
        super().__init__(np.random.PCG64(0))
        self._left = table

    def standard_normal(self, size: tuple[int, int, int]) -> FloatArray:  # type: ignore[override]
        """Give the next instants, (kinds, instants, vehicles)."""
        now, self._left = self._left[:, : size[1]], self._left[:, size[1] :]
        return np.ascontiguousarray(now)


ROUGH = SensorModel(
    position_noise_m=0.3,
    slow_position_noise_m=0.5,
    slow_correlation_s=4.0,
    multipath_noise_m=0.2,
    multipath_correlation_s=0.7,
    latency_s=0.17,
)


def standing(t_s: FloatArray, vehicles: int = MANY, speed_mps: float = 5.0) -> Samples:
    """Vehicles that never leave the origin, and say that they move."""
    motion = np.zeros((t_s.size, vehicles, 6))
    motion[:, :, 2] = speed_mps
    begins = np.zeros((t_s.size, vehicles), dtype=np.uint8)
    begins[0] = NEW
    return Samples(t_s, motion, begins, np.ones((t_s.size, vehicles), dtype=np.bool_))


def shown(model: SensorModel, truth: Samples, seed: int = 1) -> FloatArray:
    sensors = Sensors(model)
    return sensors.sense(sensors.init(truth.active.shape[1], np.random.default_rng(seed)), truth)[0]


def drive(seed: int, gap_s: float) -> Trajectory:
    """Two parts of uneven steps, with turns, stops, and rates."""
    rng = np.random.default_rng(seed)
    steps_s: FloatArray = rng.uniform(0.08, 0.12, 80)
    steps_s[40] = gap_s
    t = np.cumsum(steps_s) - steps_s[0]
    turns: FloatArray = rng.normal(0.0, 0.4, t.size)
    angle = np.cumsum(turns)
    pace = np.maximum(6.0 * np.sin(0.15 * np.arange(t.size)), 0.0)[:, None] * 0.1
    position = np.cumsum(pace * np.stack([np.sin(angle), np.cos(angle)], axis=1), axis=0)
    found = with_motion(build_trajectory("made/1", t, position))
    column = rng.normal(size=len(found))
    return replace(found, acceleration_mps2=column, yaw_rate_radps=0.1 * column, up_m=2.0 * column)


def present(column: FloatArray | None) -> FloatArray:
    assert column is not None
    return column


def table(trip: Trajectory) -> FloatArray:
    columns = (trip.speed_mps, trip.heading_rad, trip.acceleration_mps2, trip.yaw_rate_radps)
    return np.column_stack((trip.position_m, *map(present, columns)))


def frames_of(trip: Trajectory) -> list[FleetFrame]:
    """A fleet of one that drives the trip."""
    one, (rows,) = np.ones(1), (table(trip),)

    def frame(k: int, begins: BoolArray) -> FleetFrame:
        return FleetFrame(
            float(trip.t_s[k]),
            rows[k : k + 1, :2].copy(),
            speed_mps=rows[k, 2] * one,
            heading_rad=rows[k, 3] * one,
            acceleration_mps2=rows[k, 4] * one,
            yaw_rate_radps=rows[k, 5] * one,
            length_m=4.5 * one,
            vehicle_id=np.zeros(1, dtype=np.int64),
            active=one > 0.0,
            begins=begins,
        )

    return [frame(k, np.array([k in trip.segments])) for k in range(len(trip))]


def test_wandering_errors_are_stationary_with_the_sum_of_two_decays() -> None:
    """At uneven times: variances s² and u², correlation (s² exp(-lag / S) + u² exp(-lag / U)) / (s² + u²)."""
    model = replace(ROUGH, position_noise_m=0.0, latency_s=0.0)
    t = np.array([0.0, 0.3, 0.5, 2.0, 9.0])
    error = shown(model, standing(t))[:, :, :2].reshape(t.size, -1)
    variance = 0.5**2 + 0.2**2
    assert error.var(axis=1) == pytest.approx(np.full(t.size, variance), rel=0.03)
    lag_s = t[:, None] - t
    slow, fast = np.exp(-np.abs(lag_s) / 4.0), np.exp(-np.abs(lag_s) / 0.7)
    np.testing.assert_allclose(np.corrcoef(error), (0.25 * slow + 0.04 * fast) / variance, atol=0.02)


@settings(derandomize=True, deadline=None, max_examples=20)
@given(size_m=st.floats(0.01, 5.0), correlation_s=st.floats(1.0, 3000.0), step_s=st.floats(0.02, 1.0))
def test_a_step_of_a_wandering_error_has_its_closed_form(
    size_m: float, correlation_s: float, step_s: float
) -> None:
    model = replace(IDEAL, slow_position_noise_m=size_m, slow_correlation_s=correlation_s)
    error = shown(model, standing(np.array([0.0, step_s]), 20_000))[:, :, :2]
    expected = size_m * np.sqrt(2.0 * (1.0 - np.exp(-step_s / correlation_s)))
    assert (error[1] - error[0]).std() == pytest.approx(expected, rel=0.03)


def test_each_column_has_the_noise_of_its_own_size_and_no_other() -> None:
    sizes = {
        "position_noise_m": (0, 1),
        "speed_noise_mps": (2,),
        "heading_noise_rad": (3,),
        "acceleration_noise_mps2": (4,),
        "yaw_rate_noise_radps": (5,),
    }
    truth = standing(np.arange(3.0))
    for name, columns in sizes.items():
        error = shown(replace(IDEAL, **{name: 0.02}), truth) - truth.motion
        expected = [0.02 if column in columns else 0.0 for column in range(6)]
        assert error.std(axis=(0, 1)) == pytest.approx(expected, rel=0.02)
        assert np.abs(error.mean(axis=(0, 1))).max() < 5.0 * 0.02 / np.sqrt(3.0 * MANY)


def test_errors_of_vehicles_axes_and_columns_are_independent() -> None:
    error = shown(ROUGH, standing(np.arange(2.0)))
    rows = np.concatenate([error[0].T, error[1, :, 2:].T])
    np.testing.assert_allclose(np.corrcoef(rows), np.eye(rows.shape[0]), atol=0.025)
    assert abs(np.corrcoef(error[0, 1:, 0], error[0, :-1, 0])[0, 1]) < 0.025


@settings(derandomize=True, deadline=None, max_examples=30)
@given(seed=st.integers(0, 1000), gap_s=st.sampled_from([0.1, 0.6, 30.0]), latency_s=st.floats(0.0, 0.6))
def test_a_trip_and_a_fleet_of_one_see_the_same_bits(seed: int, gap_s: float, latency_s: float) -> None:
    """From the same numbers, which a trip draws by kind for all of its samples."""
    trip = drive(seed, gap_s)
    model = replace(ROUGH, latency_s=latency_s)
    seen = sense(trip, model, np.random.default_rng(seed))
    numbers = np.random.default_rng(seed).standard_normal((DRAWS, len(trip), 1))
    fleet = [frame for _, frame in sensed(frames_of(trip), model, Told(numbers))]
    rows = np.array(
        [
            np.concatenate(
                (f.position_m[0], f.speed_mps, f.heading_rad, f.acceleration_mps2, f.yaw_rate_radps)
            )
            for f in fleet
        ]
    )
    assert rows.tobytes() == np.ascontiguousarray(table(seen)).tobytes()


@settings(derandomize=True, deadline=None, max_examples=30)
@given(cuts=st.sets(st.integers(1, 59)), latency_s=st.floats(0.0, 0.9), seed=st.integers(0, 100))
def test_instants_given_together_or_in_blocks_show_the_same_bits(
    cuts: set[int], latency_s: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    truth = standing(np.cumsum(rng.uniform(0.05, 0.3, 60)), 3)
    truth.motion[:] = rng.normal(1.0, 1.0, truth.motion.shape)
    truth.begins[rng.random((60, 3)) < 0.05] = PART
    truth.begins[rng.random((60, 3)) < 0.05] = NEW
    truth.active[rng.random((60, 3)) < 0.1] = False
    sensors = Sensors(replace(ROUGH, latency_s=latency_s))
    whole, _ = sensors.sense(sensors.init(3, np.random.default_rng(seed)), truth)
    state = sensors.init(3, Told(np.random.default_rng(seed).standard_normal((DRAWS, 60, 3))))
    bounds = [0, *sorted(cuts), 60]
    for a, b in pairwise(bounds):
        block = Samples(truth.t_s[a:b], truth.motion[a:b], truth.begins[a:b], truth.active[a:b])
        seen, state = sensors.sense(state, block)
        assert seen.tobytes() == whole[a:b].tobytes()


@settings(derandomize=True, deadline=None, max_examples=30)
@given(seed=st.integers(0, 1000), gap_s=st.sampled_from([0.1, 0.6, 30.0]), latency_s=st.floats(0.0, 0.6))
def test_latency_is_interpolation_inside_each_part(seed: int, gap_s: float, latency_s: float) -> None:
    trip = drive(seed, gap_s)
    seen = sense(trip, replace(IDEAL, latency_s=latency_s), np.random.default_rng(0))
    late = np.maximum(trip.t_s - latency_s, trip.t_s[trip.segment_start])
    for name in ("speed_mps", "acceleration_mps2", "yaw_rate_radps", "up_m"):
        expected: FloatArray = np.interp(late, trip.t_s, trip.columns()[name])
        np.testing.assert_allclose(seen.columns()[name], expected, atol=1e-9)
    for axis in range(2):
        expected = np.interp(late, trip.t_s, trip.position_m[:, axis])
        np.testing.assert_allclose(seen.position_m[:, axis], expected, atol=1e-9)


@pytest.mark.parametrize("latency_s", [0.0, 0.05])
def test_a_turn_through_south_is_late_by_the_short_way(latency_s: float) -> None:
    truth = standing(np.array([0.0, 0.1]), 1)
    truth.motion[:, 0, 3] = 3.1, -3.1
    seen = shown(replace(IDEAL, latency_s=latency_s), truth)[1, 0, 3]
    assert abs(seen) == pytest.approx(np.pi if latency_s else 3.1, abs=1e-9)


def test_a_slow_vehicle_holds_its_heading_until_a_part_or_another_vehicle_begins() -> None:
    truth = standing(np.arange(6.0), 1, speed_mps=0.4)
    truth.motion[:, 0, 3] = np.arange(6.0) / 10.0
    truth.begins[2], truth.begins[4] = PART, NEW
    assert shown(IDEAL, truth)[:, 0, 3] == pytest.approx([0.0, 0.0, 0.2, 0.2, 0.4, 0.4])


def test_wandering_errors_go_on_into_a_part_and_are_anew_for_another_vehicle() -> None:
    model = replace(IDEAL, slow_position_noise_m=1.0, slow_correlation_s=1e9, multipath_noise_m=1.0)
    model = replace(model, multipath_correlation_s=1e9)
    truth = standing(np.arange(3.0))
    truth.begins[1], truth.begins[2] = PART, NEW
    first, part, other = shown(model, truth)[:, :, 0]
    np.testing.assert_allclose(part, first, atol=1e-3)
    assert other.std() == pytest.approx(np.sqrt(2.0), rel=0.02)
    assert abs(np.corrcoef(first, other)[0, 1]) < 0.02


def test_a_given_state_is_left_alone_and_one_seed_gives_one_input() -> None:
    sensors = Sensors(ROUGH)
    first, then = standing(np.array([0.0]), 5), standing(np.array([0.1]), 5)
    then.begins[:] = 0
    shows: list[bytes] = []
    for _ in range(2):
        _, state = sensors.sense(sensors.init(5, np.random.default_rng(3)), first)
        kept = [state.errors.wandering.copy(), state.errors.heading_rad.copy()]
        seen, after = sensors.sense(state, then)
        assert np.array_equal(kept[0], state.errors.wandering)
        assert np.array_equal(kept[1], state.errors.heading_rad)
        assert not np.array_equal(kept[0], after.errors.wandering)
        shows.append(seen.tobytes())
    assert shows[0] == shows[1]


WANDERING = replace(IDEAL, slow_position_noise_m=0.5, slow_correlation_s=4.0, multipath_noise_m=0.2)
EVERY_S = np.arange(0.0, 3.0, 1.0)


@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0])
def test_a_shared_bias_is_so_much_of_the_variance_and_changes_nothing_else(ratio: float) -> None:
    """Over many vehicles what is common does not spread; the rest has the variance that is left."""
    model = replace(WANDERING, shared_slow_ratio=ratio)
    errors = shown(model, standing(EVERY_S))[:, :, :2]
    own = 0.25 * (1.0 - ratio) + 0.04
    assert errors.var(axis=1) == pytest.approx(own, rel=0.03)
    apart = shown(WANDERING, standing(EVERY_S))[:, :, :2]
    if ratio == 0.0:
        assert (errors == apart).all()
    alone = shown(replace(model, slow_position_noise_m=0.0), standing(EVERY_S))[:, :, :2]
    common = errors - alone - np.sqrt(1.0 - ratio) * (apart - alone)
    assert np.ptp(common, axis=1) == pytest.approx(0.0, abs=1e-12)
    assert (np.abs(common) > 0.0).all() == (ratio > 0.0)


def test_a_vehicle_alone_errs_as_much_and_for_as_long_whatever_it_shares() -> None:
    """Runs of one vehicle with seeds of their own: variance 0.25, correlation exp(-1/4) after a second."""
    model = replace(IDEAL, slow_position_noise_m=0.5, slow_correlation_s=4.0, shared_slow_ratio=0.6)
    errors = np.array([shown(model, standing(EVERY_S, 1), seed)[:, 0, :2] for seed in range(4000)])
    assert errors.var(axis=0) == pytest.approx(0.25, rel=0.1)
    for before, after in pairwise(range(EVERY_S.size)):
        for axis in range(2):
            found = np.corrcoef(errors[:, before, axis], errors[:, after, axis])[0, 1]
            assert found == pytest.approx(np.exp(-0.25), abs=0.05)


def test_a_shared_bias_goes_on_from_call_to_call() -> None:
    model = replace(IDEAL, slow_position_noise_m=0.5, slow_correlation_s=4.0, shared_slow_ratio=1.0)
    sensors, truth = Sensors(model), standing(EVERY_S, 3)
    whole = shown(model, truth)
    state, rows = sensors.init(3, np.random.default_rng(1)), list[FloatArray]()
    for at in range(EVERY_S.size):
        now = slice(at, at + 1)
        part = Samples(truth.t_s[now], truth.motion[now], truth.begins[now], truth.active[now])
        seen, state = sensors.sense(state, part)
        rows.append(seen[0])
    assert np.array(rows) == pytest.approx(whole, abs=1e-12)


def test_empty_slots_stay_empty_where_a_bias_is_shared() -> None:
    truth = standing(EVERY_S, 2)
    truth.active[:, 1] = False
    model = replace(IDEAL, slow_position_noise_m=0.5, shared_slow_ratio=1.0)
    assert (shown(model, truth)[:, 1] == 0.0).all()


def test_more_than_all_cannot_be_shared() -> None:
    with pytest.raises(ValueError, match=r"shared_slow_ratio must be 0\.\.1"):
        SensorModel(shared_slow_ratio=1.1)
