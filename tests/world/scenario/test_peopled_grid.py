"""Claims about people in a grid."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.geodesy import heading_to_velocity, wrap_angle_rad
from modelcast.core.kinds import Kind
from modelcast.world.encounters import near_pairs
from modelcast.world.scenario import people_arrays as walking
from modelcast.world.scenario import town_arrays as arrays
from modelcast.world.scenario.base import STEP_S, FleetFrame, run_scenario
from modelcast.world.scenario.footways import KERB_M, STREET_HALF_M, make_footways
from modelcast.world.scenario.grid import Grid
from modelcast.world.scenario.motion import checked
from modelcast.world.scenario.people import Pedestrians
from modelcast.world.scenario.peopled_grid import PeopledGrid, PeopledState

BLOCK_M = 200.0
PRIORITY = Grid(3, 3, 20.0, junctions="priority", straight_ratio=0.8, misjudged_ratio=0.5, warm_up_s=30.0)
SIGNALS = Grid(3, 3, 20.0, warm_up_s=30.0)
DURATION_S = 150.0
WALKS_MPS = 0.5
"""Above the speed of who stops or sets off."""


def walked(scenario: PeopledGrid, seed: int) -> tuple[list[PeopledState], list[FleetFrame]]:
    states = [scenario.init(np.random.default_rng(seed))]
    for _ in range(round(DURATION_S / STEP_S) - 1):
        states.append(scenario.step(states[-1]))
    return states, [scenario.frame(state) for state in states]


@pytest.fixture(scope="module", name="towns")
def _towns() -> list[tuple[PeopledGrid, list[PeopledState], list[FleetFrame]]]:
    found = []
    for seed, grid in enumerate((PRIORITY, SIGNALS)):
        scenario = PeopledGrid(grid, 120, 40, who=Pedestrians(careless_ratio=0.5))
        found.append((scenario, *walked(scenario, seed)))
    return found


def touching(frame: FleetFrame, one: IntArray, other: IntArray) -> BoolArray:
    """Whether rectangles overlap, by separating axes, (N,)."""
    assert frame.width_m is not None
    apart = (frame.position_m[other] - frame.position_m[one]).T
    found = np.ones(one.size, dtype=np.bool_)
    for slots in (one, other):
        for quarter in (0.0, np.pi / 2):
            axis = frame.heading_rad[slots] + quarter
            reach: FloatArray = np.zeros(one.size)
            for who in (one, other):
                turn = axis - frame.heading_rad[who]
                reach += 0.5 * frame.length_m[who] * np.abs(np.cos(turn))
                reach += 0.5 * frame.width_m[who] * np.abs(np.sin(turn))
            found &= np.abs(apart[0] * np.sin(axis) + apart[1] * np.cos(axis)) < reach
    return found


def test_nobody_is_inside_a_vehicle(towns):
    """Also where half of them are careless, and drivers misjudge gaps."""
    close = 0
    for _, _, frames in towns:
        for frame in frames[::2]:
            one, other = near_pairs(frame.position_m, frame.active, 6.0)
            mixed = (frame.kind[one] == Kind.VEHICLE) & (frame.kind[other] != Kind.VEHICLE)
            close += int(mixed.sum())
            assert not touching(frame, one[mixed], other[mixed]).any()
    assert close > 1000, "people and vehicles do meet"


def test_nobody_is_inside_a_building(towns):
    for _, _, frames in towns:
        for frame in frames[::5]:
            aside = np.abs(frame.position_m - BLOCK_M * np.round(frame.position_m / BLOCK_M))
            assert (aside.min(axis=1) < STREET_HALF_M).all()


def test_nobody_jumps_and_columns_are_derivatives_of_each_other(towns):
    for _, _, frames in towns:
        list(checked(iter(frames)))
        for before, after in pairwise(frames):
            people = after.kind != Kind.VEHICLE
            mean = 0.5 * (
                heading_to_velocity(before.speed_mps, before.heading_rad)
                + heading_to_velocity(after.speed_mps, after.heading_rad)
            )
            off = np.hypot(*((after.position_m - before.position_m) / STEP_S - mean)[people].T)
            assert off.max() < 0.55, "a last step to a kerb or a corner, no more"
            assert np.quantile(off, 0.99) < 0.4
            turned = np.abs(wrap_angle_rad(after.heading_rad - before.heading_rad))[people]
            assert turned.max() < 0.31, "3 rad/s"


def test_pedestrians_turn_only_where_they_stand(towns):
    for _, _, frames in towns:
        for before, after in pairwise(frames[:600]):
            on_foot = after.kind == Kind.PEDESTRIAN
            turned = np.abs(wrap_angle_rad(after.heading_rad - before.heading_rad)) > 1e-9
            assert not after.speed_mps[on_foot & turned].any()


def test_free_walking_speeds_are_weidmanns(towns):
    traits = Pedestrians().draw(20_000, np.random.default_rng(1))
    assert traits[0].mean() == pytest.approx(1.34, abs=0.01)
    assert traits[0].std() == pytest.approx(0.26, abs=0.01)
    for scenario, states, frames in towns:
        first = scenario.grid.slots
        speed = np.array([frame.speed_mps[first : first + 120] for frame in frames])
        fastest = np.quantile(np.where(speed > WALKS_MPS, speed, np.nan), 0.5, axis=0)
        known = ~np.isnan(fastest)
        assert np.corrcoef(fastest[known], states[0].traits[0][known])[0, 1] > 0.8


def test_people_stop_at_the_kerb_and_cross(towns):
    """Who waits does so on the pavement, and people do cross."""
    for scenario, states, frames in towns:
        waited = np.array([state.walkers[walking.WAITED] for state in states])
        assert waited.max() > 3.0
        assert states[-1].stepped_out > 40
        assert 0 < states[-1].carelessly < states[-1].stepped_out
        waits = (waited > 1.0) & (np.array([state.walkers_at[walking.STAGE] for state in states]) == 0)
        first = scenario.grid.slots
        place = np.array([frame.position_m[first : first + 120] for frame in frames])
        aside = np.abs(place - BLOCK_M * np.round(place / BLOCK_M)).min(axis=2)
        assert (aside[waits] > KERB_M).all()


def test_with_signals_only_the_careless_step_out_at_red():
    careful = PeopledGrid(SIGNALS, 120, 0, who=Pedestrians(careless_ratio=0.0))
    state = careful.init(np.random.default_rng(2))
    stepped = 0
    for _ in range(1000):
        after = careful.step(state)
        now = (after.walkers_at[walking.STAGE] == 1) & (state.walkers_at[walking.STAGE] == 0)
        streets = SIGNALS.streets
        for walker in np.flatnonzero(now):
            junction = int(after.walkers_at[walking.NODE, walker]) // 4
            link = int(streets.approach[junction].max())
            cycle_s = streets.cycle_s[link] + 19.0
            at = (state.grid.number * STEP_S + state.grid.offset_s[link]) % cycle_s
            assert cycle_s - 19.0 <= at < cycle_s - 12.0
            stepped += 1
        state = after
    assert stepped > 10
    assert state.carelessly == 0


def test_careless_people_make_vehicles_brake():
    """The hardest decelerations of traffic are those for people who step out."""
    hardest: list[float] = []
    for ratio in (0.0, 1.0):
        scenario = PeopledGrid(
            replace(PRIORITY, misjudged_ratio=0.0), 150, 0, who=Pedestrians(careless_ratio=ratio)
        )
        frames = list(run_scenario(scenario, np.random.default_rng(3), duration_s=120.0))
        vehicles = np.array([frame.acceleration_mps2[: scenario.grid.slots] for frame in frames])
        hardest.append(float((vehicles < -2.0).mean()))
    assert hardest[1] > 1.5 * hardest[0]


def test_cyclists_keep_beside_the_lanes_and_wait_at_junctions(towns):
    for _, states, frames in towns:
        for state, frame in zip(states[::10], frames[::10], strict=True):
            riding = np.flatnonzero(frame.kind == Kind.CYCLIST)
            on_link = state.riders[arrays.S] > 0.0
            place = frame.position_m[riding]
            aside = np.abs(place - BLOCK_M * np.round(place / BLOCK_M)).min(axis=1)[on_link]
            assert ((aside > 3.6) & (aside < KERB_M)).all()
        waited = np.array([state.waited_s for state in states])
        assert waited.max() > 2.0
        speed = np.array([frame.speed_mps[frame.kind == Kind.CYCLIST] for frame in frames])
        assert (speed.max(axis=0) > 2.0).all(), "nobody waits for ever"
        assert 4.0 < np.median(speed[speed > 3.0]) < 7.0


def test_one_seed_gives_the_same_bytes():
    scenario = PeopledGrid(PRIORITY, 20, 10)
    first, again = (
        list(run_scenario(scenario, np.random.default_rng(5), duration_s=3.0))[-1] for _ in range(2)
    )
    assert first.position_m.tobytes() == again.position_m.tobytes()
    other = list(run_scenario(scenario, np.random.default_rng(6), duration_s=3.0))[-1]
    assert first.position_m.tobytes() != other.position_m.tobytes()


def test_footways_lead_there_and_back_and_cross_both_lanes_of_an_arm():
    ways = make_footways(SIGNALS.streets, columns=3, rows=3, block_m=BLOCK_M)
    for corner in range(len(ways.corner_m)):
        for direction in range(4):
            target = int(ways.onto[corner, direction])
            if target < 0:
                continue
            step = ways.corner_m[target] - ways.corner_m[corner]
            along = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)][direction]) * ways.length_m[corner, direction]
            assert step == pytest.approx(along)
            assert ways.onto[target, (direction + 2) % 4] == corner
            there, back = ways.lanes[corner, direction], ways.lanes[target, (direction + 2) % 4]
            np.testing.assert_array_equal(there, back[[2, 3, 0, 1]])
    crossed = ways.lanes[ways.lanes[:, :, 1] >= 0]
    assert len(crossed) == 4 * SIGNALS.streets.direction.size // 2
    for link in range(SIGNALS.streets.direction.size):
        assert ((crossed[:, [1, 3]] == link).sum(axis=1) == 1).sum() == 4, "two ways each, at both ends"


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: PeopledGrid(SIGNALS, 0, 0), "at least one"),
        (lambda: PeopledGrid(SIGNALS, -1, 5), "at least one"),
        (lambda: PeopledGrid(Grid(3, 3, 20.0, junction_m=20.0)), "junction_m"),
        (lambda: Pedestrians(0.0), "speed_mps"),
        (lambda: Pedestrians(careless_ratio=1.5), "careless_ratio"),
        (lambda: Pedestrians(patience_s=(5.0, 1.0)), "patience_s"),
        (lambda: Pedestrians(aside_m=4.0), "aside_m"),
    ],
)
def test_impossible_people_are_refused(make, match: str):
    with pytest.raises(ValueError, match=match):
        make()
