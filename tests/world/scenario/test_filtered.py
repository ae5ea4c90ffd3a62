"""Claims about what a fleet makes of what it sees."""

import numpy as np
import pytest

from modelcast.station.sensing.motion_filter import MotionFilter
from modelcast.world.scenario.base import FleetFrame, run_scenario
from modelcast.world.scenario.filtered import FleetFilter
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import sensed
from modelcast.world.sensors import SensorModel


def estimates(seconds: float) -> list[tuple[FleetFrame, FleetFrame, FleetFrame]]:
    """Truth, samples and estimates of a short road, which vehicles leave and enter."""
    road = Highway(200.0, 60.0, warm_up_s=10.0)
    frames = run_scenario(road, np.random.default_rng(1), duration_s=seconds)
    fleet = FleetFilter(MotionFilter())
    state = fleet.init(road.slots)
    rows: list[tuple[FleetFrame, FleetFrame, FleetFrame]] = []
    for truth, seen in sensed(frames, SensorModel(), np.random.default_rng(2)):
        shown, state = fleet.estimate(state, seen)
        rows.append((truth, seen, shown))
    return rows


def test_estimates_are_nearer_to_the_truth_and_new_vehicles_begin_anew() -> None:
    rows = estimates(12.0)
    missed = np.array([np.hypot(*(s.position_m - t.position_m).T) for t, s, _ in rows])
    off = np.array([np.hypot(*(e.position_m - t.position_m).T) for t, _, e in rows])
    identity = np.array([t.vehicle_id for t, _, _ in rows])
    new = identity[1:] != identity[:-1]
    assert new.any()
    assert np.array_equal(off[1:][new], missed[1:][new])
    assert np.sqrt((off[10:] ** 2).mean()) < 0.75 * np.sqrt((missed[10:] ** 2).mean())


def test_a_frame_of_another_size_or_time_is_refused() -> None:
    truth = estimates(0.1)[0][0]
    fleet = FleetFilter(MotionFilter())
    with pytest.raises(ValueError, match="slots"):
        fleet.estimate(fleet.init(3), truth)
    _, state = fleet.estimate(fleet.init(len(truth)), truth)
    with pytest.raises(ValueError, match="later"):
        fleet.estimate(state, truth)
