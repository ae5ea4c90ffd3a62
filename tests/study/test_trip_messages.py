"""Claims about what a sender transmits over a trip, event for event."""

from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
import pytest

from modelcast.core.arrays import BoolArray
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.station.banks import BASELINE_BANK, PAPER_BANK
from modelcast.station.policy.base import MessageKind, TransmitInputs
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.trips.trajectory import Trajectory

MARGIN_M = 1e-9
"""Two ways to predict differ by less; where an error lies closer to the threshold, neither is wrong."""

THRESHOLDS_M = (0.2, 0.3, 0.4, 0.5)
STARTS = ("order", "keep", "survivor", "hindsight", "guarded")
IDENTIFIES = ("on-failure", "final", "best", "never")

TWO_GPS = Bank(
    (
        GaussianProcess(form="intercept"),
        ConstantVelocity(),
        GaussianProcess(20, "anchored", noise_floor_m=0.01),
    )
)


def ready(trip: Trajectory, bank: Bank) -> TripRuntime:
    return TripRuntime(trip, bank, velocity_estimator_for(trip))


def events(walk: TripMessages) -> list[tuple[int, str, int]]:
    at = np.flatnonzero(walk.transmits)
    return [(int(i), MessageKind(walk.kind[i]).label, int(walk.in_use[i])) for i in at]


def updates(walk: TripMessages) -> BoolArray:
    return np.isin(walk.kind, (MessageKind.UPDATE, MessageKind.KEEP_ALIVE))


def every_rule() -> list[ErrorDriven]:
    return [
        ErrorDriven(threshold_m, start, identify, longest_s)
        for threshold_m, start, identify, longest_s in product(THRESHOLDS_M, STARTS, IDENTIFIES, (None, 2.0))
    ]


def differences(
    trip: Trajectory, bank: Bank, replica: Callable[..., Any], algorithm_1: Callable[..., Any]
) -> tuple[list[ErrorDriven], int]:
    """Policies whose walk is not the reference's, and how many could be compared."""
    walked, plain = ready(trip, bank), replica(trip, bank)
    wrong, compared = [], 0
    for policy in every_rule():
        expected, margin_m = algorithm_1(
            plain,
            threshold_m=policy.threshold_m,
            start=policy.start,
            identify=policy.identify,
            longest_s=policy.max_inter_transmit_time_s or np.inf,
        )
        if margin_m < MARGIN_M:
            continue
        compared += 1
        if events(walked.run(policy)) != expected:
            wrong.append(policy)
    return wrong, compared


@pytest.mark.slow
@pytest.mark.real
@pytest.mark.parametrize("name", ["TESLA_MODELX", "MERCEDES_GLE450"])
def test_the_walk_is_algorithm_1_on_test_track_trips(
    name: str,
    dynamic_trips: dict[str, Trajectory],
    replica: Callable[..., Any],
    algorithm_1: Callable[..., Any],
) -> None:
    wrong, compared = differences(dynamic_trips[name], PAPER_BANK, replica, algorithm_1)
    assert (wrong, compared) == ([], 160)


@pytest.mark.slow
@pytest.mark.real
def test_the_walk_is_algorithm_1_on_the_safety_pilot_log(
    spmd_trip: Trajectory, replica: Callable[..., Any], algorithm_1: Callable[..., Any]
) -> None:
    wrong, compared = differences(spmd_trip, PAPER_BANK, replica, algorithm_1)
    assert (wrong, compared) == ([], 160)


@pytest.mark.slow
def test_the_walk_is_algorithm_1_with_three_sub_models_over_gaps(
    gapped_drive: Trajectory, replica: Callable[..., Any], algorithm_1: Callable[..., Any]
) -> None:
    wrong, compared = differences(gapped_drive, TWO_GPS, replica, algorithm_1)
    assert wrong == []
    assert compared > 100


