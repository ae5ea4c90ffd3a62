"""Forward collision warning: which remote is in path, how near, and how sure."""

from dataclasses import replace
from math import cos, inf, sin
from statistics import NormalDist

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.apps.forward_collision import ForwardCollisionWarning
from modelcast.apps.motions import LENGTH_M, Motions
from modelcast.apps.pair_kernels import path_way
from modelcast.apps.warning_ranges import WARNING_RANGES, CampLinear
from modelcast.apps.warnings import Level, Warnings

FCW = ForwardCollisionWarning()
SPEEDS = st.floats(0, 40).map(lambda value: round(value, 6))
GAINS = st.floats(-8, 3).map(lambda value: round(value, 6))


def test_the_margin_is_the_gap_between_bumpers_less_the_warning_range(pair):
    found = FCW.assess(*pair((0.3, 70.0), remote=(10.0, -1.0, 0.0)))
    (asked,) = CampLinear().warning_range_m(20.0, 0.0, 10.0, -1.0)
    assert found.margin_m[0] == pytest.approx(70.0 - LENGTH_M - asked)


@pytest.mark.parametrize(
    ("beyond_m", "level"), [(-0.01, Level.WARNING), (0.01, Level.CAUTION), (21.0, Level.NONE)]
)
def test_it_warns_from_a_margin_of_zero_and_cautions_a_second_before(pair, beyond_m: float, level: Level):
    (asked,) = CampLinear().warning_range_m(20.0, 0.0, 0.0, 0.0)
    found = FCW.assess(*pair((0.0, asked + LENGTH_M + beyond_m), remote=(0.0, 0.0, 0.0)))
    assert found.level[0] == level
    assert found.warned[0] == (level == Level.WARNING)


@pytest.mark.parametrize(
    ("offset_m", "turn_rad"),
    [((0.0, -20.0), 0.0), ((1.9, 20.0), 0.0), ((-1.9, 20.0), 0.0), ((0.0, 20.0), 0.9), ((0.0, 20.0), np.pi),
     ((0.0, 205.0), 0.0)],
)  # fmt: skip
def test_what_is_behind_beside_crossing_oncoming_or_far_is_no_threat(pair, offset_m, turn_rad: float):
    found = FCW.assess(*pair(offset_m, remote=(0.0, 0.0, 0.0), turn_rad=turn_rad))
    assert (found.level[0], found.margin_m[0], found.time_s[0], found.certainty[0]) == (
        Level.NONE,
        inf,
        inf,
        0.0,
    )


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_path_bends_with_the_host(pair, side: float):
    """A remote 60 m along a circle of 100 m is in path, and as far as it is on the straight."""
    angle = 0.6
    place = (side * 100.0 * (1 - cos(angle)), 100.0 * sin(angle))
    bent = pair(place, host=(20.0, 0.0, side * 0.2), remote=(5.0, 0.0, 0.0), turn_rad=side * angle)
    straight = pair((0.0, 60.0), remote=(5.0, 0.0, 0.0))
    assert FCW.assess(*bent).margin_m[0] == pytest.approx(FCW.assess(*straight).margin_m[0])
    ahead = pair((0.0, 60.0), host=(20.0, 0.0, side * 0.2), remote=(5.0, 0.0, 0.0))
    assert FCW.assess(*ahead).level[0] == Level.NONE


def test_a_slow_host_s_yaw_rate_does_not_bend_its_path(pair):
    assert (
        FCW.assess(*pair((0.0, 4.7), host=(1.0, 0.0, 0.5), remote=(0.0, 0.0, 0.0))).level[0] == Level.WARNING
    )


