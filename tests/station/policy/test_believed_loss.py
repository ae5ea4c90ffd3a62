"""Claims about senders that expect losses: against their words in plain Python, and in closed form."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantAcceleration, ConstantTurnRateAcceleration
from modelcast.models.trusted import Trusted
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.station.banks import believe_of
from modelcast.station.policy.base import MessageKind
from modelcast.station.policy.believed_loss_kernels import (
    DEPTH,
    MOST_LOST,
    believed_loss,
    error_growth,
    share_held,
)
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.error_driven_kernels import longest_silence_s
from modelcast.station.sender.lane_rules import check_rules
from modelcast.station.sensing.velocity import REPORTED
from modelcast.trips.trajectory import Trajectory, build_trajectory

MARGIN_M = 1e-9
"""Two ways to predict differ by less; where an error lies closer to its limit, neither is wrong."""

CTRA, CA, CV = Trusted(ConstantTurnRateAcceleration(), 1.0, 1.0), ConstantAcceleration(), ConstantVelocity()


def swerving(seed: int) -> Trajectory:
    """Twenty seconds of a car whose acceleration and yaw rate jump every second."""
    rng = np.random.default_rng(seed)
    acceleration = np.repeat(rng.uniform(-2.0, 2.0, 20), 10)
    yaw_rate = np.repeat(rng.uniform(-0.3, 0.3, 20), 10)
    speed = 15.0 + np.cumsum(acceleration) * 0.1
    heading = np.cumsum(yaw_rate) * 0.1
    steps = 0.1 * speed[:, None] * np.stack([np.sin(heading), np.cos(heading)], axis=1)
    return build_trajectory(
        "made/swerves",
        np.round(0.1 * np.arange(200), 6),
        np.cumsum(steps, axis=0),
        speed_mps=speed,
        heading_rad=np.mod(heading, 2.0 * np.pi),
        acceleration_mps2=acceleration,
        yaw_rate_radps=yaw_rate,
    )


def speeding(acceleration_mps2: float, seconds: float) -> Trajectory:
    """A car that accelerates for ever: constant velocity errs by half of it times its age squared."""
    t = np.round(0.1 * np.arange(round(10.0 * seconds)), 6)
    speed = 10.0 + acceleration_mps2 * t
    return build_trajectory(
        "made/faster",
        t,
        np.stack([10.0 * t + 0.5 * acceleration_mps2 * t * t, np.zeros(t.size)], axis=1),
        speed_mps=speed,
        heading_rad=np.full(t.size, 0.5 * np.pi),
        acceleration_mps2=np.full(t.size, acceleration_mps2),
        yaw_rate_radps=np.zeros(t.size),
    )


def spoken_in_words(
    runtime: TripRuntime, policy: ErrorDriven, speed_mps: FloatArray
) -> tuple[list[tuple[int, str]], float]:
    """What a bank of one sends by the words of the policy, and how close it came to either limit [m]."""
    trip, loss = runtime.trip, policy.packet_error_ratio
    member = runtime.bank.members[0]
    growth = max(1.0, (1.0 + loss) / ((1.0 - loss) * policy.budget) ** 2)
    runtime.fit_at(np.arange(len(trip)))

    def error_m(of: int, at: int) -> float:
        age_s = np.array([trip.t_s[at] - runtime.stated_s[of]])
        moved = member.predict(runtime.parameters[of : of + 1], age_s, dt_s=trip.dt_s)[0, 0]
        off = runtime.stated_m[of] + moved - trip.position_m[at]
        return float(np.hypot(*off))

    sent: list[tuple[int, str]] = []
    margin_m = np.inf
    for at in range(len(trip)):
        if not sent:
            sent.append((at, "update"))
            continue
        held = [number for number, _ in reversed(sent)][:DEPTH]
        shares = [(1.0 - loss) * loss**k for k in range(len(held) - 1)]
        shares.append(loss ** (len(held) - 1))
        expected_m = sum(share * error_m(of, at) for share, of in zip(shares, held, strict=True))
        margin_m = min(margin_m, abs(expected_m - growth * policy.threshold_m))
        longest_s = policy.max_inter_transmit_time_s or np.inf
        longest_s = min(longest_s, 0.5 * policy.approach_m / speed_mps[at])
        if expected_m >= growth * policy.threshold_m:
            sent.append((at, "update"))
        elif trip.t_s[at] - trip.t_s[held[0]] >= longest_s - 1e-9:
            sent.append((at, "keep-alive"))
    return sent, margin_m


def events(walk: TripMessages) -> list[tuple[int, str]]:
    return [(int(at), MessageKind(walk.kind[at]).label) for at in np.flatnonzero(walk.transmits)]


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize(
    ("loss", "budget", "approach_m"),
    [(0.1, np.inf, np.inf), (0.4, 4.0 / 3.0, np.inf), (0.4, np.inf, 20.0), (0.7, 1.0, 30.0)],
)
def test_a_sender_that_expects_losses_is_what_its_words_say(
    seed: int, loss: float, budget: float, approach_m: float
) -> None:
    trip = swerving(seed)
    runtime = TripRuntime(trip, Bank((CTRA,)), REPORTED)
    policy = ErrorDriven(
        0.2,
        max_inter_transmit_time_s=1.5,
        believe="expected",
        packet_error_ratio=loss,
        budget=budget,
        approach_m=approach_m,
    )
    assert trip.speed_mps is not None
    expected, margin_m = spoken_in_words(runtime, policy, trip.speed_mps)
    assert margin_m >= MARGIN_M
    assert events(runtime.run(policy)) == expected


def test_with_no_losses_to_expect_it_is_algorithm_1() -> None:
    for bank, start in ((Bank((CTRA,)), "order"), (Bank((CTRA, CA, CV)), "guarded")):
        for seed in range(3):
            runtime = TripRuntime(swerving(seed), bank, REPORTED)
            plain = ErrorDriven(0.15, start, "never", 1.0)  # type: ignore[arg-type]
            expecting = ErrorDriven(0.15, start, "never", 1.0, believe="expected")  # type: ignore[arg-type]
            assert events(runtime.run(expecting)) == events(runtime.run(plain))


def test_more_losses_expected_are_answered_by_more_messages_where_the_budget_is_open() -> None:
    runtime = TripRuntime(swerving(3), Bank((CTRA,)), REPORTED)
    counts = [
        runtime.run(ErrorDriven(0.2, believe="expected", packet_error_ratio=loss, budget=np.inf)).updates
        for loss in (0.0, 0.2, 0.4, 0.6)
    ]
    assert all(fewer < more for fewer, more in pairwise(counts))


@pytest.mark.parametrize(("loss", "share"), [(0.2, 0.06), (0.4, 0.06), (0.6, 0.13)])
@pytest.mark.parametrize("budget", [1.0, 2.0])
def test_the_budget_holds_where_errors_grow_with_the_square_of_their_age(
    loss: float, share: float, budget: float
) -> None:
    """Messages come in whole samples; at 60 % losses, what is beyond the last six remembered is left out."""
    runtime = TripRuntime(speeding(1.0, 120.0), Bank((CV,)), REPORTED)
    threshold_m = 8.0  # every 4 s without losses
    policy = ErrorDriven(threshold_m, believe="expected", packet_error_ratio=loss, budget=budget)
    at = np.flatnonzero(runtime.run(policy).transmits)[DEPTH + 4 :]
    growth = error_growth(loss, budget)
    wanted_s = 4.0 / budget if growth > 1.0 else 4.0 * (1.0 - loss) / (1.0 + loss) ** 0.5
    assert float(np.diff(at).mean()) * 0.1 == pytest.approx(wanted_s, rel=share)


def expected_m(runtime: TripRuntime, walk: TripMessages, loss: float) -> FloatArray:
    """The mean error over what a remote may hold before each sample's message, by what was sent (T,) [m]."""
    trip, bank = runtime.trip, runtime.bank
    found, sent = np.full(len(trip), np.inf), list[tuple[int, int]]()
    for at in range(len(trip)):
        held = sent[::-1][:DEPTH]
        shares = [share_held(loss, k, k + 1 == len(held)) for k in range(len(held))]
        errors: list[float] = []
        for of, m in held:
            own = runtime.parameters[of : of + 1, bank.offsets[m] : bank.offsets[m + 1]]
            age_s = np.array([trip.t_s[at] - runtime.stated_s[of]])
            moved = bank.members[m].predict(own, age_s, dt_s=trip.dt_s)[0, 0]
            errors.append(float(np.hypot(*(runtime.stated_m[of] + moved - trip.position_m[at]))))
        if held:
            found[at] = np.dot(shares, errors)
        if walk.transmits[at]:
            sent.append((at, int(walk.in_use[at])))
    return found