@pytest.mark.real
@pytest.mark.parametrize("identify", IDENTIFIES)
def test_deciding_in_batch_sample_by_sample_is_the_walk(
    identify: Any, dynamic_trips: dict[str, Trajectory], replica: Callable[..., Any]
) -> None:
    trips = [trip for trip in dynamic_trips.values() if len(trip) == 1299][:4]
    policy = ErrorDriven(0.3, "survivor", identify, 2.0)
    senders = [replica(trip, PAPER_BANK) for trip in trips]
    members = range(2)
    rng = np.random.default_rng(0)
    state = policy.init(len(trips), 2)
    origin, spoken = np.zeros(len(trips), dtype=int), np.zeros(len(trips), dtype=int)
    kinds, used = [], []
    for now in range(1299):
        t_s = np.array([trip.t_s[now] for trip in trips])
        errors = [
            [one.tracking_error_m(origin[v], now, m) if now else np.inf for m in members]
            for v, one in enumerate(senders)
        ]
        inputs = TransmitInputs(
            t_s,
            t_s - [trip.t_s[i] for trip, i in zip(trips, origin, strict=True)],
            silence_s=t_s - [trip.t_s[i] for trip, i in zip(trips, spoken, strict=True)],
            tracking_error_m=np.array(errors),
            available=np.array([[one.has_window(now, m) for m in members] for one in senders]),
        )
        decisions, state = policy.decide(state, inputs, rng)
        origin[np.isin(decisions.kind, (MessageKind.UPDATE, MessageKind.KEEP_ALIVE))] = now
        spoken[decisions.kind != MessageKind.NOTHING] = now
        kinds.append(decisions.kind)
        used.append(decisions.in_use)
    for v, trip in enumerate(trips):
        walk = ready(trip, PAPER_BANK).run(policy)
        assert np.array_equal(walk.kind, np.array(kinds)[:, v])
        assert np.array_equal(walk.in_use, np.array(used)[:, v])


def test_on_constant_acceleration_the_baseline_speaks_when_half_a_t_squared_reaches_the_threshold(
    accelerating: Trajectory,
) -> None:
    """At 2 m/s² the error is t²: 0.25 m at 0.5 s exactly, which has failed; 0.3 m is reached by 0.6 s."""
    for threshold_m, steps in ((0.25 - 1e-6, 5), (0.3, 6), (1.0 - 1e-6, 10)):
        walk = ready(accelerating, BASELINE_BANK).run(ErrorDriven(threshold_m))
        assert set(np.diff(np.flatnonzero(walk.transmits))) == {steps}
        assert walk.identifications == 0


def test_an_error_equal_to_the_threshold_has_failed() -> None:
    """Standing still after one sample at 1 m/s along a binary grid: the errors are exactly 1/8, 2/8, ..."""
    t = np.arange(9) * 0.125
    trip = Trajectory(
        "made/equal",
        t,
        np.zeros((9, 2)),
        segments=np.array([0, 9]),
        dt_s=0.125,
        speed_mps=np.where(t == 0.0, 1.0, 0.0),
        heading_rad=np.zeros(9),
    )
    assert events(ready(trip, BASELINE_BANK).run(ErrorDriven(0.5)))[1] == (4, "update", 0)
    assert events(ready(trip, BASELINE_BANK).run(ErrorDriven(np.nextafter(0.5, 1.0))))[1] == (5, "update", 0)


@pytest.mark.parametrize("policy", every_rule()[::5], ids=str)
def test_the_baseline_never_identifies(policy: ErrorDriven, gapped_drive: Trajectory) -> None:
    walk = ready(gapped_drive, BASELINE_BANK).run(policy)
    assert walk.identifications == 0
    assert not walk.in_use.any()


@pytest.mark.parametrize("bank", [BASELINE_BANK, PAPER_BANK, TWO_GPS], ids=lambda bank: bank.name)
@pytest.mark.parametrize("longest_s", [0.5, 2.0])
def test_no_silence_exceeds_the_limit_by_more_than_a_step(
    bank: Bank, longest_s: float, gapped_drive: Trajectory
) -> None:
    walk = ready(gapped_drive, bank).run(ErrorDriven(0.5, max_inter_transmit_time_s=longest_s))
    at = np.flatnonzero(walk.transmits)
    t_s = gapped_drive.t_s
    steps_s = t_s[at[1:]] - t_s[at[1:] - 1]
    assert (np.diff(t_s[at]) < longest_s + steps_s).all()
    assert t_s[-1] - t_s[at[-1]] < longest_s


