"""Claims about what the host holds under loss, delay and expiry."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modelcast.channel.link_record import LinkRecord
from modelcast.channel.recorded import RecordedLosses
from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.core.chance import child_generator
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.interacting import InteractingMultipleModel
from modelcast.runtime.trip import believed_kernels
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.station.banks import BASELINE_BANK, PAPER_BANK
from modelcast.station.policy.base import MessageKind
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.receiver.belief_kernels import BELIEF_COLUMNS
from modelcast.station.sensing.velocity import REPORTED
from modelcast.study.case import TripCase, make_case
from modelcast.study.evaluate import evaluate
from modelcast.study.settings import EvaluationSettings
from modelcast.study.tracking import LossRuns, TrackingRun, draw_losses, run_tracking
from modelcast.trips.trajectory import Trajectory, build_trajectory

SINGLE_M = 2e-6
"""Errors are kept in single precision: half a unit in the last place of 16 m is 1e-6 m."""

HYBRID = Bank((GaussianProcess(form="intercept"), ConstantVelocity()))


def runs(case: TripCase, settings: EvaluationSettings) -> dict[tuple[str, str | None, float], TrackingRun]:
    """Every contender's run, by policy, rate basis and threshold."""
    mbc = TripRuntime(case.seen, settings.bank, case.estimator)
    baseline = TripRuntime(case.seen, BASELINE_BANK, case.estimator)
    return {
        (run.contender.policy, run.contender.rate_basis, run.contender.threshold_m): run
        for run in run_tracking(case, [mbc], baseline, settings)
    }


def walked(case: TripCase, settings: EvaluationSettings, threshold_m: float = 0.3) -> TripMessages:
    bank = TripRuntime(case.seen, settings.bank, case.estimator)
    return bank.run(settings.policy(threshold_m, keep_alive=True))


def mbc(case: TripCase, settings: EvaluationSettings, threshold_m: float = 0.3) -> TrackingRun:
    return runs(case, settings)["mbc", None, threshold_m]


def is_update(walk: TripMessages) -> BoolArray:
    return np.isin(walk.kind, (MessageKind.UPDATE, MessageKind.KEEP_ALIVE))


def own_error_m(case: TripCase, settings: EvaluationSettings, walk: TripMessages) -> FloatArray:
    """The sender's error of the sub-model in use, after its message, where that was no update."""
    sender = TripRuntime(case.seen, settings.bank, case.estimator)
    return sender.tracking_error_m(walk)[np.arange(walk.kind.size), walk.in_use]


@pytest.mark.parametrize("identify", ["on-failure", "final", "best"])
def test_without_loss_the_host_errs_as_the_sender_does_and_stays_below_the_threshold(
    identify: Any, gapped_case: TripCase
) -> None:
    """It holds at identifications too; at an update the error is the new models' own at horizon zero."""
    settings = EvaluationSettings((0.3,), (0.0,), seeds=1, bank=HYBRID, identify=identify)
    walk = walked(gapped_case, settings)
    after = mbc(gapped_case, settings).after_m[0, 0]
    kept = ~is_update(walk)
    assert (walk.kind == MessageKind.IDENTIFICATION).any()
    assert after[kept] == pytest.approx(own_error_m(gapped_case, settings, walk)[kept], abs=SINGLE_M)
    assert (after[kept] < 0.3).all()


def test_at_an_update_constant_velocity_has_no_error_and_a_gaussian_process_its_residual(
    gapped_case: TripCase,
) -> None:
    settings = EvaluationSettings((0.3,), (0.0,), seeds=1, bank=HYBRID)
    walk = walked(gapped_case, settings)
    after = mbc(gapped_case, settings).after_m[0, 0]
    coasting = is_update(walk) & (walk.in_use == 1)
    assert coasting.any()
    assert (after[coasting] == 0.0).all()
    assert after[is_update(walk) & (walk.in_use == 0)].max() > 0.0


