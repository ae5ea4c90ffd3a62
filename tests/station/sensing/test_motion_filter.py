"""Claims about a vehicle's own estimate of its motion."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.station import arrays
from modelcast.station.sensing.motion_filter import MotionFilter
from modelcast.station.sensing.sensing import Sensing
from modelcast.station.sensing.sensing_kernels import forget_each, sense
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import sensed
from modelcast.world.sensors import IDEAL, SensorModel, filter_for

ROUNDING = 1e-8
"""Sums in another order, of numbers up to 100; the dense filter inverts a matrix."""

DT_S = 0.1


def curve(steps: int, *, speed_mps: float = 20.0, yaw_rate_radps: float = 0.1) -> FloatArray:
    """A circle at constant speed, as the filter takes it, (T, 6)."""
    t = np.arange(steps) * DT_S
    heading = yaw_rate_radps * t
    radius = speed_mps / yaw_rate_radps
    east, north = radius * (1.0 - np.cos(heading)), radius * np.sin(heading)
    still = np.zeros(steps)
    return np.stack([east, north, still + speed_mps, heading, still, still + yaw_rate_radps], axis=1)


def noisy(truth: FloatArray, vehicles: int, seed: int, model: SensorModel) -> FloatArray:
    """What vehicles see of one path, (T, V, 6)."""
    sizes = np.array(
        [
            model.position_noise_m,
            model.position_noise_m,
            model.speed_noise_mps,
            model.heading_noise_rad,
            model.acceleration_noise_mps2,
            model.yaw_rate_noise_radps,
        ]
    )
    noise = np.random.default_rng(seed).standard_normal((len(truth), vehicles, 6))
    return truth[:, None, :] + noise * sizes


def filtered(seen: FloatArray, motion: MotionFilter) -> FloatArray:
    """Estimates of all steps by stations that sense every measurement, (T, V, 6)."""
    vehicles = seen.shape[1]
    every, none = np.arange(vehicles), np.zeros(vehicles, dtype=np.bool_)
    stations, numbers = arrays.sensed(vehicles, len(seen)), Sensing(motion=motion).numbers(DT_S)
    shown: list[FloatArray] = []
    for number, one in enumerate(seen):
        t_s = np.full(vehicles, number * DT_S)
        sense(stations, every, t_s, np.ascontiguousarray(one), none, numbers)
        shown.append(stations.shown.copy())
    return np.array(shown)


def dense(seen: FloatArray, motion: MotionFilter) -> FloatArray:
    """Positions (T, 2) by the textbook: one matrix of everything measured, and its inverse."""
    powers = np.array([[1.0, DT_S, DT_S**2 / 2], [0.0, 1.0, DT_S], [0.0, 0.0, 1.0]])
    moments = np.array(
        [
            [DT_S**5 / 20, DT_S**4 / 8, DT_S**3 / 6],
            [DT_S**4 / 8, DT_S**3 / 3, DT_S**2 / 2],
            [DT_S**3 / 6, DT_S**2 / 2, DT_S],
        ]
    )
    go = np.kron(powers, np.eye(2))
    state, spread = np.zeros(6), np.zeros((6, 6))
    shown: list[FloatArray] = []
    for number, (east, north, speed, heading, acceleration, yaw_rate) in enumerate(seen):
        ahead = np.array([np.sin(heading), np.cos(heading)])
        right = np.array([np.cos(heading), -np.sin(heading)])
        turned = np.stack([ahead, right])
        across = np.hypot(speed * motion.heading_rad, 0.01)
        if number == 0:
            rates = turned.T @ [acceleration, speed * yaw_rate]
            state = np.concatenate([[east, north], speed * ahead, rates])
            spread = np.diag(np.repeat([motion.position_m, motion.speed_mps + across, 1.0], 2) ** 2)
        else:
            jerk = turned.T @ np.diag([motion.jerk_along**2, motion.jerk_across**2]) @ turned
            state, spread = go @ state, go @ spread @ go.T + np.kron(moments, jerk)
            look = np.kron(np.eye(3), np.eye(2))
            look[2:4, 2:4] = look[4:6, 4:6] = turned
            swing = np.hypot(speed * motion.yaw_rate_radps, motion.acceleration_mps2)
            stds = [motion.position_m, motion.position_m, motion.speed_mps, across]
            errors = np.diag(np.array([*stds, motion.acceleration_mps2, swing]) ** 2)
            off = np.array([east, north, speed, 0.0, acceleration, speed * yaw_rate]) - look @ state
            gain = spread @ look.T @ np.linalg.inv(look @ spread @ look.T + errors)
            state, spread = state + gain @ off, spread - gain @ look @ spread
        shown.append(state[:2].copy())
    return np.array(shown)


def test_it_is_the_textbook_filter() -> None:
    motion = MotionFilter(0.02, 0.1, jerk_along=0.3, jerk_across=0.7)
    seen = noisy(curve(40), 1, 1, SensorModel(position_noise_m=0.02))
    assert filtered(seen, motion)[:, 0, :2] == pytest.approx(dense(seen[:, 0], motion), abs=ROUNDING)


def test_it_knows_place_speed_and_course_better_than_they_are_measured() -> None:
    """After two seconds, the root mean square errors are under 0.65, 0.4 and 0.4 of the sensors'."""
    model = SensorModel()
    truth = curve(60)
    off = filtered(noisy(truth, 400, 2, model), filter_for(model))[20:] - truth[20:, None]
    rms = np.sqrt((off**2).mean(axis=(0, 1)))
    assert rms[:2].max() < 0.65 * model.position_noise_m
    assert rms[2] < 0.4 * model.speed_noise_mps
    assert rms[3] < 0.4 * model.heading_noise_rad


