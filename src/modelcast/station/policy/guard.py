"""The guard: no bank may cost a vehicle more than a few messages beyond what constant velocity would send.

A bank that saves messages on nearly every trip can cost some on one that is unlike all it was made for. The
sender can tell: beside its own messages it counts those that two virtual senders would have sent over the
same past, one with constant velocity alone and one with the same bank unguarded. Both are causal and put
nothing on the air.

While the sender has sent `ALLOWED` messages more than the first, or more still, constant velocity serves. An
update is then also sent whenever the virtual one sends; so from that one on, both send at the same instants
and the sender falls no further behind. The bank comes back once it would have led constant velocity by 2^n
messages over the whole trip, n being the messages lost so far: what has cost more must prove more.
"""

import numpy as np

from modelcast.core.arrays import BoolArray, IntArray
from modelcast.station.policy import guard_kernels as kernels
from modelcast.station.policy.rules import StartRule

__all__ = ["ALLOWED", "GUARD", "falls_back", "unguarded"]

ALLOWED = kernels.ALLOWED
"""Messages that a sender may have sent more than constant velocity alone before the guard acts."""

GUARD = "cv"
"""Name of the sub-model that serves then; a guarded bank must have it."""


def unguarded(start: StartRule) -> StartRule:
    """Return the start rule without its guard.

    Parameters
    ----------
    start
        Any start rule.
    """
    return "hindsight" if start == "guarded" else start


def falls_back(behind: IntArray, lead: IntArray) -> BoolArray:
    """Whether constant velocity serves, for B vehicles.

    Parameters
    ----------
    behind
        Messages that each has sent more than constant velocity alone would have, its newest included, (B,).
    lead
        Messages fewer than constant velocity's that the bank would have sent without a guard, (B,).

    Returns
    -------
    BoolArray
        (B,). Where it is set, `modelcast.station.policy.base.TransmitInputs.predicted_life` should be highest
        for constant velocity, and an error be infinite at an instant when constant velocity alone would send.

    Raises
    ------
    ValueError
        Where the shapes differ.

    Examples
    --------
    >>> falls_back(np.array([1, 2, 2, 3]), np.array([-1, 3, 4, 4])).tolist()
    [False, True, False, True]
    """
    if behind.shape != lead.shape:
        raise ValueError(f"behind and lead must have one shape, got {behind.shape} and {lead.shape}")
    found = [kernels.falls_back(int(b), int(ahead)) for b, ahead in zip(behind, lead, strict=True)]
    return np.array(found, dtype=np.bool_)