@pytest.mark.real
@pytest.mark.parametrize("threshold_m", [0.2, 0.5])
def test_without_loss_the_claim_holds_on_real_trips(
    threshold_m: float, dynamic_trips: dict[str, Trajectory]
) -> None:
    settings = EvaluationSettings((threshold_m,), (0.0,), seeds=1, protocol="recorded")
    for trip in dynamic_trips.values():
        case = make_case(trip, settings)
        walk = walked(case, settings, threshold_m)
        after = mbc(case, settings, threshold_m).after_m[0, 0]
        kept = ~is_update(walk)
        assert after[kept] == pytest.approx(own_error_m(case, settings, walk)[kept], abs=SINGLE_M)
        assert (after[kept] < threshold_m).all()


def test_in_the_sensor_protocol_it_holds_against_the_input_and_not_against_the_truth(
    drive: Trajectory,
) -> None:
    settings = EvaluationSettings((0.2,), (0.0,), seeds=1, protocol="sensor")
    settings = replace(settings, sensor=replace(settings.sensor, slow_position_noise_m=0.3))
    case = make_case(drive, settings)
    kept = ~is_update(walked(case, settings, 0.2))
    assert mbc(replace(case, truth=case.seen), settings, 0.2).after_m[0, 0, kept].max() < 0.2
    assert mbc(case, settings, 0.2).after_m[0, 0, kept].max() > 0.2


def plain_replay(
    case: TripCase,
    bank: TripRuntime,
    walk: TripMessages,
    lost: BoolArray,
    settings: EvaluationSettings,
) -> dict[str, list[float]]:
    """Error after and before each instant's messages, and age, by the rules of the receiver in words."""
    delay_s = settings.delay_s
    expiry_s = np.inf if settings.expiry_s is None else settings.expiry_s
    held: tuple[int, int] | None = None  # update and sub-model
    heard_s = -np.inf
    pending = [int(i) for i in np.flatnonzero(walk.transmits & ~lost)]
    found: dict[str, list[float]] = {"after": [], "before": [], "age": []}

    def error_m(now: int) -> float:
        if held is None or case.truth.t_s[now] - heard_s > expiry_s:
            return np.nan
        at, member = held
        own = bank.parameters[at : at + 1, bank.bank.offsets[member] : bank.bank.offsets[member + 1]]
        age = np.array([case.truth.t_s[now] - case.truth.t_s[at]])
        moved = bank.bank.members[member].predict_at(own, age, dt_s=case.seen.dt_s)[0]
        return float(np.hypot(*(case.seen.position_m[at] + moved - case.truth.position_m[now])))

    for now, t_s in enumerate(case.truth.t_s):
        found["before"].append(error_m(now))
        while pending and case.truth.t_s[pending[0]] + delay_s <= t_s + 1e-9:
            message = pending.pop(0)
            if case.truth.t_s[message] + delay_s - heard_s > expiry_s:
                held = None  # forgotten
            heard_s = case.truth.t_s[message] + delay_s
            if walk.kind[message] != MessageKind.IDENTIFICATION:
                held = (message, int(walk.in_use[message]))
            elif held is not None and held[0] == walk.update_index[message]:
                held = (held[0], int(walk.in_use[message]))
        found["after"].append(error_m(now))
        known = held is not None and not np.isnan(found["after"][-1])
        found["age"].append(t_s - case.truth.t_s[held[0]] if known else np.nan)
    return found


@pytest.mark.parametrize(("delay_s", "expiry_s"), [(0.0, None), (0.25, None), (0.0, 0.8), (0.3, 0.9)])
def test_the_replay_follows_the_rules_of_the_receiver(
    delay_s: float, expiry_s: float | None, gapped_case: TripCase
) -> None:
    """Lost identifications, lost updates, identifications of lost updates, delay and expiry all occur."""
    settings = EvaluationSettings(
        (0.3,), (0.0, 0.6), seeds=2, bank=HYBRID, identify="best", delay_s=delay_s, expiry_s=expiry_s
    )
    run, lost = mbc(gapped_case, settings), draw_losses(gapped_case, settings)
    bank = TripRuntime(gapped_case.seen, HYBRID, gapped_case.estimator)
    walk = bank.run(settings.policy(0.3, keep_alive=True))
    for ratio, seed in ((0, 0), (1, 0), (1, 1)):
        expected = plain_replay(gapped_case, bank, walk, lost[ratio, seed], settings)
        for name, errors in (("after", run.after_m), ("age", run.age_s)):
            assert errors[ratio, seed] == pytest.approx(expected[name], rel=1e-6, abs=SINGLE_M, nan_ok=True)
        both = ~np.isnan(run.before_m[ratio, seed])
        before = np.array(expected["before"])
        assert run.before_m[ratio, seed, both] == pytest.approx(before[both], rel=1e-6, abs=SINGLE_M)


