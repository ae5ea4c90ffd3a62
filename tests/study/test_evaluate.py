"""Claims about the tables of an evaluation: rates, pooling, what is excluded, and what fails."""

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from modelcast.channel.link_record import LinkRecord
from modelcast.channel.recorded import RecordedLosses
from modelcast.core.exceptions import ConfigError
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.learned import Selector
from modelcast.runtime.trip.context import ContextSettings
from modelcast.station.banks import PAPER_BANK, bank_from_text
from modelcast.station.policy.costs import CostTable
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.study.case import STANDING_SPEED_MPS, SensedTrip, make_case
from modelcast.study.evaluate import evaluate
from modelcast.study.histogram import BIN_RATIO
from modelcast.study.result import POOLED, EvaluationResult
from modelcast.study.settings import EvaluationSettings
from modelcast.study.table import Row
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive

SETTINGS = EvaluationSettings(
    (0.3,), (0.0, 0.4), seeds=3, protocol="recorded", keep_samples="all", bank=PAPER_BANK
)

SINGLE_RATIO = 1e-6
"""Samples are kept in single precision."""


@pytest.fixture(scope="module")
def slow_drive() -> Trajectory:
    """A generated drive at 5 Hz, so that one of its samples weighs twice one at 10 Hz."""
    return generate_drive(seed=8, duration_s=95.0, rate_hz=5.0).truth


@pytest.fixture(scope="module")
def both(gapped_drive: Trajectory, slow_drive: Trajectory) -> EvaluationResult:
    return evaluate([gapped_drive, slow_drive], SETTINGS)


def rates(result: EvaluationResult, policy: str) -> dict[str, Row]:
    return {row.trip: row for row in result.rates if row.policy == policy}


@pytest.mark.parametrize("policy", ["mbc", "baseline"])
def test_pooled_rates_are_sums_of_messages_over_sums_of_time(both: EvaluationResult, policy: str) -> None:
    rows = rates(both, policy)
    pooled = rows.pop(POOLED)
    time_s = sum(row.duration_s for row in rows.values())
    assert len(rows) == 2
    assert pooled.duration_s == pytest.approx(time_s)
    for count, rate in (("updates", "update_rate_hz"), ("identifications", "identification_rate_hz")):
        assert getattr(pooled, rate) == pytest.approx(
            sum(getattr(row, count) for row in rows.values()) / time_s
        )
    assert pooled.total_rate_hz == pytest.approx(pooled.update_rate_hz + pooled.identification_rate_hz)
    byte_count = sum(row.bytes_per_s * row.duration_s for row in rows.values())
    assert pooled.bytes_per_s == pytest.approx(byte_count / time_s)


def test_durations_leave_gaps_out(gapped_drive: Trajectory) -> None:
    """100 s less gaps of 4.9 s and 0.8 s beside the one step that follows every sample."""
    (row,) = evaluate([gapped_drive], SETTINGS).trips
    assert row.gaps == 2
    assert row.duration_s == pytest.approx(len(gapped_drive) * 0.1)


def test_moving_rates_count_messages_and_time_above_walking_pace(drive: Trajectory) -> None:
    result = evaluate([drive], SETTINGS)
    assert drive.speed_mps is not None
    stopped = float((drive.speed_mps < STANDING_SPEED_MPS).sum() * 0.1)
    (trip,) = result.trips
    assert trip.standing_s == pytest.approx(stopped, abs=0.4)
    row = rates(result, "baseline")[drive.trip_id]
    moving_messages = row.moving_total_rate_hz * (trip.duration_s - trip.standing_s)
    assert moving_messages == pytest.approx(round(moving_messages))
    assert 0 < moving_messages <= row.updates
    assert row.moving_total_rate_hz > row.total_rate_hz


def test_a_parked_car_has_no_moving_rate() -> None:
    t = np.arange(200) * 0.1
    parked = build_trajectory("made/parked", t, np.zeros((200, 2)), speed_mps=0 * t, heading_rad=0 * t)
    result = evaluate([parked], SETTINGS)
    assert rates(result, "mbc")[POOLED].moving_total_rate_hz == 0.0
    assert result.trips[0].standing_s == pytest.approx(20.0)
    assert rates(result, "mbc")[POOLED].updates == 1