@given(
    turn_rad=st.floats(-7.0, 7.0),
    east_m=st.floats(-1e4, 1e4),
    north_m=st.floats(-1e4, 1e4),
    seed=st.integers(0, 99),
)
def test_where_the_world_s_origin_and_north_are_changes_nothing(  # noqa: PLR0917 - given
    random_pairs, moved, turn_rad, east_m, north_m, seed: int
):
    host, remote = random_pairs(np.random.default_rng(seed), 40)
    one = FCW.assess(host, remote)
    other = FCW.assess(moved(host, turn_rad, (east_m, north_m)), moved(remote, turn_rad, (east_m, north_m)))
    clear = ~np.isfinite(one.margin_m) | (np.abs(one.margin_m) > 1e-6)
    np.testing.assert_array_equal(one.level[clear], other.level[clear])
    np.testing.assert_allclose(one.margin_m, other.margin_m, rtol=0, atol=1e-7)
    np.testing.assert_allclose(one.certainty, other.certainty, rtol=0, atol=1e-7)


@pytest.mark.parametrize("name", WARNING_RANGES)
@given(host=SPEEDS, remote=SPEEDS, gains=st.tuples(GAINS, GAINS))
def test_a_smaller_gap_never_lowers_the_level(name: str, host: float, remote: float, gains):
    gaps = np.linspace(190.0, 0.5, 30)
    rows = len(gaps)
    found = replace(FCW, algorithm=WARNING_RANGES[name]).assess(
        Motions.of(np.zeros((rows, 2)), speed_mps=host, heading_rad=0.0, acceleration_mps2=gains[0]),
        Motions.of(
            np.stack([0 * gaps, gaps], axis=1), speed_mps=remote, heading_rad=0.0, acceleration_mps2=gains[1]
        ),
    )
    assert (np.diff(found.level) >= 0).all()
    assert (np.diff(found.certainty) >= 0).all()


@pytest.mark.parametrize(
    "column", ["position_m", "speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps"]
)
def test_of_what_is_not_known_nothing_is_said(pair, column: str):
    host, remote = pair((0.0, 8.0), remote=(0.0, 0.0, 0.0))
    assert FCW.assess(host, remote).level[0] == Level.WARNING
    for known, unknown in ((host, remote), (remote, host)):
        lost = replace(unknown, **{column: np.full_like(getattr(unknown, column), np.nan)})
        found = FCW.assess(known, lost) if known is host else FCW.assess(lost, known)
        assert (found.level[0], found.time_s[0], found.certainty[0]) == (Level.NONE, inf, 0.0)
        assert np.isnan(found.margin_m[0])


@pytest.mark.parametrize("yaw_rate", [0.0, 0.05])
def test_certainty_is_the_share_of_places_that_would_be_warned_of(pair, yaw_rate: float):
    """Monte Carlo of both places; the lane is wide, since an offset counts as exact."""
    rng = np.random.default_rng(2)
    wide = replace(FCW, lane_half_width_m=1e3)
    covariance = np.array([[1.0, 0.9], [0.9, 2.0]])
    (asked,) = CampLinear().warning_range_m(20.0, 0.0, 12.0, -0.5)
    place = (0.5, asked + LENGTH_M + 0.8)
    host, remote = pair(place, host=(20.0, 0.0, yaw_rate), remote=(12.0, -0.5, 0.0), covariance_m2=covariance)
    host = replace(host, covariance_m2=np.diag([0.5, 0.25])[None])
    certainty = wide.assess(host, remote).certainty[0]
    draws = 100_000
    drawn = Motions.of(
        rng.multivariate_normal(place, covariance + np.diag([0.5, 0.25]), draws),
        speed_mps=12.0, heading_rad=0.0, acceleration_mps2=-0.5,
    )  # fmt: skip
    hosts = Motions.of(np.zeros((draws, 2)), speed_mps=20.0, heading_rad=0.0, yaw_rate_radps=yaw_rate)
    assert certainty == pytest.approx(wide.assess(hosts, drawn).warned.mean(), abs=5e-3)
    assert 0.1 < certainty < 0.9


