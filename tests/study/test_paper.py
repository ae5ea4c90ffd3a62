"""Claims about the reproduction: readings are evaluations, choices complete, verdicts as they say."""

from collections.abc import Iterable
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from modelcast.core.exceptions import ConfigError
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import PAPER_BANK, free_bank
from modelcast.study.case import make_case
from modelcast.study.evaluate import evaluate
from modelcast.study.histogram import BIN_RATIO
from modelcast.study.metrics import quantiles
from modelcast.study.network.pairs import PAIRED
from modelcast.study.paper.choices import CHOICES, PLAIN, Choice, Reading, combined, one_at_a_time
from modelcast.study.paper.claims import claim_rows
from modelcast.study.paper.complement import Complement, Survival
from modelcast.study.paper.plan import PaperPlan
from modelcast.study.paper.readings import ReadingRows, figure_of, run_reading
from modelcast.study.paper.result import PaperResult
from modelcast.study.paper.run import Job, reproduce_paper, run_job
from modelcast.study.paper.traffic import with_traffic
from modelcast.study.paper.verdict import Estimate, verdict_of
from modelcast.study.result import POOLED
from modelcast.study.rules import RATE_BASES
from modelcast.study.table import Row
from modelcast.study.tracking import LossRuns, walks_under_loss
from modelcast.trips.manoeuvres.base import FoundManoeuvre, ManoeuvreKind
from modelcast.trips.manoeuvres.rank import count_manoeuvres, rank_trips
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive

PLAN = PaperPlan((0.3, 0.5), (0.0, 0.2, 0.4), seeds=2, seed=3, resamples=50)


@pytest.fixture(scope="module")
def trips() -> list[Trajectory]:
    """Two drives, each in a file of its own."""
    drives = [generate_drive(seed, duration_s).truth for seed, duration_s in ((1, 90.0), (2, 110.0))]
    return [replace(drive, trip_id=f"drive{at}/1") for at, drive in enumerate(drives)]


@pytest.fixture(scope="module")
def found(trips: list[Trajectory]) -> PaperResult:
    return reproduce_paper(trips, PLAN)


def test_every_choice_is_a_field_and_the_plain_reading_takes_its_first_option() -> None:
    assert sorted(choice.field for choice in CHOICES) == sorted(item.name for item in fields(Reading))
    for choice in CHOICES:
        assert choice.options[0].value == getattr(PLAIN, choice.field)
        assert len({option.value for option in choice.options}) == len(choice.options) > 1
    assert PLAIN.bank == PAPER_BANK


def test_the_readings_differ_from_the_plain_one_in_one_choice_each() -> None:
    readings = one_at_a_time()
    assert len(readings) == 1 + sum(len(choice.options) - 1 for choice in CHOICES)
    assert len({one.label for one in readings}) == len(readings)
    for one in readings[1:]:
        changed = [
            item.name
            for item in fields(Reading)
            if getattr(one.reading, item.name) != getattr(PLAIN, item.name)
        ]
        assert [choice.field for choice in CHOICES if choice.title == one.choice] == changed


