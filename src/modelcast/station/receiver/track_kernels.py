"""Compiled rules of one track: what a host makes of the messages of one remote, whoever the host is.

Trip runtime, fleet runtime and local dynamic map follow these rules. A track is a row ``held``
(`TRACK_COLUMNS`,); a message is *content*, a number that its caller gives it: two messages of one remote that
its host may hold at one time have two numbers, from 0 on. All times are finite.
"""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector

__all__ = [
    "ACCEPTED",
    "HELD_CONTENT",
    "HELD_FIT_S",
    "HELD_MEMBER",
    "HELD_NAMED_S",
    "HELD_RECEIVED_S",
    "IN_FUTURE",
    "OLDER",
    "REPEATED",
    "STALE",
    "TRACK_COLUMNS",
    "UNKNOWN_UPDATE",
    "forget",
    "is_live",
    "is_timely",
    "take_identification",
    "take_update",
]

TRACK_COLUMNS = 5
"""Numbers of a track: those named below."""

(
    HELD_CONTENT,  # number of the content held, -1 for none
    HELD_MEMBER,  # sub-model in use
    HELD_FIT_S,  # instant of the fit [s]
    HELD_NAMED_S,  # instant of the newest message that named a sub-model [s]
    HELD_RECEIVED_S,  # arrival of the last message that renewed the track [s]
) = range(TRACK_COLUMNS)

ACCEPTED, OLDER, UNKNOWN_UPDATE, IN_FUTURE, STALE, REPEATED = range(6)
"""What becomes of a message."""


@kernel(inlined=True)
def forget(held: FloatVector) -> None:
    """Let a track hold nothing."""
    held[HELD_CONTENT] = -1.0
    held[HELD_MEMBER] = 0.0
    held[HELD_FIT_S] = -np.inf
    held[HELD_NAMED_S] = -np.inf
    held[HELD_RECEIVED_S] = -np.inf


@kernel(inlined=True)
def is_live(held: FloatVector, t_s: float, expiry_s: float) -> bool:
    """Whether a track holds something, and was renewed no longer than ``expiry_s`` ago."""
    return held[HELD_CONTENT] >= 0.0 and t_s - held[HELD_RECEIVED_S] <= expiry_s


@kernel(inlined=True)
def take_update(
    held: FloatVector, content: int, member: int, fit_s: float, received_s: float, expiry_s: float
) -> int:
    """Take in an update: `ACCEPTED`, `OLDER` or `REPEATED`.

    One fitted before what is held changes nothing. Of two of one instant the first stays; the second tells
    that the remote is alive, unless it is the first once more, as a relay repeats it: a copy tells nothing of
    the remote that was not known. An expired track is forgotten first.
    """
    if not is_live(held, received_s, expiry_s):
        forget(held)
    if fit_s < held[HELD_FIT_S]:
        return OLDER
    if fit_s == held[HELD_FIT_S]:
        if content != held[HELD_CONTENT]:
            held[HELD_RECEIVED_S] = received_s
        return REPEATED
    held[HELD_RECEIVED_S] = received_s
    held[HELD_CONTENT] = content
    held[HELD_MEMBER] = member
    held[HELD_FIT_S] = fit_s
    held[HELD_NAMED_S] = fit_s
    return ACCEPTED


@kernel(inlined=True)
def take_identification(
    held: FloatVector, content: int, member: int, named_s: float, received_s: float, expiry_s: float
) -> int:
    """Take in an identification that names an update's ``content``: `ACCEPTED`, `OLDER`, `UNKNOWN_UPDATE`.

    One that names another update than the one held changes nothing and does not tell that the remote is
    alive: a host that lost the update must not believe the one before for ever. An expired track is
    forgotten, and comes back with an update alone.
    """
    if not is_live(held, received_s, expiry_s):
        forget(held)
        return UNKNOWN_UPDATE
    if content != held[HELD_CONTENT]:
        return UNKNOWN_UPDATE
    if named_s <= held[HELD_NAMED_S]:
        return OLDER
    held[HELD_MEMBER] = member
    held[HELD_NAMED_S] = named_s
    held[HELD_RECEIVED_S] = received_s
    return ACCEPTED


@kernel(inlined=True)
def is_timely(t_s: float, received_s: float, max_ahead_s: float, max_age_s: float) -> int:
    """Judge the date of a message by its arrival: `ACCEPTED`, `IN_FUTURE` or `STALE`.

    Dated more than ``max_ahead_s`` later it would lock out all that follow; more than ``max_age_s`` earlier
    it is a recording, or was long on its way. What is no number is in the future.
    """
    if not t_s <= received_s + max_ahead_s:
        return IN_FUTURE
    if t_s < received_s - max_age_s:
        return STALE
    return ACCEPTED