def test_rows_and_settings_that_make_no_sense_are_refused(pair):
    host, _ = pair()
    two = Motions.of(np.zeros((2, 2)), speed_mps=1.0, heading_rad=0.0)
    with pytest.raises(ValueError, match="row by row"):
        FCW.assess(host, two)
    with pytest.raises(ValueError, match="longest_gap_m"):
        ForwardCollisionWarning(longest_gap_m=-1.0)
    with pytest.raises(ValueError, match="time_s"):
        Warnings(np.zeros(2, dtype=np.int64), time_s=np.zeros(1), margin_m=np.zeros(2), certainty=np.zeros(2))


@pytest.mark.parametrize(("north_m", "time_s"), [(4.0, 0.0), (4.5, 0.0), (4.9, 0.02)])
def test_bumpers_that_touch_touch_now(pair, north_m: float, time_s: float):
    """A leader that stands does not drive backwards, whatever its acceleration says."""
    for gain in (0.0, -3.0):
        found = FCW.assess(*pair((0.0, north_m), remote=(0.0, gain, 0.0)))
        assert found.time_s[0] == pytest.approx(time_s)
        assert found.level[0] == Level.WARNING


def test_a_near_leader_that_draws_away_is_no_reason_for_caution(pair):
    found = FCW.assess(*pair((0.0, LENGTH_M + 0.5), remote=(25.0, 0.0, 0.0)))
    assert (found.level[0], found.margin_m[0]) == (Level.NONE, 0.5)


@pytest.mark.parametrize("whose", ["host", "remote", "both"])
def test_certainty_is_that_of_the_normal_distribution_along_the_path(pair, whose: str):
    """Heading north-east, the deviation is that of (east + north) / sqrt 2; covariances add."""
    (asked,) = CampLinear().warning_range_m(20.0, 0.0, 10.0, 0.0)
    away = (asked + LENGTH_M + 1.0) / np.sqrt(2.0)
    host, remote = pair((away, away), remote=(10.0, 0.0, 0.0), turn_rad=np.pi / 4)
    covariance = np.array([[[3.0, 0.5], [0.5, 1.0]]])
    host = replace(
        host, heading_rad=np.array([np.pi / 4]), covariance_m2=covariance if whose != "remote" else None
    )
    remote = replace(remote, covariance_m2=covariance if whose != "host" else None)
    deviation = np.sqrt((3.0 + 1.0 + 2 * 0.5) / 2.0 * (2.0 if whose == "both" else 1.0))
    assert FCW.assess(host, remote).certainty[0] == pytest.approx(
        NormalDist().cdf(-1.0 / deviation), abs=1e-9
    )


@pytest.mark.parametrize("curvature", [0.0, 1e-6, 0.02, -0.02])
def test_the_gradient_of_the_way_is_its_slope(curvature: float):
    way, by_ahead, by_right = path_way(30.0, 4.0, curvature)
    step = 1e-5
    ahead = (path_way(30.0 + step, 4.0, curvature)[0] - path_way(30.0 - step, 4.0, curvature)[0]) / (2 * step)
    right = (path_way(30.0, 4.0 + step, curvature)[0] - path_way(30.0, 4.0 - step, curvature)[0]) / (2 * step)
    assert (by_ahead, by_right) == pytest.approx((ahead, right), abs=1e-8)
    assert way == pytest.approx(30.0 if abs(curvature) < 1e-5 else way, rel=1e-4)


def test_a_course_is_held_against_the_path_s_where_the_remote_is(pair):
    """Beyond 45 degrees of a bend: who follows it is in path, who keeps the host's course is not."""
    angle = 1.0
    place = (100.0 * (1 - cos(angle)), 100.0 * sin(angle))
    bend = pair(place, host=(20.0, 0.0, 0.2), remote=(5.0, 0.0, 0.0), turn_rad=angle)
    assert np.isfinite(FCW.assess(*bend).margin_m[0])
    across = pair(place, host=(20.0, 0.0, 0.2), remote=(5.0, 0.0, 0.0), turn_rad=0.0)
    assert FCW.assess(*across).margin_m[0] == inf
