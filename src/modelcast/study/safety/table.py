"""Scores of single recordings pooled: shares, delays, and ratios to a rival with their intervals."""

from collections.abc import Sequence

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.chance import child_generator
from modelcast.study.compare.bootstrap import Limits, limits, resample_weights
from modelcast.study.safety.result import POOLED_SAFETY, ConditionScores, RecordingScores, SafetyKind
from modelcast.study.safety.rules import BASES
from modelcast.study.table import Row, Table

__all__ = ["delay_quantiles", "pooled_rows", "share_of"]

_HOUR_S = 3600.0
_DELAYS = (0.5, 0.9, 0.99)


def pooled_rows(recordings: Sequence[RecordingScores], against: str, *, resamples: int, seed: int) -> Table:
    """Table of `POOLED_SAFETY` over all recordings, by sensor, kind of loss, loss ratio, basis and candidate.

    Parameters
    ----------
    recordings
        Of every sensor and kind of loss the same recordings, with the same conditions.
    against
        Candidate that the ratios are taken to.
    resamples, seed
        Of the bootstrap.
    """
    groups: dict[SafetyKind, list[RecordingScores]] = {}
    for one in recordings:
        groups.setdefault(one.kind, []).append(one)
    rows: list[Row] = []
    for own in groups.values():
        rows += _group_rows(own, against, resamples, seed)
    return POOLED_SAFETY.table(rows)


def _joined(own: Sequence[RecordingScores], key: tuple[object, ...], name: str) -> FloatArray:
    """One of the arrays of a condition over all recordings."""
    return np.concatenate([getattr(_of(one, key), name) for one in own])


def _of(recording: RecordingScores, key: tuple[object, ...]) -> ConditionScores:
    for one in recording.conditions:
        if (one.candidate, one.basis, one.packet_error_ratio) == key:
            return one
    raise ValueError(f"{recording.name} has no scores of {key}: score all recordings by the same settings")


def _group_rows(own: Sequence[RecordingScores], against: str, resamples: int, seed: int) -> list[Row]:
    positives = np.concatenate([one.positives for one in own])
    negatives = np.concatenate([one.negatives for one in own])
    duration_s = np.concatenate([one.duration_s for one in own])
    leaders_s = sum(one.leaders_s for one in own)
    first = own[0].conditions[0]
    rng = child_generator(seed, "safety bootstrap")
    events, pairs = positives.size, negatives.size
    runs = first.missed.shape[1]
    each_event = np.arange(events, dtype=np.int64)
    each_pair = np.arange(pairs, dtype=np.int64)
    of_events = resample_weights(each_event, resamples, rng) if events else np.zeros((resamples, 0))
    of_pairs = resample_weights(each_pair, resamples, rng)
    of_runs = resample_weights(np.arange(runs, dtype=np.int64), resamples, rng)

    def over(mine: FloatArray, rival: FloatArray, weights: FloatArray) -> tuple[float, Limits]:
        """Ratio of sums, and its interval over rows and runs."""
        drawn = [np.einsum("br,rk,bk->b", weights, values, of_runs) for values in (mine, rival)]
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = float(np.float64(mine.sum()) / np.float64(rival.sum()))
            return ratio, limits(drawn[0] / drawn[1], np.arange(weights.shape[1], dtype=np.int64))

    rows: list[Row] = []
    # A loss ratio and basis after the other, so that senders stand side by side.
    order = sorted(own[0].conditions, key=lambda one: (one.packet_error_ratio, BASES.index(one.basis)))
    for condition in order:
        key = (condition.candidate, condition.basis, condition.packet_error_ratio)
        rival = (against, *key[1:])
        missed, false = _joined(own, key, "missed"), _joined(own, key, "false")
        delay_s = _joined(own, key, "delay_s")
        spends = [_of(one, key).spend for one in own]
        missed_over, missed_limits = over(missed, _joined(own, rival, "missed"), of_events)
        false_over, false_limits = over(false, _joined(own, rival, "false"), of_pairs)
        p50_s, p90_s, p99_s = delay_quantiles(delay_s)
        rows.append(
            POOLED_SAFETY.row(
                **own[0].kind._asdict(),
                packet_error_ratio=condition.packet_error_ratio,
                basis=condition.basis,
                candidate=condition.candidate,
                threshold_m=float(np.median([m for spend in spends for m in spend.thresholds_m])),
                message_rate_hz=sum(spend.messages for spend in spends) / leaders_s,
                airtime_ratio=sum(spend.airtime_s for spend in spends) / leaders_s,
                missed_ratio=share_of(missed.sum(), positives.sum() * runs),
                false_ratio=share_of(false.sum(), negatives.sum() * runs),
                missed_events=share_of(int(np.isinf(delay_s).sum()), delay_s.size),
                false_per_hour=share_of(
                    _joined(own, key, "false_warnings").sum() * _HOUR_S, duration_s.sum() * runs
                ),
                delay_p50_s=p50_s,
                delay_p90_s=p90_s,
                delay_p99_s=p99_s,
                missed_over=missed_over,
                false_over=false_over,
                missed_over_low=missed_limits[0],
                missed_over_high=missed_limits[1],
                false_over_low=false_limits[0],
                false_over_high=false_limits[1],
            )
        )
    return rows


def delay_quantiles(delay_s: FloatArray) -> list[float]:
    """Quantiles of all delays, those missed as infinite; NaN where there was nothing to warn of.

    Parameters
    ----------
    delay_s
        One a warning and run, of any shape [s].

    Returns
    -------
    list of float
        At 50, 90 and 99 % [s].
    """
    if delay_s.size == 0:
        return [float("nan")] * len(_DELAYS)
    return np.quantile(delay_s, _DELAYS, method="higher").tolist()


def share_of(part: float, whole: float) -> float:
    """Part over whole; NaN where there is no whole."""
    return float(part) / float(whole) if whole else float("nan")