@pytest.mark.parametrize(
    "reading",
    [
        PLAIN,
        replace(PLAIN, start="keep", identify="best", keep_alive_s=2.0),
        replace(PLAIN, order="gp-first", protocol="sensor", velocity="slope-2"),
        replace(PLAIN, noise_floor_m=0.01, quantised=True),
    ],
)
def test_a_reading_is_the_evaluation_with_its_options(trips: list[Trajectory], reading: Reading) -> None:
    """Messages to the last bit; errors beside every rival as closely as the evaluation's pools tell them."""
    rows = run_reading(trips, reading, PLAN)
    process = GaussianProcess(form="anchored", noise_floor_m=reading.noise_floor_m)
    members: Any = (ConstantVelocity(), process)
    alone = evaluate(
        trips,
        replace(
            PLAN.settings(reading),
            bank=Bank(members if reading.order == "cv-first" else members[::-1], "paper"),
        ),
    )
    for at, threshold_m in enumerate(PLAN.thresholds_m):
        mbc, baseline = (
            next(
                row
                for row in alone.rates
                if (row.trip, row.policy, row.threshold_m) == (POOLED, policy, threshold_m)
            )
            for policy in ("mbc", "baseline")
        )
        sent = mbc.updates + mbc.identifications
        assert rows.messages[at].message_ratio == pytest.approx(sent / baseline.updates, rel=1e-12)
        assert rows.updates[at].message_ratio == pytest.approx(mbc.updates / baseline.updates, rel=1e-12)
        assert rows.messages[at].airtime_ratio == pytest.approx(
            mbc.airtime_per_s / baseline.airtime_per_s, rel=1e-9
        )
        for basis, schedule in rows.tracking:
            row = rows.pooled(replace(reading, rate_basis=basis, schedule=schedule))[at]
            own, rival = (
                next(
                    one.pte_p90_m
                    for one in alone.tracking
                    if (one.trip, one.policy, one.rate_basis) == (POOLED, policy, own_basis)
                    and (one.threshold_m, one.packet_error_ratio) == (threshold_m, 0.4)
                )
                for policy, own_basis in (("mbc", None), (f"baseline-{schedule}", basis))
            )
            assert row.p90_ratio == pytest.approx(own / rival, rel=2 * BIN_RATIO)


def test_the_process_alone_is_that_bank_of_one(trips: list[Trajectory]) -> None:
    rows = run_reading(trips, PLAIN, PLAN)
    alone = Bank((GaussianProcess(form="anchored", noise_floor_m=1e-5),))
    rates = evaluate(trips, replace(PLAN.settings(PLAIN, ()), bank=alone)).rates
    for row in rows.alone:
        mbc, baseline = (
            next(
                one
                for one in rates
                if (one.trip, one.policy, one.threshold_m) == (POOLED, policy, row.threshold_m)
            )
            for policy in ("mbc", "baseline")
        )
        assert row.message_ratio == pytest.approx(mbc.updates / baseline.updates)


@pytest.mark.slow
def test_combinations_take_the_options_that_were_best_or_worst_by_themselves(found: PaperResult) -> None:
    by_label = {one.labelled.label: one for one in found.readings}
    for label, figure, pick in (
        ("combined: fewest messages", "messages", min),
        ("combined: most messages", "messages", max),
        ("combined: best tracking", "tracking", min),
        ("combined: worst tracking", "tracking", max),
    ):
        taken = by_label[label].labelled.reading
        for choice in CHOICES:
            if choice.stated:  # what the paper says is no way to read it
                assert getattr(taken, choice.field) == choice.options[0].value
                continue
            figures = {
                option.value: getattr(
                    by_label.get(f"{choice.title}: {option.label}", found.readings[0]), figure
                )
                for option in choice.options
            }
            assert figures[getattr(taken, choice.field)] == pick(figures.values())
    assert found.readings[-1].labelled.label == "combined: worst tracking"


@pytest.mark.slow
def test_a_reading_that_differs_in_its_rival_alone_is_not_run_again(trips: list[Trajectory]) -> None:
    done: list[Job] = []

    def each(function: Any, jobs: Iterable[Job]) -> list[Any]:
        jobs = list(jobs)
        done.extend(jobs)
        return [function(job) for job in jobs]

    steps: list[tuple[int, int]] = []
    reproduce_paper(trips, PLAN, each=each, progress=lambda at, of: steps.append((at, of)))
    ran = [job.reading for job in done if job.what == "reading"]
    assert len(set(ran)) == len(ran)
    assert {(reading.rate_basis, reading.schedule) for reading in ran} == {("update", "periodic")}
    parts = 1 + sum(job.what != "count" for job in done)  # all trips are counted in one
    assert [at for at, _ in steps] == list(range(1, parts + 1))
    assert steps[-1] == (parts, parts)


