"""How receivers read a message: by what they know beside Part I.

| reading | what it makes of a message |
|---|---|
| `LEGACY` | coasts place, speed and heading of Part I by constant velocity; knows no identification |
| `FREE` | coasts Part I by the free sub-model's rule, whatever model the message carries |
| `MODEL` | uses the sub-model that the message names |

All three hear the same octets: Part I is that of a basic safety message whoever sends it.
"""

from enum import IntEnum

import numpy as np

from modelcast.models.bank import Bank
from modelcast.models.members import ReadyBank
from modelcast.models.payload import CORE_PARAMETERS
from modelcast.models.plain_meaning import is_free
from modelcast.station.receiver import reading_kernels as kernels

__all__ = ["Reading", "free_rule", "goes_straight"]


class Reading(IntEnum):
    """What a receiver makes of a message; the numbers are those of `reading_kernels`."""

    LEGACY = kernels.LEGACY
    FREE = kernels.FREE
    MODEL = kernels.MODEL


def free_rule(bank: Bank, dt_s: float) -> kernels.FreeRule:
    """Return how Part I is coasted by a bank's meaning of a plain message; it is good in this process alone.

    Parameters
    ----------
    bank
        A bank with a free sub-model (`modelcast.station.banks.free_bank`).
    dt_s
        Sampling interval [s].

    Raises
    ------
    ValueError
        Where no sub-model of the bank is free.

    Examples
    --------
    >>> from modelcast.models.kinematic import ConstantTurnRateAcceleration
    >>> free_rule(Bank((ConstantTurnRateAcceleration(),)), 0.1).places
    array([0, 1, 2, 3])
    """
    if bank.plain_place < 0:
        raise ValueError(f"receivers that read Part I need a free sub-model, {bank.name} has none")
    member = bank.members[bank.plain_place]
    places = [CORE_PARAMETERS.index(name) for name in member.parameter_names if name in CORE_PARAMETERS]
    return kernels.FreeRule(ReadyBank.of(Bank((member,)), dt_s).members, np.array(places, dtype=np.int64))


def goes_straight(bank: Bank) -> tuple[bool, ...]:
    """Which sub-models of a bank go on at constant velocity, and so deny no acceleration that Part I states.

    Parameters
    ----------
    bank
        As senders have it.

    Examples
    --------
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> from modelcast.models.kinematic import ConstantAcceleration
    >>> goes_straight(Bank((ConstantAcceleration(), ConstantVelocity())))
    (False, True)
    """
    straight = CORE_PARAMETERS[:2]
    return tuple(is_free(member) and member.parameter_names == straight for member in bank.members)
