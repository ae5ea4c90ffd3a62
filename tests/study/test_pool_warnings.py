"""Claims about warnings of fleets pooled over seeds."""

from math import inf, isnan, nan

import numpy as np
import pytest

from made_rows import filled
from modelcast.station.receiver.reading import Reading
from modelcast.study.network.pool_warnings import pool_warnings
from modelcast.study.network.rows import RUNS, CaseResult, NetworkCase
from modelcast.study.network.warned import measure_warnings
from modelcast.study.safety.fleet_result import PairingScores
from modelcast.study.table import Row


def a_run(policy: str, number: int = 0, threshold_m: float = nan) -> CaseResult:
    case = NetworkCase(50.0, "dsrc", policy, "none", number, threshold_m=threshold_m)
    return CaseResult(filled(RUNS, 2.0, **case.values()), (), outcomes=(), seconds=())


def scored(
    missed: list[int], false: list[int], *, group: int = 0, reading: Reading = Reading.MODEL, first: int = 0
) -> PairingScores:
    """True warnings of ten instants each, and hosts of twenty others each; those wholly missed never came."""
    events, hosts = np.arange(first, first + len(missed)), np.arange(len(false))
    return PairingScores(
        "fcw",
        group,
        reading,
        host_s=3600.0 * len(false),
        counted=20 * len(false) + 10 * len(missed),
        host=hosts,
        negatives=np.full(hosts.size, 20),
        false=np.array(false, dtype=np.int64),
        false_warnings=np.minimum(np.array(false, dtype=np.int64), 1),
        event_host=events,
        event_remote=events + 100,
        event_s=events * 0.1,
        positives=np.full(events.size, 10),
        missed=np.array(missed, dtype=np.int64),
        delay_s=np.array([inf if one == 10 else 0.1 * one for one in missed]),
    )


def warned(run: CaseResult, *scores: PairingScores, senders: tuple[str, ...] = ()) -> CaseResult:
    return measure_warnings(run, scores, senders or (run.run.policy,))


def only(rows: list[Row], **wanted: object) -> Row:
    (found,) = [row for row in rows if all(getattr(row, name) == value for name, value in wanted.items())]
    return found


def test_shares_delays_and_false_ones_an_hour_are_those_of_all_seeds_together():
    runs = [
        warned(a_run("mbc", 0), scored([0, 5], [2, 0])),
        warned(a_run("mbc", 1), scored([10, 1], [0, 0])),
    ]
    (row,) = pool_warnings(runs)
    assert (row.seeds, row.events, row.positives, row.negatives) == (2, 4, 40, 80)
    assert row.missed_ratio == 16 / 40
    assert row.false_ratio == 2 / 80
    assert row.never_ratio == 1 / 4
    assert row.false_per_hour == 1 / 4
    assert (row.delay_p50_s, row.delay_p90_s) == (pytest.approx(0.5), inf)
    assert isnan(row.missed_over)


def test_ratios_are_those_to_the_rival_at_the_same_warnings():
    runs = [
        warned(a_run("baseline"), scored([4, 6, 2], [4, 4])),
        warned(a_run("mbc"), scored([2, 3, 1], [6, 6])),
    ]
    rows = pool_warnings(runs, "baseline")
    mine = only(rows, policy="mbc")
    assert (mine.missed_over, mine.false_over) == (0.5, 1.5)
    # Each warning is missed half as often, whichever are drawn.
    assert (mine.missed_over_low, mine.missed_over_high) == (0.5, 0.5)
    assert only(rows, policy="baseline").missed_over == 1.0
    assert all(isnan(row.missed_over) for row in pool_warnings(runs))


def test_who_met_other_warnings_is_held_against_nobody():
    runs = [
        warned(a_run("baseline"), scored([4, 6, 2], [4])),
        warned(a_run("mbc"), scored([2, 3, 1], [6], first=1)),
    ]
    assert isnan(only(pool_warnings(runs, "baseline"), policy="mbc").missed_over)


def test_the_rival_has_the_same_threshold_where_there_is_one():
    runs = [
        warned(a_run("baseline", threshold_m=0.2), scored([2, 2], [1])),
        warned(a_run("baseline", threshold_m=0.5), scored([8, 8], [1])),
        warned(a_run("mbc", threshold_m=0.5), scored([4, 4], [1])),
        warned(a_run("cam"), scored([4, 4], [1])),
    ]
    rows = pool_warnings(runs, "baseline")
    assert only(rows, policy="mbc").missed_over == 0.5
    assert only(rows, policy="cam").missed_over == 2.0


def test_a_mixed_fleet_is_held_against_legacy_readers_of_the_rival_and_has_a_row_over_all_senders():
    readings = (Reading.LEGACY, Reading.MODEL)

    def mixed(share: int, legacy: int, model: int) -> CaseResult:
        senders = ("baseline", "mbc")
        found = [
            scored([missed] * 2, [group, 1], group=group, reading=reading, first=10 * group)
            for reading, missed in zip(readings, (legacy, model), strict=True)
            for group in (0, 1)
        ]
        return warned(a_run(f"baseline+mbc@{share}"), *found, senders=senders)

    rows = pool_warnings([mixed(0, 4, 4), mixed(50, 6, 2)], "baseline+mbc@0")
    whole = only(rows, policy="baseline+mbc@50", sender="all", reading="model")
    assert (whole.events, whole.missed_ratio, whole.missed_over) == (4, 0.2, 0.5)
    # Of the two hosts the first has one false instant of the second sender's remotes, the other one of both.
    assert whole.false_ratio == 3 / 80
    assert whole.false_per_hour == 3 / 2
    assert only(rows, policy="baseline+mbc@50", sender="all", reading="legacy").missed_over == 1.5
    part = only(rows, policy="baseline+mbc@50", sender="mbc", reading="model")
    assert part.events == 2
    assert isnan(part.missed_over)


def test_intervals_hold_the_share_and_narrow_with_more_warnings():
    rng = np.random.default_rng(3)
    widths: list[float] = []
    for count in (20, 500):
        missed = rng.integers(0, 11, size=count).tolist()
        row = pool_warnings([warned(a_run("mbc"), scored(missed, [1, 2, 3]))])[0]
        assert row.missed_low is not None
        assert row.missed_high is not None
        assert row.missed_low < row.missed_ratio < row.missed_high
        widths.append(row.missed_high - row.missed_low)
    assert widths[1] < 0.4 * widths[0]


def test_seeds_that_differ_widen_the_interval():
    """Two seeds, of which one misses all: drawing runs must show that the two are what there is."""
    alike = [warned(a_run("mbc", number), scored([0, 10] * 50, [1])) for number in (0, 1)]
    apart = [warned(a_run("mbc", number), scored([10 * number] * 100, [1])) for number in (0, 1)]
    one, other = (pool_warnings(runs)[0] for runs in (alike, apart))
    assert one.missed_ratio == other.missed_ratio == 0.5
    assert (other.missed_low, other.missed_high) == (0.0, 1.0)
    assert one.missed_low is not None
    assert one.missed_low > 0.3


def test_a_fleet_without_applications_has_no_row():
    assert pool_warnings([a_run("mbc")], "mbc") == []


def test_a_delay_without_end_is_no_number_in_rows():
    (run,) = [warned(a_run("mbc"), scored([10, 3], [0]))]
    assert [isnan(row.delay_s) for row in run.warned_events] == [True, False]
    assert run.warnings[0].never == 1
    assert run.warnings[0].replaced(never=0) != run.warnings[0]