def scattered() -> Trajectory:
    """A trip that jumps about, so that every update and sub-model predicts something else by metres."""
    rng = np.random.default_rng(8)
    t = np.arange(14) * 0.1
    position, speed, heading = (
        rng.normal(0.0, 5.0, (14, 2)),
        rng.uniform(5.0, 20.0, 14),
        rng.uniform(0, 6, 14),
    )
    return build_trajectory("made/scattered", t, position, speed_mps=speed, heading_rad=heading)


def held_after(kinds: list[str], used: list[int], lost: list[int]) -> list[tuple[int, int]]:
    """Update and sub-model held at each of four samples, told from the error, when some messages are lost."""
    trip = scattered()
    bank = TripRuntime(trip, Bank((ConstantVelocity(), GaussianProcess(form="intercept"))), REPORTED)
    bank.fit_at(np.arange(10, 14))
    kind = np.array([[{"-": 0, "update": 1, "identify": 2, "alive": 3}[one] for one in kinds]])
    missing = np.zeros((1, 4), dtype=np.bool_)
    missing[0, lost] = True
    errors = np.empty((5, 1, 4))
    believed_kernels.replay(
        bank.own.ready.members,
        believed_kernels.SentTrip(
            trip.t_s[10:].copy(),
            bank.stated_s[10:].copy(),
            bank.stated_m[10:].copy(),
            bank.parameters[10:].copy(),
            np.zeros((4, 2)),
            np.tile([1.0, 0.0], (4, 1)),
            np.zeros((4, 4)),
            np.zeros(2, dtype=np.bool_),
        ),
        believed_kernels.Schedules(
            kind,
            np.array([used]),
            np.maximum.accumulate(np.where(np.isin(kind, (1, 3)), np.arange(4), 0), axis=1),
        ),
        missing,
        0.0,
        np.inf,
        errors,
        np.empty((1, 4)),
        np.empty(1, dtype=np.int64),
        np.empty((0, 4, BELIEF_COLUMNS)),
    )
    held = []
    for now in range(4):
        off_m = {}
        for at, member in np.ndindex(now + 1, 2):
            own = bank.parameters[
                10 + at : 11 + at, bank.bank.offsets[member] : bank.bank.offsets[member + 1]
            ]
            age = trip.t_s[[10 + now]] - trip.t_s[10 + at]
            moved = bank.bank.members[member].predict_at(own, age, dt_s=trip.dt_s)[0]
            off_m[at, member] = abs(np.hypot(*(trip.position_m[10 + at] + moved)) - errors[0, 0, now])
        held.append(min(off_m, key=lambda key: off_m[key]))
    return held


@pytest.mark.parametrize(
    ("kinds", "used", "lost", "expected"),
    [
        pytest.param(
            ["update", "-", "identify", "-"], [0, 0, 1, 1], [], [(0, 0), (0, 0), (0, 1), (0, 1)], id="no loss"
        ),
        pytest.param(
            ["update", "-", "identify", "-"],
            [0, 0, 1, 1],
            [2],
            [(0, 0), (0, 0), (0, 0), (0, 0)],
            id="a lost identification leaves the old sub-model",
        ),
        pytest.param(
            ["update", "-", "update", "-"],
            [0, 0, 1, 1],
            [2],
            [(0, 0), (0, 0), (0, 0), (0, 0)],
            id="a lost update leaves the old model",
        ),
        pytest.param(
            ["update", "-", "update", "identify"],
            [0, 0, 0, 1],
            [2],
            [(0, 0), (0, 0), (0, 0), (0, 0)],
            id="an identification of a lost update changes nothing",
        ),
        pytest.param(
            ["update", "alive", "identify", "update"],
            [0, 1, 0, 1],
            [1],
            [(0, 0), (0, 0), (0, 0), (3, 1)],
            id="a lost keep-alive is a lost update",
        ),
    ],
)
def test_what_is_held_after_a_loss(
    kinds: list[str],
    used: list[int],
    lost: list[int],
    expected: list[tuple[int, int]],
) -> None:
    assert held_after(kinds, used, lost) == expected


