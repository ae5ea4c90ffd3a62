"""Claims about the guard of legacy receivers: the plain part of the last message must hold for them too."""

from typing import Any

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.messages.bsm import decode_bsm
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.station.banks import named_bank, profile_number_of
from modelcast.station.policy.base import MessageKind, TransmitInputs
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.error_driven_kernels import (
    IDENTIFICATION,
    KEEP_ALIVE,
    NOTHING,
    UPDATE,
    for_legacy,
)
from modelcast.station.sender.octets import StationOctets
from modelcast.station.sensing.sensing import NOWHERE
from modelcast.station.sensing.velocity import REPORTED
from modelcast.study.agreement import agreement
from modelcast.study.case import make_case
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive

CTRA, CV = ConstantTurnRateAcceleration(), ConstantVelocity()
SPEED_MPS, BRAKING_MPS2 = 30.0, -3.0

PLACE_M = 0.0121
"""A place goes through codes of latitude and longitude of 1.1 cm: half of one on each axis."""


def braking(count: int = 81) -> Trajectory:
    """Straight north, at constant deceleration."""
    t_s = 0.1 * np.arange(count)
    way = SPEED_MPS * t_s + 0.5 * BRAKING_MPS2 * t_s**2
    return build_trajectory(
        "braking/1",
        t_s,
        np.stack([np.zeros(count), way], axis=1),
        speed_mps=SPEED_MPS + BRAKING_MPS2 * t_s,
        heading_rad=np.zeros(count),
        acceleration_mps2=np.full(count, BRAKING_MPS2),
        yaw_rate_radps=np.zeros(count),
    )


def sent_at(walk: TripMessages) -> list[int]:
    return np.flatnonzero(walk.transmits).tolist()


@pytest.mark.parametrize(("legacy_m", "every"), [(0.2, 4), (0.5, 6), (1.0, 9), (3.0, 15)])
def test_a_braking_car_is_heard_whenever_constant_velocity_errs_by_the_threshold(
    legacy_m: float, every: int
) -> None:
    """Of 3 m/s^2 it errs by a t^2 / 2, so the next sample after sqrt(2 e / a) calls for an update."""
    assert every == np.ceil(10.0 * np.sqrt(2.0 * legacy_m / -BRAKING_MPS2))
    runtime = TripRuntime(braking(), Bank((CTRA, CV)), REPORTED)
    policy = ErrorDriven(0.5, "keep", "never")
    assert sent_at(runtime.run(policy)) == [0]  # the model holds to the end
    minding = ErrorDriven(0.5, "keep", "never", legacy_threshold_m=legacy_m)
    assert sent_at(runtime.run(minding)) == list(range(0, 81, every))


def test_a_threshold_that_nobody_reaches_changes_nothing() -> None:
    for bank, rules in (
        (named_bank("default").bank, ("guarded", "never")),
        (Bank((CTRA, CV)), ("order", "on-failure")),
        (Bank((CTRA, CV)), ("survivor", "best")),
    ):
        case = make_case(generate_drive(seed=4, duration_s=90.0).input, EvaluationSettings())
        runtime = TripRuntime(case.seen, bank, case.estimator, quantised=True)
        policy = ErrorDriven(0.3, *rules)  # type: ignore[arg-type]
        far = ErrorDriven(0.3, *rules, legacy_threshold_m=1e9)  # type: ignore[arg-type]
        for one, other in zip(_columns(runtime.run(policy)), _columns(runtime.run(far)), strict=True):
            np.testing.assert_array_equal(one, other)


def _columns(walk: TripMessages) -> tuple[Any, ...]:
    return walk.kind, walk.in_use, walk.update_index


def legacy_errors(runtime: TripRuntime, walk: TripMessages, bank: Bank, identify: str) -> FloatArray:
    """Error at each sample of who decodes Part I and coasts it, after what is sent there, (T,)."""
    trip = runtime.trip
    writer = StationOctets.of(runtime.bank, profile_number_of(bank), identify, trip.origin or NOWHERE)
    octets = dict(zip(sent_at(walk), writer.encode(runtime.sent(walk)), strict=True))
    errors = np.empty(len(trip))
    fit_s, place, velocity = 0.0, np.zeros(2), np.zeros(2)
    for at, t_s in enumerate(trip.t_s.tolist()):
        if at in octets and walk.kind[at] != MessageKind.IDENTIFICATION:
            core = decode_bsm(octets[at]).core
            speed, heading = core.value("speed_mps"), core.value("heading_rad")
            assert speed is not None
            assert heading is not None
            fit_s, place = float(runtime.stated_s[at]), runtime.stated_m[at]
            velocity = speed * np.array([np.sin(heading), np.cos(heading)])
        errors[at] = np.hypot(*(place + velocity * (t_s - fit_s) - runtime.samples[at, :2]))
    return errors


