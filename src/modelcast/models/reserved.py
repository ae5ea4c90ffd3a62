"""Names that mean the same whatever the profile, and the check that no sub-model takes one for itself.

A bank is written as names joined by ``+`` (`modelcast.station.banks`). Where a profile's sub-model had such a
name, the name would mean another sub-model than the one that was trained.
"""

from dataclasses import replace

from modelcast.models.base import AbstractSubModel
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess, KernelProcess, linear_process, process_of
from modelcast.models.interacting import InteractingMultipleModel
from modelcast.models.kinematic import (
    ConstantAcceleration,
    ConstantTurnRateAcceleration,
    ConstantTurnRateVelocity,
)
from modelcast.models.regimes import REGIME_BANK
from modelcast.models.shipped import SHIPPED
from modelcast.models.wrapped import unwrapped

__all__ = ["EXPRESSION", "KINEMATIC", "UNTRAINED", "check_name"]

KINEMATIC: dict[str, AbstractSubModel] = {
    "cv": ConstantVelocity(),
    "ca": ConstantAcceleration(),
    "ctrv": ConstantTurnRateVelocity(),
    "ctra": ConstantTurnRateAcceleration(),
    "imm": InteractingMultipleModel(),
}

UNTRAINED = (*KINEMATIC, "gp-anchored", "gp-intercept", "gp-adaptive", "gp-linear")
"""Sub-models that need no profile, beside those of an expression."""

EXPRESSION = "gp("
"""How the name of a kernel's sub-model begins."""

_BANKS = ("paper", *SHIPPED, "trained", REGIME_BANK)
"""Words that stand for whole banks."""


def check_name(member: AbstractSubModel) -> None:
    """Refuse a sub-model whose name means something else in a bank's text.

    Parameters
    ----------
    member
        Of a profile.

    Raises
    ------
    ValueError
        Where its name is a bank's or another sub-model's, or cannot stand among names joined by ``+``.

    Examples
    --------
    >>> check_name(GaussianProcess(label="mine"))
    >>> check_name(GaussianProcess(label="cv"))
    Traceback (most recent call last):
    ValueError: no sub-model of a profile may be named 'cv': on the command line that is another sub-model
    """
    member = unwrapped(member)
    name = member.name
    refused = f"no sub-model of a profile may be named {name!r}: "
    if name in _BANKS:
        raise ValueError(f"{refused}on the command line that is a whole bank")
    if name in UNTRAINED or name.startswith(EXPRESSION):
        if not _means(member, name):
            raise ValueError(f"{refused}on the command line that is another sub-model")
    elif name != name.strip() or any(one in name for one in "+()"):
        raise ValueError(f"{refused}'+', parentheses and spaces at the ends cannot be part of a bank's text")


def _means(member: AbstractSubModel, name: str) -> bool:
    """Whether a sub-model is what its name means without a profile, window and noise floor apart."""
    if name in KINEMATIC:
        return type(member) is type(KINEMATIC[name])
    if name == "gp-linear":
        return member == linear_process(member.window)
    if not isinstance(member, GaussianProcess):
        return isinstance(member, KernelProcess)
    if name in UNTRAINED:
        return member.hyperparameters is None and replace(member, label="").name == name
    try:
        same = process_of(name[len(EXPRESSION) : -1], member.samples, noise_floor_m=member.noise_floor_m)
    except ValueError:
        return False
    return member == same
