"""Compiled replay of what a host believed over a trip, given what was sent and what was lost."""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    BoolMatrix,
    BoolVector,
    FloatCube,
    FloatMatrix,
    FloatVector,
    IntMatrix,
    IntVector,
)
from modelcast.models.member_kernels import Members, absorb_member, predict_member
from modelcast.station.policy.error_driven_kernels import IDENTIFICATION, NOTHING
from modelcast.station.receiver.reading_kernels import coast_by_member, state_rates
from modelcast.station.receiver.track_kernels import (
    ACCEPTED,
    HELD_CONTENT,
    HELD_FIT_S,
    HELD_MEMBER,
    TRACK_COLUMNS,
    forget,
    is_live,
    take_identification,
    take_update,
)

__all__ = ["Schedules", "SentTrip", "replay"]

_TIME_SLACK_S = 1e-9


class SentTrip(NamedTuple):
    """What was sent over a trip of T samples, and what was true.

    ``t_s`` (T,); ``stated_s`` (T,) and ``stated_m`` (T, 2) as messages state them; ``parameters`` (T, P);
    ``truth_m`` (T, 2) and unit vectors of the true course ``direction`` (T, 2). ``told`` (T, 4) are speed,
    heading, acceleration and yaw rate as messages state them, ``coasts`` (M,) says which members predict a
    constant velocity: both matter to motions alone.
    """

    t_s: FloatVector
    stated_s: FloatVector
    stated_m: FloatMatrix
    parameters: FloatMatrix
    truth_m: FloatMatrix
    direction: FloatMatrix
    told: FloatMatrix
    coasts: BoolVector


class Schedules(NamedTuple):
    """S schedules of messages: ``kind``, ``in_use`` and ``update_index`` at each sample, (S, T)."""

    kind: IntMatrix
    in_use: IntMatrix
    update_index: IntMatrix


@kernel(inlined=True)
def _off(
    members: Members, x: SentTrip, held: FloatVector, grown: FloatVector, j: int, out: FloatVector
) -> None:
    """How far the host's belief is off at a sample, east and north into ``out`` (2,)."""
    at, member = int(held[HELD_CONTENT]), int(held[HELD_MEMBER])
    own = grown[members.offsets[member] : members.offsets[member + 1]]
    predict_member(members, member, own, x.t_s[j] - held[HELD_FIT_S], out)
    out[0] = x.stated_m[at, 0] + out[0] - x.truth_m[j, 0]
    out[1] = x.stated_m[at, 1] + out[1] - x.truth_m[j, 1]


@kernel(inlined=True)
def _absorb(
    members: Members, x: SentTrip, last: int, member: int, i: int, moved: FloatVector, grown: FloatVector
) -> None:
    """Take the update of sample ``i`` by ``member`` for what is held, ``grown`` (P,).

    ``last`` is the sample of the update held before, where that member was in use, else -1. ``moved`` (3,)
    is overwritten.
    """
    at = max(last, 0)
    moved[0] = x.stated_s[i] - x.stated_s[at]
    moved[1], moved[2] = x.stated_m[i, 0] - x.stated_m[at, 0], x.stated_m[i, 1] - x.stated_m[at, 1]
    offsets = members.offsets
    for m in range(offsets.size - 1):
        own = x.parameters[i, offsets[m] : offsets[m + 1]]
        held = grown[offsets[m] : offsets[m + 1]]
        absorb_member(members, m, own, moved, last >= 0 and m == member, held)


@kernel
def _move(
    members: Members,
    x: SentTrip,
    held: FloatVector,
    grown: FloatVector,
    j: int,
    out: FloatVector,
) -> None:
    """How the host believes the sender to move at a sample, into ``out`` (BELIEF_COLUMNS,)."""
    at, member = int(held[HELD_CONTENT]), int(held[HELD_MEMBER])
    own = grown[members.offsets[member] : members.offsets[member + 1]]
    coast_by_member(members, member, own, x.t_s[j] - held[HELD_FIT_S], x.told[at, 1], out)
    out[0] += x.stated_m[at, 0]
    out[1] += x.stated_m[at, 1]
    if x.coasts[member]:
        state_rates(x.told[at], out)


@kernel
def replay(
    members: Members,
    x: SentTrip,
    sent: Schedules,
    lost: BoolMatrix,
    delay_s: float,
    expiry_s: float,
    errors: FloatCube,
    gaps_s: FloatMatrix,
    gap_count: IntVector,
    motions: FloatCube,
) -> None:
    """Replay R runs over one trip; run r follows schedule r modulo S.

    ``lost`` (R, T) says which instants' messages never arrive. Writes ``errors`` (5, R, T): the tracking
    error after and before the instant's message, its parts along and across the track, and the age of the
    model held, all NaN where the host holds nothing. ``gaps_s`` (R, T) receives the gaps between receptions
    of each run and ``gap_count`` (R,) their number; ``motions`` (R, T, BELIEF_COLUMNS) how the sender is
    believed to move, unless it has no rows.
    """
    off, held, moved = np.empty(2), np.empty(TRACK_COLUMNS), np.empty(3)
    grown = np.empty(x.parameters.shape[1])
    for run in range(lost.shape[0]):
        schedule = run % sent.kind.shape[0]
        forget(held)
        heard_s, arriving, written = -np.inf, 0, 0
        for j in range(lost.shape[1]):
            first_arrival, before, touched = arriving, np.nan, False
            while arriving <= j and x.t_s[arriving] + delay_s <= x.t_s[j] + _TIME_SLACK_S:
                arriving += 1
            for i in range(first_arrival, arriving):
                if sent.kind[schedule, i] == NOTHING or lost[run, i]:
                    continue
                if not touched and is_live(held, x.t_s[j], expiry_s):
                    _off(members, x, held, grown, j, off)
                    before = np.sqrt(off[0] * off[0] + off[1] * off[1])
                touched = True
                arrival_s, member = x.t_s[i] + delay_s, sent.in_use[schedule, i]
                if heard_s > -np.inf:
                    gaps_s[run, written] = arrival_s - heard_s
                    written += 1
                heard_s = arrival_s
                if sent.kind[schedule, i] == IDENTIFICATION:
                    _ = take_identification(
                        held, sent.update_index[schedule, i], member, x.t_s[i], arrival_s, expiry_s
                    )
                else:
                    continues = is_live(held, arrival_s, expiry_s) and held[HELD_MEMBER] == member
                    last = int(held[HELD_CONTENT]) if continues else -1
                    if take_update(held, i, member, x.stated_s[i], arrival_s, expiry_s) == ACCEPTED:
                        _absorb(members, x, last, member, i, moved, grown)
            if not is_live(held, x.t_s[j], expiry_s):
                errors[:, run, j] = np.nan
                if motions.shape[0] > 0:
                    motions[run, j, :] = np.nan
                continue
            _off(members, x, held, grown, j, off)
            after = np.sqrt(off[0] * off[0] + off[1] * off[1])
            errors[0, run, j] = after
            errors[1, run, j] = before if touched else after
            errors[2, run, j] = off[0] * x.direction[j, 0] + off[1] * x.direction[j, 1]
            errors[3, run, j] = off[1] * x.direction[j, 0] - off[0] * x.direction[j, 1]
            errors[4, run, j] = x.t_s[j] - held[HELD_FIT_S]
            if motions.shape[0] > 0:
                _move(members, x, held, grown, j, motions[run, j])
        gap_count[run] = written
