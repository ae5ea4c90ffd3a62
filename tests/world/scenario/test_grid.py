"""Claims about the Manhattan grid."""

from itertools import pairwise

import numpy as np
import pytest

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.geodesy import heading_to_velocity, wrap_angle_rad
from modelcast.world.encounters import near_pairs
from modelcast.world.scenario import town_arrays as arrays
from modelcast.world.scenario.base import STEP_S, FleetFrame, run_scenario
from modelcast.world.scenario.grid import Grid, GridState
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


def rectangles(frame: FleetFrame) -> FloatArray:
    """Rows east, north, heading and length of all vehicles, (4, V)."""
    return np.stack([*frame.position_m.T, frame.heading_rad, frame.length_m])


def touching(one: FloatArray, other: FloatArray) -> BoolArray:
    """Whether rectangles of 1.8 m width overlap, by separating axes; rows as of `rectangles`, (4, N)."""
    apart = other[:2] - one[:2]
    axes = [(np.sin(h), np.cos(h)) for h in (one[2], one[2] + np.pi / 2, other[2], other[2] + np.pi / 2)]
    halves = (0.5 * one[3], 0.9, 0.5 * other[3], 0.9)
    found = np.ones(one.shape[1], dtype=np.bool_)
    for east, north in axes:
        reach = sum(h * np.abs(e * east + n * north) for h, (e, n) in zip(halves, axes, strict=True))
        found &= np.abs(apart[0] * east + apart[1] * north) < reach
    return found


def encroachments(states: list[GridState], frames: list[FleetFrame], lag: int, every: int) -> IntArray:
    """Where a vehicle is where one on a crossing way is ``lag`` steps later: step and both, (N, 3)."""
    found: list[IntArray] = []
    for n in range(0, len(frames) - lag, every):
        first, second, slots = frames[n], frames[n + lag], len(frames[n])
        both = np.concatenate([first.position_m, second.position_m])
        a, b = near_pairs(both, np.ones(2 * slots, dtype=np.bool_), 6.0)
        across = (a < slots) & (b >= slots) & (b - slots != a)
        a, b = a[across], b[across] - slots
        came, came_then = (states[m].integers[arrays.CAME_FROM] for m in (n, n + lag))
        turned = np.abs(wrap_angle_rad(first.heading_rad[a] - second.heading_rad[b]))
        crossing = (came[a] != came_then[b]) & (turned > 0.5)
        a, b = a[crossing], b[crossing]
        hit = touching(rectangles(first)[:, a], rectangles(second)[:, b])
        found.append(np.stack([np.full(hit.sum(), n), a[hit], b[hit]], axis=1))
    return np.concatenate(found)


def driven(grid: Grid, duration_s: float, seed: int) -> tuple[list[GridState], list[FleetFrame]]:
    states = [grid.init(np.random.default_rng(seed))]
    for _ in range(round(duration_s / STEP_S) - 1):
        states.append(grid.step(states[-1]))
    return states, [grid.frame(state) for state in states]


@pytest.mark.slow
@pytest.mark.parametrize(("density", "straight"), [(20.0, 0.8), (35.0, 0.5)])
def test_with_priority_nobody_comes_within_a_second_of_another_way(density: float, straight: float) -> None:
    grid = Grid(5, 5, density, junctions="priority", straight_ratio=straight, warm_up_s=60.0)
    states, frames = driven(grid, 180.0, 1)
    for lag in (0, 3, 6, 9):
        assert not encroachments(states, frames, lag, 2).size
    assert states[-1].crossings > 60
    assert states[-1].misjudged == 0
    speed = column(frames, "speed_mps")
    assert (speed.max(axis=0) > 3.0).mean() > 0.9, "hardly anybody waits for minutes"


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_who_misjudges_crosses_within_a_second_of_another_and_touches_nobody(seed: int) -> None:
    """Post-encroachment times under 1 s, by rectangles and not by the rule: one an entry, give or take."""
    grid = Grid(6, 6, 15.0, junctions="priority", straight_ratio=0.8, misjudged_ratio=1.0, warm_up_s=60.0)
    states, frames = driven(grid, 240.0, seed)
    runs = np.array([state.runs for state in states])
    entries = ((runs[1:] == 1) & (runs[:-1] == 0)).sum()
    assert entries == states[-1].misjudged > 20
    assert not encroachments(states, frames, 0, 1).size
    conflicts: set[tuple[int, int]] = set()
    for lag in (1, 3, 5, 7, 9, 10):
        for n, a, b in encroachments(states, frames, lag, 1):
            assert runs[n, a] == 1 or runs[n + lag, b] == 1, "only who misjudges comes close"
            conflicts.add((min(a, b), max(a, b)))
    assert 0.75 * entries <= len(conflicts) <= 1.25 * entries


def test_the_share_that_runs_red_is_the_one_asked_for() -> None:
    """Of those who come to a signal in its first seconds of red: none, half of them, all."""
    found: list[float] = []
    for ratio in (0.0, 0.5, 1.0):
        grid = Grid(4, 4, 20.0, misjudged_ratio=ratio)
        state = grid.init(np.random.default_rng(4))
        for _ in range(3000):
            state = grid.step(state)
        found.append(state.misjudged / state.crossings)
    assert found[0] == 0.0
    assert found[2] > 0.04
    assert found[1] == pytest.approx(0.5 * found[2], rel=0.5)


def test_ways_that_conflict_are_those_that_cross_or_meet() -> None:
    """[quarter turns anticlockwise to the other's direction, own move, other's move]."""
    conflicts = make_streets(3, 3, block_m=200.0, junction_m=15.0, green_s=12.0).conflicts
    straight, left, right = range(3)
    assert not conflicts[0].any(), "who comes the same way follows"
    assert conflicts[2, straight, left]
    assert conflicts[2, left, straight]
    assert conflicts[2, left, right], "both leave by the same street"
    assert not conflicts[2, straight, straight]
    assert not conflicts[2, left, left]
    assert conflicts[1, straight, straight]
    assert conflicts[3, straight, straight]
    assert not conflicts[1, right].any(), "a right turn does not touch the way of who comes from the right"
    assert conflicts[3, right, straight], "but meets who comes straight on from the left"
    for turns in range(1, 4):
        assert (conflicts[turns] == conflicts[4 - turns].T).all()


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
        ({"junctions": "roundabout"}, "junctions"),
        ({"misjudged_ratio": 1.1}, "misjudged_ratio"),
        ({"straight_ratio": 1.0}, "straight_ratio"),
    ],
)
def test_impossible_grids_are_refused(change: dict[str, object], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        Grid(**change)  # type: ignore[arg-type]
