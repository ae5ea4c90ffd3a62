"""Laws of cruise control: formulas by hand, what they do where little is known, and what theory says."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from modelcast.apps.cruise.acc import Acc
from modelcast.apps.cruise.base import AbstractCruiseLaw, Following, Ranging, following
from modelcast.apps.cruise.fallback import desired
from modelcast.apps.cruise.path import PathCacc
from modelcast.apps.cruise.ploeg import Ploeg
from modelcast.apps.motions import Motions

LAWS: tuple[AbstractCruiseLaw, ...] = (PathCacc(), Ploeg(), Acc())
every_law = pytest.mark.parametrize("law", LAWS, ids=[law.name for law in LAWS])

ROUNDING = 1e-12
"""A handful of sums and products of numbers near 1 to 100."""

FREQUENCIES_RADPS = np.linspace(0.01, 20.0, 4000)
LAG_S = 0.5

SEEN_RATIO = 1e-3
"""How far the greatest of so many frequencies may lie off the true one."""


def known(**changes: float) -> Following:
    """Return two followers at 20 m/s and an equilibrium of nobody's in particular, but for the changes."""
    values = {
        "speed_mps": 20.0,
        "acceleration_mps2": 0.3,
        "commanded_mps2": 0.2,
        "gap_m": 6.0,
        "ahead_speed_mps": 21.0,
        "ahead_acceleration_mps2": -0.4,
        "leader_speed_mps": 22.0,
        "leader_acceleration_mps2": -0.6,
    } | changes
    columns = {name: np.full(2, value) for name, value in values.items()}
    return Following(columns.pop("speed_mps"), columns.pop("acceleration_mps2"), **columns)


def worst(law: AbstractCruiseLaw, vehicles: int = 8, lag_s: float = LAG_S) -> tuple[float, float]:
    """Greatest ratio of two spacing errors, and of two speeds, that follow one another."""
    s = 1j * FREQUENCIES_RADPS
    leader = np.ones_like(s)
    headway_s = float(law.gap_m(np.ones(1))[0] - law.gap_m(np.zeros(1))[0])
    ahead, errors, speeds = leader, list[np.ndarray](), list[float]()
    for _ in range(vehicles - 1):
        here = law.response(s, ahead, leader, lag_s)
        errors.append(np.abs(here - ahead + headway_s * s * here))
        speeds.append(float(np.max(np.abs(here / ahead))))
        ahead = here
    growth = [float(np.max(after / before)) for before, after in pairwise(errors)]
    return max(growth), max(speeds)


def test_path_says_what_its_formula_says() -> None:
    """C1 = 0.5, xi = 1, omega = 0.2: weights 0.5 and 0.5, gains 0.3, 0.1 and 0.04, written out."""
    by_hand = 0.5 * -0.4 + 0.5 * -0.6 - 0.3 * (20.0 - 21.0) - 0.1 * (20.0 - 22.0) - 0.04 * (5.0 - 6.0)
    assert PathCacc().acceleration(known(), 0.01) == pytest.approx([by_hand] * 2, abs=ROUNDING)
    assert PathCacc().gains == pytest.approx((0.3, 0.1, 0.04))


def test_path_overdamped_has_the_root_in_its_gains() -> None:
    """With xi = 1.25 the root is 1.25 + 0.75 = 2."""
    law = PathCacc(leader_weight=0.25, damping=1.25, bandwidth_radps=0.4)
    assert law.gains == pytest.approx(((2.5 - 0.25 * 2.0) * 0.4, 2.0 * 0.4 * 0.25, 0.16))


def test_ploeg_says_what_its_formula_says() -> None:
    rate = (-0.2 + 0.2 * (6.0 - 2.0 - 10.0) + 0.7 * (21.0 - 20.0 - 0.15) - 0.4) / 0.5
    assert Ploeg().acceleration(known(), 0.01) == pytest.approx([0.2 + 0.01 * rate] * 2, abs=ROUNDING)


def test_acc_says_what_its_formula_says() -> None:
    by_hand = -(20.0 - 21.0 + 0.1 * (2.0 + 1.2 * 20.0 - 6.0)) / 1.2
    assert Acc().acceleration(known(), 0.01) == pytest.approx([by_hand] * 2, abs=ROUNDING)


@every_law
def test_content_followers_ask_for_nothing(law: AbstractCruiseLaw) -> None:
    gap_m = float(law.gap_m(np.array([20.0]))[0])
    still = known(
        gap_m=gap_m,
        ahead_speed_mps=20.0,
        leader_speed_mps=20.0,
        acceleration_mps2=0.0,
        commanded_mps2=0.0,
        ahead_acceleration_mps2=0.0,
        leader_acceleration_mps2=0.0,
    )
    assert law.acceleration(still, 0.01) == pytest.approx([0.0, 0.0], abs=ROUNDING)


@every_law
def test_what_a_law_needs_is_what_it_cannot_speak_without(law: AbstractCruiseLaw) -> None:
    """Each column alone unknown in one row: that row is without a word where the law says it needs it."""
    heard = (
        "gap_m",
        "ahead_speed_mps",
        "ahead_acceleration_mps2",
        "leader_speed_mps",
        "leader_acceleration_mps2",
    )
    for name in heard:
        one = replace(known(), **{name: np.array([1.0, np.nan])})
        assert np.isnan(law.acceleration(one, 0.01)).tolist() == [False, name in law.needs], name
        assert law.knows_enough(one).tolist() == [True, name not in law.needs]


