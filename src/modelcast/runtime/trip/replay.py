"""What a host believed over a trip, given what its sender sent and what was lost."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray, owned
from modelcast.messages.bsm_fields import CORE_FIELDS, CORE_INDEX
from modelcast.models.point_kernels import ACCELERATION, VELOCITY_EAST, VELOCITY_NORTH, YAW_RATE
from modelcast.runtime.trip import believed_kernels
from modelcast.runtime.trip.believed_kernels import Schedules, SentTrip
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.station.receiver.belief_kernels import BELIEF_COLUMNS
from modelcast.station.receiver.reading import goes_straight

__all__ = ["Replayed", "replay", "schedules_of", "sent_trip"]


@dataclass(frozen=True, slots=True, eq=False)
class Replayed:
    """R runs over one trip of T samples; NaN where the host holds nothing.

    Parameters
    ----------
    errors
        Tracking error after and before the instant's message, its parts along and across the track [m], and
        the age of the model held [s], (5, R, T).
    gaps_s
        Gaps between receptions, an array a run [s].
    motions
        How the sender is believed to move, columns as `modelcast.station.receiver.belief_kernels` has them,
        (R, T, BELIEF_COLUMNS); no rows where they were not asked for.
    """

    errors: FloatArray
    gaps_s: tuple[FloatArray, ...]
    motions: FloatArray


def schedules_of(walks: Sequence[TripMessages]) -> Schedules:
    """What several policies sent over one trip, as the replay takes it.

    Parameters
    ----------
    walks
        S of them.
    """
    return Schedules(
        np.stack([walk.kind for walk in walks]),
        np.stack([walk.in_use for walk in walks]),
        np.stack([walk.update_index for walk in walks]),
    )


def sent_trip(ready: TripRuntime, truth_m: FloatArray, direction: FloatArray) -> SentTrip:
    """What the messages of a trip say, and what was true.

    Parameters
    ----------
    ready
        The sender, its fits made.
    truth_m
        True places, (T, 2) [m].
    direction
        Unit vectors of the true course, (T, 2).
    """
    return SentTrip(
        ready.trip.t_s,
        ready.stated_s,
        ready.stated_m,
        ready.parameters,
        truth_m,
        direction,
        _told(ready.samples),
        np.array(goes_straight(ready.bank), dtype=np.bool_),
    )


def replay(
    ready: TripRuntime,
    sent: Schedules,
    lost: BoolArray,
    truth_m: FloatArray,
    direction: FloatArray,
    *,
    delay_s: float = 0.0,
    expiry_s: float = np.inf,
    motions: bool = False,
) -> Replayed:
    """Replay R runs over one trip; run r follows schedule r modulo S.

    Parameters
    ----------
    ready
        The sender.
    sent
        S schedules of its messages.
    lost
        Which instants' messages never arrive, (R, T).
    truth_m, direction
        As for `sent_trip`.
    delay_s
        From an instant to the arrival of its message [s].
    expiry_s
        Silence after which the host drops the sender [s].
    motions
        Whether to find how it is believed to move, too.
    """
    runs, count = lost.shape
    errors, gaps_s = np.empty((5, runs, count)), np.empty((runs, count))
    gap_count: IntArray = np.zeros((runs,), dtype=np.int64)
    moves = np.empty((runs if motions else 0, count, BELIEF_COLUMNS))
    believed_kernels.replay(
        ready.own.ready.members,
        sent_trip(ready, truth_m, direction),
        sent,
        owned(lost, np.bool_),
        delay_s,
        expiry_s,
        errors,
        gaps_s,
        gap_count,
        moves,
    )
    gaps = tuple(row[:written].copy() for row, written in zip(gaps_s, gap_count, strict=True))
    return Replayed(errors, gaps, moves)


def _told(samples: FloatArray) -> FloatArray:
    """Speed, heading, acceleration and yaw rate of samples in the steps of Part I, (T, 4)."""
    east, north = samples[:, VELOCITY_EAST], samples[:, VELOCITY_NORTH]
    found = np.column_stack(
        (np.hypot(east, north), np.arctan2(east, north), samples[:, ACCELERATION], samples[:, YAW_RATE])
    )
    names = ("speed_mps", "heading_rad", "acceleration_forward_mps2", "yaw_rate_radps")
    steps = np.array([CORE_FIELDS[CORE_INDEX[name]].resolution for name in names])
    return np.round(found / steps) * steps