@given(vehicle=st.integers(0, 4), seed=st.integers(0, 9))
@settings(max_examples=10)
def test_a_vehicle_is_filtered_alike_alone_and_in_a_fleet(vehicle: int, seed: int) -> None:
    seen = noisy(curve(10), 5, seed, SensorModel())
    alone = filtered(seen[:, vehicle : vehicle + 1], MotionFilter())
    assert np.array_equal(alone[:, 0], filtered(seen, MotionFilter())[:, vehicle])


def test_the_first_sample_is_taken_as_it_is() -> None:
    seen = curve(2)[1:, None]
    assert filtered(seen, MotionFilter()) == pytest.approx(seen, abs=ROUNDING)


def test_a_jump_of_the_receiver_is_followed_at_once_and_leaves_the_speed_alone() -> None:
    seen = curve(60, yaw_rate_radps=1e-6)[:, None]
    seen[40:, :, 0] += 0.5
    shown = filtered(seen, MotionFilter())
    assert shown[40, 0, 0] - seen[40, 0, 0] == pytest.approx(0.0, abs=0.02)
    assert shown[40:, 0, 2] == pytest.approx(20.0, abs=0.05)
    assert np.abs(shown[40:, 0, 3]).max() < 0.005


def test_a_car_that_stands_keeps_the_course_it_is_shown() -> None:
    seen = np.zeros((30, 1, 6))
    seen[:, :, 3] = 2.0
    shown = filtered(seen, MotionFilter())
    assert (shown[:, :, 3] == 2.0).all()
    assert np.abs(shown[:, :, :2]).max() == 0.0


def test_sensors_without_noise_still_make_a_filter() -> None:
    truth = curve(30)
    off = filtered(truth[:, None], filter_for(IDEAL))[:, 0, :2] - truth[:, :2]
    assert np.abs(off).max() < 1e-3  # jerk of a circle: 0.2 m/s³


@pytest.mark.parametrize("name", ["position_m", "jerk_across"])
def test_impossible_errors_are_refused_by_name(name: str) -> None:
    for value in (0.0, np.inf):
        with pytest.raises(ValueError, match=name):
            replace(MotionFilter(), **{name: value})


def test_vehicles_of_a_road_are_nearer_to_the_truth_and_new_ones_begin_anew() -> None:
    """On a short road, which vehicles leave and enter."""
    road = Highway(200.0, 60.0, warm_up_s=10.0)
    frames = run_scenario(road, np.random.default_rng(1), duration_s=12.0)
    stations = arrays.sensed(road.slots, 16)
    nothing = arrays.fits(road.slots, 1, members=0, parameters=0)
    numbers = Sensing(motion=MotionFilter()).numbers(DT_S)
    every, none = np.arange(road.slots), np.zeros(road.slots, dtype=np.bool_)
    missed, off, ids = list[FloatArray](), list[FloatArray](), list[IntArray]()
    for truth, seen in sensed(frames, SensorModel(), np.random.default_rng(2)):
        forget_each(stations, nothing, truth.vehicle_id != (ids[-1] if ids else -1))
        columns = (seen.speed_mps, seen.heading_rad, seen.acceleration_mps2, seen.yaw_rate_radps)
        measured = np.column_stack((seen.position_m, *columns))
        sense(stations, every, np.full(road.slots, truth.t_s), measured, none, numbers)
        missed.append(np.hypot(*(seen.position_m - truth.position_m).T))
        off.append(np.hypot(*(stations.shown[:, :2] - truth.position_m).T))
        ids.append(truth.vehicle_id)
    new = np.array(ids)[1:] != np.array(ids)[:-1]
    assert new.any()
    assert np.array_equal(np.array(off)[1:][new], np.array(missed)[1:][new])
    assert np.sqrt(np.mean(np.square(off[10:]))) < 0.75 * np.sqrt(np.mean(np.square(missed[10:])))