def test_without_the_leader_the_ranging_sensor_speaks_and_without_it_nobody() -> None:
    law, second = PathCacc(), Acc(headway_s=0.8)
    deaf = replace(known(), leader_speed_mps=np.array([22.0, np.nan]))
    asked, lost = desired(law, deaf, 0.01, fallback=second)
    assert lost.tolist() == [False, True]
    assert asked.tolist() == [law.acceleration(known(), 0.01)[0], second.acceleration(known(), 0.01)[1]]
    blind = replace(deaf, gap_m=np.full(2, np.nan))
    asked, lost = desired(law, blind, 0.01, fallback=second)
    assert (asked.tolist(), lost.tolist()) == ([0.0, 0.0], [True, True])


def test_gap_and_speed_come_from_the_sensor_where_there_is_one_and_else_from_the_air() -> None:
    """East at 60 degrees from north, 9 m ahead and 1 m aside: 9 m along the course less two half lengths."""
    course = np.pi / 3.0
    along, aside = np.array([np.sin(course), np.cos(course)]), np.array([np.cos(course), -np.sin(course)])
    own = Motions.of([[3.0, 4.0]], speed_mps=[20.0], heading_rad=[course], length_m=4.0)
    ahead = Motions.of(
        np.array([3.0, 4.0]) + 9.0 * along + aside,
        speed_mps=[21.0],
        heading_rad=[course],
        acceleration_mps2=[0.5],
        length_m=5.0,
    )
    leader = Motions.of([[50.0, 50.0]], speed_mps=[25.0], heading_rad=[course], acceleration_mps2=[0.7])
    told = following(own, ahead, leader, commanded_mps2=np.zeros(1))
    assert told.gap_m == pytest.approx([4.5])
    assert told.ahead_speed_mps.tolist() == [21.0]
    seen = following(
        own, ahead, leader, commanded_mps2=np.zeros(1), ranging=Ranging(np.array([7.0]), np.array([-2.0]))
    )
    assert (seen.gap_m.tolist(), seen.ahead_speed_mps.tolist()) == ([7.0], [22.0])
    for one in (told, seen):
        assert one.ahead_acceleration_mps2.tolist() == [0.5]
        assert (one.leader_speed_mps.tolist(), one.leader_acceleration_mps2.tolist()) == ([25.0], [0.7])


def test_path_at_02_rad_a_second_damps_spacing_errors_and_at_02_hz_it_does_not() -> None:
    """What the unit of the bandwidth is: with a lag of 0.5 s only the angular one is stable."""
    assert worst(PathCacc())[0] <= 1.0
    assert worst(PathCacc(bandwidth_radps=2.0 * np.pi * 0.2))[0] > 1.4


def test_path_without_a_lag_has_the_spacing_error_of_the_closed_form() -> None:
    """e_i / e_(i-1) = 0.5 (s + 0.4) / (s + 0.2) for the defaults, from Rajamani's equations."""
    s = 1j * FREQUENCIES_RADPS
    leader = np.ones_like(s)
    first = PathCacc().response(s, leader, leader, 0.0)
    second = PathCacc().response(s, first, leader, 0.0)
    # The first follows the leader itself, without an error.
    assert first == pytest.approx(leader)
    third = PathCacc().response(s, 1.1 * leader, leader, 0.0)
    fourth = PathCacc().response(s, third, leader, 0.0)
    assert (fourth - third) / (third - 1.1 * leader) == pytest.approx(0.5 * (s + 0.4) / (s + 0.2))
    assert second == pytest.approx(leader)


@pytest.mark.parametrize(("headway_s", "stable"), [(0.3, False), (0.95, False), (1.0, True), (1.2, True)])
def test_acc_is_stable_from_twice_the_lag_on(headway_s: float, stable: bool) -> None:
    growth, _ = worst(Acc(headway_s=headway_s))
    assert (growth <= 1.0 + 1e-9) == stable


def test_ploeg_told_what_is_done_amplifies_where_told_what_is_asked_it_does_not() -> None:
    """Ploeg's own is 1 / (h s + 1); the acceleration that the vehicle ahead has comes a lag later."""
    assert worst(Ploeg())[0] == pytest.approx(1.248, abs=SEEN_RATIO)
    s = 1j * FREQUENCIES_RADPS
    alone = Ploeg().response(s, np.ones_like(s), np.ones_like(s), 0.0)
    assert alone == pytest.approx(1.0 / (0.5 * s + 1.0))


def test_columns_of_different_lengths_are_refused() -> None:
    with pytest.raises(ValueError, match="gap_m"):
        replace(known(), gap_m=np.zeros(3))


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: PathCacc(leader_weight=1.0), "leader_weight"),
        (lambda: PathCacc(damping=0.9), "damping"),
        (lambda: PathCacc(bandwidth_radps=0.0), "bandwidth_radps"),
        (lambda: PathCacc(spacing_m=-1.0), "spacing_m"),
        (lambda: Ploeg(headway_s=0.0), "headway_s"),
        (lambda: Ploeg(speed_gain=np.nan), "speed_gain"),
        (lambda: Acc(distance_gain=0.0), "distance_gain"),
    ],
)
def test_impossible_laws_are_refused(make: type, match: str) -> None:
    with pytest.raises(ValueError, match=match):
        make()