def test_the_first_message_is_never_lost_and_higher_ratios_lose_more(gapped_case: TripCase) -> None:
    settings = EvaluationSettings((0.3,), (0.0, 0.2, 0.4, 1.0), seeds=3)
    lost = draw_losses(gapped_case, settings)
    assert not lost[:, :, 0].any()
    assert not lost[0].any()
    assert lost[3, :, 1:].all()
    assert not (lost[1] & ~lost[2]).any()


def test_every_contender_meets_the_same_losses(gapped_case: TripCase) -> None:
    """Draws are a function of seed, run and trip alone; the baseline's bank as MBC gives its errors."""
    settings = EvaluationSettings((0.3,), (0.4,), seeds=3, bank=BASELINE_BANK)
    found = runs(gapped_case, settings)
    same, baseline = found["mbc", None, 0.3], found["baseline", None, 0.3]
    assert np.array_equal(same.after_m, baseline.after_m, equal_nan=True)
    rng = child_generator(0, 2, gapped_case.truth.trip_id, "loss")
    expected = rng.random(len(gapped_case.truth)) < 0.4
    assert np.array_equal(draw_losses(gapped_case, settings)[0, 2, 1:], expected[1:])


def test_recorded_losses_are_replayed_as_the_channel_gives_them(gapped_case: TripCase) -> None:
    lost = np.random.default_rng(4).random(500) < 0.3
    lost[[0, -1]] = False
    channel = RecordedLosses((LinkRecord("a hears b", lost, period_s=0.1),))
    settings = EvaluationSettings((0.3,), (channel.packet_error_ratio,), seeds=2, recorded=channel)
    rng = child_generator(0, 1, gapped_case.truth.trip_id, "loss")
    expected = channel.losses(gapped_case.truth.t_s, rng)
    assert np.array_equal(draw_losses(gapped_case, settings)[0, 1, 1:], expected[1:])
    with pytest.raises(ValueError, match="the one of the recorded losses"):
        replace(settings, packet_error_ratios=(0.0, channel.packet_error_ratio))
    with pytest.raises(ValueError, match="one of the two"):
        replace(settings, mean_burst_s=0.5)


def test_seeds_and_trips_have_their_own_losses(gapped_case: TripCase, drive: Trajectory) -> None:
    settings = EvaluationSettings((0.3,), (0.4,), seeds=2)
    lost = draw_losses(gapped_case, settings)
    assert not np.array_equal(lost[0, 0], lost[0, 1])
    assert not np.array_equal(lost, draw_losses(gapped_case, replace(settings, seed=1)))
    other = draw_losses(make_case(drive, replace(settings, protocol="recorded")), settings)
    assert not np.array_equal(lost[0, 0, :300], other[0, 0, :300])


def test_delay_shifts_arrivals(accelerating: Trajectory) -> None:
    """Delayed by d, a message that is k samples old arrives: the first d seconds hold nothing."""
    settings = EvaluationSettings((1.0,), (0.0,), seeds=1, delay_s=0.35, protocol="recorded")
    case = make_case(accelerating, settings)
    run = runs(case, settings)["baseline", None, 1.0]
    prompt = runs(case, replace(settings, delay_s=0.0))["baseline", None, 1.0]
    assert np.isnan(run.after_m[0, 0, :4]).all()
    assert np.isfinite(run.after_m[0, 0, 4:]).all()
    just_sent = prompt.age_s[0, 0, :-4] == 0.0
    assert run.age_s[0, 0, 4:][just_sent] == pytest.approx(0.4, rel=1e-5)


