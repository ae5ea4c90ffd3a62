"""Claims about trips played otherwise."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.study.training.playback import AS_RECORDED, Playback, play
from modelcast.trips.trajectory import Trajectory, build_trajectory

RADIUS_M, SPEED_MPS, COUNT = 50.0, 15.0, 151


def circle(gap_at: int | None = None) -> Trajectory:
    """A left turn at constant speed, with speed and heading."""
    t_s = 0.1 * np.arange(COUNT)
    if gap_at is not None:
        t_s[gap_at:] += 3.0
    angle = SPEED_MPS * t_s / RADIUS_M
    return build_trajectory(
        "made/1",
        t_s,
        RADIUS_M * np.column_stack([np.sin(angle), 1.0 - np.cos(angle)]),
        speed_mps=np.full(COUNT, SPEED_MPS),
        heading_rad=np.angle(np.exp(1j * (np.pi / 2 - angle))),
    )


def test_a_trip_as_recorded_is_the_very_trip() -> None:
    trip = circle()
    assert play(trip, AS_RECORDED) is trip


@given(stretch=st.floats(0.5, 2.0), backwards=st.booleans())
def test_a_circle_stays_a_circle_of_the_same_lateral_acceleration(stretch: float, backwards: bool) -> None:
    played = play(circle(), Playback(stretch, backwards))
    centre_m = np.array([0.0, RADIUS_M * stretch**2])
    off_m = played.position_m - centre_m
    assert np.hypot(*off_m.T) == pytest.approx(RADIUS_M * stretch**2, abs=1e-4)
    assert played.speed_mps == pytest.approx(SPEED_MPS * stretch)
    assert played.speed_mps is not None
    lateral_mps2 = played.speed_mps**2 / np.hypot(*off_m.T)
    assert lateral_mps2 == pytest.approx(SPEED_MPS**2 / RADIUS_M, rel=1e-5)
    moved_m = np.hypot(*np.diff(played.position_m, axis=0).T)
    assert moved_m / played.dt_s == pytest.approx(SPEED_MPS * stretch, rel=1e-3)


@given(stretch=st.floats(0.5, 2.0), backwards=st.booleans())
def test_the_heading_is_where_the_positions_go(stretch: float, backwards: bool) -> None:
    played = play(circle(), Playback(stretch, backwards))
    east, north = (played.position_m[2:] - played.position_m[:-2]).T
    assert played.heading_rad is not None
    off_rad = np.angle(np.exp(1j * (np.arctan2(east, north) - played.heading_rad[1:-1])))
    assert np.abs(off_rad).max() < 2e-3
    assert np.abs(played.heading_rad).max() <= np.pi


def test_twice_backwards_is_the_trip() -> None:
    trip = circle(gap_at=60)
    twice = play(play(trip, Playback(backwards=True)), Playback(backwards=True))
    assert twice.t_s == pytest.approx(trip.t_s)
    assert twice.position_m == pytest.approx(trip.position_m)
    assert twice.segments.tolist() == trip.segments.tolist()


def test_parts_stay_apart() -> None:
    trip = circle(gap_at=60)
    played = play(trip, Playback(0.5, backwards=True))
    assert played.segments.tolist() == [0, 46, 46 + 30]
    assert np.diff(played.t_s)[45] == pytest.approx(0.5 * 3.1, abs=0.1)


@pytest.mark.parametrize("stretch", [0.0, -1.0, np.nan, np.inf])
def test_a_stretch_that_is_none_is_refused(stretch: float) -> None:
    with pytest.raises(ValueError, match="stretch must be positive and finite"):
        Playback(stretch)
