"""The contract of scenarios, over all of them."""

import copy
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from modelcast.core.kinds import Kind
from modelcast.world.drive import generate_drive
from modelcast.world.scenario.base import NOBODY, STEP_S, AbstractScenario, run_scenario
from modelcast.world.scenario.braking import BrakingStreams
from modelcast.world.scenario.grid import Grid
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.joined import Joined
from modelcast.world.scenario.laid_tracks import crossings_of, laid_tracks
from modelcast.world.scenario.library import TripRoad
from modelcast.world.scenario.peopled_grid import PeopledGrid
from modelcast.world.scenario.recorded import make_replay

DRIVES = [generate_drive(seed, 90.0).truth for seed in (1, 2)]
SCENARIOS: dict[str, AbstractScenario[Any]] = {
    "straight": Highway(800.0, 60.0, warm_up_s=5.0),
    "ring": Highway(800.0, 60.0, form="ring", warm_up_s=5.0),
    "one lane, one way": Highway(800.0, 10.0, lanes=1, both_directions=False, warm_up_s=5.0),
    "braking": BrakingStreams(800.0, 60.0, brakings_per_minute=60.0, warm_up_s=5.0),
    "cut-ins": BrakingStreams(800.0, 60.0, cut_ins_per_minute=60.0, warm_up_s=5.0),
    "grid": Grid(3, 3, 25.0, warm_up_s=5.0),
    "grid with priority": Grid(3, 3, 25.0, junctions="priority", misjudged_ratio=0.5, warm_up_s=5.0),
    "grid with people": PeopledGrid(Grid(3, 3, 25.0, warm_up_s=5.0), 30, 20),
    "tracks of people beside a road": Joined(
        Highway(800.0, 20.0, warm_up_s=5.0),
        laid_tracks(
            DRIVES,
            [Kind.PEDESTRIAN, Kind.CYCLIST],
            crossings_of(Grid(2, 2, 20.0)),
            rng=np.random.default_rng(1),
            duration_s=60.0,
        ),
    ),
    "replay": make_replay(DRIVES, [0.0, 1.0]),
    "library": TripRoad(DRIVES, 600.0, 50.0),
}


@pytest.fixture(name="scenario", params=SCENARIOS.values(), ids=SCENARIOS)
def _scenario(request: pytest.FixtureRequest) -> AbstractScenario[Any]:
    scenario: AbstractScenario[Any] = request.param
    return scenario


def test_frames_have_the_promised_shapes_times_and_ranges(scenario: AbstractScenario[Any]) -> None:
    frames = list(run_scenario(scenario, np.random.default_rng(1), duration_s=15.0))
    assert len(frames) == 150
    for number, frame in enumerate(frames):
        assert frame.t_s == round(number * STEP_S, 6)
        assert len(frame) == scenario.slots
        assert frame.position_m.flags.c_contiguous
        assert frame.vehicle_id.dtype == np.int64
        assert frame.active.dtype == np.bool_
        for name in ("position_m", "speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps"):
            column = getattr(frame, name)
            assert column.dtype == np.float64
            assert np.isfinite(column).all()
            assert not column[~frame.active].any()
        assert frame.speed_mps.min() >= 0.0
        assert (np.abs(frame.heading_rad) <= np.pi).all()
        assert (frame.length_m[frame.active] > 0.0).all()


def test_identifiers_are_unique_and_never_used_again(scenario: AbstractScenario[Any]) -> None:
    frames = list(run_scenario(scenario, np.random.default_rng(1), duration_s=20.0))
    slot_of: dict[int, int] = {}
    before: set[int] = set()
    gone: set[int] = set()
    for frame in frames:
        assert ((frame.vehicle_id == NOBODY) == ~frame.active).all()
        here = frame.vehicle_id[frame.active].tolist()
        assert len(set(here)) == len(here)
        gone |= before - set(here)
        assert not gone & set(here)
        before = set(here)
        for slot in np.flatnonzero(frame.active):
            assert slot_of.setdefault(int(frame.vehicle_id[slot]), int(slot)) == slot


def test_a_state_may_be_stepped_again(scenario: AbstractScenario[Any]) -> None:
    """With the generator as it was, the same state leads to the same next state: nothing is hidden."""
    state = scenario.init(np.random.default_rng(3))
    again = copy.deepcopy(state)
    first = scenario.frame(scenario.step(state))
    scenario.step(scenario.step(state))
    second = scenario.frame(scenario.step(again))
    assert first.position_m.tobytes() == second.position_m.tobytes()
    assert first.vehicle_id.tobytes() == second.vehicle_id.tobytes()


def test_every_scenario_is_held_to_the_contract(
    concrete_classes: Callable[[type[Any]], set[type[Any]]],
) -> None:
    assert concrete_classes(AbstractScenario) == {type(scenario) for scenario in SCENARIOS.values()}
