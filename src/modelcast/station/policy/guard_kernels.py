"""Compiled rule of the guard: who serves, the bank or one of its guards, and when that changes.

A guard is a virtual sender of one plain sub-model over the same past: it puts nothing on the air and is
counted. The sender either says what the bank's lane says, or is *in step* with a guard: it sends when that
sends, what that sends. `modelcast.station.policy.guard` has the rule in words, and its bound.
"""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolMatrix, BoolVector, FloatVector, IntMatrix, IntVector

__all__ = [
    "ALLOWED",
    "BANK",
    "FIRST_LEAD",
    "GROWTH",
    "GUARDS",
    "OWN",
    "PATIENCE",
    "SHARE",
    "WORSE",
    "Guarding",
    "allowance",
    "forget_guard",
    "guarding",
    "needed_lead",
    "steer",
    "steer_through",
]

GUARDS = 2
"""Guards that a sender may have: constant velocity, and a plain sub-model that says more."""

OWN = GUARDS
"""Place of the sender's own count behind those of its guards."""

BANK = -1
"""Who serves where no guard does."""

ALLOWED = (2.0, 4.0)
"""Messages that a sender may always be behind each guard before that serves."""

SHARE = (0.01, 0.03)
"""Of each guard's messages, less one, that a sender may be behind it."""

FIRST_LEAD = 4.0
"""Lead over the guard in step that lets the bank serve again while no more than allowed was lost."""

GROWTH = 4.0
"""What each message lost beyond that multiplies the lead with."""

WORSE = 2
"""Messages more than the other guard's at which the sender changes guards."""


PATIENCE = 1.0
"""Messages beyond what is granted that the bank may lose by sub-models of its own choice."""


class Guarding(NamedTuple):
    """What L lanes know of their guards.

    ``counts`` (L, GUARDS + 1) messages of each guard and, last, of the lane; ``lead`` (L,) of the bank over
    the guard in step, since it was last none; ``step`` (L,) the guard in step, `BANK` for none; ``granted``
    (L,) how far beyond the allowance the lane may be before a guard serves; ``stand_in`` (L,) the guard whose
    sub-model the bank's lane carries while the sender waits for it, `BANK` for its own choice.
    """

    counts: IntMatrix
    lead: IntVector
    step: IntVector
    granted: FloatVector
    stand_in: IntVector


def guarding(count: int) -> Guarding:
    """Return lanes that have sent nothing.

    Parameters
    ----------
    count
        L.
    """
    return Guarding(
        np.zeros((count, GUARDS + 1), dtype=np.int64),
        np.zeros(count, dtype=np.int64),
        np.full(count, BANK, dtype=np.int64),
        np.zeros(count),
        np.full(count, BANK, dtype=np.int64),
    )


@kernel(inlined=True)
def forget_guard(g: Guarding, b: int) -> None:
    """Let a lane have sent nothing."""
    for i in range(GUARDS + 1):
        g.counts[b, i] = 0
    g.lead[b], g.granted[b] = 0, 0.0
    g.step[b] = g.stand_in[b] = BANK


@kernel
def allowance(guard: int, sent: int) -> float:
    """Messages that a sender may be behind a guard that has sent so many."""
    return max(ALLOWED[guard], SHARE[guard] * sent - 1.0)


@kernel
def needed_lead(over: float) -> float:
    """Lead that lets the bank serve again, by the messages lost beyond the allowance."""
    return FIRST_LEAD * GROWTH ** max(over, 0.0)


@kernel
def steer(g: Guarding, b: int, bank: bool, guards: tuple[bool, bool], count: int) -> bool:
    """Take in what the bank's lane and the guards of a lane send at a sample; whether the bank restarts.

    The first ``count`` of ``guards`` are there. Afterwards ``g.step[b]`` says whom the lane is with, at this
    sample too; where the bank restarts its lane must update now, as the guard that it takes over from does.
    """
    step = int(g.step[b])
    best = 0 if count == 1 or g.counts[b, 0] < g.counts[b, 1] else 1
    apart = g.counts[b, step] - g.counts[b, 1 - step] if step != BANK and count > 1 else 0
    for i in range(count):
        g.counts[b, i] += int(guards[i])
    sent = g.counts[b, OWN] + int(bank if step == BANK else guards[step])
    over = -np.inf
    for i in range(count):
        over = max(over, sent - g.counts[b, i] - allowance(i, g.counts[b, i]))
    restarts = False
    if step == BANK:
        g.granted[b] = min(g.granted[b], max(over + 1.0, 0.0))
        if over >= g.granted[b] and guards[best]:
            g.step[b], g.lead[b] = best, 0
    else:
        g.lead[b] = max(g.lead[b] + int(guards[step]) - int(bank), 0)
        if apart >= WORSE and guards[1 - step]:
            g.step[b], g.lead[b] = 1 - step, 0
        elif guards[step] and g.lead[b] >= needed_lead(over):
            g.step[b], g.granted[b] = BANK, max(over + 1.0, 0.0)
            restarts = True
    waits = bool(g.step[b] == BANK) and not restarts and over >= g.granted[b] + PATIENCE
    g.stand_in[b] = best if waits else BANK
    now = int(g.step[b])
    g.counts[b, OWN] += int((bank or restarts) if now == BANK else guards[now])
    return restarts


@kernel
def steer_through(
    g: Guarding, bank: BoolVector, guards: BoolMatrix, out_step: IntVector, out_restarts: BoolVector
) -> None:
    """Steer the first lane by what is sent at T samples: outputs are (T,)."""
    count = guards.shape[1]
    for number in range(bank.size):
        said = (bool(guards[number, 0]), bool(guards[number, count - 1]))
        out_restarts[number] = steer(g, 0, bool(bank[number]), said, count)
        out_step[number] = g.step[0]
