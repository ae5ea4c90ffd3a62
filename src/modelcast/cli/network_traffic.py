"""The traffic of one run of ``modelcast network``: frames from a scenario, SUMO, or recordings."""

import functools
import tempfile
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from modelcast.cli.network_plan import BUILT_IN, SUMO, NetworkPlan
from modelcast.core.chance import child_generator
from modelcast.core.kinds import Kind
from modelcast.io.fcd_survey import FcdSurvey
from modelcast.io.traffic_survey import TrafficSurvey
from modelcast.study.network.rows import NetworkCase
from modelcast.study.network.simulate import traffic_chance
from modelcast.trips.trajectory import Trajectory
from modelcast.world.scenario.base import STEP_S, AbstractScenario, FleetFrame, run_scenario
from modelcast.world.scenario.braking import BrakingStreams
from modelcast.world.scenario.grid import Grid
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.joined import Joined
from modelcast.world.scenario.laid_tracks import crossings_of, laid_tracks
from modelcast.world.scenario.library import TripRoad
from modelcast.world.scenario.peopled_grid import PeopledGrid
from modelcast.world.scenario.recorded import Replay
from modelcast.world.scenario.resampling import resampled

if TYPE_CHECKING:
    from modelcast.io.sumo import SumoSurvey
    from modelcast.io.sumo_config import SumoConfig

__all__ = [
    "BLOCK_M",
    "CROSSING_MISJUDGED_RATIO",
    "CROSSING_STRAIGHT_RATIO",
    "CUT_INS_PER_MINUTE",
    "sumo_survey",
    "traffic",
]

BLOCK_M = 200.0
"""Distance between the junctions of a grid [m]."""

CUT_INS_PER_MINUTE = 20.0
"""Of the scenario ``cut-in``, on the whole road [1/min]."""

CROSSING_STRAIGHT_RATIO, CROSSING_MISJUDGED_RATIO = 0.8, 0.5
"""Of the scenario ``crossing``: who goes straight on, and who misjudges."""

_MOST_SUMO_VEHICLES = 1.6
"""Slots for SUMO's traffic over the vehicles that the density asks for: what flows in varies."""


@contextmanager
def traffic(
    plan: NetworkPlan, case: NetworkCase, found: TrafficSurvey | None = None
) -> Generator[Iterator[FleetFrame]]:
    """The traffic of one run; all policies and radios of a seed and density meet the same.

    Parameters
    ----------
    plan
        What all runs share.
    case
        The run. Of several platoons, runs take one each in turn.
    found
        What the traffic's file holds, where it is one and that is known already.

    Raises
    ------
    ModelcastError
        Where a file is not what it should be, or SUMO refuses its input.
    ValueError
        Where vehicles do not fit on the road, or no trip can be used.
    """
    rng = traffic_chance(plan.seed, case.run)
    if plan.scenario in BUILT_IN:
        scenario = _built_in(plan, case.density_per_km)
        if plan.tracks:
            scenario = Joined(scenario, _laid_tracks(plan, case))
        yield run_scenario(scenario, rng, duration_s=plan.duration_s)
    elif plan.scenario in SUMO:
        with tempfile.TemporaryDirectory(prefix="modelcast-") as name:
            yield _sumo_frames(plan, case, Path(name))
    elif plan.scenario == "platoon":
        platoon = _platoon(plan.trips[case.run % len(plan.trips)])
        lasts_s = min(plan.duration_s, platoon.duration_s)
        yield run_scenario(platoon, rng, duration_s=lasts_s)
    elif plan.scenario == "trips":
        lanes = plan.lanes_for(case.density_per_km)
        laid = TripRoad(_trips(plan.trips), plan.length_m, case.density_per_km, lanes=lanes)
        yield run_scenario(laid, rng, duration_s=plan.duration_s)
    elif plan.from_sumo_config:
        yield _configured_frames(plan, case)
    else:
        from modelcast.io.fcd import read_fcd

        known = found if isinstance(found, FcdSurvey) else None
        frames = resampled(read_fcd(plan.scenario, found=known, people=plan.persons), STEP_S)
        yield takewhile(lambda frame: frame.t_s < plan.duration_s, frames)


def _built_in(plan: NetworkPlan, density_per_km: float) -> AbstractScenario[Any]:
    """The scenario of a name of `BUILT_IN`."""
    lanes = plan.lanes_for(density_per_km)
    if plan.scenario in {"highway", "loaded"}:
        return Highway(plan.length_m, density_per_km, lanes=lanes)
    if plan.scenario == "braking":
        return BrakingStreams(plan.length_m, density_per_km, lanes=lanes)
    if plan.scenario == "cut-in":
        return BrakingStreams(
            plan.length_m,
            density_per_km,
            lanes=lanes,
            brakings_per_minute=0.0,
            cut_ins_per_minute=CUT_INS_PER_MINUTE,
        )
    grid = _grid(plan, density_per_km)
    return PeopledGrid(grid, plan.pedestrians, plan.cyclists) if plan.has_people else grid