@pytest.mark.slow
def test_the_same_plan_gives_the_same_result(trips: list[Trajectory], found: PaperResult) -> None:
    again = reproduce_paper(trips, PLAN)
    assert again.claims == found.claims
    assert [one.rows.messages for one in again.readings] == [one.rows.messages for one in found.readings]


def test_work_done_elsewhere_and_out_of_order_is_refused(trips: list[Trajectory]) -> None:
    def backwards(function: Any, jobs: Iterable[Job]) -> list[Any]:
        return [function(job) for job in reversed(list(jobs))]

    with pytest.raises(TypeError, match="ReadingRows for EvaluationResult"):
        reproduce_paper(trips, replace(PLAN, thresholds_m=(0.5,), seeds=1), each=backwards)


@pytest.mark.slow
def test_short_trips_are_left_out_and_named(trips: list[Trajectory]) -> None:
    first = trips[0]
    stump = build_trajectory("stump/1", first.t_s[:6], first.position_m[:6])
    result = reproduce_paper([*trips, stump], replace(PLAN, thresholds_m=(0.5,), packet_error_ratios=(0.4,)))
    assert list(result.failures) == ["stump/1"]
    with pytest.raises(ConfigError, match="no usable trip"):
        reproduce_paper([stump], PLAN)


def test_the_plan_must_hold_the_ratio_that_readings_are_compared_at() -> None:
    with pytest.raises(ValueError, match=r"must hold 0\.4"):
        PaperPlan(packet_error_ratios=(0.0, 0.5))
    with pytest.raises(ValueError, match="resamples"):
        PaperPlan(resamples=0)


def test_the_number_that_ranks_is_the_geometric_mean_over_thresholds(found: PaperResult) -> None:
    plain = found.readings[0]
    ratios = [row.message_ratio for row in plain.rows.messages]
    assert plain.messages == pytest.approx(float(np.prod(ratios)) ** (1 / len(ratios)))
    assert figure_of(plain.rows, replace(PLAIN, rate_basis="total"), "tracking") > plain.tracking


def test_time_is_shared_between_who_holds(trips: list[Trajectory]) -> None:
    """Against a walk by hand: errors under the threshold, counted where both sub-models serve."""
    shared = run_reading(trips, PLAIN, PLAN).complement
    only, both, neither = np.zeros(2), 0.0, 0.0
    for trip in trips:
        settings = PLAN.settings(PLAIN, ())
        case = make_case(trip, settings)
        ready = TripRuntime(case.seen, settings.bank, case.estimator)
        errors = ready.tracking_error_m(ready.run(settings.policy(0.3, keep_alive=False)))
        for row in errors:
            if np.isinf(row).any():
                continue
            first, second = row < 0.3
            only += trip.dt_s * np.array([first and not second, second and not first])
            both += trip.dt_s * (first and second)
            neither += trip.dt_s * (not first and not second)
    assert shared.only_s == pytest.approx(tuple(only))
    assert (shared.both_s, shared.neither_s) == pytest.approx((both, neither))
    assert shared.timeline is not None
    shown = shared.timeline.tracking_error_m
    alone = (shown < 0.3) & np.isfinite(shown).all(axis=1)[:, None]
    assert (alone[:, 0] & ~alone[:, 1]).any()
    assert (alone[:, 1] & ~alone[:, 0]).any()


def test_manoeuvres_are_survived_as_long_as_paths_stay_near(trips: list[Trajectory]) -> None:
    starts = [
        (
            FoundManoeuvre(ManoeuvreKind.TURN, 40.0, 45.0, size=1.5),
            FoundManoeuvre(ManoeuvreKind.STOP, 70.0, 75.0, size=5.0),
        ),
        (),
    ]
    shared = run_reading(trips, PLAIN, PLAN, starts).complement
    assert [(one.trip, one.kind) for one in shared.survivals] == [("drive0/1", "turn"), ("drive0/1", "stop")]
    assert all(0.0 <= life <= 4.0 for one in shared.survivals for life in one.survival_s.values())
    assert shared.manoeuvre is not None
    assert shared.manoeuvre.start_s == pytest.approx(39.5)  # the turn, whichever parts the paths more
    drawn = {name: min(life, 4.0) for name, life in shared.manoeuvre.survival_s.items()}
    assert drawn == pytest.approx(shared.survivals[0].survival_s)


