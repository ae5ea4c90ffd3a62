"""Claims about the Manhattan grid."""

from itertools import pairwise

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import heading_to_velocity, wrap_angle_rad
from modelcast.world.scenario.base import STEP_S, FleetFrame, run_scenario
from modelcast.world.scenario.grid import Grid
from modelcast.world.scenario.streets import make_streets, turn_curve

TRAPEZOID_MPS = 0.05
"""A step's mean velocity against that of its ends, in a turn and at a stop."""


@pytest.fixture(scope="module", name="frames")
def _frames() -> list[FleetFrame]:
    return list(run_scenario(Grid(4, 4, 30.0), np.random.default_rng(1), duration_s=180.0))


def column(frames: list[FleetFrame], name: str) -> FloatArray:
    return np.array([getattr(frame, name) for frame in frames])


def test_columns_are_derivatives_of_each_other(frames: list[FleetFrame]) -> None:
    velocity = heading_to_velocity(column(frames, "speed_mps"), column(frames, "heading_rad"))
    moved = np.diff(column(frames, "position_m"), axis=0) / STEP_S
    assert np.abs(moved - 0.5 * (velocity[1:] + velocity[:-1])).max() < TRAPEZOID_MPS
    turned = wrap_angle_rad(np.diff(column(frames, "heading_rad"), axis=0))
    rate = column(frames, "yaw_rate_radps")
    assert np.abs(turned - 0.5 * STEP_S * (rate[1:] + rate[:-1])).max() < 1e-3


def test_turns_are_smooth_and_driven_at_a_bearable_speed(frames: list[FleetFrame]) -> None:
    across = column(frames, "speed_mps") * column(frames, "yaw_rate_radps")
    assert 2.0 < np.abs(across).max() < 4.5
    assert np.sqrt(((np.diff(across, axis=0) / STEP_S) ** 2).mean()) < 0.5
    assert np.abs(np.diff(column(frames, "yaw_rate_radps"), axis=0)).max() < 0.12


def test_driving_is_gentle(frames: list[FleetFrame]) -> None:
    jerk = np.diff(column(frames, "acceleration_mps2"), axis=0) / STEP_S
    assert np.sqrt((jerk**2).mean()) < 1.0
    assert column(frames, "acceleration_mps2").min() > -6.0


def test_cars_stop_at_signals_and_all_of_them_get_on(frames: list[FleetFrame]) -> None:
    speed = column(frames, "speed_mps")
    assert 0.1 < (speed < 0.1).mean() < 0.7
    assert (speed.max(axis=0) > 3.0).all()


@pytest.mark.parametrize("density", [30.0, 100.0])
def test_nobody_collides_in_minutes(density: float) -> None:
    """Three discs stand for a car: their middles stay apart by its width."""
    frames = list(run_scenario(Grid(4, 4, density), np.random.default_rng(2), duration_s=180.0))
    for frame in frames[::20]:
        ahead = heading_to_velocity(np.ones(len(frame)), frame.heading_rad)
        discs = np.stack([frame.position_m + k * ahead for k in (-1.4, 0.0, 1.4)], axis=1)
        near = np.triu(
            np.hypot(*(frame.position_m[:, None] - frame.position_m[None]).transpose(2, 0, 1)) < 7.0, 1
        )
        for a, b in np.argwhere(near):
            assert np.hypot(*(discs[a][:, None] - discs[b][None]).transpose(2, 0, 1)).min() > 1.7


def test_one_seed_gives_the_same_bytes() -> None:
    grid = Grid(3, 3, 30.0, warm_up_s=5.0)
    first, again = (list(run_scenario(grid, np.random.default_rng(5), duration_s=3.0)) for _ in range(2))
    assert first[-1].position_m.tobytes() == again[-1].position_m.tobytes()


def test_a_turn_ends_at_a_right_angle_and_is_as_long_as_its_points_are_apart() -> None:
    length_m, points = turn_curve(12.0)
    assert points[-1] == pytest.approx([12.0, 12.0, np.pi / 2])
    assert np.hypot(*np.diff(points[:, :2], axis=0).T).sum() == pytest.approx(length_m, rel=1e-3)


def test_approaches_of_a_junction_are_never_green_together() -> None:
    streets = make_streets(3, 3, block_m=200.0, junction_m=15.0, green_s=12.0)
    for junction in range(9):
        links = np.flatnonzero(streets.ends == junction)
        starts = np.sort(streets.green_start_s[links])
        assert all(b - a >= 12.0 + 5.0 for a, b in pairwise(starts))
        assert streets.cycle_s[links[0]] - starts[-1] >= 17.0


def test_nobody_makes_a_u_turn_or_leaves() -> None:
    streets = make_streets(3, 4, block_m=200.0, junction_m=15.0, green_s=12.0)
    assert (streets.follower >= 0).any(axis=1).all()
    for link, following in enumerate(streets.follower):
        for kind, turn in enumerate((0, 1, -1)):
            if following[kind] >= 0:
                expected = (streets.direction[link] + turn) % 4
                assert streets.direction[following[kind]] == expected


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"columns": 1}, "columns"),
        ({"density_per_km": 1000.0}, "density_per_km"),
        ({"junction_m": 2.0}, "junction_m"),
        ({"green_s": 0.0}, "green_s"),
    ],
)
def test_impossible_grids_are_refused(change: dict[str, float], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        Grid(**change)  # type: ignore[arg-type]