def test_a_keep_alive_is_sent_only_where_something_still_holds(gapped_drive: Trajectory) -> None:
    sender = ready(gapped_drive, PAPER_BANK)
    walk = sender.run(ErrorDriven(0.3, max_inter_transmit_time_s=1.0))
    alive = walk.kind == MessageKind.KEEP_ALIVE
    assert alive.any()
    assert (sender.tracking_error_m(walk)[alive].min(axis=1) < 0.3).all()


def test_an_update_is_sent_where_nothing_holds_and_nowhere_else(gapped_drive: Trajectory) -> None:
    """Under the rules that leave Algorithm 1 as it is."""
    for identify in ("on-failure", "best"):
        sender = ready(gapped_drive, PAPER_BANK)
        walk = sender.run(ErrorDriven(0.3, identify=identify))
        failed = sender.tracking_error_m(walk).min(axis=1) >= 0.3
        assert np.array_equal(walk.kind == MessageKind.UPDATE, failed)


@pytest.mark.parametrize("start", STARTS)
def test_final_never_returns_to_a_sub_model_that_failed_since_the_update(
    start: Any, gapped_drive: Trajectory
) -> None:
    sender = ready(gapped_drive, TWO_GPS)
    walk = sender.run(ErrorDriven(0.2, start, "final"))
    assert walk.identifications > 0
    for first, end in zip(
        np.flatnonzero(updates(walk)), [*np.flatnonzero(updates(walk))[1:], None], strict=True
    ):
        failed = np.maximum.accumulate(sender.tracking_error_m(walk)[first:end][1:] >= 0.2)
        used = walk.in_use[first:end][1:]
        assert not failed[np.arange(used.size), used].any()


def test_best_always_uses_the_smallest_error(gapped_drive: Trajectory) -> None:
    sender = ready(gapped_drive, TWO_GPS)
    walk = sender.run(ErrorDriven(0.3, identify="best"))
    kept = ~updates(walk)
    best = sender.tracking_error_m(walk)[kept].argmin(axis=1)
    assert np.array_equal(walk.in_use[kept], best)


@pytest.mark.parametrize("identify", IDENTIFIES)
def test_the_sub_model_in_use_holds_after_every_sample_without_an_update(
    identify: Any, gapped_drive: Trajectory
) -> None:
    sender = ready(gapped_drive, TWO_GPS)
    walk = sender.run(ErrorDriven(0.3, identify=identify))
    kept = np.flatnonzero(~updates(walk))
    assert (sender.tracking_error_m(walk)[kept, walk.in_use[kept]] < 0.3).all()


def test_thresholds_share_fits_without_changing_each_other(gapped_drive: Trajectory) -> None:
    shared = ready(gapped_drive, PAPER_BANK)
    for threshold_m in (*THRESHOLDS_M, *THRESHOLDS_M[::-1]):
        policy = ErrorDriven(threshold_m)
        assert events(shared.run(policy)) == events(ready(gapped_drive, PAPER_BANK).run(policy))


def test_constant_velocity_serves_where_a_window_is_short(gapped_drive: Trajectory) -> None:
    bank = Bank((GaussianProcess(form="intercept"), ConstantVelocity()))
    walk = ready(gapped_drive, bank).run(ErrorDriven(0.2))
    short = np.arange(len(gapped_drive)) - gapped_drive.segment_start + 1 < 10
    assert (walk.in_use[short & updates(walk)] == 1).all()
    assert walk.in_use[0] == 1


def test_a_bank_without_a_member_for_short_windows_is_completed(gapped_drive: Trajectory) -> None:
    """At a start, and after a gap, constant velocity serves; elsewhere the bank's own member alone."""
    alone = ready(gapped_drive, Bank((GaussianProcess(form="intercept"),)))
    assert [member.name for member in alone.bank.members] == ["gp-intercept", "cv"]
    walk = alone.run(ErrorDriven(0.3))
    short = np.arange(len(gapped_drive)) - gapped_drive.segment_start + 1 < 10
    at = updates(walk)
    assert (walk.in_use[short & at] == 1).all()
    assert (walk.in_use[~short & at] == 0).all()
    fitted_late = ~short[walk.update_index]
    later = np.roll(fitted_late, 1)
    later[0] = False
    assert np.isinf(alone.tracking_error_m(walk)[later & fitted_late & ~at, 1]).all()
