"""Claims about senders before they send: what each name stands for, its lanes, its bank, its empty arrays."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modelcast.messages.airtime import Stack
from modelcast.messages.cam_sizes import measured_cam_sizes
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.kinematic import ConstantAcceleration, ConstantTurnRateAcceleration
from modelcast.models.learned import Selector
from modelcast.models.profile import default_profile
from modelcast.station.banks import BASELINE_BANK, free_bank
from modelcast.station.policy.cam import CooperativeAwareness
from modelcast.station.policy.costs import CostTable
from modelcast.station.policy.dcc import AdaptiveDcc, ReactiveDcc
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.j2945 import J2945
from modelcast.station.policy.j2945_parameters import J2945Parameters
from modelcast.station.policy.measured_cam import MeasuredCam
from modelcast.station.policy.periodic import Periodic
from modelcast.station.sender import message_arrays as at
from modelcast.station.sender.bank import SenderBank
from modelcast.station.sender.lane_rules import check_rules, speaking_lanes
from modelcast.station.sender.names import FREE_SENDERS, MODEL_SENDERS, SENDERS
from modelcast.station.sender.sender import Sender, engine_parameters, named_sender
from modelcast.station.sender.stations import guards_of, sender_bank, sending_stations, widest
from modelcast.station.sender.timed_kernels import timers
from modelcast.station.sensing.motion_filter import MotionFilter

CA, CTRA, CV = ConstantAcceleration(), ConstantTurnRateAcceleration(), ConstantVelocity()
GP = GaussianProcess(3, "intercept")
PLAIN = Bank((CV,))


def sender(policy: Any, bank: Bank = PLAIN, **more: Any) -> Sender:
    return Sender("tested", policy, bank, **more)


def costs(members: int, ages: int = 1) -> CostTable:
    """Lives of so many sub-models, in so many classes of age."""
    return CostTable(
        10.0,
        4.0,
        thresholds_m=np.array([0.1]),
        update_life_s=np.array([1.0]),
        age_edges_s=np.arange(1.0, ages),
        share_edges=np.empty(0),
        residual_life_s=np.ones((1, members, ages, 1)),
    )


def test_what_is_not_said_of_a_sender_is_a_few_milliseconds_and_a_code_of_latitude() -> None:
    plain = sender(Periodic(2.0))
    assert (plain.jitter_s, plain.within_m, plain.power_dbm, plain.start) == (0.005, 0.0112, 20.0, "order")
    assert (plain.threshold_m, plain.motion, plain.selector) == (0.2, None, None)


def test_a_spread_of_a_tenth_of_a_second_and_more_is_refused_and_a_resolution_of_0_is_not() -> None:
    assert sender(Periodic(2.0), jitter_s=0.0999, within_m=0.0).within_m == 0.0
    for jitter_s in (0.1, 0.15, 1.0, -0.001, float("nan")):
        with pytest.raises(ValueError, match="jitter_s must lie"):
            sender(Periodic(2.0), jitter_s=jitter_s)
    for within_m in (-1e-9, float("nan")):
        with pytest.raises(ValueError, match="within_m must not be negative"):
            sender(Periodic(2.0), within_m=within_m)


def test_a_bank_of_one_has_nothing_to_choose_from() -> None:
    policy = ErrorDriven(0.3, "keep", "best", 4.0)
    assert sender(policy).lanes == ErrorDriven(0.3, "order", "never", 4.0)
    assert sender(policy, Bank((CA, CV))).lanes == policy
    timed = sender(Periodic(2.0), Bank((CA, CV)), threshold_m=0.7, start="hindsight")
    assert timed.lanes == ErrorDriven(0.7, "hindsight", "never")


def test_engines_extrapolate_at_any_age_and_a_fifth_of_a_second_at_most() -> None:
    assert engine_parameters() == J2945Parameters(
        local_as_is_age_s=0.0, local_max_age_s=0.2, remote_as_is_age_s=0.0
    )
    own = J2945Parameters(jitter_s=0.011, local_max_age_s=0.9)
    assert engine_parameters(own) == replace(
        own, local_as_is_age_s=0.0, local_max_age_s=0.2, remote_as_is_age_s=0.0
    )


def test_plain_senders_have_the_policy_of_their_name() -> None:
    assert named_sender("bsm-10hz").policy == Periodic(10.0)
    assert named_sender("cam").policy == CooperativeAwareness(control=AdaptiveDcc())
    assert named_sender("cam-reactive").policy == CooperativeAwareness(control=ReactiveDcc())
    assert named_sender("cam-uncontrolled").policy == CooperativeAwareness(control=None)
    assert named_sender("cam-road").policy == MeasuredCam(control=AdaptiveDcc())
    assert named_sender("baseline", threshold_m=0.4, keep_alive_s=3.0).policy == ErrorDriven(
        0.4, "order", "never", 3.0, approach_m=20.0
    )
    assert named_sender("j2945").policy == J2945(engine_parameters())
    for name in ("bsm-10hz", "cam", "baseline", "mbc"):
        assert named_sender(name).within_m == 0.0112
        assert named_sender(name).start == "order"


def test_cars_frames_are_those_of_cam_road_alone_and_need_no_certificates() -> None:
    assert named_sender("cam-road").frames == measured_cam_sizes()
    assert named_sender("cam-road", stack=Stack("always", other_bytes=9)).stack == Stack("unsigned")
    assert named_sender("cam", stack=Stack("always")).stack == Stack("always")
    assert all(named_sender(name).frames is None for name in SENDERS if name != "cam-road")


def test_only_senders_named_for_it_filter_their_motion() -> None:
    own = MotionFilter(position_m=0.5)
    for name in ("bsm-10hz", "cam", "baseline", "mbc", "j2945"):
        assert named_sender(name, motion=own).motion is None
    for name in ("j2945-filtered", "j2945-mbc", "j2945-mbc-relaxed", "j2945-mbc-relaxed-5"):
        assert named_sender(name, motion=own).motion is own
        assert named_sender(name).motion == MotionFilter()


@pytest.mark.parametrize(("name", "longest_s"), [("j2945-mbc-relaxed", 2.0), ("j2945-mbc-relaxed-5", 5.0)])
def test_relaxed_senders_wait_as_their_name_says_and_resolve_two_fifths_of_their_error(
    name: str, longest_s: float
) -> None:
    for error_m, within_m in ((0.01, 0.004), (0.02, 0.008), (0.1, 0.0112), (3.0, 0.0112)):
        relaxed = named_sender(name, relaxed_error_m=error_m)
        assert isinstance(relaxed.policy, J2945)
        own = relaxed.policy.parameters
        assert own.min_inter_transmit_time_s == own.max_inter_transmit_time_s == longest_s
        assert own.min_tracking_error_m == own.max_tracking_error_m == error_m
        assert (own.local_max_age_s, own.remote_as_is_age_s) == (0.2, 0.0)
        assert relaxed.within_m == pytest.approx(within_m, rel=1e-12)
    noisy = named_sender(name, motion=MotionFilter(position_m=0.5)).policy
    exact = named_sender(name, motion=MotionFilter(position_m=0.001)).policy
    assert isinstance(noisy, J2945)
    assert isinstance(exact, J2945)
    assert (noisy.parameters.min_tracking_error_m, exact.parameters.min_tracking_error_m) == (0.5, 0.01)
    assert named_sender("j2945-mbc").within_m == 0.0112


@pytest.mark.parametrize("error_m", [0.0, -0.1, float("nan")])
def test_an_error_that_calls_for_a_message_is_positive(error_m: float) -> None:
    with pytest.raises(ValueError, match="relaxed_error_m must be positive"):
        named_sender("j2945-mbc-relaxed", relaxed_error_m=error_m)


def test_a_guarded_bank_of_several_needs_constant_velocity_and_one_alone_does_not() -> None:
    guarded = ErrorDriven(0.2, "guarded", "never")
    check_rules(guarded, Bank((CA,)), None)
    check_rules(guarded, Bank((CA, CV)), None)
    check_rules(ErrorDriven(0.2, "keep"), Bank((CA, CTRA)), None)
    with pytest.raises(ValueError, match="needs cv in the bank, got ca, ctra"):
        check_rules(guarded, Bank((CA, CTRA)), None)


def test_costs_must_fit_the_bank_only_where_they_are_counted() -> None:
    bank = Bank((CA, CV))
    check_rules(ErrorDriven(0.2, identify="never", costs=costs(3)), bank, None)
    check_rules(ErrorDriven(0.2, identify="cheapest", costs=costs(2)), bank, None)
    with pytest.raises(ValueError, match="3"):
        check_rules(ErrorDriven(0.2, identify="cheapest", costs=costs(3)), bank, None)


@pytest.mark.parametrize("guards", [(0,), (1,), (1, 0)])
def test_a_guarded_sender_has_silent_lanes_before_its_own(guards: tuple[int, ...]) -> None:
    """One a guard alone, then its bank's; without a guard it is one lane in order."""
    keep, guarded = ErrorDriven(0.2, "keep", "best", 3.0), ErrorDriven(0.4, "guarded", "final")
    lanes = speaking_lanes([guarded, keep, guarded], [7, 3, 5], guards=guards, dt_s=0.1, within_m=0.25)
    rules, own, count = lanes.rules, len(guards) + 2, 2 * len(guards) + 5
    assert lanes.speaks.tolist() == [own - 1, own, 2 * own]
    assert rules.vehicle.tolist() == [7] * own + [3] + [5] * own
    assert rules.threshold_m.tolist() == [0.4] * own + [0.2] + [0.4] * own
    assert rules.silence_s.tolist() == [np.inf] * own + [3.0] + [np.inf] * own
    group = [
        *[ErrorDriven(0.4, identify="never")] * len(guards),
        replace(guarded, start="hindsight"),
        guarded,
    ]
    policies = [*group, keep, *group]
    assert rules.start.tolist() == [one.start_code for one in policies]
    assert rules.identify.tolist() == [one.codes[2] for one in policies]
    assert rules.only.tolist() == [*guards, -1, -1, -1, *guards, -1, -1]
    bank, speaker, of_guards = np.full(count, -1), np.full(count, -1), np.full((count, 2), -1)
    for first in (0, own + 1):
        at = first + len(guards)
        bank[at + 1], speaker[at] = at, at + 1
        of_guards[at + 1, : len(guards)] = np.arange(first, at)
    assert rules.bank.tolist() == bank.tolist()
    assert rules.speaker.tolist() == speaker.tolist()
    assert rules.guards.tolist() == of_guards.tolist()
    assert rules.selector.tolist() == [[0.0]] * count
    assert rules.within_m == 0.25


