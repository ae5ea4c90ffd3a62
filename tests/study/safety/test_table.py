"""Scores pooled: shares, ratios and their intervals, from counts made by hand."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.study.safety.result import ConditionScores, PairNames, RecordingScores, SenderSpend
from modelcast.study.safety.table import pooled_rows


def made(name: str, missed: dict[str, list[list[int]]], *, events: int = 3) -> RecordingScores:
    """One pair with a few warnings of ten instants each, in two runs."""
    return RecordingScores(
        name, "default", None,
        pairs=[PairNames("a", "b", 1.0)],
        counted=np.array([200]), negatives=np.array([200 - 10 * events]),
        duration_s=np.array([3600.0]), leaders_s=3600.0,
        event_pair=np.zeros(events, dtype=np.int64), event_s=np.arange(events, dtype=np.float64) * 60.0,
        positives=np.full(events, 10),
        conditions=[
            ConditionScores(
                candidate, "airtime", 0.4,
                spend=SenderSpend(720, 1.8, (0.2,)),
                missed=np.array(counts),
                delay_s=np.where(np.array(counts) == 10, np.inf, 0.1 * np.array(counts)),
                false=np.array([[5, 7]]), false_warnings=np.array([[1, 3]]),
            )
            for candidate, counts in missed.items()
        ],
    )  # fmt: skip


def test_shares_delays_and_ratios_of_two_recordings() -> None:
    first = made("one", {"cv": [[4, 6], [10, 10], [2, 0]], "mbc": [[2, 3], [5, 5], [1, 0]]})
    second = made("two", {"cv": [[8, 8], [0, 0], [10, 10]], "mbc": [[4, 4], [0, 0], [5, 5]]})
    cv, mbc = pooled_rows([first, second], "cv", resamples=200, seed=1)
    assert cv.missed_ratio == pytest.approx(68 / 120)
    assert mbc.missed_over == pytest.approx(0.5)
    # Every warning halves, so every resample does.
    assert (mbc.missed_over_low, mbc.missed_over_high) == pytest.approx((0.5, 0.5))
    assert (cv.missed_over_low, cv.missed_over_high) == (1.0, 1.0)
    assert cv.missed_events == pytest.approx(4 / 12)
    assert (cv.delay_p50_s, cv.delay_p90_s) == (pytest.approx(0.8), np.inf)
    assert cv.false_ratio == pytest.approx(24 / (2 * 2 * 170))
    assert cv.false_per_hour == pytest.approx(2.0)
    assert cv.message_rate_hz == pytest.approx(0.2)
    assert cv.airtime_ratio == pytest.approx(0.0005)


def test_intervals_are_of_warnings_and_runs() -> None:
    noisy = made("one", {"cv": [[10, 10], [10, 10], [10, 10]], "mbc": [[0, 0], [10, 10], [5, 5]]})
    _, mbc = pooled_rows([noisy], "cv", resamples=2000, seed=2)
    low, high = mbc.missed_over_low, mbc.missed_over_high
    assert low is not None
    assert high is not None
    assert low == pytest.approx(0.0, abs=0.2)
    assert high == pytest.approx(1.0, abs=0.2)


def test_one_warning_has_no_interval_and_none_has_no_share() -> None:
    (row,) = pooled_rows([made("one", {"cv": [[4, 6]]}, events=1)], "cv", resamples=50, seed=0)
    assert (row.missed_over_low, row.missed_over_high) == (None, None)
    none = made("one", {"cv": np.empty((0, 2), dtype=np.int64).tolist()}, events=0)
    none = replace(
        none,
        conditions=[
            ConditionScores(
                "cv", "airtime", 0.4, spend=SenderSpend(1, 0.1, (0.2,)),
                missed=np.empty((0, 2), dtype=np.int64), delay_s=np.empty((0, 2)),
                false=np.array([[0, 0]]), false_warnings=np.array([[0, 0]]),
            )
        ],
    )  # fmt: skip
    (row,) = pooled_rows([none], "cv", resamples=50, seed=0)
    assert np.isnan(row.missed_ratio)
    assert np.isnan(row.delay_p50_s)
    assert np.isnan(row.missed_over)


def test_recordings_of_other_conditions_are_refused() -> None:
    one = made("one", {"cv": [[4, 6], [1, 1], [2, 0]], "mbc": [[4, 6], [1, 1], [2, 0]]})
    two = made("two", {"cv": [[4, 6], [1, 1], [2, 0]]})
    with pytest.raises(ValueError, match="two has no scores"):
        pooled_rows([one, two], "cv", resamples=10, seed=0)
