"""Claim: what is evaluated, what is simulated and what drives send the same octets, on any drive."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.exceptions import ConfigError
from modelcast.station.banks import named_bank
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sender.lane_rules import check_rules
from modelcast.study.agreement import agreement, first_difference
from modelcast.study.case import make_case
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive

OF_FOUR = "learned+ctra+gp-vehicle+cv"
BANKS = (
    "default",
    OF_FOUR,
    "paper",
    "ctra",
    "gp-intercept+cv",
    "shs",
    "hdp-hmm+ctra+shs+cv",
    "imm",
    "learned+imm+cv",
)
RULES = ("guarded/never", "hindsight/cheapest", "order/on-failure", "keep/on-failure", "survivor/on-failure")


def policy_of(bank: str, rules: str, threshold_m: float) -> ErrorDriven:
    start, identify = rules.split("/")
    costs = (
        named_bank("default" if bank == OF_FOUR else bank).costs("bytes") if identify == "cheapest" else None
    )
    return ErrorDriven(threshold_m, start, identify, costs=costs)  # type: ignore[arg-type]


@st.composite
def drives(draw: st.DrawFn) -> Trajectory:
    """Drives that change acceleration and yaw rate, with noise, gaps, and all or some of the columns."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = draw(st.integers(30, 160))
    each = draw(st.integers(5, 40))
    held = np.repeat(np.arange(count), each)[:count]
    acceleration, yaw_rate = rng.normal(0.0, 2.0, count)[held], rng.normal(0.0, 0.3, count)[held]
    speed = np.maximum(draw(st.floats(0.0, 30.0)) + np.cumsum(acceleration) * 0.1, 0.0)
    heading = np.mod(np.cumsum(yaw_rate) * 0.1, 2 * np.pi)
    step = speed[:, None] * np.stack([np.sin(heading), np.cos(heading)], axis=1) * 0.1
    noise_m = draw(st.sampled_from([0.0, 0.01, 0.3]))
    position = np.cumsum(step, axis=0) + rng.normal(0.0, 1.0, (count, 2)) * noise_m
    t_s = 0.1 * np.arange(count)
    t_s[draw(st.integers(0, count - 1)) :] += draw(st.sampled_from([0.0, 0.3, 2.0]))
    reported = draw(st.booleans())
    return build_trajectory(
        "made/1",
        t_s,
        position,
        speed_mps=speed if reported else None,
        heading_rad=heading if reported else None,
        acceleration_mps2=acceleration if draw(st.booleans()) else None,
        yaw_rate_radps=yaw_rate if draw(st.booleans()) else None,
    )


any_choice = given(
    drives(), st.sampled_from(BANKS), st.sampled_from(RULES), st.sampled_from([0.05, 0.2, 0.5])
)


@settings(max_examples=12)
@any_choice
def test_three_runtimes_and_the_host_agree(
    drive: Trajectory, bank: str, rules: str, threshold_m: float
) -> None:
    all_agree(drive, bank, rules, threshold_m)


@pytest.mark.slow
@settings(max_examples=100)
@any_choice
def test_three_runtimes_and_the_host_agree_on_many_drives(
    drive: Trajectory, bank: str, rules: str, threshold_m: float
) -> None:
    all_agree(drive, bank, rules, threshold_m)


def all_agree(drive: Trajectory, bank: str, rules: str, threshold_m: float) -> None:
    try:
        policy = policy_of(bank, rules, threshold_m)
    except (ConfigError, ValueError):
        assert rules == "hindsight/cheapest"
        assert bank not in ("default", OF_FOUR)
        return
    if bank == "default" and policy.identify != "never":
        with pytest.raises(ValueError, match="identify must be never with free-predictive, free, got"):
            check_rules(policy, named_bank(bank).bank, None)
        return
    case = make_case(drive, EvaluationSettings(protocol="recorded"))
    found = agreement(case, named_bank(bank).bank, policy)
    assert found.agrees, found
    assert found.messages > 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bank", "rules"),
    [
        ("default", "guarded/never"),
        pytest.param("default", "order/never", marks=pytest.mark.slow),
        *((OF_FOUR, rules) for rules in RULES[:2]),
        *(pytest.param(OF_FOUR, rules, marks=pytest.mark.slow) for rules in RULES[2:]),
    ],
)
def test_they_agree_on_a_long_drive_of_a_bank_of_four(bank: str, rules: str) -> None:
    drive = generate_drive(seed=5, duration_s=90.0).input
    case = make_case(drive, EvaluationSettings(protocol="recorded"))
    found = agreement(case, named_bank(bank).bank, policy_of(bank, rules, 0.3))
    assert found.agrees, found
    assert found.messages > 10


@pytest.mark.parametrize(
    ("found", "text"),
    [
        ([(0, b"ab"), (7, b"cd")], ""),
        ([(0, b"ab"), (8, b"cd")], "message 1: sample 8, not 7"),
        ([(0, b"ab"), (7, b"cx")], "message 1: byte 1 of 2 (sample 7)"),
        ([(0, b"a"), (7, b"cd")], "message 0: byte 1 of 2 (sample 0)"),
        ([(0, b"ab"), (7, b"cde")], "message 1: byte 2 of 2 (sample 7)"),
        ([(0, b"ab")], "1 messages, not 2"),
        ([(0, b"ab"), (7, b"cd"), (9, b"")], "3 messages, not 2"),
    ],
)
def test_the_first_difference_is_told(found: list[tuple[int, bytes]], text: str) -> None:
    assert first_difference([(0, b"ab"), (7, b"cd")], found) == text
