"""Claims about comparisons: who is trained on what, agreement with single evaluations, and intervals."""

from collections.abc import Sequence
from dataclasses import replace
from operator import attrgetter
from typing import Any

import numpy as np
import pytest
from scipy import stats

from modelcast.core.exceptions import ConfigError
from modelcast.models.bank import Bank
from modelcast.models.gp import GaussianProcess
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.station.banks import BASELINE_BANK, PAPER_BANK, free_bank
from modelcast.study.compare.bootstrap import (
    limits,
    quantile_resamples,
    ratio_resamples,
    resample_weights,
)
from modelcast.study.compare.candidate import FixedCandidate, TrainedCandidate
from modelcast.study.compare.result import ComparisonResult, messages_of
from modelcast.study.compare.run import compare
from modelcast.study.compare.settings import CompareSettings
from modelcast.study.evaluate import evaluate
from modelcast.study.metrics import quantiles
from modelcast.study.result import POOLED
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory
from modelcast.world.drive import generate_drive

SHARED = EvaluationSettings((0.3, 0.5), (0.0, 0.4), seeds=2, seed=3)
SETTINGS = CompareSettings(SHARED, ("recorded", "sensor"), resamples=200)
CANDIDATES = (
    FixedCandidate("cv", BASELINE_BANK),
    FixedCandidate("ctra", Bank((ConstantTurnRateAcceleration(),))),
    FixedCandidate("paper", PAPER_BANK, "keep", "final"),
)
LEVEL_RATIO = 0.02
"""Resampled quantiles are counted at levels that are at most this share apart on these drives."""


@pytest.fixture(scope="module")
def trips() -> list[Trajectory]:
    """Three drives of unlike lengths, each in a file of its own, so that each is a route of its own."""
    drives = [
        generate_drive(seed, duration_s).truth for seed, duration_s in ((1, 90.0), (2, 100.0), (5, 120.0))
    ]
    return [replace(drive, trip_id=f"drive{at}/1") for at, drive in enumerate(drives)]


@pytest.fixture(scope="module")
def compared(trips: list[Trajectory]) -> ComparisonResult:
    return compare(trips, CANDIDATES, SETTINGS)


def learner(given: list[list[str]]) -> TrainedCandidate:
    """A candidate that writes down its training trips; its noise floor tells the folds apart."""

    def learn(trips: Sequence[Trajectory], settings: EvaluationSettings) -> EvaluationSettings:
        given.append([trip.trip_id for trip in trips])
        bank = Bank((GaussianProcess(form="intercept", noise_floor_m=0.01 * len(given)),))
        return replace(settings, bank=bank)

    return TrainedCandidate("learner", learn)


def test_a_trained_candidate_never_sees_the_route_it_is_judged_on(trips: list[Trajectory]) -> None:
    platoon = [*trips, replace(trips[0], trip_id="drive0/2")]
    given: list[list[str]] = []
    result = compare(platoon, [learner(given)], replace(SETTINGS, protocols=("recorded",)))
    assert [row.route for row in result.trips] == [0, 1, 2, 0]
    assert given == [
        ["drive1/1", "drive2/1"],
        ["drive0/1", "drive2/1", "drive0/2"],
        ["drive0/1", "drive1/1", "drive0/2"],
    ]


def test_each_trip_is_judged_with_what_was_learnt_on_the_other_routes(trips: list[Trajectory]) -> None:
    result = compare(trips, [learner([])], replace(SETTINGS, protocols=("recorded",)))
    for at, trip in enumerate(trips):
        bank = Bank((GaussianProcess(form="intercept", noise_floor_m=0.01 * (at + 1)),))
        alone = evaluate([trip], replace(SHARED, bank=bank, protocol="recorded", references=False))
        expected = [row.updates for row in alone.rates if (row.trip, row.policy) == (trip.trip_id, "mbc")]
        own = [row for row in result.counts if (row.trip, row.candidate) == (trip.trip_id, "learner")]
        assert [row.updates for row in own] == expected


def test_a_trained_candidate_needs_another_route(trips: list[Trajectory]) -> None:
    with pytest.raises(ConfigError, match=r"all trips lie on one route.*learner.*other routes.*profile"):
        compare(trips[:1], [learner([])], SETTINGS)


