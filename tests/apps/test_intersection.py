"""Intersection movement assist: who meets whom where paths cross, and until when the host can wait."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from modelcast.apps.intersection import IntersectionAssist
from modelcast.apps.motions import LENGTH_M, WIDTH_M, Motions
from modelcast.apps.warnings import Level

IMA = IntersectionAssist()
STOP_M = 15.0 * 2.05 + 15.0**2 / (2 * IMA.braking_mps2)
EDGE_M = (LENGTH_M + WIDTH_M) / 2
"""From the middle of a right-angled crossing to that of a car whose front arrives, or whose rear leaves."""


def crossing(
    pair, host_m: float, remote_m: float, *, host=(15.0, 0.0, 0.0), remote=(15.0, 0.0, 0.0), side=1.0
):
    """The host goes north, the remote east or west; both so far before the crossing."""
    return pair((-side * remote_m, host_m), host=host, remote=remote, turn_rad=side * np.pi / 2)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("beyond_m", "level"), [(-0.01, Level.WARNING), (0.01, Level.CAUTION)])
def test_the_host_must_act_when_it_could_just_stop_before_the_area(
    pair, side: float, beyond_m: float, level: Level
):
    way = STOP_M + EDGE_M + beyond_m
    found = IMA.assess(*crossing(pair, way, way, side=side))
    assert found.margin_m[0] == pytest.approx(beyond_m)
    assert found.level[0] == level
    assert found.time_s[0] == pytest.approx((way - EDGE_M) / 15.0)


@pytest.mark.parametrize("first", [1.0, -1.0])
@pytest.mark.parametrize(("apart_s", "level"), [(0.99, Level.WARNING), (1.01, Level.NONE)])
def test_stays_that_are_apart_by_more_than_the_limit_are_no_conflict(
    pair, first: float, apart_s: float, level: Level
):
    """One's rear leaves so long before the other's front arrives."""
    later = 30.0 + first * (2 * EDGE_M + 15.0 * apart_s)
    assert IMA.assess(*crossing(pair, 30.0, later)).level[0] == level


def test_one_who_stops_before_the_area_is_no_conflict(pair):
    meets = crossing(pair, 40.0, 40.0)
    assert IMA.assess(*meets).level[0] == Level.WARNING
    stops = 15.0**2 / (2 * (40.0 - EDGE_M))
    for share, level in ((0.99, Level.WARNING), (1.01, Level.NONE)):
        patient = replace(IMA, longest_s=60.0, apart_s=60.0)
        found = patient.assess(*crossing(pair, 40.0, 40.0, remote=(15.0, -share * stops, 0.0)))
        assert found.level[0] == level
    assert IMA.assess(*crossing(pair, 40.0, 40.0, host=(15.0, -stops * 1.01, 0.0))).level[0] == Level.NONE


@pytest.mark.parametrize(
    ("host_m", "remote_m"), [(-EDGE_M - 0.1, 10.0), (10.0, -EDGE_M - 0.1), (150.0, 150.0)]
)
def test_who_has_passed_or_is_long_before_is_left_alone(pair, host_m: float, remote_m: float):
    found = IMA.assess(*crossing(pair, host_m, remote_m))
    assert (found.level[0], found.margin_m[0], found.time_s[0]) == (Level.NONE, inf, inf)


@pytest.mark.parametrize("turn_rad", [0.0, 0.5, np.pi, np.pi - 0.5])
def test_same_and_opposite_courses_do_not_cross(pair, turn_rad: float):
    assert IMA.assess(*pair((0.0, 30.0), turn_rad=turn_rad)).level[0] == Level.NONE


def test_at_a_slant_the_area_is_wider(pair):
    """At 45 degrees it reaches (w_R + w_H cos) / (2 sin) to either side."""
    angle, way = np.pi / 4, 60.0
    place = (-way * np.sin(angle), way - way * np.cos(angle))
    half = (WIDTH_M + WIDTH_M * np.cos(angle)) / (2 * np.sin(angle)) + LENGTH_M / 2
    found = IMA.assess(*pair(place, host=(15.0, 0.0, 0.0), remote=(15.0, 0.0, 0.0), turn_rad=angle))
    assert found.margin_m[0] == pytest.approx(way - half - STOP_M)


def test_where_the_world_s_origin_and_north_are_changes_nothing(random_pairs, moved):
    host, remote = (replace(one, kind=None) for one in random_pairs(np.random.default_rng(4), 4000))
    one = IMA.assess(host, remote)
    other = IMA.assess(moved(host, 1.1, (500.0, -300.0)), moved(remote, 1.1, (500.0, -300.0)))
    assert (one.level > Level.NONE).sum() > 200
    assert (one.level != other.level).sum() <= 2
    same = one.level == other.level
    np.testing.assert_allclose(one.margin_m[same], other.margin_m[same], atol=1e-6)
    np.testing.assert_allclose(one.certainty[same], other.certainty[same], atol=1e-6)


def test_certainty_is_the_share_of_places_that_leave_no_room_to_stop(pair):
    """Monte Carlo; the limits are wide, since the meeting itself counts as certain."""
    wide = replace(IMA, apart_s=30.0, longest_s=60.0)
    covariance = np.array([[1.0, -0.8], [-0.8, 2.0]])
    way = STOP_M + EDGE_M + 0.7
    host, remote = crossing(pair, way, way)
    certainty = wide.assess(host, replace(remote, covariance_m2=covariance[None])).certainty[0]
    draws = 100_000
    places = np.random.default_rng(8).multivariate_normal(remote.position_m[0], covariance, draws)
    drawn = Motions.of(places, speed_mps=15.0, heading_rad=np.pi / 2)
    hosts = Motions.of(np.zeros((draws, 2)), speed_mps=15.0, heading_rad=0.0)
    assert certainty == pytest.approx(wide.assess(hosts, drawn).warned.mean(), abs=6e-3)


def test_bad_settings_are_refused():
    with pytest.raises(ValueError, match="apart_s"):
        IntersectionAssist(apart_s=-1.0)
    with pytest.raises(ValueError, match="least_angle_rad"):
        IntersectionAssist(least_angle_rad=0.0)
    with pytest.raises(ValueError, match="braking_mps2"):
        IntersectionAssist(braking_mps2=0.0)


def test_a_host_in_the_area_must_act(pair):
    found = IMA.assess(*crossing(pair, 0.5 * EDGE_M, 20.0, host=(2.0, 0.0, 0.0)))
    assert found.level[0] == Level.WARNING
    assert found.margin_m[0] == pytest.approx(-0.5 * EDGE_M - 2.0 * 2.05 - 2.0**2 / (2 * IMA.braking_mps2))


def test_a_remote_whose_rear_is_still_in_the_area_counts(pair):
    assert IMA.assess(*crossing(pair, EDGE_M + 9.0, 0.5 - EDGE_M)).level[0] == Level.WARNING
