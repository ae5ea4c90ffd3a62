"""Emergency electronic brake light: what is hard, where it counts, and when the host must brake."""

from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.apps.brake_light import BrakeLight
from modelcast.apps.motions import LENGTH_M, Motions
from modelcast.apps.warnings import Level
from modelcast.station.policy.j2945_parameters import J2945Parameters

EEBL = BrakeLight()
SPEEDS = st.floats(0, 40).map(lambda value: round(value, 6))
GAINS = st.floats(-8, 3).map(lambda value: round(value, 6))


@pytest.mark.parametrize(("share", "level"), [(0.99, Level.NONE), (1.0, Level.WARNING)])
def test_braking_is_hard_from_the_standard_s_event_on(pair, share: float, level: Level):
    hard = J2945Parameters().critical_deceleration_mps2
    assert EEBL.hard_braking_mps2 == hard
    assert EEBL.assess(*pair((0.0, 30.0), remote=(20.0, -share * hard, 0.0))).level[0] == level


@pytest.mark.parametrize(
    ("east_m", "level"),
    [(0.0, Level.WARNING), (1.9, Level.CAUTION), (-5.3, Level.CAUTION), (5.5, Level.NONE)],
)
def test_the_level_falls_from_lane_to_lane(pair, east_m: float, level: Level):
    found = EEBL.assess(*pair((east_m, 30.0), remote=(20.0, -6.0, 0.0)))
    assert found.level[0] == level
    assert np.isfinite(found.margin_m[0]) == (level == Level.WARNING)


@pytest.mark.parametrize(
    ("north_m", "turn_rad"), [(-30.0, 0.0), (30.0, np.pi), (30.0, np.pi / 2), (310.0, 0.0)]
)
def test_what_is_behind_oncoming_crossing_or_far_says_nothing(pair, north_m: float, turn_rad: float):
    found = EEBL.assess(*pair((0.0, north_m), remote=(20.0, -6.0, 0.0), turn_rad=turn_rad))
    assert (found.level[0], found.margin_m[0], found.certainty[0]) == (Level.NONE, inf, 0.0)


@pytest.mark.parametrize(("beyond_m", "level"), [(-0.01, Level.WARNING), (0.01, Level.CAUTION)])
def test_the_host_must_brake_where_a_moderate_braking_would_just_stop_behind(
    pair, beyond_m: float, level: Level
):
    """The remote stops on v²/2a, the host on its delay and v²/2b."""
    needed = 20.0 * 2.05 + 20.0**2 / (2 * EEBL.braking_mps2) - 18.0**2 / (2 * 6.0)
    found = EEBL.assess(*pair((0.0, needed + LENGTH_M + beyond_m), remote=(18.0, -6.0, 0.0)))
    assert found.margin_m[0] == pytest.approx(beyond_m)
    assert found.level[0] == level


@given(host=SPEEDS, remote=SPEEDS, gains=st.tuples(GAINS, st.floats(-8, -4)))
def test_a_smaller_gap_never_lowers_the_level(host: float, remote: float, gains):
    gaps = np.linspace(290.0, 0.5, 60)
    places = np.stack([0 * gaps, gaps], axis=1)
    found = EEBL.assess(
        Motions.of(np.zeros((60, 2)), speed_mps=host, heading_rad=0.0, acceleration_mps2=gains[0]),
        Motions.of(places, speed_mps=remote, heading_rad=0.0, acceleration_mps2=gains[1]),
    )  # fmt: skip
    assert (np.diff(found.level) >= 0).all()
    assert found.level[0] >= Level.CAUTION


def test_bad_settings_are_refused():
    with pytest.raises(ValueError, match="beside_m"):
        BrakeLight(beside_m=-1.0)
    with pytest.raises(ValueError, match="braking_mps2"):
        BrakeLight(braking_mps2=0.0)


def test_its_time_is_that_of_the_contact(pair):
    """20 m/s against a remote that brakes from 20 m/s by 5 m/s²: gap = 5 t² / 2."""
    found = EEBL.assess(*pair((0.0, LENGTH_M + 10.0), remote=(20.0, -5.0, 0.0)))
    assert found.time_s[0] == pytest.approx(2.0)