def _grid(plan: NetworkPlan, density_per_km: float) -> Grid:
    """The streets and vehicles of a scenario of `PEOPLED`."""
    if plan.scenario == "grid":
        return Grid(plan.blocks, plan.blocks, density_per_km, block_m=BLOCK_M)
    return Grid(
        plan.blocks,
        plan.blocks,
        density_per_km,
        block_m=BLOCK_M,
        junctions="priority",
        straight_ratio=CROSSING_STRAIGHT_RATIO,
        misjudged_ratio=CROSSING_MISJUDGED_RATIO,
    )


def _laid_tracks(plan: NetworkPlan, case: NetworkCase) -> Replay:
    """Recorded tracks of people over the crossings of the grid, each run in a way of its own."""
    on_foot, riding = _trips(plan.pedestrian_tracks), _trips(plan.cyclist_tracks)
    return laid_tracks(
        (*on_foot, *riding),
        [*(Kind.PEDESTRIAN for _ in on_foot), *(Kind.CYCLIST for _ in riding)],
        crossings_of(_grid(plan, case.density_per_km)),
        rng=child_generator(plan.seed, case.run, "tracks"),
        duration_s=plan.duration_s,
    )


@functools.lru_cache(maxsize=8)
def _platoon(path: str) -> Replay:
    """The cars of an OpenACC file; a process reads it once."""
    from modelcast.io.openacc import read_platoon

    return read_platoon(path)


@functools.lru_cache(maxsize=2)
def _trips(paths: tuple[str, ...]) -> tuple[Trajectory, ...]:
    """The trips of all files; a process reads them once."""
    from modelcast.io.trips import read_trips

    return tuple(read_trips(paths)) if paths else ()


@functools.lru_cache(maxsize=32)
def _survey(
    path: str, seed: int, *, duration_s: float, lead_in_s: float, people: bool
) -> tuple["SumoConfig", "SumoSurvey"]:
    """A configuration and what its run of that seed holds; a process runs it once for this."""
    from modelcast.io.sumo import survey_sumo
    from modelcast.io.sumo_config import read_sumo_config

    source = read_sumo_config(path)
    found = survey_sumo(source, duration_s=duration_s, seed=seed, warm_up_s=lead_in_s, people=people)
    return source, found


def _configured(plan: NetworkPlan, seed: int) -> tuple["SumoConfig", "SumoSurvey"]:
    return _survey(
        plan.scenario, seed, duration_s=plan.duration_s, lead_in_s=plan.lead_in_s, people=plan.persons
    )


def sumo_survey(plan: NetworkPlan, seed: int) -> "SumoSurvey":
    """What a run of a configuration of SUMO holds.

    Parameters
    ----------
    plan
        It names the configuration.
    seed
        SUMO's.

    Raises
    ------
    ModelcastError
        Where SUMO refuses it.
    """
    return _configured(plan, seed)[1]


def _configured_frames(plan: NetworkPlan, case: NetworkCase) -> Iterator[FleetFrame]:
    """The traffic of a configuration of SUMO, run with a seed of the case's own."""
    from modelcast.io.sumo import run_sumo

    source, found = _configured(plan, plan.seed + case.run)
    return run_sumo(
        source,
        slots=found.most,
        duration_s=plan.duration_s,
        seed=found.seed,
        warm_up_s=plan.lead_in_s,
        people=plan.persons,
    )


def _sumo_frames(plan: NetworkPlan, case: NetworkCase, folder: Path) -> Iterator[FleetFrame]:
    from modelcast.io.sumo import run_sumo
    from modelcast.io.sumo_roads import grid_input, highway_input, junction_input

    seed, lasts_s = plan.seed + case.run, plan.duration_s + 60.0
    density = case.density_per_km
    if plan.scenario == "sumo-highway":
        source = highway_input(
            folder, length_m=plan.length_m, density_per_km=density, lanes=plan.lanes_for(density), seed=seed,
            duration_s=lasts_s,
        )  # fmt: skip
        vehicles = density * plan.length_m / 1000.0
    elif plan.scenario == "sumo-grid":
        source = grid_input(
            folder, columns=plan.blocks, rows=plan.blocks, density_per_km=density, block_m=BLOCK_M,
            seed=seed, duration_s=lasts_s,
        )  # fmt: skip
        vehicles = density * 2.0 * plan.blocks * (plan.blocks - 1) * BLOCK_M / 1000.0
    else:
        source = junction_input(folder, seed=seed, duration_s=lasts_s)
        vehicles = 200.0
    slots = int(_MOST_SUMO_VEHICLES * vehicles) + 50
    return run_sumo(source, slots=slots, duration_s=plan.duration_s, seed=seed, warm_up_s=30.0)