def test_without_a_guard_a_guarded_sender_is_one_lane_in_order() -> None:
    keep, guarded = ErrorDriven(0.2, "keep", "best", 3.0), ErrorDriven(0.4, "guarded", "final")
    alone = speaking_lanes([guarded, keep], [0, 1], guards=(), dt_s=0.1)
    assert alone.speaks.tolist() == [0, 1]
    assert alone.rules.start.tolist() == [ErrorDriven(0.4).start_code, keep.start_code]
    for column in (alone.rules.bank, alone.rules.speaker, alone.rules.only):
        assert column.tolist() == [-1, -1]


def test_costs_of_every_lane_stand_in_a_row_and_zeros_behind_the_short_ones() -> None:
    policies = [ErrorDriven(0.1, identify="cheapest", costs=costs(2, ages)) for ages in (1, 4, 2)]
    packed = [one.codes[3] for one in policies]
    found = speaking_lanes(policies, [0, 1, 2], guards=(), dt_s=0.1).rules.costs
    assert found.shape == (3, max(one.size for one in packed))
    for row, one in zip(found, packed, strict=True):
        assert row[: one.size].tolist() == one.tolist()
        assert not row[one.size :].any()


def test_there_is_one_policy_a_vehicle() -> None:
    keep = ErrorDriven(0.2)
    for policies, vehicles in (([keep], [0, 1]), ([keep, keep], [0])):
        with pytest.raises(ValueError, match=r"shorter|longer"):
            speaking_lanes(policies, vehicles, guards=(), dt_s=0.1)


