"""Claims about traffic by SUMO; they need the extra `sumo`."""

import importlib.util
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from modelcast.core.exceptions import ConfigError, MissingExtraError
from modelcast.core.geodesy import heading_to_velocity
from modelcast.io.sumo import run_sumo
from modelcast.io.sumo_roads import SumoInput, grid_input, highway_input, junction_input
from modelcast.world.scenario.base import STEP_S

INSTALLED = importlib.util.find_spec("libsumo") is not None and importlib.util.find_spec("sumo") is not None
needs_sumo = pytest.mark.skipif(not INSTALLED, reason="needs SUMO: pip install eclipse-sumo libsumo")

INPUTS = {
    "highway": lambda at: highway_input(at, length_m=900.0, density_per_km=60.0),
    "grid": lambda at: grid_input(at, columns=3, rows=3),
    "junction": lambda at: junction_input(at, flow_per_h=900.0),
}


@pytest.mark.skipif(INSTALLED, reason="SUMO is installed: nothing is missing")
def test_without_sumo_one_line_names_the_extra(tmp_path: Path) -> None:
    with pytest.raises(MissingExtraError, match="needs eclipse-sumo and libsumo: "):
        highway_input(tmp_path)


@needs_sumo
@pytest.mark.parametrize("make", INPUTS.values(), ids=INPUTS)
def test_vehicles_drive_as_their_columns_say(make: Callable[[Path], SumoInput], tmp_path: Path) -> None:
    frames = list(run_sumo(make(tmp_path), slots=150, duration_s=15.0, warm_up_s=10.0))
    assert [frame.t_s for frame in frames] == pytest.approx([k * STEP_S for k in range(150)])
    identity = np.array([frame.vehicle_id for frame in frames])
    there = np.array([frame.active for frame in frames])
    assert there.sum(axis=1).min() > 5
    same = (identity[1:] == identity[:-1]) & there[1:]
    velocity = np.array([heading_to_velocity(f.speed_mps, f.heading_rad) for f in frames])
    moved = np.diff(np.array([f.position_m for f in frames]), axis=0) / STEP_S
    error = np.abs(moved - 0.5 * (velocity[1:] + velocity[:-1])).max(axis=2)[same]
    assert np.median(error) < 0.05
    # lane geometry has corners, at which SUMO's vehicles turn in one step
    assert np.quantile(error, 0.98) < 1.0
    jerk = np.diff(np.array([f.acceleration_mps2 for f in frames]), axis=0)[same] / STEP_S
    assert np.sqrt((jerk**2).mean()) < 2.0


@needs_sumo
def test_one_seed_gives_the_same_frames(tmp_path: Path) -> None:
    source = junction_input(tmp_path)
    first, again = (list(run_sumo(source, slots=50, duration_s=5.0, warm_up_s=5.0, seed=7)) for _ in range(2))
    assert first[-1].position_m.tobytes() == again[-1].position_m.tobytes()


@needs_sumo
def test_the_density_of_the_highway_is_the_one_asked_for(tmp_path: Path) -> None:
    frame = next(run_sumo(highway_input(tmp_path, density_per_km=60.0), slots=300, duration_s=1.0))
    assert frame.active.sum() == pytest.approx(120, abs=6)


@needs_sumo
def test_too_few_slots_and_refused_networks_are_errors(tmp_path: Path) -> None:
    source = highway_input(tmp_path, length_m=400.0)
    with pytest.raises(ConfigError, match="slots"):
        list(run_sumo(source, slots=2, duration_s=1.0))
    with pytest.raises(ConfigError, match="at least 8 m"):
        highway_input(tmp_path, density_per_km=2000.0)
    with pytest.raises(ConfigError, match="refuse"):
        list(run_sumo(SumoInput(tmp_path / "none.xml", source.routes), slots=2, duration_s=1.0))
