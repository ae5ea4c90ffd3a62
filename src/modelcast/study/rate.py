"""Message rates on an ideal channel, without keep-alive: the paper's first figure."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import fsum

import numpy as np

from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.study.case import TripCase
from modelcast.study.result import POOLED, RATES
from modelcast.study.rules import FREE_RECEIVER
from modelcast.study.sent import sent_load
from modelcast.study.settings import EvaluationSettings
from modelcast.study.table import Row

__all__ = ["RateCount", "count_free", "count_rates", "pooled_rates", "rate_row"]


@dataclass(frozen=True, slots=True)
class RateCount:
    """Messages of one walk.

    Parameters
    ----------
    policy, bank, threshold_m
        Whose messages.
    updates, identifications, moving_messages
        How many, and how many of all were sent while moving.
    duration_s, moving_s
        Time observed and time moving [s].
    message_bytes
        Application bytes sent.
    airtime_s
        How long they occupy the channel [s].
    """

    policy: str
    bank: str
    threshold_m: float
    updates: int
    identifications: int
    moving_messages: int
    duration_s: float
    moving_s: float
    message_bytes: int
    airtime_s: float


def count_rates(
    case: TripCase, mbc: TripRuntime, baseline: TripRuntime, settings: EvaluationSettings
) -> list[tuple[RateCount, TripMessages]]:
    """TripMessages both policies at every threshold and count their messages.

    Parameters
    ----------
    case
        The trip.
    mbc, baseline
        Both banks, ready for what the sender sees.
    settings
        Thresholds, rules and sizes.
    """
    counts: list[tuple[RateCount, TripMessages]] = []
    policies = [settings.policy(threshold_m, keep_alive=False) for threshold_m in settings.thresholds_m]
    for walks in zip(mbc.run_each(policies), baseline.run_each(policies), strict=True):
        for name, ready, walk in zip((settings.sender, "baseline"), (mbc, baseline), walks, strict=True):
            counts.append((_counted(case, name, ready, walk, settings), walk))
    return counts


def count_free(
    case: TripCase, free: TripRuntime, settings: EvaluationSettings
) -> list[tuple[RateCount, TripMessages]]:
    """Count the messages of the free receiver's sender at every threshold.

    Parameters
    ----------
    case
        The trip.
    free
        Its bank, ready for what the sender sees.
    settings
        Thresholds, and sizes.
    """
    own = settings.of_free
    walks = free.run_each([own.policy(threshold_m, keep_alive=False) for threshold_m in own.thresholds_m])
    return [(_counted(case, FREE_RECEIVER, free, walk, own), walk) for walk in walks]


def _counted(
    case: TripCase, name: str, ready: TripRuntime, walk: TripMessages, settings: EvaluationSettings
) -> RateCount:
    sent = sent_load(walk, ready.bank, case.truth.t_s, settings)
    return RateCount(
        name,
        ready.bank.name,
        walk.policy.threshold_m,
        walk.updates,
        walk.identifications,
        int((walk.transmits & ~case.standing).sum()),
        case.truth.duration_s,
        float(np.count_nonzero(~case.standing) * case.truth.dt_s),
        int(sent.size_bytes.sum()),
        float(sent.airtime_s.sum()),
    )


def rate_row(trip: str, count: RateCount) -> Row:
    """The table row of one count."""
    total = count.updates + count.identifications
    moving_s = count.moving_s
    return RATES.row(
        trip=trip,
        policy=count.policy,
        bank=count.bank,
        threshold_m=count.threshold_m,
        updates=count.updates,
        identifications=count.identifications,
        duration_s=count.duration_s,
        update_rate_hz=count.updates / count.duration_s,
        identification_rate_hz=count.identifications / count.duration_s,
        total_rate_hz=total / count.duration_s,
        moving_total_rate_hz=count.moving_messages / moving_s if moving_s > 0 else 0.0,
        bytes_per_s=count.message_bytes / count.duration_s,
        airtime_per_s=count.airtime_s / count.duration_s,
    )


def pooled_rates(counts: Iterable[RateCount]) -> list[Row]:
    """Rows that pool the same policy and threshold over trips: sums of messages over sums of time.

    The sums of times are exact before they are rounded once, so the order of the trips does not matter.
    """
    groups: dict[tuple[str, str, float], list[RateCount]] = {}
    for count in counts:
        groups.setdefault((count.policy, count.bank, count.threshold_m), []).append(count)
    return [
        rate_row(
            POOLED,
            RateCount(
                *key,
                sum(count.updates for count in group),
                sum(count.identifications for count in group),
                sum(count.moving_messages for count in group),
                fsum(count.duration_s for count in group),
                fsum(count.moving_s for count in group),
                sum(count.message_bytes for count in group),
                fsum(count.airtime_s for count in group),
            ),
        )
        for key, group in groups.items()
    ]