def as_pooled(trip: str, value: Any) -> Any:
    """What equals a figure of an evaluation: a pooled one within a bin of its histogram."""
    return pytest.approx(value, rel=2.0**-9, abs=1e-6) if trip == POOLED else value


@pytest.mark.parametrize("protocol", ["recorded", "sensor"])
@pytest.mark.parametrize("candidate", CANDIDATES, ids=lambda one: one.name)
def test_rows_are_those_of_a_single_evaluation(
    trips: list[Trajectory], compared: ComparisonResult, candidate: FixedCandidate, protocol: str
) -> None:
    """To the last bit: the work shared among candidates changes nothing.

    But pooled percentiles of an evaluation are those of a histogram, within one of its bins.
    """
    settings = replace(candidate.fitted((), SHARED), protocol=protocol, references=False)
    alone = evaluate(trips, settings)
    chosen = [row for row in compared.counts if (row.candidate, row.protocol) == (candidate.name, protocol)]
    for row in chosen:
        mbc, baseline = (
            next(
                one
                for one in alone.rates
                if (one.trip, one.policy, one.threshold_m) == (row.trip, policy, row.threshold_m)
            )
            for policy in ("mbc", "baseline")
        )
        assert (row.updates, row.identifications) == (mbc.updates, mbc.identifications)
        assert row.message_bytes / row.duration_s == mbc.bytes_per_s
        assert (row.baseline_messages, row.baseline_bytes / row.duration_s) == (
            baseline.updates,
            baseline.bytes_per_s,
        )
    tracked = [
        row for row in compared.tracking if (row.candidate, row.protocol) == (candidate.name, protocol)
    ]
    assert len(tracked) == (1 + len(trips)) * 4
    for row in tracked:
        own, matched, periodic, baseline, free, free_matched = (
            next(
                one
                for one in alone.tracking
                if (one.trip, one.policy, one.threshold_m, one.packet_error_ratio)
                == (row.trip, policy, row.threshold_m, row.packet_error_ratio)
                and one.rate_basis in {None, "total"}
            )
            for policy in (
                "mbc",
                "baseline-matched",
                "baseline-periodic",
                "baseline",
                "free",
                "free-matched",
            )
        )
        assert (row.p90_m, row.p99_m) == as_pooled(row.trip, (own.pte_p90_m, own.pte_p99_m))
        assert (row.matched_p90_m, row.matched_p99_m) == as_pooled(
            row.trip, (matched.pte_p90_m, matched.pte_p99_m)
        )
        assert (row.periodic_p90_m, row.periodic_p99_m) == as_pooled(
            row.trip, (periodic.pte_p90_m, periodic.pte_p99_m)
        )
        for prefix, one in (("baseline", baseline), ("free", free), ("free_matched", free_matched)):
            figures = [getattr(row, f"{prefix}_{name}") for name in ("p90_m", "p99_m")]
            assert tuple(figures) == as_pooled(row.trip, (one.pte_p90_m, one.pte_p99_m))
            assert getattr(row, f"{prefix}_rate_hz") == pytest.approx(one.message_rate_hz)
        assert row.message_rate_hz == pytest.approx(own.message_rate_hz)
        assert row.p90_ratio == row.p90_m / min(row.matched_p90_m, row.periodic_p90_m)
        assert row.p90_over_free == row.p90_m / row.free_matched_p90_m


def test_the_baselines_may_be_given_the_rate_of_updates(trips: list[Trajectory]) -> None:
    """As in the rows of an evaluation on that basis; updates are fewer than all messages."""
    paper = FixedCandidate("paper", PAPER_BANK)
    asked = replace(SETTINGS, evaluation=replace(SHARED, free=None), protocols=("recorded",))
    by_update, by_total = (
        compare(trips, [paper], replace(asked, rate_basis=basis)).tracking for basis in ("update", "total")
    )
    alone = evaluate(trips, replace(paper.fitted((), SHARED), protocol="recorded", references=False)).tracking
    for row, total in zip(by_update, by_total, strict=True):
        assert (row.rate_basis, total.rate_basis) == ("update", "total")
        assert row.p90_m == total.p90_m
        (matched,) = (
            one
            for one in alone
            if (one.trip, one.policy, one.rate_basis, one.threshold_m, one.packet_error_ratio)
            == (row.trip, "baseline-matched", "update", row.threshold_m, row.packet_error_ratio)
        )
        assert row.matched_p90_m == as_pooled(row.trip, matched.pte_p90_m)
        if row.trip == POOLED:
            assert row.matched_rate_hz < total.matched_rate_hz


