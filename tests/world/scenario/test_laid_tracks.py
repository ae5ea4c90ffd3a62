"""Claims about recorded tracks over the crossings of a grid."""

import numpy as np
import pytest

from modelcast.core.kinds import CYCLIST_M, PEDESTRIAN_M, Kind
from modelcast.trips.trajectory import build_trajectory
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.grid import Grid
from modelcast.world.scenario.joined import Joined
from modelcast.world.scenario.laid_tracks import crossings_of, laid_tracks
from modelcast.world.scenario.recorded import Replay

TOWN = Grid(2, 2, 15.0, warm_up_s=1.0)


def track(turn_rad: float, speed_mps: float):
    """A straight track of 8 s with a small bow, far from any grid."""
    t_s = np.arange(0.0, 8.0, 0.1)
    along, aside = speed_mps * t_s, 0.3 * np.sin(np.pi * t_s / t_s[-1])
    place = np.stack(
        [
            along * np.sin(turn_rad) + aside * np.cos(turn_rad),
            along * np.cos(turn_rad) - aside * np.sin(turn_rad),
        ],
        axis=1,
    )
    return build_trajectory("f/1", t_s, place + np.array([5000.0, -300.0]), source="test")


@pytest.fixture(scope="module", name="replay")
def _replay() -> Replay:
    tracks = [track(0.4, 1.4), track(2.5, 4.0), track(-1.0, 1.1)]
    kinds = [Kind.PEDESTRIAN, Kind.CYCLIST, Kind.PEDESTRIAN]
    return laid_tracks(tracks, kinds, crossings_of(TOWN), rng=np.random.default_rng(2), duration_s=30.0)


def test_every_arm_has_a_crossing_in_both_directions():
    crossings = crossings_of(TOWN)
    assert len(crossings) == 2 * TOWN.streets.direction.size
    assert (np.abs(crossings[:, :2] - crossings[:, 2:]).sum(axis=1) == 11.5).all()


def test_tracks_lie_along_crossings_and_keep_their_shape_and_speed(replay):
    middles = crossings_of(TOWN)[:, :2]
    for slot, speed in enumerate((1.4, 4.0, 1.1)):
        here = replay.position_m[replay.active[:, slot], slot]
        chord = here[-1] - here[0]
        assert np.abs(chord).min() == pytest.approx(0.0, abs=0.05), "along a street"
        assert np.hypot(*(middles - 0.5 * (here[0] + here[-1])).T).min() < 0.3
        assert np.hypot(*chord) == pytest.approx(speed * 7.9, rel=0.02)
        bow = np.abs(here - here[0])[:, int(np.argmin(np.abs(chord)))].max()
        assert bow == pytest.approx(0.3, abs=0.05)


def test_beside_a_grid_they_have_kinds_sizes_and_names_of_their_own(replay):
    frames = list(run_scenario(Joined(TOWN, replay), np.random.default_rng(3), duration_s=5.0))
    vehicles = TOWN.slots
    for frame in frames:
        assert frame.kind[:vehicles].max() == Kind.VEHICLE
        assert frame.kind[vehicles:].tolist() == [Kind.PEDESTRIAN, Kind.CYCLIST, Kind.PEDESTRIAN]
        named = frame.vehicle_id[frame.active]
        assert len(set(named.tolist())) == named.size
        here = frame.active[vehicles:]
        sizes = np.array([PEDESTRIAN_M, CYCLIST_M, PEDESTRIAN_M])
        np.testing.assert_array_equal(frame.length_m[vehicles:][here], sizes[here, 0])
        np.testing.assert_array_equal(frame.width_m[vehicles:], sizes[:, 1])


def test_no_track_is_refused():
    with pytest.raises(ValueError, match="at least one"):
        laid_tracks([], [], crossings_of(TOWN), rng=np.random.default_rng(1), duration_s=5.0)
