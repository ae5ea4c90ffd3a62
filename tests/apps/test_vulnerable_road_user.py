"""Vulnerable road user warning: who meets whom, and until when the host can act."""

from math import inf, pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.apps.motions import LENGTH_M, WIDTH_M, Motions
from modelcast.apps.vulnerable_road_user import VulnerableRoadUserWarning
from modelcast.apps.warnings import Level
from modelcast.core.kinds import Kind

VRU = VulnerableRoadUserWarning()
CAR_MPS = 50.0 / 3.6
WALKS_MPS = 5.0 / 3.6
PERSON_M = (0.6, 0.5)
REACH_M = 0.5 * (WIDTH_M + PERSON_M[0]) + VRU.aside_m
"""Offset at which who walks across enters the strip."""
HALF_M = 0.5 * (LENGTH_M + PERSON_M[1])
STOP_M = CAR_MPS * VRU.delay_s + CAR_MPS**2 / (2.0 * VRU.braking_mps2)
PERSON_STOP_M = WALKS_MPS * VRU.person_delay_s + WALKS_MPS**2 / (2.0 * VRU.person_braking_mps2)


def car(ahead_m=0.0, speed_mps=CAR_MPS, **motion: Any):
    """A car on its way north, so far before the origin."""
    return Motions.of([[0.0, -ahead_m]], speed_mps=speed_mps, heading_rad=0.0, **motion)


def person(
    east_m, north_m=0.0, *, speed_mps=WALKS_MPS, heading_rad=-pi / 2, kind=Kind.PEDESTRIAN, **motion: Any
):
    """Somebody who walks west unless told otherwise."""
    return Motions.of(
        [[east_m, north_m]], speed_mps=speed_mps, heading_rad=heading_rad, length_m=PERSON_M[0],
        width_m=PERSON_M[1], kind=kind, **motion,
    )  # fmt: skip


def meets_after(time_s):
    """Who is in the middle of the car's path then, if it walks on."""
    return person(WALKS_MPS * time_s)


def test_the_vehicles_margin_is_the_gap_less_the_way_to_stop():
    """The near-side crossing of Euro NCAP at 50 km/h and 5 km/h."""
    for ahead_m in (35.0, 40.0, 45.0, 60.0):
        found = VRU.assess(car(ahead_m), meets_after((ahead_m - HALF_M) / CAR_MPS))
        margin_m = ahead_m - HALF_M - STOP_M
        assert found.margin_m[0] == pytest.approx(margin_m)
        assert found.level[0] == (Level.WARNING if margin_m <= 0.0 else Level.CAUTION)
        assert found.time_s[0] == pytest.approx((ahead_m - HALF_M) / CAR_MPS)


def test_the_persons_margin_is_the_way_to_the_strip_less_its_way_to_stop():
    for way_m in (1.0, PERSON_STOP_M - 1e-6, PERSON_STOP_M + 1e-6, 4.0):
        walks = person(REACH_M + way_m)
        found = VRU.assess(walks, car(HALF_M + CAR_MPS * (way_m + REACH_M) / WALKS_MPS))
        assert found.margin_m[0] == pytest.approx(way_m - PERSON_STOP_M)
        assert found.warned[0] == (way_m <= PERSON_STOP_M)


def test_who_walks_along_is_met_like_a_leader():
    ahead_m = HALF_M + 0.5 * (PERSON_M[0] - PERSON_M[1]) + 30.0
    found = VRU.assess(car(ahead_m), person(0.0, heading_rad=0.0))
    closing = CAR_MPS - WALKS_MPS
    lost_m = closing * VRU.delay_s + closing**2 / (2.0 * VRU.braking_mps2)
    assert found.margin_m[0] == pytest.approx(30.0 - lost_m)
    assert found.time_s[0] == pytest.approx(30.0 / closing)


def test_who_stands_beside_the_strip_is_no_threat_and_in_it_is():
    for east_m, threat in ((REACH_M + 0.01, False), (REACH_M - 0.01, True)):
        found = VRU.assess(car(40.0), person(east_m, speed_mps=0.0))
        assert np.isfinite(found.margin_m[0]) == threat


def test_who_is_off_the_path_long_enough_before_or_enters_long_enough_after_does_not_meet():
    comes_s, gone_s = 36.0 / CAR_MPS, (36.0 + 2 * HALF_M) / CAR_MPS
    vehicle = car(36.0 + HALF_M)
    leaves = -REACH_M + WALKS_MPS * comes_s
    enters = REACH_M + WALKS_MPS * gone_s
    slack = WALKS_MPS * VRU.apart_s
    for east_m, meets in (
        (leaves - slack - 0.01, False),
        (leaves - slack + 0.01, True),
        (enters + slack - 0.01, True),
        (enters + slack + 0.01, False),
    ):
        walks = person(east_m)
        assert np.isfinite(VRU.assess(vehicle, walks).margin_m[0]) == meets
        assert np.isfinite(VRU.assess(walks, vehicle).margin_m[0]) == meets, "both sides see one meeting"


def test_a_car_that_turns_meets_who_is_on_its_bend():
    radius_m, speed_mps = 15.0, 5.0
    turns = car(0.0, speed_mps, yaw_rate_radps=speed_mps / radius_m)
    on_bend = person(radius_m, radius_m, speed_mps=0.0)
    assert np.isfinite(VRU.assess(turns, on_bend).margin_m[0])
    assert VRU.assess(turns, on_bend).time_s[0] == pytest.approx(
        (radius_m * pi / 2 - HALF_M) / speed_mps, abs=0.02
    )
    assert VRU.assess(car(0.0, speed_mps), on_bend).margin_m[0] == inf