def test_the_baselines_bank_compared_with_itself_is_one(compared: ComparisonResult) -> None:
    rows = [row for row in compared.ratios if row.candidate == "cv"]
    assert {(row.message_ratio, row.message_low, row.message_high) for row in rows} == {(1.0, 1.0, 1.0)}
    assert {row.trips_over for row in rows} == {0}
    tracked = [row for row in compared.tracking if (row.candidate, row.trip) == ("cv", POOLED)]
    assert all(row.matched_rate_hz == row.message_rate_hz for row in tracked)


def test_ratios_are_of_sums_and_differences_to_the_free_receiver(compared: ComparisonResult) -> None:
    ratios: dict[str, float] = {}
    for name in ("free", "paper"):
        rows = [
            row
            for row in compared.counts
            if (row.candidate, row.protocol, row.threshold_m) == (name, "sensor", 0.5)
        ]
        assert len(rows) == 3
        ratios[name] = sum(messages_of(row) for row in rows) / sum(row.baseline_messages for row in rows)
    (row,) = (
        row
        for row in compared.ratios
        if (row.candidate, row.protocol, row.threshold_m) == ("paper", "sensor", 0.5)
    )
    assert row.message_ratio == ratios["paper"]
    assert row.difference == ratios["paper"] - ratios["free"]
    assert row.message_low is not None
    assert row.message_high is not None
    assert row.message_low <= row.message_ratio <= row.message_high


def test_ratios_to_the_candidate_compared_against_are_of_sums_on_the_same_trips(
    trips: list[Trajectory],
) -> None:
    """And the bound is one in twenty more, or five messages."""
    candidates = [FixedCandidate("cv", BASELINE_BANK), FixedCandidate("paper", PAPER_BANK)]
    found = compare(trips, candidates, replace(SETTINGS, against="paper"))
    assert found.rival == "paper"
    assert list(dict.fromkeys(row.rival for row in found.rivals)) == ["paper", "free"]
    for row in found.rivals:
        if row.rival != "paper":
            continue
        own, other = (
            [
                one
                for one in found.counts
                if (one.candidate, one.protocol, one.threshold_m) == (name, row.protocol, row.threshold_m)
            ]
            for name in (row.candidate, "paper")
        )
        for name, ratio in (
            ("messages", row.message_ratio),
            ("message_bytes", row.bytes_ratio),
            ("airtime_s", row.airtime_ratio),
        ):
            read = messages_of if name == "messages" else attrgetter(name)
            sums = [sum(map(read, rows)) for rows in (own, other)]
            assert ratio == pytest.approx(sums[0] / sums[1])
        excess = [
            messages_of(one) - max(1.05 * messages_of(two), messages_of(two) + 5)
            for one, two in zip(own, other, strict=True)
        ]
        assert (row.trips, row.trips_over) == (len(own), sum(value > 0 for value in excess))
        assert row.worst_excess == max(excess)
        worst = excess.index(row.worst_excess)
        assert row.worst_trip == own[worst].trip == other[worst].trip
        assert row.worst_ratio == messages_of(own[worst]) / messages_of(other[worst])
        if row.candidate == "paper":
            assert (row.message_ratio, row.message_low, row.message_high) == (1.0, 1.0, 1.0)


def test_trips_over_the_bound_are_counted_and_the_worst_is_named(compared: ComparisonResult) -> None:
    for row in compared.ratios:
        counts = [
            one
            for one in compared.counts
            if (one.candidate, one.protocol, one.threshold_m)
            == (row.candidate, row.protocol, row.threshold_m)
        ]
        beyond = {
            one.trip: messages_of(one) - max(1.02 * one.baseline_messages, one.baseline_messages + 3)
            for one in counts
        }
        assert row.trips_over == sum(value > 0 for value in beyond.values())
        assert row.worst_excess == beyond[row.worst_trip] == max(beyond.values())