def test_a_path_that_stays_near_is_not_said_to_fail(trips: list[Trajectory]) -> None:
    wide = replace(PLAN, thresholds_m=(1000.0,))
    turn = FoundManoeuvre(ManoeuvreKind.TURN, 40.0, 45.0, size=1.5)
    shared = run_reading(trips[:1], PLAIN, wide, [(turn,)]).complement
    assert shared.manoeuvre is None  # both hold throughout: the paths do not part
    assert shared.survivals[0].survival_s == pytest.approx({"cv": 4.0, "gp-anchored": 4.0})


def claims_of(found: PaperResult, lives: list[tuple[float, float]]) -> dict[str, Any]:
    """Claims of the same readings with other survivals of the process and of constant velocity."""
    survivals = tuple(
        Survival("t/1", "turn", float(at), {"cv": other, "gp-anchored": own})
        for at, (own, other) in enumerate(lives)
    )
    shared = Complement(
        ("cv", "gp-anchored"),
        0.3,
        only_s=(1.0, 0.5),
        both_s=40.0,
        neither_s=1.0,
        timeline=None,
        manoeuvre=None,
        survivals=survivals,
    )
    readings = [replace(one, rows=replace(one.rows, complement=shared)) for one in found.readings]
    return {row.name: row for row in claim_rows(readings)}


def test_manoeuvres_are_judged_by_a_sign_test_that_leaves_ties_out(found: PaperResult) -> None:
    name = "the process follows manoeuvres"
    assert claims_of(found, [(2.0, 1.0)] * 12 + [(1.0, 1.0)] * 50)[name].verdicts["plain"] == "holds"
    assert claims_of(found, [(1.0, 2.0)] * 12)[name].verdicts["plain"] == "fails"
    assert claims_of(found, [(2.0, 1.0)] * 6 + [(1.0, 2.0)] * 4)[name].verdicts["plain"] == "not shown"
    assert claims_of(found, [])[name].verdicts["plain"] == "not run"


def test_sub_models_complete_each_other_where_both_have_their_time(found: PaperResult) -> None:
    row = claims_of(found, [])["they complete each other"]
    assert row.verdicts["plain"] == "holds"
    assert row.figure == "only cv 2.4 %, only gp-anchored 1.2 %, both 94.1 %, neither 2.4 %"


def test_every_claim_has_a_plain_verdict_and_those_of_readings_all(found: PaperResult) -> None:
    labels = [one.labelled.label for one in found.readings]
    by_reading = [row for row in found.claims if len(row.verdicts) > 4]
    assert len(by_reading) == 11
    for row in by_reading:
        assert list(row.verdicts) == labels
    assert all("plain" in row.verdicts for row in found.claims)
    assert {row.name for row in found.claims if row.verdicts["plain"] == "not run"} == {
        "any radio",
        "fewer collisions",
        "a channel less busy",
    }


def test_the_claim_about_messages_is_the_verdict_on_their_ratios(found: PaperResult) -> None:
    (row,) = (one for one in found.claims if one.name == "fewer messages")
    for one in found.readings:
        estimates = [Estimate(r.message_ratio, r.message_low, r.message_high) for r in one.rows.messages]
        assert row.verdicts[one.labelled.label] == verdict_of(estimates)


