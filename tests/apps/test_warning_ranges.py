"""The published warning ranges: their formulas, their cases, and what they share."""

import numpy as np
import pytest

from modelcast.apps.pair_kernels import closed, contact_time
from modelcast.apps.warning_ranges import (
    FEET,
    MILES,
    WARNING_RANGES,
    CampCoefficients,
    CampLinear,
    Knipling,
    Nhtsa,
    get_warning_range,
)
from modelcast.core.exceptions import ConfigError

G = 9.80665
DELAY_S = 2.05


def required_g(closing_mps: float, leader_mps2: float, moving: bool) -> float:
    """CAMP's deceleration in its form with rounded coefficients, as a share of g."""
    return -0.165 + 0.685 * leader_mps2 / G + 0.080 * moving - 0.00877 * closing_mps


def required_miles_g(closing_mps: float, leader_mps2: float, moving: bool) -> float:
    """The second set of coefficients."""
    return -0.164 + 0.668 * leader_mps2 / G - 0.00368 * closing_mps / 0.44704 + 0.078 * moving


@pytest.mark.parametrize(
    ("coefficients", "required", "relative"), [(FEET, required_g, 3e-3), (MILES, required_miles_g, 1e-12)]
)
@pytest.mark.parametrize(("host", "gain"), [(30.0, 0.0), (20.0, -1.5), (8.0, 1.0)])
def test_camp_behind_a_stopped_leader_is_delay_and_braking(
    coefficients: CampCoefficients, required, relative: float, host: float, gain: float
):
    late = host + gain * DELAY_S
    expected = late**2 / (-2 * G * required(late, 0.0, moving=False))
    expected += host * DELAY_S + 0.5 * gain * DELAY_S**2
    (found,) = CampLinear(coefficients).warning_range_m(host, gain, 0.0, 0.0)
    assert found == pytest.approx(expected, rel=relative)


@pytest.mark.parametrize(
    ("coefficients", "required", "relative"), [(FEET, required_g, 3e-3), (MILES, required_miles_g, 1e-12)]
)
def test_camp_behind_a_slower_leader_that_moves_on(coefficients, required, relative: float):
    host, leader, leader_gain = 30.0, 20.0, -0.5
    leader_late = leader + leader_gain * DELAY_S
    needed = G * required(host - leader_late, leader_gain, moving=True)
    assert (host - leader_late) / (leader_gain - needed) < leader_late / -leader_gain
    expected = (host - leader_late) ** 2 / (-2 * (needed - leader_gain))
    expected += (host - leader) * DELAY_S - 0.5 * leader_gain * DELAY_S**2
    (found,) = CampLinear(coefficients).warning_range_m(host, 0.0, leader, leader_gain)
    assert found == pytest.approx(expected, rel=relative)


@pytest.mark.parametrize("leader", [25.0, 7.0])
def test_camp_behind_a_leader_that_stops_within(leader: float):
    """Both while the leader still moves after the delay and where it stands by then."""
    leader_gain, host = -4.0, leader
    leader_late = max(leader + leader_gain * DELAY_S, 0.0)
    needed = G * required_miles_g(host - leader_late, leader_gain, moving=True)
    expected = host**2 / (-2 * needed) - leader_late**2 / (-2 * leader_gain)
    expected += -0.5 * leader_gain * DELAY_S**2
    (found,) = CampLinear(MILES).warning_range_m(host, 0.0, leader, leader_gain)
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("name", WARNING_RANGES)
def test_behind_a_leader_of_the_same_steady_speed_nothing_is_asked(name: str):
    speeds = np.array([5.0, 20.0, 35.0])
    assert not WARNING_RANGES[name].warning_range_m(speeds, 0.0, speeds, 0.0).any()
    assert not WARNING_RANGES[name].warning_range_m(speeds, 0.0, speeds + 4.0, 0.0).any()


@pytest.mark.parametrize("name", WARNING_RANGES)
def test_ranges_are_finite_not_negative_and_grow_with_the_host_s_speed(name: str):
    rng = np.random.default_rng(5)
    host, leader = rng.uniform(0, 40, 4000), rng.uniform(0, 40, 4000)
    gain, leader_gain = rng.uniform(-8, 3, 4000), rng.uniform(-8, 3, 4000)
    one = WARNING_RANGES[name]
    ranges = one.warning_range_m(host, gain, leader, leader_gain)
    assert np.isfinite(ranges).all()
    assert (ranges >= 0.0).all()
    assert (one.warning_range_m(host + 1.0, gain, leader, leader_gain) >= ranges - 1e-9).all()


def test_knipling_stops_behind_the_place_where_the_leader_stops():
    stopping = 2.05 * 20.0 + 20.0**2 / (2 * 0.6 * G)
    found = Knipling().warning_range_m(20.0, 0.0, [0.0, 0.4, 15.0, 15.0, 20.0], [0.0, 0.0, -5.0, 0.0, -5.0])
    np.testing.assert_allclose(found, [stopping, stopping, stopping - 15.0**2 / 10.0, 0.0, 0.0])