def test_the_free_receiver_is_a_candidate_unless_it_is_one_or_left_out(trips: list[Trajectory]) -> None:
    rates = replace(SHARED, packet_error_ratios=(), references=False)
    asked = CompareSettings(rates, ("recorded",), resamples=20)
    named = FixedCandidate("plain", free_bank())
    other = FixedCandidate("free", BASELINE_BANK)
    for candidates, settings, names, free in (
        (CANDIDATES[:1], asked, ["cv", "free"], "free"),
        ([CANDIDATES[0], named], asked, ["cv", "plain"], "plain"),
        ([other], asked, ["free", "free receiver"], "free receiver"),
        (CANDIDATES[:1], replace(asked, evaluation=replace(rates, free=None)), ["cv"], None),
    ):
        result = compare(trips[:1], candidates, settings)
        assert [row.name for row in result.candidates] == names
        assert (result.free, result.settings["against"]) == (free, free or names[0])


def test_without_the_free_receiver_nothing_is_said_of_it(trips: list[Trajectory]) -> None:
    alone = replace(SETTINGS, evaluation=replace(SHARED, free=None), protocols=("recorded",))
    for row in compare(trips, CANDIDATES[:1], alone).tracking:
        names = ("free_p90_m", "free_matched_rate_hz", "p99_over_free", "p90_over_free_low")
        assert set(row.picked(names).values()) == {None}
        assert row.baseline_p90_m == row.p90_m


def test_the_free_receiver_at_its_own_rate_is_itself(compared: ComparisonResult) -> None:
    rows = [row for row in compared.tracking if row.candidate == "free"]
    assert rows
    for row in rows:
        assert row.p90_m == row.free_p90_m == row.free_matched_p90_m
        assert row.message_rate_hz == row.free_rate_hz == row.free_matched_rate_hz
        if row.trip == POOLED:
            assert (row.p90_over_free, row.p90_over_free_low, row.p90_over_free_high) == (1.0, 1.0, 1.0)


def test_differences_can_be_taken_to_any_candidate(trips: list[Trajectory]) -> None:
    settings = replace(SETTINGS, against="ctra", evaluation=replace(SHARED, packet_error_ratios=()))
    result = compare(trips, CANDIDATES, settings)
    assert not result.tracking
    own = {row.candidate: row for row in result.ratios if row.threshold_m == 0.3}
    assert own["ctra"].difference == 0.0
    assert own["cv"].difference == pytest.approx(1.0 - own["ctra"].message_ratio)


def test_one_trip_has_no_intervals(trips: list[Trajectory]) -> None:
    result = compare(trips[:1], CANDIDATES[:2], SETTINGS)
    assert {(row.message_low, row.difference_high, row.bytes_low) for row in result.ratios} == {(None,) * 3}
    assert {(row.p90_low, row.p99_over_free_high) for row in result.tracking} == {(None, None)}


def test_the_same_seed_gives_the_same_result(trips: list[Trajectory], compared: ComparisonResult) -> None:
    steps: list[tuple[int, int]] = []
    again = compare(trips, CANDIDATES, SETTINGS, progress=lambda done, total: steps.append((done, total)))
    assert again == compared
    assert steps == [(at + 1, 24) for at in range(24)]


def test_mistakes_are_named(trips: list[Trajectory]) -> None:
    short = replace(trips[0], trip_id="short/1")
    tiny = Trajectory("tiny/1", short.t_s[:5], short.position_m[:5], segments=np.array([0, 5]), dt_s=0.1)
    result = compare([trips[0], tiny], CANDIDATES, SETTINGS)
    assert result.failures == {"tiny/1": "its longest part has 5 samples, a window needs 13: record longer"}
    for given, candidates, settings, said in (
        ([tiny], CANDIDATES, SETTINGS, "no usable trip .tiny/1"),
        (trips, (), SETTINGS, "at least one candidate"),
        (trips, CANDIDATES[:1] * 2, SETTINGS, "two candidates are named cv"),
        ([trips[0], trips[0]], CANDIDATES, SETTINGS, "two trips are named drive0/1"),
        (
            trips,
            CANDIDATES,
            replace(SETTINGS, against="gp"),
            "no candidate is named 'gp'; there are cv, ctra, paper, free",
        ),
    ):
        with pytest.raises(ConfigError, match=said):
            compare(given, candidates, settings)
    for changes in ({"protocols": ()}, {"protocols": ("real",)}, {"resamples": 0}, {"cluster": "car"}):
        with pytest.raises(ValueError, match=next(iter(changes))):
            replace(SETTINGS, **changes)


