"""What a plain message means: the sub-models that a receiver can use with Part I alone.

A sub-model is *free* where no message says more for it than Part I does. A bank has one meaning of a plain
message, a free sub-model that all who hold the bank coast by; every other sub-model that does the same at a
receiver may be sent as a plain message too. Whoever does not hold the bank reads the same message as ever.
"""

import numpy as np

from modelcast.models.base import AbstractSubModel
from modelcast.models.payload import CORE_PARAMETERS

__all__ = ["is_free", "plain_place", "same_receiver"]

_DT_S = 0.1
"""Interval at which tables are compared; free sub-models of modelcast have none that depends on it [s]."""


def is_free(member: AbstractSubModel) -> bool:
    """Whether a receiver needs nothing of it but Part I.

    Parameters
    ----------
    member
        A sub-model, in any form.

    Examples
    --------
    >>> from modelcast.models.kinematic import ConstantTurnRateAcceleration
    >>> is_free(ConstantTurnRateAcceleration())
    True
    """
    layout = member.payload_layout
    return layout is not None and not layout.fields and set(member.parameter_names) <= set(CORE_PARAMETERS)


def same_receiver(one: AbstractSubModel, other: AbstractSubModel) -> bool:
    """Whether two free sub-models predict alike at a receiver, however their senders choose the values.

    Parameters
    ----------
    one, other
        Free sub-models.
    """
    if one.parameter_names != other.parameter_names:
        return False
    trusts = [(member.trusted_horizon_s, member.trusted_turn_s) for member in (one, other)]
    if trusts[0] != trusts[1]:
        return False
    first, second = one.point_functions(_DT_S), other.point_functions(_DT_S)
    if first.predict is not second.predict:
        return False
    by_parameters = one.predicts_by_parameters and other.predicts_by_parameters
    alike = first.calls == second.calls and np.array_equal(first.constants, second.constants)
    return by_parameters or alike


def plain_place(members: tuple[AbstractSubModel, ...], name: str = "") -> int:
    """Place of the sub-model that a plain message is coasted by, -1 where none of a bank is free.

    Parameters
    ----------
    members
        Of the bank.
    name
        The one that the bank names; empty for the first that is free.

    Raises
    ------
    ValueError
        Where no member has that name, or it needs more than Part I.

    Examples
    --------
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> from modelcast.models.kinematic import ConstantTurnRateAcceleration
    >>> members = (ConstantTurnRateAcceleration(), ConstantVelocity())
    >>> plain_place(members), plain_place(members, "cv")
    (0, 1)
    """
    free = [place for place, member in enumerate(members) if is_free(member)]
    if not name:
        return free[0] if free else -1
    named = [place for place in free if members[place].name == name]
    if not named:
        known = ", ".join(members[place].name for place in free) or "none"
        raise ValueError(f"plain must name a sub-model that Part I is enough for ({known}), got {name!r}")
    return named[0]