def test_only_a_vehicle_and_a_person_are_looked_at():
    people = {Kind.PEDESTRIAN, Kind.CYCLIST, Kind.ROAD_WORKER}
    for host in Kind:
        for remote in Kind:
            if host in people and remote == Kind.VEHICLE:
                continue
            vehicle = car(36.0, kind=host)
            walks = meets_after(36.0 / CAR_MPS)
            other = person(*walks.position_m[0], kind=remote)
            asked = host == Kind.VEHICLE and remote in people
            assert (VRU.assess(vehicle, other).level[0] != Level.NONE) == asked
            assert (VRU.assess(other, vehicle).level[0] != Level.NONE) == asked


def test_a_car_that_stands_is_no_threat_and_one_that_stops_before_neither():
    walks = person(0.0, speed_mps=0.0)
    assert VRU.assess(car(10.0, 0.0), walks).margin_m[0] == inf
    stops_m = CAR_MPS**2 / (2.0 * 4.0)
    for ahead_m, threat in ((stops_m + HALF_M - 0.1, True), (stops_m + HALF_M + 0.1, False)):
        found = VRU.assess(car(ahead_m, acceleration_mps2=-4.0), walks)
        assert np.isfinite(found.margin_m[0]) == threat


def test_the_certainty_is_that_of_the_place_along_the_margin():
    covariance = np.diag([4.0, 9.0])[None]
    ahead_m = HALF_M + STOP_M + 3.0
    found = VRU.assess(car(ahead_m), meets_after((ahead_m - HALF_M) / CAR_MPS))
    assert found.certainty[0] == 0.0
    unsure = meets_after((ahead_m - HALF_M) / CAR_MPS)
    vague = Motions.of(
        unsure.position_m, speed_mps=WALKS_MPS, heading_rad=-pi / 2, length_m=PERSON_M[0],
        width_m=PERSON_M[1], kind=Kind.PEDESTRIAN, covariance_m2=covariance,
    )  # fmt: skip
    assert VRU.assess(car(ahead_m), vague).certainty[0] == pytest.approx(0.158655, abs=1e-6), "one deviation"
    walks = person(REACH_M + PERSON_STOP_M + 2.0)
    comes = HALF_M + CAR_MPS * (PERSON_STOP_M + 2.0 + REACH_M) / WALKS_MPS
    found = VRU.assess(walks, car(comes, covariance_m2=covariance))
    assert found.certainty[0] == pytest.approx(0.158655, abs=1e-6), "2 m across the path"


@given(
    turn=st.floats(-pi, pi),
    east=st.floats(-1e3, 1e3),
    north=st.floats(-1e3, 1e3),
    aside=st.floats(-6.0, 6.0),
    ahead=st.floats(3.0, 80.0),
    course=st.floats(-pi, pi),
    pace=st.floats(0.0, 7.0),
    mirrored=st.booleans(),
)
def test_nothing_depends_on_where_north_is_or_which_side_is_right(
    moved, *, turn, east, north, aside, ahead, course, pace, mirrored
):
    vehicle, other = car(ahead), person(aside, speed_mps=pace, heading_rad=course)
    side = -1.0 if mirrored else 1.0
    same = person(side * aside, speed_mps=pace, heading_rad=side * course)
    for whole in ((vehicle, other), (other, vehicle)):
        first = VRU.assess(*whole)
        if np.isfinite(first.margin_m[0]) and abs(first.margin_m[0]) < 1e-6:
            continue
        swapped = [same if one is other else one for one in whole]
        again = VRU.assess(*(moved(one, turn, (east, north)) for one in swapped))
        if np.isfinite(first.margin_m[0]) != np.isfinite(again.margin_m[0]):
            continue  # on the edge of a meeting: rounding decides
        assert again.margin_m[0] == pytest.approx(first.margin_m[0], rel=1e-6, abs=1e-6)
        assert again.level[0] == first.level[0]


@given(ahead=st.floats(6.0, 60.0), aside=st.floats(-4.0, 4.0), pace=st.floats(0.0, 2.5))
def test_a_collision_course_is_always_a_threat(ahead, aside, pace):
    """Who overlaps the car at some time within 5 s, by stepping both on, gets at least a caution."""
    walks = person(aside, speed_mps=pace)
    times = np.arange(0.0, 5.0, 0.02)
    apart_north = np.abs(ahead - CAR_MPS * times)
    apart_east = np.abs(aside - pace * times)
    hit = (apart_north < HALF_M - 0.05) & (apart_east < 0.5 * (WIDTH_M + PERSON_M[0]) - 0.05)
    if hit.any():
        assert VRU.assess(car(ahead), walks).level[0] >= Level.CAUTION
        assert VRU.assess(walks, car(ahead)).level[0] >= Level.CAUTION


@pytest.mark.parametrize("change", [{"delay_s": -1.0}, {"braking_mps2": 0.0}, {"person_braking_mps2": 0.0}])
def test_impossible_settings_are_refused(change):
    with pytest.raises(ValueError, match="must"):
        VulnerableRoadUserWarning(**change)


def test_kinds_of_another_shape_are_refused():
    with pytest.raises(ValueError, match="kind"):
        Motions(
            np.zeros((2, 2)), speed_mps=np.zeros(2), heading_rad=np.zeros(2), acceleration_mps2=np.zeros(2),
            yaw_rate_radps=np.zeros(2), length_m=np.ones(2), width_m=np.ones(2),
            kind=np.zeros(3, dtype=np.int64),
        )  # fmt: skip