def test_nhtsa_leaves_just_the_distance_to_be_left():
    """Drive what it warns of: brake after the delay, and measure the smallest gap on the way."""
    rng = np.random.default_rng(11)
    for _ in range(40):
        host, leader, leader_gain = rng.uniform(5, 35), rng.uniform(0, 30), rng.uniform(-6, 0)
        gain = rng.choice([0.0, -2.0])
        delay = 0.5 if gain < 0 else 1.6
        (gap,) = Nhtsa().warning_range_m(host, gain, leader, leader_gain)
        t_s = np.linspace(0.0, 40.0, 40_001)
        late = max(host + gain * delay, 0.0)
        speed = np.where(
            t_s < delay, np.maximum(host + gain * t_s, 0.0), late - 0.55 * G * (t_s - delay)
        ).clip(0)
        leader_speed = (leader + leader_gain * t_s).clip(0)
        gaps = (
            gap
            - np.concatenate(
                [[0.0], np.cumsum(((speed - leader_speed)[1:] + (speed - leader_speed)[:-1]) / 2)]
            )
            * 1e-3
        )
        nearest = gaps[t_s >= delay].min()
        if gap > 0.0:
            assert nearest == pytest.approx(2.0 + 0.1 * host, abs=2e-2)
        else:
            assert nearest >= -1e-3


def test_what_is_closed_and_when_it_touches_are_those_of_the_driven_way():
    rng = np.random.default_rng(3)
    t_s = np.linspace(0.0, 60.0, 60_001)
    for _ in range(150):
        host, leader = rng.uniform(0, 30, 2) * (rng.random(2) > 0.2)
        gain, leader_gain = rng.choice([-6.0, -3.3, -1.1, 0.0, 0.6], 2)
        gap = rng.uniform(0.5, 60.0)
        way = travelled(host, gain, t_s) - travelled(leader, leader_gain, t_s)
        most = closed(host, gain, leader, leader_gain)
        if np.isfinite(most):
            assert most == pytest.approx(max(way.max(), 0.0), abs=1e-2)
        else:
            assert way[-1] > way[-2]
        time_s = contact_time(gap, host, gain, leader, leader_gain)
        reached = np.flatnonzero(way >= gap)
        if reached.size:
            assert time_s == pytest.approx(t_s[reached[0]], abs=2e-3)
        else:
            assert time_s > t_s[-1] - 1e-3


def travelled(speed: float, gain: float, t_s: np.ndarray) -> np.ndarray:
    """Way of a vehicle that does not reverse."""
    until = np.minimum(t_s, speed / -gain) if gain < 0 else t_s
    return speed * until + 0.5 * gain * until**2


def test_nan_gives_nan_and_bad_input_is_refused():
    assert np.isnan(CampLinear().warning_range_m([np.nan], 0.0, 10.0, 0.0)).all()
    with pytest.raises(ValueError, match="negative"):
        CampLinear().warning_range_m(-1.0, 0.0, 10.0, 0.0)
    with pytest.raises(ValueError, match="delay_s"):
        CampLinear(delay_s=-1.0)
    with pytest.raises(ValueError, match="braking_mps2"):
        Nhtsa(0.0)
    with pytest.raises(ConfigError, match="knipling, nhtsa"):
        get_warning_range("camp")
    assert get_warning_range("knipling") == Knipling()


@pytest.mark.parametrize("which", range(4))
def test_whatever_is_not_known_makes_the_range_unknown(which: int):
    given = [20.0, 0.0, 10.0, -1.0]
    given[which] = np.nan
    assert np.isnan(Nhtsa().warning_range_m(*given)).all()


def test_knipling_asks_nothing_behind_a_leader_that_hardly_brakes():
    assert Knipling().warning_range_m(20.0, 0.0, 19.0, -0.1)[0] == 0.0


@pytest.mark.parametrize(
    ("motion", "most"),
    [
        ((20.0, -4.0, 20.0, -5.0), 50.0 - 40.0),  # the leader stops first
        ((20.0, -5.0, 20.0, -4.0), 0.0),
        ((20.0, -4.0, 10.0, -4.0), 50.0 - 12.5),
        ((20.0, -4.0, 10.0, -1.0), 10.0**2 / 6.0),  # equal speeds on the way
        ((20.0, -4.0, 0.0, 0.0), 50.0),
        ((20.0, -4.0, 0.0, 1.0), 20.0**2 / 10.0),
        ((20.0, 0.0, 15.0, 1.0), 12.5),
        ((20.0, 0.0, 15.0, 0.0), np.inf),
        ((20.0, 0.0, 30.0, -1.0), np.inf),
        ((10.0, 1.0, 30.0, 0.0), np.inf),
        ((15.0, 0.0, 20.0, 0.0), 0.0),
        ((0.0, 0.0, 0.0, 0.0), 0.0),
        ((0.0, 0.0, 5.0, -1.0), 0.0),
        ((0.0, -1.0, 0.0, -2.0), 0.0),
    ],
)
def test_what_is_closed_case_by_case(motion: tuple[float, float, float, float], most: float):
    assert closed(*motion) == pytest.approx(most)
