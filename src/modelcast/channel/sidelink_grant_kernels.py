"""Compiled choice of a grant: by which kind of resource a message goes, and when a reservation comes back."""

from modelcast.channel.random_kernels import uniform
from modelcast.channel.sidelink_selection_kernels import SidelinkConstants
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import IntMatrix, UInt64Vector

__all__ = [
    "AHEAD",
    "BAND",
    "BYTES",
    "COUNTER",
    "GRANT_COLUMNS",
    "INTERVAL",
    "LENGTH",
    "MESSAGE",
    "NEXT",
    "RESERVED",
    "SENT",
    "SHOT",
    "SHOTS",
    "SHOT_LENGTH",
    "SKIPS",
    "TURNS",
    "UNUSED",
    "VIA",
    "WISH",
    "draw_counter",
    "draw_shots",
    "interval_for",
    "is_foreseen",
    "wants_one_shot",
]

# Columns of ``grant`` (V, GRANT_COLUMNS): integers. A vehicle has up to four turns to come: first and second
# copy by the resource that it reserves, and by one for a single message.
TURNS = 4
RESERVED, SHOT = 0, 2
"""The first of the two turns of each kind."""

BAND, NEXT = 0, TURNS
"""Columns of the first sub-channel of each turn, -1 for none, and of its subframe."""

(
    COUNTER,
    UNUSED,
    LENGTH,
    SHOT_LENGTH,
    INTERVAL,
    SHOTS,
    SKIPS,
    MESSAGE,
    BYTES,
    VIA,
    SENT,
    AHEAD,
    WISH,
) = range(2 * TURNS, 2 * TURNS + 13)
"""Messages until reselection; turns in a row without one; sub-channels of either kind; the interval [ms];
messages until the next interleaved one-shot; whether the coming turn is skipped for one; the waiting message,
-1 for none; its bytes; by which kind of turn it goes; copies sent; subframe in which the next message is
expected, -1 where that is not known; the grant asked for."""

GRANT_COLUMNS = 2 * TURNS + 13
_ANY, _ONE_SHOT = 0, 2
_SHORT_MS = (20, 50)
_HUNDRED = 100


@kernel(inlined=True)
def draw_counter(random: UInt64Vector, constants: SidelinkConstants) -> int:
    """Return a reselection counter."""
    span = constants.counter_high - constants.counter_low + 1
    return constants.counter_low + int(uniform(random) * span)


@kernel(inlined=True)
def draw_shots(random: UInt64Vector, constants: SidelinkConstants) -> int:
    """Return how many messages on, the next goes out by a one-shot."""
    span = constants.shots_high - constants.shots_low + 1
    return constants.shots_low + int(uniform(random) * span)


@kernel(inlined=True)
def is_foreseen(grant: IntMatrix, v: int, subframe: int, constants: SidelinkConstants) -> bool:
    """Whether a reservation can come back for the next message of a vehicle that sends now."""
    needed = grant[v, AHEAD] + constants.first - subframe
    return bool(grant[v, AHEAD] >= 0 and needed <= constants.longest)


@kernel(inlined=True)
def interval_for(grant: IntMatrix, v: int, subframe: int, constants: SidelinkConstants) -> int:
    """Return the interval with which a resource used now comes back, by when the next message is expected.

    The shortest, from the radio's own on, with which the resource comes back once that message is ready; the
    longest where none is long enough, the radio's own where the time is not known.
    """
    if not constants.interval_by_next or grant[v, AHEAD] < 0:
        return constants.interval
    needed = max(grant[v, AHEAD] + constants.first - subframe, constants.interval)
    for short in _SHORT_MS:
        if needed <= short:
            return short
    return min(-(-needed // _HUNDRED) * _HUNDRED, constants.longest)


@kernel(inlined=True)
def wants_one_shot(wish: int, constants: SidelinkConstants) -> bool:
    """Whether a message goes out by a one-shot whatever is reserved."""
    return bool(wish == _ONE_SHOT or (wish == _ANY and constants.one_shot))