def test_the_older_messages_that_remotes_may_hold_are_those_before_the_last() -> None:
    """Two members take turns: what is remembered is the member that was sent, with its own parameters."""
    runtime = TripRuntime(swerving(5), Bank((CA, CV)), REPORTED)
    policy = ErrorDriven(0.2, "hindsight", "never", believe="expected", packet_error_ratio=0.3)
    walk = runtime.run(policy)
    assert set(walk.in_use[walk.transmits].tolist()) == {0, 1}
    limit_m = error_growth(0.3, policy.budget) * 0.2
    errors_m = expected_m(runtime, walk, 0.3)
    assert np.abs(errors_m - limit_m).min() >= MARGIN_M
    assert walk.transmits.tolist() == (errors_m >= limit_m).tolist()


def jerking(seed: int) -> Trajectory:
    """A car whose acceleration turns round three times a second: what it did last it does not do next."""
    rng = np.random.default_rng(seed)
    signs = np.repeat((-1.0) ** np.arange(67), 3)[:200]
    speed = 15.0 + np.cumsum(3.0 * signs * rng.uniform(0.6, 1.4, 200)) * 0.1
    return build_trajectory(
        "made/jerks",
        np.round(0.1 * np.arange(200), 6),
        np.stack([np.cumsum(speed) * 0.1, np.zeros(200)], axis=1),
        speed_mps=speed,
        heading_rad=np.full(200, np.pi / 2),
        acceleration_mps2=np.gradient(speed, 0.1),
        yaw_rate_radps=np.zeros(200),
    )


