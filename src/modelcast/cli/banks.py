"""Banks of sub-models by name, as users type them."""

from collections.abc import Callable

from modelcast.core.exceptions import ConfigError
from modelcast.evaluation.settings import PAPER_BANK, PAPER_NOISE_FLOOR_M
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import (
    GaussianProcess,
    derivative_process,
    linear_process,
    trained_process,
    vehicle_process,
)
from modelcast.models.kinematic import (
    ConstantAcceleration,
    ConstantTurnRateAcceleration,
    ConstantTurnRateVelocity,
)
from modelcast.models.trusted import Trusted

__all__ = ["MEMBER_NAMES", "bank_from_text"]

INTERCEPT_NOISE_FLOOR_M = 1e-3
"""Smallest noise of ``gp-intercept`` and ``gp-adaptive`` where the user names none [m]."""

_GIVEN: dict[str, Callable[[int], AbstractSubModel]] = {
    "gp-linear": linear_process,
    "gp-trained": trained_process,
    "gp-vehicle": vehicle_process,
    "gp-derivative": derivative_process,
}
"""Processes with given hyper-parameters, by window length."""

_KINEMATIC: dict[str, AbstractSubModel] = {
    "cv": ConstantVelocity(),
    "ca": ConstantAcceleration(),
    "ctrv": ConstantTurnRateVelocity(),
    "ctra": ConstantTurnRateAcceleration(),
}

MEMBER_NAMES = (*_KINEMATIC, "gp-anchored", "gp-intercept", "gp-adaptive", *_GIVEN)
"""Sub-models that a bank may be made of."""


def bank_from_text(
    text: str,
    *,
    noise_floor_m: float | None = None,
    window: int = 10,
    trusted_horizon_s: float | None = None,
) -> Bank:
    """The bank a user means.

    Parameters
    ----------
    text
        ``paper`` (constant velocity, then the anchored Gaussian process), or sub-models in order, joined by
        ``+``: ``cv``, ``ca``, ``ctrv``, ``ctra``, ``gp-anchored``, ``gp-intercept``, ``gp-adaptive``,
        ``gp-linear``, ``gp-trained``, ``gp-vehicle``, ``gp-derivative``.
    noise_floor_m
        Smallest position noise the Gaussian processes fitted by likelihood may assume [m]; where None, none
        to speak of for the paper's form and 1 mm for the others.
    window
        Samples they are fitted to.
    trusted_horizon_s
        Age beyond which sub-models other than constant velocity are damped [s]; None for never.

    Raises
    ------
    ConfigError
        Where a name is unknown or a value out of range.

    Examples
    --------
    >>> bank_from_text("gp-intercept+cv").name
    'gp-intercept+cv'
    """
    names = [member.name for member in PAPER_BANK.members] if text == "paper" else text.split("+")
    try:
        members = tuple(_member(name.strip(), noise_floor_m, window) for name in names)
        if trusted_horizon_s is not None:
            members = tuple(
                member if isinstance(member, ConstantVelocity) else Trusted(member, trusted_horizon_s)
                for member in members
            )
        return Bank(members, "paper" if text == "paper" else "")
    except ValueError as error:
        raise ConfigError(f"--bank {text}: {error}") from error


def _member(name: str, noise_floor_m: float | None, window: int) -> AbstractSubModel:
    if name in _KINEMATIC:
        return _KINEMATIC[name]
    if name == "gp-anchored":
        floor_m = PAPER_NOISE_FLOOR_M if noise_floor_m is None else noise_floor_m
        return GaussianProcess(window, "anchored", noise_floor_m=floor_m)
    if name in ("gp-intercept", "gp-adaptive"):
        floor_m = INTERCEPT_NOISE_FLOOR_M if noise_floor_m is None else noise_floor_m
        noise = "estimated" if name == "gp-adaptive" else "floor"
        return GaussianProcess(window, "intercept", noise_floor_m=floor_m, noise=noise)
    if name in _GIVEN:
        return _GIVEN[name](window)
    known = f"{', '.join(MEMBER_NAMES[:-1])} and {MEMBER_NAMES[-1]}"
    raise ValueError(f"no sub-model is named '{name}'; there are {known}")