def test_a_bank_says_what_was_added_to_it_and_what_guards_it() -> None:
    """Constant velocity stands in where all members need more than one sample."""
    for bank, members, fallback, guards in (
        (PLAIN, ["cv"], -1, ()),
        (Bank((CA,)), ["ca"], -1, ()),
        (Bank((GP,)), ["gp-intercept", "cv"], 1, ()),
        (Bank((CA, CV)), ["ca", "cv"], -1, (1,)),
        (Bank((CV, GP, CA)), ["cv", "gp-intercept", "ca"], -1, (0,)),
        (Bank((CTRA, CA, CV)), ["ctra", "ca", "cv"], -1, (2, 0)),
    ):
        ready = SenderBank.of(bank, 0.1)
        assert [one.name for one in ready.bank.members] == members
        assert (ready.fallback, ready.guards) == (fallback, guards)
        models = ready.models(guards)
        assert (models.fallback, models.guard, models.dt_s) == (fallback, (*guards, -1)[0], 0.1)
        assert (models.selector, models.selector_window) == (0, 1)
        assert ready.models().guard == -1


def test_a_guard_is_one_where_the_start_rule_asks_for_it() -> None:
    for start, bank, guards in (
        ("guarded", Bank((CA, CV)), (1,)),
        ("guarded", Bank((CV, CTRA)), (0, 1)),
        ("hindsight", Bank((CA, CV)), ()),
        ("order", Bank((CA, CV)), ()),
        ("guarded", PLAIN, ()),
    ):
        own = sender(ErrorDriven(0.2, start, "never"), bank)  # pyright: ignore[reportArgumentType]
        assert guards_of(own, sender_bank(own, 0.1)) == guards


