"""The guard: no bank may cost a vehicle more than a few messages beyond what plain sub-models would send.

A bank that saves messages on nearly every trip can cost some on one that is unlike all it was made for. The
sender can tell. Beside its own messages it counts those of its *guards*, virtual senders over the same past:
constant velocity alone, and the bank's best plain sub-model alone where it has one. They are causal and put
nothing on the air.

1. A sender may be behind a guard that has sent G messages by ``max(a, s·G - 1)``: a = 2 and s = 0.01 for
   constant velocity, 4 and 0.03 for the other. What it is beyond that is its *overrun* o, the larger of both.
2. Where the overrun has reached what is granted, 0 at first, and the guard that has sent fewest sends, the
   sender sends with it, and is in step with it from then on: both send the same at the same instants, and
   the sender falls no further behind. Until that guard sends, the bank serves on; but once it has lost one
   message more, its messages carry that guard's sub-model.
3. In step, where the other guard has sent two messages fewer and sends, the sender changes guards.
4. In step, the virtual bank's lead over that guard is counted, from its lowest on. Where it reaches
   ``4·4^max(o, 0)``, the bank starts anew with the guard's next message, which costs nothing, and is granted
   ``max(o + 1, 0)``. As the overrun falls, so does what is granted: to ``max(o + 1, 0)``.

Notes
-----
Let w be the most messages that the bank or a guard sends within one silence of a guard, q the guards that the
sender was in step with since the bank last served, 0 for none or where there is one guard, and G the most
messages that a guard has sent. At any time, on any trip, the sender is behind each guard by less than

    max over guards of max(a, s·G - 1) + max(1, log4 G) + w + q·(1 + w).

No causal sender that ever leaves a guard does without w: `docs/decisions/027-guard.md` has both proofs.

References
----------
E. Even-Dar, M. Kearns, Y. Mansour, J. Wortman, "Regret to the Best vs. Regret to the Average", Machine
Learning 72, 2008, doi:10.1007/s10994-008-5060-7: a small bound against one expert, and what it costs against
the best. E. S. Page, "Continuous Inspection Schemes", Biometrika 41, 1954, doi:10.1093/biomet/41.1-2.100: a
sum that is counted from its lowest on.
"""

from dataclasses import dataclass
from math import log

import numpy as np

from modelcast.core.arrays import BoolArray, IntArray
from modelcast.station.policy import guard_kernels as kernels
from modelcast.station.policy.rules import StartRule

__all__ = ["FREE_GUARDS", "GUARD", "Steered", "most_behind", "steered", "unguarded"]

GUARD = "cv"
"""Name of the sub-model that guards every bank; a guarded bank must have it."""

FREE_GUARDS = ("free", "ctra")
"""Names of sub-models that a plain message states all of; the first of them that a bank has guards it too."""


def unguarded(start: StartRule) -> StartRule:
    """Return the start rule without its guard.

    Parameters
    ----------
    start
        Any start rule.
    """
    return "hindsight" if start == "guarded" else start


@dataclass(frozen=True, slots=True)
class Steered:
    """What the guard does over T samples.

    Parameters
    ----------
    step
        The guard in step after each sample, -1 where the bank serves, (T,).
    restarts
        Samples at which the bank starts anew, (T,).
    sends
        Samples at which the sender sends, (T,).
    """

    step: IntArray
    restarts: BoolArray
    sends: BoolArray


def steered(bank: BoolArray, guards: BoolArray) -> Steered:
    """Apply the rule to given messages of a virtual bank and its guards.

    In a station the bank's lane goes on from where it restarts; here its messages are what they are.

    Parameters
    ----------
    bank
        Samples at which the bank sends, (T,).
    guards
        Samples at which each guard sends, (T, 1) or (T, 2): constant velocity first.

    Raises
    ------
    ValueError
        Where the shapes do not agree.

    Examples
    --------
    Constant velocity would have sent once; the bank sends at every sample until it is behind by more than
    two, and the guard sends again:

    >>> bank, guard = np.ones(8, dtype=bool), np.zeros((8, 1), dtype=bool)
    >>> guard[[0, 4]] = True
    >>> steered(bank, guard).sends.astype(int).tolist()
    [1, 1, 1, 1, 1, 0, 0, 0]
    """
    if bank.ndim != 1 or guards.shape not in ((bank.size, 1), (bank.size, kernels.GUARDS)):
        raise ValueError(
            f"bank must be (T,) and guards (T, 1) or (T, {kernels.GUARDS}), got {bank.shape}, {guards.shape}"
        )
    step, restarts = np.empty(bank.size, dtype=np.int64), np.empty(bank.size, dtype=np.bool_)
    kernels.steer_through(
        kernels.guarding(1),
        np.ascontiguousarray(bank, dtype=np.bool_),
        np.ascontiguousarray(guards, dtype=np.bool_),
        step,
        restarts,
    )
    followed = np.take_along_axis(guards, np.maximum(step, 0)[:, None], axis=1)[:, 0]
    return Steered(step, restarts, np.where(step == kernels.BANK, bank | restarts, followed))


def most_behind(sent: IntArray, within: int, visits: int) -> float:
    """Return the bound on how far a sender is behind each of its guards: it is behind by less.

    Parameters
    ----------
    sent
        Messages of its guards so far, (1,) or (2,): constant velocity first.
    within
        Most messages that the bank or a guard sent within one silence of a guard.
    visits
        Guards in step since the bank last served; 0 where there is one guard.

    Examples
    --------
    >>> most_behind(np.array([64]), 1, 0)
    6.0
    """
    allowed = max(kernels.allowance(i, int(count)) for i, count in enumerate(sent))
    most = max(int(sent.max()), 1)
    return allowed + max(1.0, log(most, kernels.GROWTH)) + within + visits * (1.0 + within)
