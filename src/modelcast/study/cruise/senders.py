"""Senders of a study of platoons: those of `named_sender`, and such as speak at any fixed rate.

``bsm-2hz`` sends basic safety messages twice a second, ``free-2.5hz`` plain messages that receivers coast by
the best free sub-model: what errors or timers save is to be held against as many messages sent by the clock.
"""

import re
from dataclasses import replace

from modelcast.models.bank import Bank
from modelcast.station.policy.error_driven import LOSS_BUDGET
from modelcast.station.policy.periodic import Periodic
from modelcast.station.sender.names import ERROR_SENDERS, MODEL_SENDERS, SENDERS
from modelcast.station.sender.sender import Sender, named_sender

__all__ = ["has_threshold", "is_sender", "platoon_sender"]

_CLOCKED = re.compile(r"(bsm|free)-(\d+(?:\.\d+)?)hz")

_UNUSED_M = 0.2
"""For senders that no error calls."""


def _clocked(name: str) -> tuple[str, float] | None:
    """Content and rate of a sender by the clock, None for any other name."""
    found = None if name in SENDERS else _CLOCKED.fullmatch(name)
    if found is None or not 0.1 <= float(found[2]) <= 10.0:
        return None
    return ("bsm-10hz" if found[1] == "bsm" else "free"), float(found[2])


def is_sender(name: str) -> bool:
    """Whether there is a sender of that name; rates lie within 0.1 and 10 a second.

    Parameters
    ----------
    name
        Any text.

    Examples
    --------
    >>> is_sender("mbc"), is_sender("free-2.5hz"), is_sender("bsm-20hz")
    (True, True, False)
    """
    return name in SENDERS or _clocked(name) is not None


def has_threshold(name: str) -> bool:
    """Whether an error calls for the messages of the sender of that name.

    Parameters
    ----------
    name
        A sender's.
    """
    return name in ERROR_SENDERS


def platoon_sender(
    name: str,
    *,
    threshold_m: float | None = None,
    keep_alive_s: float = 1.0,
    approach_m: float = float("inf"),
    budget: float = LOSS_BUDGET,
    bank: Bank | None = None,
) -> Sender:
    """The sender of that name.

    Parameters
    ----------
    name
        As `is_sender` knows it.
    threshold_m
        Error that calls; None where none does [m].
    keep_alive_s, approach_m, budget
        As in `named_sender`.
    bank
        Of the senders that send models; None for the shipped profile's.

    Raises
    ------
    ValueError
        Where there is no such sender, or it does not take the bank.

    Examples
    --------
    >>> platoon_sender("bsm-2hz").policy
    Periodic(rate_hz=2.0)
    """
    clocked = _clocked(name)
    sender = named_sender(
        name if clocked is None else clocked[0],
        bank=bank if name in MODEL_SENDERS else None,
        threshold_m=_UNUSED_M if threshold_m is None else threshold_m,
        keep_alive_s=keep_alive_s,
        approach_m=approach_m,
        budget=budget,
    )
    return sender if clocked is None else replace(sender, name=name, policy=Periodic(clocked[1]))