def test_before_and_after_differ_only_where_a_message_arrives(gapped_case: TripCase) -> None:
    """At every update that arrives; an identification may name an update that did not, and change nothing."""
    settings = EvaluationSettings((0.3,), (0.4,), seeds=1, bank=HYBRID)
    run, walk = mbc(gapped_case, settings), walked(gapped_case, settings)
    arrived = walk.transmits & ~draw_losses(gapped_case, settings)[0, 0]
    before, after = run.before_m[0, 0], run.after_m[0, 0]
    assert np.isnan(before[0])
    assert np.array_equal(before[1:][~arrived[1:]], after[1:][~arrived[1:]])
    renewed = arrived & is_update(walk)
    assert (before[renewed] != after[renewed]).all()


def test_before_a_message_without_loss_some_error_had_reached_the_threshold(gapped_case: TripCase) -> None:
    settings = EvaluationSettings((0.3,), (0.0,), seeds=1, bank=HYBRID, keep_alive_s=None)
    run, walk = mbc(gapped_case, settings), walked(gapped_case, settings)
    sent = walk.transmits & (np.arange(walk.kind.size) > 0)
    assert (run.before_m[0, 0, sent] >= 0.3 - SINGLE_M).all()


def test_along_and_cross_track_parts_make_up_the_error(gapped_case: TripCase) -> None:
    run = mbc(gapped_case, EvaluationSettings((0.3,), (0.6,), seeds=2))
    parts = np.hypot(run.along_m.astype(float), run.cross_m.astype(float))
    assert np.allclose(parts, run.after_m, rtol=1e-6, atol=SINGLE_M, equal_nan=True)


def test_left_of_the_course_is_positive(accelerating: Trajectory) -> None:
    """The true car drives east; a belief that lies north of it lies to its left."""
    settings = EvaluationSettings((1.0,), (0.0,), seeds=1, protocol="recorded")
    case = make_case(accelerating, settings)
    south = replace(case, truth=replace(case.truth, position_m=case.truth.position_m - (3.0, 2.0)))
    run = runs(south, settings)["baseline", None, 1.0]
    assert run.cross_m[0, 0] == pytest.approx(2.0)
    assert run.along_m[0, 0, 0] == pytest.approx(3.0)


def test_samples_before_the_first_reception_and_after_expiry_are_excluded_and_counted(
    drive: Trajectory,
) -> None:
    settings = EvaluationSettings(
        (0.3,), (0.0, 0.6), seeds=2, protocol="recorded", delay_s=0.45, expiry_s=0.7, keep_samples="all"
    )
    result = evaluate([drive], settings)
    blocks = {(block.policy, block.rate_basis): block for block in result.samples}
    for row in result.tracking:
        at = settings.packet_error_ratios.index(row.packet_error_ratio)
        missing = np.isnan(blocks[row.policy, row.rate_basis].errors["tracking_error_m"][at])
        assert missing[:, :5].all()
        assert row.excluded_samples == missing.sum()
        assert row.samples == missing.size - missing.sum()
    assert max(row.excluded_samples for row in result.tracking) > 10


def matched(case: TripCase, settings: EvaluationSettings) -> list[tuple[str | None, float, int, float]]:
    """Basis, threshold, messages wanted and messages sent, of every rate-matched baseline."""
    found = runs(case, settings)
    wanted = {}
    for threshold_m in settings.thresholds_m:
        walk = walked(case, settings, threshold_m)
        wanted["update", threshold_m] = walk.updates
        wanted["total", threshold_m] = walk.updates + walk.identifications
    return [
        (basis, threshold_m, wanted[basis, threshold_m], run.messages[0])
        for (policy, basis, threshold_m), run in found.items()
        if policy == "baseline-matched" and basis is not None
    ]


