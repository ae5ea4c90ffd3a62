"""Claims about the generated drive."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.core.geodesy import heading_to_velocity, wrap_angle_rad
from modelcast.trips.inspection import inspect
from modelcast.trips.manoeuvres.base import ManoeuvreKind
from modelcast.trips.manoeuvres.rank import count_manoeuvres
from modelcast.world.drive import MIN_DURATION_S, CanBus, Drive, generate_drive

STEP_ERROR = 0.05
"""Central differences over 0.2 s miss a jerk of 15 m/s³ by 15 · 0.1² / 6 = 0.025 m/s, twice at a kink."""


def columns(drive: Drive) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    truth = drive.truth
    assert truth.speed_mps is not None
    assert truth.heading_rad is not None
    assert truth.acceleration_mps2 is not None
    assert truth.yaw_rate_radps is not None
    return truth.speed_mps, truth.heading_rad, truth.acceleration_mps2, truth.yaw_rate_radps


def rows_of(drive: Drive, name: str) -> BoolArray:
    found = np.zeros(len(drive.truth), dtype=np.bool_)
    for m in drive.manoeuvres:
        if m.name == name:
            found |= (drive.truth.t_s >= m.start_s - 0.1) & (drive.truth.t_s <= m.end_s + 0.1)
    return found


@settings(derandomize=True, deadline=None, max_examples=8)
@given(seed=st.integers(0, 10**6))
def test_a_car_could_drive_it(seed: int) -> None:
    drive = generate_drive(seed, duration_s=150.0)
    speed, _, acceleration, yaw_rate = columns(drive)
    assert speed.min() == 0.0
    assert speed.max() < 20.0
    assert -7.1 < acceleration.min() < -6.0
    assert acceleration.max() < 2.6
    assert np.abs(speed * yaw_rate).max() < 2.6
    hard = rows_of(drive, "hard brake")[1:]
    jerk = np.diff(acceleration) / np.diff(drive.truth.t_s)
    assert np.abs(jerk[~hard]).max() < 5.0
    assert np.abs(jerk[hard]).max() < 16.0
    lateral_jerk = np.diff(speed * yaw_rate) / np.diff(drive.truth.t_s)
    assert np.abs(lateral_jerk).max() < 5.0


@settings(derandomize=True, deadline=None, max_examples=8)
@given(seed=st.integers(0, 10**6))
def test_its_columns_are_derivatives_of_each_other(seed: int) -> None:
    drive = generate_drive(seed, duration_s=100.0)
    speed, heading, acceleration, yaw_rate = columns(drive)
    t = drive.truth.t_s
    velocity = np.gradient(drive.truth.position_m, t, axis=0)
    assert np.abs(velocity - heading_to_velocity(speed, heading))[1:-1].max() < STEP_ERROR
    gained = np.diff(speed) - 0.5 * (acceleration[1:] + acceleration[:-1]) * np.diff(t)
    assert np.abs(gained).max() < STEP_ERROR
    turned = wrap_angle_rad(np.diff(heading)) - 0.5 * (yaw_rate[1:] + yaw_rate[:-1]) * np.diff(t)
    assert np.abs(turned).max() < 0.005


@settings(derandomize=True, deadline=None, max_examples=8)
@given(seed=st.integers(0, 10**6))
def test_the_shortest_drive_holds_every_manoeuvre(seed: int) -> None:
    drive = generate_drive(seed, duration_s=MIN_DURATION_S)
    names = {m.name for m in drive.manoeuvres}
    assert names == {"accelerate", "cruise", "lane change", "brake", "turn", "hard brake", "stop"}
    found = count_manoeuvres(drive.truth).by_kind
    assert found[ManoeuvreKind.STOP] >= 1
    assert found[ManoeuvreKind.TURN] >= 1
    assert found[ManoeuvreKind.LANE_CHANGE] >= 1
    assert found[ManoeuvreKind.HARD_BRAKE] == 1


def test_a_lane_change_moves_one_lane_and_ends_on_the_old_heading() -> None:
    drive = generate_drive(0)
    change = next(m for m in drive.manoeuvres if m.name == "lane change")
    heading = columns(drive)[1]
    a, b = np.searchsorted(drive.truth.t_s, [change.start_s, change.end_s])
    moved = drive.truth.position_m[b] - drive.truth.position_m[a]
    across = moved @ np.array([np.cos(heading[a]), -np.sin(heading[a])])
    assert abs(across) == pytest.approx(3.5, abs=0.1)
    assert heading[b] == pytest.approx(heading[a], abs=1e-3)


def test_one_seed_gives_the_same_bytes_and_another_seed_another_drive() -> None:
    first, again, other = generate_drive(1), generate_drive(1), generate_drive(2)
    for name, column in first.input.columns().items():
        assert column.tobytes() == again.input.columns()[name].tobytes()
    assert np.abs(first.truth.position_m - other.truth.position_m).max() > 10.0


def test_the_input_is_clean_gps_and_rounded_can() -> None:
    drive = generate_drive(3)
    error = drive.input.position_m - drive.truth.position_m
    assert 0.005 < np.std(np.diff(error, axis=0)) / np.sqrt(2.0) < 0.02
    assert np.abs(error).max() < 2.0
    speed = drive.input.speed_mps
    assert speed is not None
    assert np.abs(speed / 0.01 - np.round(speed / 0.01)).max() < 1e-6
    assert np.std(speed - columns(drive)[0]) < 0.05
    assert inspect(drive.input).is_clean


def test_can_values_are_never_newer_than_their_row() -> None:
    """While the car accelerates, an exact but slow bus shows lower speeds than the truth of the row."""
    exact = CanBus(rate_hz=5.0, speed_noise_mps=0.0, speed_step_mps=1e-6)
    drive = generate_drive(4, can=exact)
    speed, _, acceleration, _ = columns(drive)
    seen = drive.input.speed_mps
    assert seen is not None
    steadily = (acceleration > 0.5) & (np.roll(acceleration, 3) > 0.5)
    assert (seen[steadily] <= speed[steadily] + 1e-5).all()
    assert (speed[steadily] - seen[steadily]).max() < 2.6 * 0.4


def test_a_drive_too_short_for_its_manoeuvres_is_refused() -> None:
    with pytest.raises(ValueError, match="duration_s"):
        generate_drive(0, duration_s=MIN_DURATION_S - 1.0)


@pytest.mark.parametrize("rate_hz", [0.0, -10.0, 51.0, float("nan")])
def test_a_rate_out_of_bounds_is_refused(rate_hz: float) -> None:
    with pytest.raises(ValueError, match="rate_hz"):
        generate_drive(0, rate_hz=rate_hz)