@pytest.mark.parametrize(
    "policy", ["mbc", "baseline", "baseline-matched", "baseline-periodic", "free", "free-matched"]
)
def test_pooled_quantiles_weigh_each_sample_by_its_time(both: EvaluationResult, policy: str) -> None:
    blocks = [one for one in both.samples if one.policy == policy and one.rate_basis in (None, "total")]
    steps_s = {trip.id: trip.dt_s for trip in both.trips}
    for at, ratio in enumerate(SETTINGS.packet_error_ratios):
        errors = [one.errors["tracking_error_m"][at].ravel().astype(float) for one in blocks]
        weights = [np.full(one.size, steps_s[block.trip]) for one, block in zip(errors, blocks, strict=True)]
        values, share = np.concatenate(errors), np.concatenate(weights)
        values, share = values[~np.isnan(values)], share[~np.isnan(values)]
        (row,) = (
            row
            for row in both.tracking
            if (row.trip, row.policy, row.packet_error_ratio) == (POOLED, policy, ratio)
            and row.rate_basis in (None, "total")
        )
        for name, probability in (("p50", 0.5), ("p90", 0.9), ("p95", 0.95), ("p99", 0.99)):
            exact = np.quantile(values, probability, weights=share, method="inverted_cdf")
            assert getattr(row, f"pte_{name}_m") == pytest.approx(exact, rel=BIN_RATIO)
        assert row.pte_mean_m == pytest.approx(np.average(values, weights=share), rel=SINGLE_RATIO)
        assert row.beyond_lane_ratio == pytest.approx(np.average(values > 1.5, weights=share))
        assert row.samples == values.size


def test_one_trip_pooled_is_the_trip(drive: Trajectory) -> None:
    """But for percentiles of the tracking error, which are exact in the trip's row alone."""
    result = evaluate([drive], SETTINGS)
    for rows in (result.rates, result.tracking):
        pooled, alone = (
            [dict(row.items()) | {"trip": ""} for row in rows if row.trip == trip]
            for trip in (POOLED, drive.trip_id)
        )
        for one, other in zip(pooled, alone, strict=True):
            exact = {name: other.pop(name) for name in list(other) if name.startswith("pte_p")}
            found = {name: one.pop(name) for name in exact}
            for name in exact.keys() - {"pte_p90_low_m", "pte_p90_high_m"}:
                assert found[name] == pytest.approx(exact[name], rel=BIN_RATIO)
        assert pooled == alone


def test_confidence_limits_hold_the_mean_of_the_seeds_percentiles(both: EvaluationResult) -> None:
    (row,) = (
        row for row in both.tracking if (row.trip, row.policy, row.packet_error_ratio) == (POOLED, "mbc", 0.4)
    )
    assert row.pte_p90_low_m is not None
    assert row.pte_p90_high_m is not None
    assert row.pte_p90_low_m < row.pte_p90_m < row.pte_p90_high_m
    assert row.seeds == 3


def test_the_same_seed_gives_the_same_result_and_another_other_losses(drive: Trajectory) -> None:
    first, second = evaluate([drive], SETTINGS), evaluate([drive], SETTINGS)
    assert first.tracking == second.tracking
    assert first.rates == second.rates
    other = evaluate([drive], replace(SETTINGS, seed=1))
    assert other.rates == first.rates
    lossy = [row.pte_p90_m for row in first.tracking if row.packet_error_ratio == 0.4]
    assert lossy != [row.pte_p90_m for row in other.tracking if row.packet_error_ratio == 0.4]


def test_the_order_of_trips_changes_no_trips_row(gapped_drive: Trajectory, slow_drive: Trajectory) -> None:
    one, other = (
        evaluate(trips, SETTINGS) for trips in ([gapped_drive, slow_drive], [slow_drive, gapped_drive])
    )
    for rows in ("rates", "tracking"):
        sides = [
            sorted(repr(row) for row in getattr(side, rows) if row.trip != POOLED) for side in (one, other)
        ]
        assert sides[0] == sides[1]


def test_the_paper_bank_sends_fewer_updates_than_the_baseline(both: EvaluationResult) -> None:
    assert rates(both, "mbc")[POOLED].updates < rates(both, "baseline")[POOLED].updates


def test_a_trip_too_short_for_a_window_fails_and_the_rest_is_complete(drive: Trajectory) -> None:
    t = np.arange(9) * 0.1
    short = build_trajectory("made/short", t, np.zeros((9, 2)))
    result = evaluate([short, drive], SETTINGS)
    assert result.failures == {
        "made/short": "its longest part has 9 samples, a window needs 10: record longer"
    }
    assert [trip.id for trip in result.trips] == [drive.trip_id]
    with pytest.raises(ConfigError, match="made/short"):
        evaluate([short], SETTINGS)