@pytest.mark.parametrize(
    "reading", [PLAIN, replace(PLAIN, identify="best", quantised=True, keep_alive_s=2.0)]
)
def test_the_free_receiver_is_the_free_bank_under_the_same_losses(
    trips: list[Trajectory], reading: Reading
) -> None:
    """Messages of the same sender with that bank alone; errors beside it at the hybrid's rate."""
    rows = run_reading(trips, reading, PLAN)
    settings = PLAN.settings(reading, (0.4,))
    alone = evaluate(trips, replace(settings, bank=free_bank(), identify="never", packet_error_ratios=()))
    for at, threshold_m in enumerate(PLAN.thresholds_m):
        (free,) = (
            one
            for one in alone.rates
            if (one.trip, one.policy, one.threshold_m) == (POOLED, "mbc", threshold_m)
        )
        own = rows.messages[at]
        sent = (own.update_rate_hz + own.identification_rate_hz) * own.duration_s
        assert rows.beside_free[at].message_ratio == pytest.approx(sent / free.updates)
        assert rows.beside_free[at].bytes_ratio == pytest.approx(own.bytes_per_s / free.bytes_per_s)
        errors: dict[str, list[Any]] = {}
        weights: list[float] = []
        for trip in trips:
            case = make_case(trip, settings)
            hybrid, plain = (
                TripRuntime(case.seen, bank, case.estimator, quantised=settings.quantised)
                for bank in (settings.bank, free_bank())
            )
            losses = LossRuns(case, plain, settings)
            walks = walks_under_loss([hybrid], settings, threshold_m)
            runs = losses.contended([hybrid], walks, settings, threshold_m, RATE_BASES)
            names = ("own", *((basis, how) for basis in RATE_BASES for how in ("matched", "periodic")))
            for name, run in zip(names, runs, strict=True):
                found = run.after_m.ravel()
                errors.setdefault(str(name), []).append(np.sort(found[~np.isnan(found)]))
            weights.append(case.truth.dt_s)
        p90 = {name: quantiles(found, weights, [0.9])[0] for name, found in errors.items()}
        assert len(rows.tracking_beside_free) == 4
        for basis, schedule in rows.tracking_beside_free:
            row = rows.beside_free_pooled(replace(reading, rate_basis=basis, schedule=schedule))[at]
            assert row.p90_ratio == pytest.approx(p90["own"] / p90[str((basis, schedule))])
            assert row.packet_error_ratio == 0.4


def test_what_the_paper_does_not_claim_is_the_verdict_on_the_free_receiver(found: PaperResult) -> None:
    fewer, nearer = found.claims[-5:-3]
    assert (fewer.place, nearer.place) == ("beside it", "beside it")
    for one in found.readings:
        messages = [Estimate(r.message_ratio, r.message_low, r.message_high) for r in one.rows.beside_free]
        errors = [
            Estimate(r.p90_ratio, r.p90_low, r.p90_high)
            for r in one.rows.beside_free_pooled(one.labelled.reading)
        ]
        assert fewer.verdicts[one.labelled.label] == verdict_of(messages)
        assert nearer.verdicts[one.labelled.label] == verdict_of(errors)
    worst = max(found.readings[0].rows.beside_free, key=lambda row: row.worst_ratio)
    assert fewer.worst.startswith(f"{worst.worst_trip} {worst.worst_ratio:.2f}")


def test_the_sweep_looks_at_every_ratio_with_losses(found: PaperResult) -> None:
    """Against the rows of the evaluation; the verdict is on their intervals, for every rival."""
    (row,) = (one for one in found.claims if one.name == "better at every loss")
    shown = []
    for ratio in (0.2, 0.4):
        ratios = []
        for threshold_m in PLAN.thresholds_m:
            own, rival = (
                next(
                    one.pte_p90_m
                    for one in found.evaluation.tracking
                    if (one.trip, one.policy, one.rate_basis) == (POOLED, policy, basis)
                    and (one.threshold_m, one.packet_error_ratio) == (threshold_m, ratio)
                )
                for policy, basis in (("mbc", None), ("baseline-periodic", "update"))
            )
            ratios.append(own / rival)
        shown.append(f"{100 * ratio:g} %: {min(ratios):.2f} to {max(ratios):.2f}")
    assert row.figure == ", ".join(shown)
    for label in ("plain", "rate basis: all messages", "baseline's schedule: error-driven"):
        (reading,) = (one for one in found.readings if one.labelled.label == label)
        swept = [one for one in reading.rows.sweep(reading.labelled.reading) if one.packet_error_ratio > 0]
        assert len(swept) == 4
        assert row.verdicts[label] == verdict_of(
            [Estimate(one.p90_ratio, one.p90_low, one.p90_high) for one in swept]
        )