@pytest.mark.real
@pytest.mark.parametrize("keep_alive_s", [None, 2.0])
def test_rate_matched_baselines_come_within_a_message_or_a_hundredth(
    keep_alive_s: float | None, dynamic_trips: dict[str, Trajectory]
) -> None:
    """Except where the keep-alive alone sends more than MBC's updates: then the baseline sends just those."""
    settings = EvaluationSettings(
        (0.2, 0.3, 0.4, 0.5), (0.0,), seeds=1, protocol="recorded", keep_alive_s=keep_alive_s
    )
    for trip in dynamic_trips.values():
        case = make_case(trip, settings)
        bank = TripRuntime(case.seen, BASELINE_BANK, case.estimator)
        fewest = bank.run(ErrorDriven(64.0, max_inter_transmit_time_s=keep_alive_s)).updates
        for basis, _, wanted, sent in matched(case, settings):
            if abs(sent - wanted) > max(1.0, 0.01 * wanted):
                assert (basis, keep_alive_s, sent) == ("update", 2.0, fewest)
                assert wanted < fewest


@pytest.mark.real
def test_periodic_baselines_send_at_mbcs_rate_of_the_time_observed(
    dynamic_trips: dict[str, Trajectory],
) -> None:
    """Give or take one message, and one more for each gap: what fell due in it leaves as one at its end."""
    settings = EvaluationSettings((0.3,), (0.0,), seeds=8, protocol="recorded")
    for trip in dynamic_trips.values():
        case = make_case(trip, settings)
        walk, found = walked(case, settings), runs(case, settings)
        for basis, wanted in (("update", walk.updates), ("total", walk.updates + walk.identifications)):
            sent = found["baseline-periodic", basis, 0.3].messages[0]
            assert abs(sent - wanted) <= trip.segments.size - 1


def test_equal_rate_baselines_with_a_window_coast_until_it_is_full(gapped_case: TripCase) -> None:
    """At a start and behind gaps by what completes their bank, elsewhere by their own sub-model alone."""
    settings = EvaluationSettings((0.2,), (0.0,), seeds=1, bank=PAPER_BANK)
    walks = [walked(gapped_case, settings, 0.2)]
    policy = settings.policy(0.2, keep_alive=True)
    longer, plain = (
        TripRuntime(gapped_case.seen, bank, gapped_case.estimator)
        for bank in (Bank((GaussianProcess(form="intercept"),)), BASELINE_BANK)
    )
    (matched, own), (_, coasting) = (
        list(LossRuns(gapped_case, ready, settings).equal_rate(policy, walks, "total"))
        for ready in (longer, plain)
    )
    assert longer.bank.members[1].name == "cv"
    assert own.messages == coasting.messages
    held_s = own.age_s[0, 0]
    np.testing.assert_array_equal(held_s, coasting.age_s[0, 0])
    update = np.arange(held_s.size) - np.rint(held_s / gapped_case.truth.dt_s).astype(np.int64)
    at_start = gapped_case.truth.segment_start[np.maximum(update, 0)]
    short = update - at_start < GaussianProcess().samples - 1
    same = own.after_m[0, 0] == coasting.after_m[0, 0]
    assert same[short].all()
    assert own.after_m[0, 0][short].max() > 0.0
    assert not same[~short].all()
    (threshold_m,) = matched.own_threshold_m
    assert threshold_m is not None
    alone = longer.run(ErrorDriven(threshold_m, max_inter_transmit_time_s=policy.max_inter_transmit_time_s))
    assert (matched.messages, alone.identifications) == ((alone.updates,), 0)


def test_paper_bank_is_constant_velocity_and_the_anchored_process() -> None:
    assert [member.name for member in PAPER_BANK.members] == ["cv", "gp-anchored"]


def test_without_loss_a_host_that_keeps_chances_stays_below_the_threshold(gapped_case: TripCase) -> None:
    """So the sender follows what its hosts made of all updates before."""
    bank = Bank((InteractingMultipleModel(),))
    settings = EvaluationSettings((0.3,), (0.0,), seeds=1, bank=bank)
    walk = walked(gapped_case, settings)
    kept, after = ~is_update(walk), mbc(gapped_case, settings).after_m[0, 0]
    assert after[kept] == pytest.approx(own_error_m(gapped_case, settings, walk)[kept], abs=SINGLE_M)
    assert (after[kept] < 0.3).all()