def test_a_trip_of_parts_too_short_for_a_window_fails() -> None:
    t = np.concatenate([np.arange(9) * 0.1 + 20.0 * part for part in range(5)])
    with pytest.raises(ConfigError, match="its longest part has 9 samples"):
        evaluate([build_trajectory("made/parts", t, np.zeros((45, 2)))], SETTINGS)


def test_two_trips_of_one_name_are_refused(drive: Trajectory) -> None:
    with pytest.raises(ConfigError, match=f"two trips are named {drive.trip_id}"):
        evaluate([drive, drive], SETTINGS)


def test_no_trip_at_all_is_refused() -> None:
    with pytest.raises(ConfigError, match="no usable trip"):
        evaluate([], SETTINGS)


def test_the_map_of_a_trip_that_is_not_there_is_refused(drive: Trajectory) -> None:
    with pytest.raises(ConfigError, match="no trip named made/other"):
        evaluate([drive], replace(SETTINGS, map_at=("made/other", 3.0)))


@pytest.mark.parametrize("at_s", [-5.0, 0.0, 33.3, 99.9, 1e6])
def test_the_map_can_be_asked_for_at_any_time(drive: Trajectory, at_s: float) -> None:
    result = evaluate([drive], replace(SETTINGS, map_at=(drive.trip_id, at_s)))
    assert result.manoeuvre is not None
    assert result.timeline is not None


def test_an_evaluation_without_losses_to_draw_has_rates_alone(drive: Trajectory) -> None:
    result = evaluate([drive], replace(SETTINGS, packet_error_ratios=()))
    assert result.rates
    assert not result.tracking


def test_events_are_the_messages_of_the_rate_runs(both: EvaluationResult) -> None:
    total = sum(row.updates + row.identifications for row in both.rates if row.trip != POOLED)
    sizes = both.events["size_bytes"]
    assert isinstance(sizes, np.ndarray)
    assert sizes.size == total
    weighed = sum(row.bytes_per_s * row.duration_s for row in both.rates if row.trip != POOLED)
    assert sizes.sum() == pytest.approx(weighed)


def test_a_sensed_trip_is_measured_against_its_truth() -> None:
    made = generate_drive(seed=2, duration_s=90.0)
    case = make_case(SensedTrip(made.truth, made.input), SETTINGS)
    assert case.protocol == "sensor"
    assert case.truth is made.truth
    assert case.seen is made.input
    with pytest.raises(ValueError, match="is trip"):
        SensedTrip(made.truth, replace(made.input, trip_id="other"))
    with pytest.raises(ValueError, match="times"):
        SensedTrip(made.truth, replace(made.input, t_s=made.input.t_s + 0.01))


@pytest.mark.slow
@pytest.mark.real
def test_a_log_on_a_coarse_grid_is_conditioned_and_a_clean_one_is_not(
    spmd_trip: Trajectory, dynamic_trips: dict[str, Trajectory]
) -> None:
    automatic = EvaluationSettings((0.3,), (0.0,), seeds=1)
    coarse = make_case(spmd_trip, automatic)
    assert (coarse.protocol, coarse.conditioning is not None) == ("sensor", True)
    clean = make_case(dynamic_trips["TESLA_MODELX"], automatic)
    assert (clean.protocol, clean.conditioning) == ("recorded", None)
    assert clean.seen is clean.truth


def test_the_course_is_held_through_a_stop() -> None:
    t = np.arange(100) * 0.1
    moved = np.minimum(10.0 * t, 30.0)
    trip = build_trajectory("made/stop", t, np.stack([0.6 * moved, 0.8 * moved], axis=1))
    case = make_case(trip, SETTINGS)
    assert case.direction == pytest.approx(np.tile([0.6, 0.8], (100, 1)))
    assert case.standing[40:].all()