def test_intervals_are_scipys_percentile_bootstrap() -> None:
    """Two programs with their own draws: the ends agree within the bootstrap's own scatter."""
    rng = np.random.default_rng(4)
    base = rng.uniform(50.0, 500.0, 30)
    sent = base * rng.uniform(0.3, 1.1, 30)
    each = np.arange(30)
    drawn = ratio_resamples(resample_weights(each, 20_000, rng), sent, base)
    peer = stats.bootstrap(
        (sent, base),
        lambda a, b, axis: a.sum(axis=axis) / b.sum(axis=axis),
        paired=True,
        method="percentile",
        n_resamples=20_000,
        rng=rng,
    )
    scatter = 0.02 * float(np.ptp(peer.confidence_interval))
    assert limits(drawn, each) == pytest.approx(tuple(peer.confidence_interval), abs=2 * scatter)


def test_the_spread_is_the_delta_methods_for_many_trips() -> None:
    rng = np.random.default_rng(5)
    base = rng.uniform(50.0, 500.0, 400)
    sent = base * rng.uniform(0.3, 1.1, 400)
    drawn = ratio_resamples(resample_weights(np.arange(400), 20_000, rng), sent, base)
    residual = sent - sent.sum() / base.sum() * base
    closed_form = np.sqrt((residual**2).sum()) / base.sum()
    assert drawn.std() == pytest.approx(closed_form, rel=0.03)


def test_a_route_is_drawn_whole_and_one_alone_has_no_limits() -> None:
    clusters = np.array([0, 1, 0, 2])
    weights = resample_weights(clusters, 500, np.random.default_rng(0))
    np.testing.assert_array_equal(weights[:, 0], weights[:, 2])
    np.testing.assert_array_equal(weights[:, [0, 1, 3]].sum(axis=1), 3.0)
    assert limits(np.arange(10.0), np.zeros(4, dtype=np.int64)) == (None, None)


def test_resampled_quantiles_are_those_of_the_resampled_trips() -> None:
    rng = np.random.default_rng(6)
    by_trip = [
        [np.sort(rng.lognormal(mean, 1.0, 200)).astype(np.float32) for _ in range(2)]
        for mean in (-1.0, 0.0, 1.5)
    ]
    shares = [0.1, 0.2, 0.1]
    weights = resample_weights(np.arange(3), 40, rng)
    found = quantile_resamples(weights, by_trip, shares, (0.9, 0.99))
    for row, drawn in zip(found, weights.astype(int), strict=True):
        rows = [one for trip, times in zip(by_trip, drawn, strict=True) for one in trip * times]
        counted = [share for share, times in zip(shares, drawn, strict=True) for _ in range(2 * times)]
        exact = quantiles(rows, counted, [0.9, 0.99])
        assert (row >= exact * (1.0 - 1e-6)).all()
        assert row == pytest.approx(exact, rel=LEVEL_RATIO)


def test_trips_that_never_had_a_track_give_no_quantiles() -> None:
    nothing = [np.empty(0, dtype=np.float32)]
    assert np.isnan(quantile_resamples(np.ones((4, 2)), [nothing, nothing], [0.1, 0.1], (0.9,))).all()


def test_pooled_rows_come_for_every_threshold_and_loss(compared: ComparisonResult) -> None:
    pooled = [row for row in compared.tracking if row.trip == POOLED]
    keys = {(row.candidate, row.protocol, row.threshold_m, row.packet_error_ratio) for row in pooled}
    assert len(pooled) == len(keys) == 4 * 2 * 2 * 2
    assert {row.reference for row in compared.references} == {
        "cam",
        "clairvoyant-1",
        "clairvoyant-2",
        "clairvoyant-3",
    }