def test_a_guarded_sender_expects_by_the_memory_of_whom_it_follows() -> None:
    """While its bank serves, what it sent itself; in step with constant velocity, what that had sent."""
    acted = 0
    for seed in range(6):
        runtime = TripRuntime(jerking(seed), Bank((CA, CV)), REPORTED)
        policy = ErrorDriven(0.2, "guarded", "never", believe="expected", packet_error_ratio=0.4, budget=2.0)
        walk = runtime.run(policy)
        alone = TripRuntime(jerking(seed), Bank((CV,)), REPORTED).run(policy.alone)
        free = runtime.run(replace(policy, start="hindsight"))
        acted += int(events(walk) != events(free))
        due = expected_m(runtime, walk, 0.4) >= error_growth(0.4, 2.0) * 0.2
        followed = walk.in_use == 1
        assert not (due & ~walk.transmits & ~followed).any()
        assert not (walk.transmits & ~due & ~alone.transmits).any()
    assert acted >= 3


@given(st.floats(0.0, MOST_LOST), st.integers(1, 2 * DEPTH))
def test_the_shares_of_what_remotes_hold_add_up(loss: float, remembered: int) -> None:
    shares = [share_held(loss, k, k + 1 == remembered) for k in range(remembered)]
    assert min(shares) >= 0.0
    assert sum(shares) == pytest.approx(1.0, abs=1e-12)


@given(st.floats(0.0, MOST_LOST), st.floats(0.5, 4.0))
def test_the_growth_is_the_series_of_squares(loss: float, budget: float) -> None:
    k = np.arange(2000)
    series = float(((1.0 - loss) * loss**k * (k + 1.0) ** 2).sum())
    assert error_growth(loss, budget) == pytest.approx(max(1.0, series / budget**2), rel=1e-9)


@pytest.mark.parametrize(
    ("observed", "believed"), [(np.nan, 0.0), (0.0, 0.0), (0.35, 0.35), (0.95, MOST_LOST), (1.0, MOST_LOST)]
)
def test_a_loss_is_believed_within_bounds(observed: float, believed: float) -> None:
    assert believed_loss(observed) == believed


@pytest.mark.parametrize(("speed_mps", "longest_s"), [(0.0, 2.0), (7.5, 2.0), (15.0, 1.0), (30.0, 0.5)])
def test_two_that_meet_come_no_closer_than_asked_between_two_messages(
    speed_mps: float, longest_s: float
) -> None:
    assert longest_silence_s(2.0, 30.0, speed_mps) == longest_s
    assert longest_silence_s(2.0, np.inf, speed_mps) == 2.0


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"believe": "heard"}, "believe"),
        ({"packet_error_ratio": 1.5}, "packet_error_ratio"),
        ({"packet_error_ratio": np.nan}, "packet_error_ratio"),
        ({"budget": 0.0}, "budget"),
        ({"approach_m": -1.0}, "approach_m"),
        ({"believe": "expected", "start": "survivor"}, "survivor"),
    ],
)
def test_what_no_sender_can_expect_is_refused_by_name(changes: dict[str, Any], named: str) -> None:
    with pytest.raises(ValueError, match=named):
        ErrorDriven(0.2, **changes)


def test_who_names_without_an_update_cannot_expect_losses() -> None:
    policy = ErrorDriven(0.2, identify="on-failure", believe="expected")
    with pytest.raises(ValueError, match="identify"):
        check_rules(policy, Bank((CA, CV)), None)
    check_rules(policy, Bank((CV,)), None)
    assert believe_of("guarded", "never") == "expected"
    assert believe_of("guarded", "on-failure") == believe_of("order", "never") == "sent"