def test_settings_name_everything_that_changes_the_numbers(
    constant_selector: Callable[..., Selector],
) -> None:
    """Two settings that give other numbers must not look the same in a summary."""
    four = bank_from_text("learned+ctra+gp-vehicle+cv")
    base = EvaluationSettings(bank=four, start="guarded", identify="never")
    changed: dict[str, Any] = {
        "thresholds_m": (0.7,),
        "packet_error_ratios": (0.1,),
        "seeds": 2,
        "seed": 5,
        "context": ContextSettings(leader=False),
        "bank": Bank((ConstantVelocity(), GaussianProcess(20, noise_floor_m=1e-5)), "paper"),
        "start": "keep",
        "identify": "best",
        "selector": constant_selector(
            tuple(one.name for one in base.bank.members), np.zeros(len(base.bank.members)), 0.2
        ),
        "costs": CostTable(
            2.0,
            1.0,
            thresholds_m=np.array([0.2]),
            update_life_s=np.array([3.0]),
            age_edges_s=np.empty(0),
            share_edges=np.empty(0),
            residual_life_s=np.ones((1, len(base.bank.members), 1, 1)),
        ),
        "keep_alive_s": None,
        "believe": "sent",
        "budget": 2.0,
        "legacy_threshold_m": 1.0,
        "mean_burst_s": 1.0,
        "delay_s": 0.1,
        "expiry_s": 3.0,
        "protocol": "sensor",
        "sensor": replace(base.sensor, position_noise_m=0.5),
        "keep_samples": "all",
        "quantised": False,
        "velocity": "slope-2",
        "sizes": replace(base.sizes, more_bytes=10),
        "stack": replace(base.stack, certificates="digest"),
        "references": False,
        "free": None,
        "detail_threshold_m": 0.5,
        "decides": ErrorDriven(0.5),
    }
    unseen = {"map_at", "trained_on", "free_trained_on", "recorded", "decided_by"}
    assert {*changed, *unseen} == {item.name for item in fields(EvaluationSettings)}
    plain = base.as_plain()
    silent = [name for name, value in changed.items() if replace(base, **{name: value}).as_plain() == plain]
    assert silent == []
    told = {
        str(replace(base, packet_error_ratios=(0.25,), recorded=RecordedLosses((link,))).as_plain())
        for lost in ([0, 1, 0, 0], [0, 0, 1, 0])
        for period_s in (0.1, 0.2)
        for link in [LinkRecord("a hears b", np.array(lost, dtype=np.bool_), period_s=period_s)]
    }
    assert len(told) == 4


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"thresholds_m": ()}, "threshold"),
        ({"detail_threshold_m": 0.33}, "detail_threshold_m must be one of 0.2, 0.3, 0.4, 0.5, got 0.33"),
        ({"thresholds_m": (0.2, 0.2)}, "thresholds_m"),
        ({"thresholds_m": (-0.2,)}, "threshold_m"),
        ({"packet_error_ratios": (1.2,)}, "packet error ratio"),
        ({"packet_error_ratios": (float("nan"),)}, "packet error ratio"),
        ({"seeds": 0}, "seeds"),
        ({"seed": -1}, "seed"),
        ({"delay_s": -0.1}, "delay_s"),
        ({"delay_s": float("nan")}, "delay_s"),
        ({"expiry_s": 0.0}, "expiry_s"),
        ({"keep_alive_s": -1.0}, "max_inter_transmit_time_s|keep_alive_s"),
        ({"mean_burst_s": -1.0}, "mean_burst_s"),
        ({"believe": "heard"}, "believe"),
        ({"budget": 0.0}, "budget"),
        ({"start": "first"}, "start"),
        ({"identify": "seldom"}, "identify"),
        ({"protocol": "real"}, "protocol"),
        ({"keep_samples": "some"}, "keep_samples"),
        ({"velocity": "slope-3"}, "velocity"),
    ],
)
def test_settings_out_of_range_are_refused_by_name(changes: dict[str, Any], named: str) -> None:
    with pytest.raises(ValueError, match=named):
        replace(EvaluationSettings(), **changes)


def test_rows_call_the_model_based_sender_by_who_decides() -> None:
    decided = EvaluationSettings(decides=ErrorDriven(0.5))
    assert EvaluationSettings().sender == EvaluationSettings().as_plain()["decided_by"] == "mbc"
    assert decided.sender == decided.as_plain()["decided_by"] == "ErrorDriven"
    assert replace(decided, decided_by="mine:ahead_s=1").sender == "mine:ahead_s=1"
    with pytest.raises(ValueError, match="decided_by must be empty where decides is None, got 'mine'"):
        EvaluationSettings(decided_by="mine")
    for taken in ("mbc", "baseline", "baseline-matched", "baseline-periodic", "free", "free-matched"):
        with pytest.raises(ValueError, match=f"must not be the name of another sender, got '{taken}'"):
            replace(decided, decided_by=taken)
