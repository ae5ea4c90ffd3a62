"""Claims about the built-in highway."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import heading_to_velocity, wrap_angle_rad
from modelcast.world.scenario import following_kernels as following
from modelcast.world.scenario.base import STEP_S, FleetFrame, run_scenario
from modelcast.world.scenario.drivers import HIGHWAY, UNIFORM, Drivers
from modelcast.world.scenario.highway import Highway

TRAPEZOID_MPS = 0.05
"""A step's mean velocity against that of its ends: jerk dt² / 12 with jerks up to 20 m/s³, and turning."""


def run(road: Highway, duration_s: float, seed: int = 1) -> list[FleetFrame]:
    return list(run_scenario(road, np.random.default_rng(seed), duration_s=duration_s))


def column(frames: list[FleetFrame], name: str) -> FloatArray:
    return np.array([getattr(frame, name) for frame in frames])


@settings(derandomize=True, deadline=None, max_examples=50)
@given(v=st.floats(0.0, 30.0), headway=st.floats(0.5, 2.5))
def test_at_the_equilibrium_gap_nobody_accelerates(v: float, headway: float) -> None:
    """Behind an equal leader the model is at rest at s0 + v T, and brakes closer, accelerates farther."""

    def wish(gap: float) -> float:
        return following.follow(v, gap, v, 0.0, 33.0, headway, 1.4, 2.0, 2.0)

    gap = 2.0 + v * headway
    assert wish(gap) == pytest.approx(0.0, abs=1e-9)
    assert wish(0.9 * gap) < 0.0 < wish(1.1 * gap)


def test_equal_drivers_on_one_lane_settle_at_the_speed_of_the_equilibrium() -> None:
    """N cars of length l on a ring of L: v = (L / N - l - s0) / T; T and a make a platoon stable."""
    stable = replace(UNIFORM, headway_s=(2.0, 2.0), acceleration_mps2=(3.0, 3.0))
    road = Highway(2000.0, 40.0, lanes=1, both_directions=False, form="ring", drivers=stable, warm_up_s=400.0)
    speed = run(road, 0.1)[0].speed_mps
    expected = (2000.0 / 80 - 4.5 - 2.0) / 2.0
    # on the ring a car in its lane is 3.75 m outside the reference circle, and that much faster
    radius = 2000.0 / (2.0 * np.pi)
    expected *= (radius + 3.75) / radius
    assert speed.mean() == pytest.approx(expected, rel=1e-3)
    assert np.abs(speed - expected).max() < 0.05 * expected  # the rest of the first disturbance


def test_a_lone_car_reaches_its_desired_speed() -> None:
    road = Highway(1000.0, 1.0, both_directions=False, drivers=UNIFORM, warm_up_s=120.0)
    assert run(road, 0.1)[0].speed_mps[0] == pytest.approx(33.3, rel=0.01)


@pytest.mark.parametrize(("density", "lanes"), [(60.0, 3), (240.0, 3), (600.0, 4)])
def test_nobody_collides_in_minutes(density: float, lanes: int) -> None:
    frames = run(Highway(1000.0, density, lanes=lanes, warm_up_s=20.0), 120.0)[::10]
    for frame in frames:
        apart = np.abs(frame.position_m[:, None] - frame.position_m[None])
        reach = 0.5 * (frame.length_m[:, None] + frame.length_m[None])
        touching = (apart[..., 0] < reach) & (apart[..., 1] < 1.8)
        assert touching.sum() == len(frame), "each vehicle touches itself only"


@pytest.mark.parametrize("form", ["straight", "ring"])
def test_columns_are_derivatives_of_each_other(form: str) -> None:
    frames = run(Highway(1500.0, 80.0, form=form), 40.0)  # type: ignore[arg-type]
    identity = column(frames, "vehicle_id")
    same = identity[1:] == identity[:-1]
    velocity = heading_to_velocity(column(frames, "speed_mps"), column(frames, "heading_rad"))
    moved = np.diff(column(frames, "position_m"), axis=0) / STEP_S
    assert np.abs(moved - 0.5 * (velocity[1:] + velocity[:-1]))[same].max() < TRAPEZOID_MPS
    for rate, value in (("acceleration_mps2", "speed_mps"), ("yaw_rate_radps", "heading_rad")):
        mean = 0.5 * (column(frames, rate)[1:] + column(frames, rate)[:-1])
        change = np.diff(column(frames, value), axis=0)
        change = wrap_angle_rad(change) if value == "heading_rad" else change
        assert np.abs(change - mean * STEP_S)[same].max() < 0.01