@pytest.mark.parametrize("dt_s", [0.1, 0.05, 0.08])
def test_rings_reach_back_two_seconds_where_predictions_are_judged_in_hindsight(dt_s: float) -> None:
    """Steps to the oldest prediction, 2 s old, to the nearest one; the newest sample comes on top."""
    back = {0.1: 20, 0.05: 40, 0.08: 25}[dt_s]
    for start, fitted in (("hindsight", back + 1), ("guarded", back + 1), ("order", 1), ("recent", 1)):
        own = sender(ErrorDriven(0.2, start, "never"), Bank((GP, CV)))  # pyright: ignore[reportArgumentType]
        stations = sending_stations(own, sender_bank(own, dt_s), np.zeros(2))
        assert stations.fits.number.shape[:2] == (2, fitted)
        assert stations.sensed.stated_m.shape[1] >= GP.window + fitted
    assert stations.lanes.update.size == 2


@pytest.mark.parametrize(("lags", "samples", "longest"), [(10, 20, 20), (20, 3, 21)])
def test_rings_hold_what_the_selector_looks_at_where_that_is_longer_than_any_window(
    constant_selector: Callable[..., Selector], lags: int, samples: int, longest: int
) -> None:
    """Two seconds are 21 samples, and one is 11."""
    selector = constant_selector(("gp-intercept", "cv"), np.zeros(2), 0.2, lags)
    bank = Bank((GaussianProcess(samples, "intercept"), CV))
    own = sender(ErrorDriven(0.2, "predicted", "never"), bank, selector=selector)
    stations = sending_stations(own, sender_bank(own, 0.1), np.zeros(1))
    assert stations.sensed.stated_m.shape[1] == longest + 1
    assert stations.models.selector_window == lags + 1
    assert stations.models.selector == selector.address
    assert stations.rules.selector.tolist() == [selector.packed(0.1, 0.2).tolist()]