ratio = st.floats(0.1, 10.0)


@given(st.lists(ratio, min_size=1, max_size=6))
def test_without_intervals_a_verdict_counts_the_ratios(values: list[float]) -> None:
    found = verdict_of([Estimate(value) for value in values])
    assert (found == "holds") == all(value < 1 for value in values)
    assert (found == "fails") == all(value > 1 for value in values)
    assert found != "not run"


@given(st.lists(st.tuples(ratio, ratio), min_size=1, max_size=6))
def test_an_interval_across_one_shows_nothing(ends: list[tuple[float, float]]) -> None:
    estimates = [Estimate((low + high) / 2, low, high) for low, high in (sorted(pair) for pair in ends)]
    crossing = [one.low <= 1 <= one.high for one in estimates]  # type: ignore[operator]
    found = verdict_of(estimates)
    assert (found == "not shown") == all(crossing)
    if any(crossing):
        assert found not in ("holds", "fails")


def test_options_of_a_reading_are_combined() -> None:
    by_field: dict[str, Choice] = {choice.field: choice for choice in CHOICES}
    start, floor = by_field["start"], by_field["noise_floor_m"]
    made = combined("mine", [(start, start.options[2]), (floor, floor.options[1])])
    assert made.reading == replace(PLAIN, start="survivor", noise_floor_m=0.001)


def test_jobs_run_alone_give_what_the_whole_gives(trips: list[Trajectory], found: PaperResult) -> None:
    rows = run_job(Job("reading", trips, PLAN, replace(PLAIN, start="keep")))
    (same,) = (one.rows for one in found.readings if one.labelled.label == "start rule: keep")
    assert isinstance(rows, ReadingRows)
    assert (rows.messages, rows.updates, rows.alone) == (same.messages, same.updates, same.alone)
    assert rows.tracking == same.tracking


def test_manoeuvres_are_those_of_the_ranked_trips(trips: list[Trajectory], found: PaperResult) -> None:
    counts = [count_manoeuvres(trip) for trip in trips]
    assert list(found.manoeuvres) == rank_trips(counts)
    assert len(found.complement.survivals) <= sum(one.total for one in counts)
    assert {one.kind for one in found.complement.survivals} <= {
        one.kind.value for found_on in counts for one in found_on.manoeuvres
    }


def paired(
    verdict: str,
    *,
    radio: str = "dsrc",
    by_range: bool = False,
    hybrid: float = 1.0,
    figure: str = "collision_rate_hz",
    bank: str = "paper",
) -> Row:
    """A row of the collisions in traffic that came to this verdict."""
    return PAIRED.row(
        density_per_km=100.0,
        radio=radio,
        bank=bank,
        threshold_m=0.2,
        figure=figure,
        low_m=50.0,
        high_m=150.0,
        by_range=by_range,
        seeds=3,
        hybrid=hybrid,
        hybrid_low=None,
        hybrid_high=None,
        baseline=2.0,
        baseline_low=None,
        baseline_high=None,
        difference=hybrid - 2.0,
        difference_low=None,
        difference_high=None,
        verdict=verdict,  # type: ignore[arg-type]
    )


@pytest.mark.parametrize(
    ("verdicts", "expected"),
    [
        (["fewer", "fewer"], "holds"),
        (["more", "more"], "fails"),
        (["fewer", "more"], "in part"),
        (["fewer", "no difference shown"], "in part"),
        (["no difference shown"], "not shown"),
        (["one seed"], "not shown"),
        ([], "not run"),
    ],
)
def test_collisions_are_fewer_where_every_density_has_fewer(
    found: PaperResult, verdicts: list[str], expected: str
) -> None:
    rows = [paired(verdict) for verdict in verdicts]
    rows += [paired("more", by_range=True)] if rows else []
    result = with_traffic(found, rows)
    claims = {row.name: row for row in result.claims}
    assert claims["fewer collisions"].verdicts == {"plain": expected}
    assert claims["a channel less busy"].verdicts == {"plain": "not run"}
    assert len(result.claims) == len(found.claims)


