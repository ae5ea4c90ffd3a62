"""Compiled account of blind retransmissions: a receiver holds a message once, whichever copy reached it.

While a copy of a message is still to come, every pair of the message and a vehicle in reach waits here with
what became of it so far. A pair counts once, when the last copy has gone out or will not: as received where
any copy was, else by what became of its last.
"""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import IntMatrix, IntVector

__all__ = [
    "PAIR_COLUMNS",
    "Copies",
    "copies_room",
    "forget_pairs",
    "kept_copies",
    "move_last",
    "seek_pairs",
    "settle",
    "tell",
]

_RECEIVER, _OUTCOME, _BIN = 0, 1, 2
PAIR_COLUMNS = 3
_RECEIVED = 0


class Copies(NamedTuple):
    """Pairs of messages of which a copy is to come, by sender.

    ``pair`` (P, 3): receiver, outcome so far, bin of distance; ``span`` (V, 2): first row and number of rows
    of a sender's message; ``place`` (V,) is scratch: the row of a receiver, -1 for none.
    """

    pair: IntMatrix
    span: IntMatrix
    place: IntVector


@kernel
def copies_room(copies: Copies, used: int, more: int) -> Copies:
    """Return the same with room for more pairs behind those used."""
    if used + more <= copies.pair.shape[0]:
        return copies
    pair = np.empty((2 * (used + more), PAIR_COLUMNS), dtype=np.int64)
    pair[:used] = copies.pair[:used]
    return Copies(pair, copies.span, copies.place)


@kernel
def kept_copies(copies: Copies) -> tuple[IntMatrix, IntMatrix]:
    """Return the pairs that still wait, one after another, and their spans."""
    span = copies.span.copy()
    pair = np.empty((span[:, 1].sum(), PAIR_COLUMNS), dtype=np.int64)
    used = 0
    for v in range(span.shape[0]):
        first, count = span[v, 0], span[v, 1]
        pair[used : used + count] = copies.pair[first : first + count]
        span[v, 0] = used
        used += count
    return pair, span


@kernel(inlined=True)
def seek_pairs(copies: Copies, v: int) -> None:
    """Let receivers find the row of their pair with a sender's message, until it is settled."""
    for row in range(copies.span[v, 0], copies.span[v, 0] + copies.span[v, 1]):
        copies.place[copies.pair[row, _RECEIVER]] = row


@kernel(inlined=True)
def forget_pairs(copies: Copies, v: int) -> None:
    """Let no receiver find the row of its pair with a sender's message any more; the pairs wait on."""
    for row in range(copies.span[v, 0], copies.span[v, 0] + copies.span[v, 1]):
        copies.place[copies.pair[row, _RECEIVER]] = -1


@kernel(inlined=True)
def move_last(copies: Copies, v: int, used: int) -> int:
    """Make the rows of a sender's message the last ones used, so that more can follow; return rows used.

    There must be room for them once more.
    """
    first, count = copies.span[v, 0], copies.span[v, 1]
    copies.span[v, 0] = used
    for row in range(count):
        for column in range(PAIR_COLUMNS):
            copies.pair[used + row, column] = copies.pair[first + row, column]
    return used + count


@kernel(inlined=True)
def settle(copies: Copies, v: int, outcomes: IntMatrix) -> None:
    """Count the pairs of a sender's message: no copy of it is to come."""
    for row in range(copies.span[v, 0], copies.span[v, 0] + copies.span[v, 1]):
        copies.place[copies.pair[row, _RECEIVER]] = -1
        if copies.pair[row, _BIN] < outcomes.shape[0]:
            outcomes[copies.pair[row, _BIN], copies.pair[row, _OUTCOME]] += 1
    copies.span[v, 1] = 0


@kernel(inlined=True)
def tell(
    copies: Copies, v: int, j: int, outcome: int, group: int, used: int, more: bool, outcomes: IntMatrix
) -> tuple[bool, int]:
    """Take in what became of a copy at a receiver: whether the message is new to it, and rows used.

    ``group`` is the bin of distance; ``more`` says that another copy is to come. Receivers that the first
    copy did not reach are counted by the one that did. The rows of a sender's first copy are the last ones
    used, in one piece; there must be room.
    """
    row = copies.place[j]
    if row >= 0:
        if copies.pair[row, _OUTCOME] == _RECEIVED:
            return False, used
        copies.pair[row, _OUTCOME] = outcome
        return outcome == _RECEIVED, used
    if more and copies.span[v, 0] + copies.span[v, 1] == used:
        copies.pair[used, _RECEIVER], copies.pair[used, _OUTCOME] = j, outcome
        copies.pair[used, _BIN] = group
        copies.span[v, 1] += 1
        return outcome == _RECEIVED, used + 1
    if group < outcomes.shape[0]:
        outcomes[group, outcome] += 1
    return outcome == _RECEIVED, used