def test_senders_of_models_take_the_bank_given_and_what_erred_least_of_late() -> None:
    bank = Bank((CTRA, CV))
    for name in MODEL_SENDERS:
        assert named_sender(name).bank == default_profile().bank
        assert named_sender(name, bank=bank).bank == bank
        if name != "mbc":
            assert named_sender(name).start == "recent"
            assert named_sender(name, start="guarded", bank=bank).start == "hindsight"
            assert named_sender(name, start="keep").start == "keep"
    for name in set(SENDERS) - set(MODEL_SENDERS) - set(FREE_SENDERS):
        assert named_sender(name, bank=bank).bank == BASELINE_BANK
        assert named_sender(name, start="keep").start == "order"


@pytest.mark.parametrize("name", FREE_SENDERS)
def test_the_free_ones_are_those_of_models_with_plain_messages_alone(name: str) -> None:
    """Same rule, same timers, same filter; 40 bytes, and the bank of nobody else."""
    free, other = named_sender(name), named_sender(name.replace("free", "mbc"))
    assert free.bank == free_bank()
    assert set(free.update_bytes.tolist()) == {40}
    assert all(free.plain)
    assert (free.motion, free.longest_silence_s) == (other.motion, other.longest_silence_s)
    if name == "free":
        assert free.policy == replace(other.lanes, start="order", identify="never")
    else:
        assert free.policy == other.policy
    assert named_sender(name, bank=Bank((CV,))).bank == Bank((CV,))
    for bank in (Bank((CTRA, CV)), Bank((GaussianProcess(),))):
        with pytest.raises(ValueError, match="one free sub-model"):
            named_sender(name, bank=bank)


def test_messages_hold_all_parameters_or_those_of_the_largest_member() -> None:
    for identify, expected in (("never", 4), ("best", 9)):
        own = sender(ErrorDriven(0.2, "order", identify), Bank((CA, CTRA, CV)))  # pyright: ignore[reportArgumentType]
        assert widest(own, sender_bank(own, 0.1)) == expected


def test_stations_that_sent_nothing_have_no_update_and_nothing_that_waits() -> None:
    own = at.senders(np.zeros(3))
    assert own.vehicle.tolist() == own.update.tolist() == [-1, -1, -1]
    assert own.number.tolist() == [0, 0, 0]
    assert own.sent_s.tolist() == own.certified_s.tolist() == [-np.inf] * 3
    phase = np.array([0.5, 0.25])
    timed = timers(phase)
    assert timed.pending.tolist() == [[np.inf] * 4] * 2
    assert timed.due_s.tolist() == [-np.inf] * 2
    assert timed.phase.tolist() == phase.tolist()
    assert timed.phase is not phase


def test_rings_hold_what_a_count_of_seven_bits_tells_apart() -> None:
    held = at.contents(2, 5)
    assert held.rows.shape == (2, 128, at.CONTENT_HEAD + 5)
    assert held.beliefs.shape == (2, 128, 3)
    assert (held.rows == -1.0).all()
    assert (held.beliefs == -1).all()


def test_an_outbox_has_room_for_what_waited_and_what_is_new_of_every_vehicle() -> None:
    out = at.outbox(5)
    for column in (out.sender, out.ready_s, out.size_bytes, out.power_dbm, out.message_id, out.next_s):
        assert column.shape == (10,)
    assert out.filled.tolist() == [0]
    assert (out.next_s == np.inf).all()


def test_a_message_id_leaves_20_bits_for_its_sender_and_a_tally_has_8_sums() -> None:
    assert 1 << at.SENDER_BITS == 1_048_576
    tally = at.sent_tally(3)
    assert tally.sums.shape == (3, 8)
    assert tally.causes.tolist() == [0, 0, 0, 0]
    assert tally.total.tolist() == [0.0] * 8