def test_the_worst_density_is_named_by_its_ratio(found: PaperResult) -> None:
    rows = [paired("fewer"), paired("more", radio="sidelink", hybrid=3.0)]
    (claim,) = (row for row in with_traffic(found, rows).claims if row.name == "fewer collisions")
    assert claim.worst == "sidelink, 100/km, 20 cm: 1.50 times the baseline's"
    assert claim.figure == "dsrc: fewer 1; sidelink: more 1"


def test_one_trip_has_intervals_over_the_seeds(trips: list[Trajectory]) -> None:
    """Student-t limits of the mean of each seed's ratio; messages, which no seed changes, have none."""
    plan = replace(PLAN, seeds=3)
    rows = run_reading(trips[:1], PLAIN, plan)
    assert rows.messages[0].message_low is None
    row = rows.pooled(PLAIN)[0]
    ratios = []
    for seed in range(3):
        errors = {}
        for name, policy, basis in (("own", "mbc", None), ("rival", "baseline-periodic", "update")):
            kept = replace(plan.settings(PLAIN, (0.4,)), keep_samples="all")
            (block,) = (
                one
                for one in evaluate(trips[:1], kept).samples
                if (one.policy, one.rate_basis, one.threshold_m) == (policy, basis, 0.3)
            )
            errors[name] = np.sort(block.errors["tracking_error_m"][0, seed])
        place = int(np.ceil(0.9 * errors["own"].size)) - 1
        ratios.append(errors["own"][place] / errors["rival"][place])
    half = stats.t.ppf(0.975, 2) * np.std(ratios, ddof=1) / np.sqrt(3)
    assert (row.p90_low, row.p90_high) == pytest.approx(
        (np.mean(ratios) - half, np.mean(ratios) + half), rel=1e-5
    )


def test_a_radio_is_indifferent_where_the_same_is_sent_over_each(found: PaperResult) -> None:
    def radios(*rates_hz: float) -> tuple[str, str]:
        rows = [
            paired("fewer", radio=radio, hybrid=rate_hz, figure="message_rate_hz")
            for radio, rate_hz in zip(("dsrc", "sidelink"), rates_hz, strict=False)
        ]
        (row,) = (one for one in with_traffic(found, rows).claims if one.name == "any radio")
        return row.verdicts["plain"], row.figure

    assert radios(1.5, 1.5) == ("holds", "dsrc, sidelink: 0 % apart")
    assert radios(1.5, 1.53) == ("fails", "dsrc, sidelink: 2 % apart")
    assert radios(1.5) == ("not run", "no traffic was run")


def test_traffic_of_other_banks_says_nothing_of_the_papers(found: PaperResult) -> None:
    rows = [paired("fewer"), paired("more", bank="default")]
    (claim,) = (one for one in with_traffic(found, rows).claims if one.name == "fewer collisions")
    assert claim.verdicts["plain"] == "holds"


def test_a_quantile_over_nothing_is_no_estimate() -> None:
    assert verdict_of([Estimate(float("nan")), Estimate(0.5)]) == "holds"
    assert verdict_of([Estimate(float("nan"))]) == "not run"


def test_a_trip_that_stands_is_judged_without_a_warning() -> None:
    t_s = np.arange(0.0, 60.0, 0.1)
    parked = build_trajectory("parked/1", t_s, np.zeros((t_s.size, 2)))
    result = reproduce_paper([parked], replace(PLAN, thresholds_m=(0.5,)))
    verdicts = {row.name: row.verdicts["plain"] for row in result.claims}
    assert verdicts["more precise tracking"] == "not run"
    assert verdicts["the process follows manoeuvres"] == "not run"