def test_a_lane_change_is_one_smooth_lane_to_the_side() -> None:
    """Without wander: 3.5 m, no overshoot, lateral acceleration continuous, of the quintic's size."""
    road = Highway(2000.0, 120.0, drivers=replace(HIGHWAY, wander_m=0.0, truck_ratio=0.0))
    state = road.init(np.random.default_rng(2))
    north, lane, lateral = [], [], []
    for _ in range(600):
        frame = road.frame(state)
        north.append(frame.position_m[:, 1])
        lane.append(state.lane)
        lateral.append(frame.speed_mps * frame.yaw_rate_radps)
        state = road.step(state)
    moves = np.diff(np.array(lane), axis=0)
    path, across = np.array(north), np.array(lateral)
    events = [(n, i) for n, i in np.argwhere(moves != 0) if 10 < n < 480 and (moves[:, i] != 0).sum() == 1]
    assert len(events) > 10
    for n, i in events:
        shift = path[n + 100, i] - path[n - 5, i]
        assert abs(shift) == pytest.approx(3.5, abs=1e-9)
        steps = np.diff(path[n - 5 : n + 100, i]) * np.sign(shift)
        assert steps.min() > -1e-9
    # the quintic: peak 5.77 w / T² = 0.81 m/s², jerk 60 w / T³ = 1.7 m/s³ at T = 5 s
    assert np.abs(across).max() < 1.0
    assert np.abs(np.diff(across, axis=0)).max() / STEP_S < 2.5


def test_driving_is_gentle() -> None:
    frames = run(Highway(2000.0, 150.0), 60.0)
    identity = column(frames, "vehicle_id")
    same = identity[1:] == identity[:-1]
    jerk = (np.diff(column(frames, "acceleration_mps2"), axis=0) / STEP_S)[same]
    assert np.sqrt((jerk**2).mean()) < 1.0
    assert column(frames, "acceleration_mps2").min() > -6.0


def test_the_density_is_the_one_asked_for_and_stays() -> None:
    road = Highway(3000.0, 85.0)
    frames = run(road, 30.0)
    assert road.slots == 255
    for frame in frames:
        assert frame.active.all()
        assert np.unique(frame.vehicle_id).size == 255
        assert (frame.position_m[:, 0] >= 0.0).all()
        assert (frame.position_m[:, 0] <= 3000.0).all()


def test_on_a_ring_everybody_stays_and_on_a_straight_road_who_comes_in_again_is_new() -> None:
    ring = run(Highway(1000.0, 30.0, form="ring"), 60.0)
    assert (column(ring, "vehicle_id") == np.arange(30)).all()
    straight = column(run(Highway(1000.0, 30.0), 60.0), "vehicle_id")
    jumped = np.diff(straight, axis=0) != 0
    assert jumped.any()
    new = straight[1:][jumped]
    assert np.unique(new).size == new.size
    assert new.min() >= 30


def test_the_fuller_the_road_the_slower_and_the_flow_has_a_maximum() -> None:
    densities = [10.0, 60.0, 150.0, 300.0, 480.0]  # of two directions with two lanes each
    speed = [run(Highway(1000.0, d, lanes=2), 20.0)[-1].speed_mps.mean() for d in densities]
    assert (np.diff(speed) < 0.0).all()
    flow = 3.6 * np.array(speed) * np.array(densities) / 4.0  # vehicles an hour and lane
    assert 1200.0 < flow.max() < 2600.0
    assert 0 < int(np.argmax(flow)) < len(densities) - 1


def test_one_seed_gives_the_same_bytes_and_another_seed_another_road() -> None:
    road = Highway(1000.0, 50.0)
    first, again, other = run(road, 5.0, 3), run(road, 5.0, 3), run(road, 5.0, 4)
    assert first[-1].position_m.tobytes() == again[-1].position_m.tobytes()
    assert first[-1].position_m.tobytes() != other[-1].position_m.tobytes()


def test_a_step_leaves_the_given_state_alone() -> None:
    road = Highway(1000.0, 50.0, warm_up_s=1.0)
    state = road.init(np.random.default_rng(1))
    before = state.numbers.copy(), state.integers.copy(), state.order.copy()
    road.step(state)
    assert all(
        (a == b).all() for a, b in zip(before, (state.numbers, state.integers, state.order), strict=True)
    )


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"length_m": 0.0}, "length_m"),
        ({"density_per_km": -1.0}, "density_per_km"),
        ({"density_per_km": 0.1}, "no vehicle"),
        ({"lanes": 0}, "lanes"),
        ({"form": "round"}, "form"),
        ({"form": "ring", "length_m": 200.0}, "too tight"),
        ({"lane_change_s": float("nan")}, "lane_change_s"),
    ],
)
def test_impossible_roads_are_refused(change: dict[str, object], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        Highway(**change)  # type: ignore[arg-type]


def test_more_vehicles_than_room_are_refused() -> None:
    with pytest.raises(ValueError, match="do not fit"):
        Highway(1000.0, 1200.0, lanes=3).init(np.random.default_rng(0))


@pytest.mark.parametrize(
    "change", [{"headway_s": (2.0, 1.0)}, {"gap_m": 0.0}, {"truck_ratio": 1.5}, {"wander_m": -0.1}]
)
def test_impossible_drivers_are_refused(change: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=next(iter(change))):
        Drivers(**change)  # type: ignore[arg-type]
