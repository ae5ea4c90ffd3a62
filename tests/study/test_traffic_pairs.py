"""Claims about the hybrid against the baseline in traffic: pairs by seed, intervals, verdicts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from made_rows import filled
from modelcast.study.network.densities import TrafficPlan, counted_verdicts
from modelcast.study.network.pairs import FIGURES, collision_rate_hz, traffic_rows, verdict_of
from modelcast.study.network.pool import gather
from modelcast.study.network.rows import (
    DISTANCES,
    OUTCOMES,
    RUNS,
    CaseResult,
    NetworkCase,
    NetworkResult,
)
from modelcast.study.table import Row, TableSchema


def made(kind: TableSchema, case: NetworkCase, value: float, **own: float) -> Row:
    """A row with the same number everywhere."""
    return filled(kind, value, **case.values(), **own)


def run_of(case: NetworkCase, value: float) -> CaseResult:
    return CaseResult(
        made(RUNS, case, value),
        [made(DISTANCES, case, 2.0 * value, low_m=0.0, high_m=25.0)],
        outcomes=[made(OUTCOMES, case, 0.5 * value, low_m=0.0, high_m=50.0)],
        seconds=[],
    )


def result(
    hybrid: list[float], baseline: list[float], threshold_m: float = 0.2, density: float = 25.0
) -> NetworkResult:
    cases = [
        (NetworkCase(density, "dsrc", policy, bank, run, threshold_m=threshold_m), value)
        for policy, bank, values in (("mbc", "paper", hybrid), ("baseline", "none", baseline))
        for run, value in enumerate(values)
        if np.isfinite(value)
    ]
    return gather([run_of(case, value) for case, value in cases])


def row_of(rows: list[Row], figure: str, *, by_range: bool = False) -> Row:
    (found,) = [row for row in rows if (row.figure, row.by_range) == (figure, by_range)]
    return found


def test_differences_are_within_seeds_so_what_seeds_share_cancels() -> None:
    """Seeds differ by far more than the policies, and the difference is shown all the same."""
    baseline = [0.1, 0.5, 0.9]
    row = row_of(traffic_rows(result([0.09, 0.48, 0.88], baseline)), "collision_ratio")
    assert row.difference == pytest.approx(-0.05 / 3)
    # Student's t at 97.5 % with 2 degrees of freedom, over the root of 3, times the deviation of the three.
    half = 4.302653 / 3**0.5 * float(np.std([-0.01, -0.02, -0.02], ddof=1))
    assert (row.difference_low, row.difference_high) == pytest.approx((-0.05 / 3 - half, -0.05 / 3 + half))
    assert row.verdict == "fewer"
    assert row.hybrid_high is not None
    assert row.baseline_low is not None
    assert row.hybrid_high > row.baseline_low
    assert row.seeds == 3


@given(st.lists(st.floats(0.0, 1.0), min_size=2, max_size=8), st.floats(-0.2, 0.2))
def test_a_constant_difference_is_a_verdict_whatever_the_seeds_are(values: list[float], by: float) -> None:
    other = [value + by for value in values]
    row = row_of(traffic_rows(result(other, values)), "busy_ratio")
    assert row.difference == pytest.approx(by, abs=1e-12)
    if abs(by) > 1e-9:
        assert row.verdict == ("fewer" if by < 0.0 else "more")


def test_exchanging_the_two_exchanges_the_verdict() -> None:
    one, other = [0.1, 0.2, 0.4], [0.2, 0.31, 0.5]
    there = row_of(traffic_rows(result(one, other)), "collision_ratio")
    back = row_of(traffic_rows(result(other, one)), "collision_ratio")
    assert (there.verdict, back.verdict) == ("fewer", "more")
    assert there.difference == pytest.approx(-back.difference)


def test_only_seeds_that_both_have_count() -> None:
    rows = traffic_rows(result([0.1, 0.2, 0.3], [0.2, np.nan, 0.4]))
    assert row_of(rows, "collision_ratio").seeds == 2
    assert row_of(rows, "collision_ratio").baseline == pytest.approx(0.3)


def test_one_seed_is_no_verdict_and_one_policy_no_row() -> None:
    row = row_of(traffic_rows(result([0.1], [0.2])), "collision_ratio")
    assert (row.verdict, row.difference_low, row.hybrid_low) == ("one seed", None, None)
    assert traffic_rows(result([0.1], [])) == []
    assert traffic_rows(result([], [0.1])) == []


def test_densities_of_their_own_and_thresholds_are_kept_apart() -> None:
    parts = [result([0.1], [0.2], threshold_m=0.2), result([0.3], [0.2], threshold_m=0.5)]
    parts.append(result([0.1], [0.2], density=np.nan))
    runs = [CaseResult(run, [], outcomes=[], seconds=[]) for part in parts for run in part.runs]
    rows = [row for row in traffic_rows(gather(runs)) if row.figure == "collision_ratio"]
    assert sorted((repr(row.density_per_km), row.threshold_m) for row in rows) == [
        ("25.0", 0.2),
        ("25.0", 0.5),
        ("nan", 0.2),
    ]


def test_every_figure_is_there_and_ranges_are_those_of_their_tables() -> None:
    rows = traffic_rows(result([0.1, 0.2], [0.2, 0.3]))
    assert [row.figure for row in rows if not row.by_range] == list(FIGURES)
    spans = {row.figure: (row.low_m, row.high_m, row.hybrid) for row in rows if row.by_range}
    assert spans["pte_p90_m"] == (0.0, 25.0, pytest.approx(0.3))
    assert spans["delivery_ratio"] == (0.0, 50.0, pytest.approx(0.075))
    # Of the radio's outcomes, hidden and concurrent frames together.
    assert spans["collision_ratio"] == (0.0, 50.0, pytest.approx(0.15))
    assert set(spans) == {
        "delivery_ratio",
        "collision_ratio",
        "held_ratio",
        "gap_p90_s",
        "pte_p90_m",
        "pte_p99_m",
    }


def test_collisions_a_second_count_frames_that_were_sent() -> None:
    case = NetworkCase(25.0, "dsrc", "mbc", "paper", 0, threshold_m=0.2)
    own = {"collision_ratio": 0.1, "message_rate_hz": 4.0, "expired_ratio": 0.25}
    assert collision_rate_hz(made(RUNS, case, 0.0, **own)) == pytest.approx(0.3)


def test_an_interval_that_touches_zero_shows_nothing() -> None:
    assert verdict_of(-1.0, 0.0) == verdict_of(0.0, 1.0) == "no difference shown"
    assert (verdict_of(-2.0, -1e-9), verdict_of(1e-9, 2.0)) == ("fewer", "more")


def test_verdicts_are_counted_by_radio() -> None:
    rows = traffic_rows(result([0.1, 0.2], [0.2, 0.3]))
    assert counted_verdicts(rows, "collision_ratio") == {"fewer": 1}
    assert counted_verdicts(rows, "collision_ratio", "sidelink") == {}


def test_the_plan_of_the_paper_is_what_the_issue_asks_for() -> None:
    plan = TrafficPlan()
    assert plan.runs == 2 * 2 * 4 * 7 * 10
    assert plan.expected_s(2) == pytest.approx(0.5 * plan.expected_s(1))