@pytest.mark.parametrize(
    ("bank", "rules"),
    [
        ("default", ("guarded", "never")),
        ("default", ("hindsight", "never")),
        ("learned+ctra+gp-vehicle+cv", ("guarded", "never")),
        ("learned+ctra+gp-vehicle+cv", ("order", "on-failure")),
        ("gp-intercept+ctra+cv", ("survivor", "best")),
    ],
)
@pytest.mark.parametrize("legacy_m", [0.4, 1.0])
def test_legacy_receivers_err_by_less_than_the_threshold_at_every_sample(
    bank: str, rules: tuple[str, str], legacy_m: float
) -> None:
    case = make_case(generate_drive(seed=4, duration_s=90.0).input, EvaluationSettings())
    chosen = named_bank(bank).bank
    runtime = TripRuntime(case.seen, chosen, case.estimator, quantised=True)
    policy = ErrorDriven(0.3, *rules)  # type: ignore[arg-type]
    minding = ErrorDriven(0.3, *rules, legacy_threshold_m=legacy_m)  # type: ignore[arg-type]
    free, bound = runtime.run(policy), runtime.run(minding)
    assert legacy_errors(runtime, free, chosen, rules[1]).max() > 2.0 * legacy_m
    assert legacy_errors(runtime, bound, chosen, rules[1]).max() < legacy_m + PLACE_M
    assert bound.updates > free.updates


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bank", "rules", "believe"),
    [
        ("default", ("guarded", "never"), "sent"),
        ("default", ("guarded", "never"), "expected"),
        ("learned+ctra+gp-vehicle+cv", ("survivor", "on-failure"), "sent"),
    ],
)
def test_what_is_evaluated_simulated_and_driven_sends_the_same_octets(
    bank: str, rules: tuple[str, str], believe: str
) -> None:
    case = make_case(generate_drive(seed=5, duration_s=90.0).input, EvaluationSettings(protocol="recorded"))
    policy = ErrorDriven(0.3, *rules, believe=believe, legacy_threshold_m=0.5)  # type: ignore[arg-type]
    found = agreement(case, named_bank(bank).bank, policy)
    assert found.agrees, found
    assert found.messages > 20


def decided(error_m: float, *, errors: tuple[float, float] = (0.1, 0.2), in_use: int = 0) -> tuple[int, int]:
    policy = ErrorDriven(0.5, legacy_threshold_m=1.0)
    inputs = TransmitInputs(
        np.array([7.0]),
        np.array([0.4]),
        silence_s=np.array([0.4]),
        tracking_error_m=np.array([errors]),
        available=np.ones((1, 2), dtype=np.bool_),
        legacy_error_m=np.array([error_m]),
    )
    state = policy.init(1, 2)
    state.in_use[:] = in_use
    decisions, _ = policy.decide(state, inputs, np.random.default_rng(0))
    return int(decisions.kind[0]), int(decisions.in_use[0])


def test_a_policy_of_its_own_asks_for_the_error_of_legacy_receivers() -> None:
    assert decided(1.0) == (MessageKind.UPDATE, 0)
    assert decided(np.nextafter(1.0, 0.0)) == (MessageKind.NOTHING, 0)
    assert decided(0.9, errors=(0.6, 0.2)) == (MessageKind.IDENTIFICATION, 1)
    assert decided(1.1, errors=(0.6, 0.2)) == (MessageKind.UPDATE, 0)  # it starts in order, naming nobody
    assert decided(1.1, in_use=1) == (MessageKind.UPDATE, 0)


def test_who_is_not_told_of_another_sub_model_keeps_the_one_in_use() -> None:
    """Constant velocity fails when legacy receivers do, so an update comes in place of naming the other."""
    runtime = TripRuntime(braking(), Bank((CV, CTRA)), REPORTED)
    named = runtime.run(ErrorDriven(0.5, "keep", "on-failure"))
    assert set(named.in_use.tolist()) == {0, 1}
    minding = runtime.run(ErrorDriven(0.5, "keep", "on-failure", legacy_threshold_m=0.5))
    assert set(minding.in_use.tolist()) == {0}
    assert sent_at(minding) == list(range(0, 81, 6))


def test_an_update_takes_the_place_of_anything_but_an_update() -> None:
    for kind in (NOTHING, IDENTIFICATION, UPDATE, KEEP_ALIVE):
        assert for_legacy(kind, 0.99, 1.0) == kind
        assert for_legacy(kind, 1.0, 1.0) == (KEEP_ALIVE if kind == KEEP_ALIVE else UPDATE)


def test_a_threshold_that_is_none_is_refused_and_so_are_inputs_without_the_error() -> None:
    for value in (0.0, -1.0, np.nan):
        with pytest.raises(ValueError, match="legacy_threshold_m must be positive"):
            ErrorDriven(0.5, legacy_threshold_m=value)
    one = np.ones(1)
    inputs = TransmitInputs(
        one, one, silence_s=one, tracking_error_m=one[:, None], available=np.ones((1, 1), dtype=np.bool_)
    )
    policy = ErrorDriven(0.5, legacy_threshold_m=1.0)
    with pytest.raises(ValueError, match=r"needs TransmitInputs\.legacy_error_m"):
        policy.decide(policy.init(1, 1), inputs, np.random.default_rng(0))
