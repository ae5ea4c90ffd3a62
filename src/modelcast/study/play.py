"""Drives one trip so that it can be played: three senders, without loss and with."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modelcast.core.arrays import BoolArray, IntArray
from modelcast.runtime.trip.replay import replay, schedules_of
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.station.policy.base import MessageKind
from modelcast.study.case import TripCase
from modelcast.study.loss_ratios import nearest_ratio
from modelcast.study.playback import Playback, PlayedRun
from modelcast.study.rules import FREE_RECEIVER, MODEL_SENDER
from modelcast.study.settings import EvaluationSettings
from modelcast.study.tracking import draw_losses

__all__ = ["draw_playback", "played_ratio"]


def played_ratio(settings: EvaluationSettings) -> float | None:
    """Return the evaluated loss ratio that is played: of those above 0 the one nearest to 0.4; None for none.

    Parameters
    ----------
    settings
        The loss ratios.

    Examples
    --------
    >>> played_ratio(EvaluationSettings(packet_error_ratios=(0.0, 0.2, 0.3)))
    0.3
    """
    return nearest_ratio([ratio for ratio in settings.packet_error_ratios if ratio > 0.0])


def draw_playback(
    case: TripCase,
    settings: EvaluationSettings,
    runtimes: tuple[TripRuntime, Sequence[TripRuntime], TripRuntime, TripRuntime | None],
    *,
    threshold_m: float,
    at_s: float,
) -> Playback:
    """Run the three senders over a trip, without loss and at the loss ratio of `played_ratio`.

    Parameters
    ----------
    case, settings
        The trip and what was asked for.
    runtimes
        The evaluated bank's on a channel without loss and, once for all loss ratios or once for each, with
        loss; the baseline's; and the free receiver's, where it is run.
    threshold_m
        The threshold that all keep [m].
    at_s
        Time of the manoeuvre [s].
    """
    clean, each, baseline, free = runtimes
    ratio = played_ratio(settings)
    lossless: BoolArray = np.zeros(len(case.truth), dtype=np.bool_)
    channels = [(0.0, clean, lossless)]
    if ratio is not None:
        lossy = each[0] if len(each) == 1 else each[settings.packet_error_ratios.index(ratio)]
        drawn = draw_losses(case, replace(settings, packet_error_ratios=(ratio,), seeds=1))
        channels.append((ratio, lossy, drawn[0, 0]))
    runs: list[PlayedRun] = []
    for share, own, lost in channels:
        played = [(MODEL_SENDER, own, own.run(settings.under_loss(threshold_m, share)))]
        if free is not None:
            played.append((FREE_RECEIVER, free, free.run(settings.of_free.under_loss(threshold_m, share))))
        kept = baseline.run(settings.policy(threshold_m, keep_alive=True))
        played.append(("baseline", baseline, kept))
        runs += [
            _played(case, settings, (sender, share), runtime=runtime, walk=walk, lost=lost)
            for sender, runtime, walk in played
        ]
    return Playback(
        case.truth.trip_id,
        threshold_m,
        at_s=at_s,
        t_s=case.truth.t_s,
        truth_m=case.truth.position_m,
        parts=case.truth.segments[1:-1],
        runs=tuple(runs),
    )


def _played(
    case: TripCase,
    settings: EvaluationSettings,
    whose: tuple[str, float],
    *,
    runtime: TripRuntime,
    walk: TripMessages,
    lost: BoolArray,
) -> PlayedRun:
    """What the receiver of one walk believes, given what is lost."""
    replayed = replay(
        runtime,
        schedules_of([walk]),
        lost[None],
        case.truth.position_m,
        case.direction,
        delay_s=settings.delay_s,
        expiry_s=np.inf if settings.expiry_s is None else settings.expiry_s,
        motions=True,
    )
    sender, ratio = whose
    sent: IntArray = np.flatnonzero(walk.kind != MessageKind.NOTHING)
    return PlayedRun(
        sender,
        tuple(member.name for member in runtime.bank.members),
        packet_error_ratio=ratio,
        believed_m=replayed.motions[0, :, :2].copy(),
        sent=sent,
        kind=walk.kind[sent],
        in_use=walk.in_use[sent],
        lost=lost[sent],
    )
