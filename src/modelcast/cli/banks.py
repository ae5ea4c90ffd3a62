"""Banks of sub-models by name, as users type them."""

from modelcast.core.exceptions import ConfigError
from modelcast.evaluation.settings import PAPER_BANK
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess

__all__ = ["bank_from_text"]


def bank_from_text(text: str, *, noise_floor_m: float = 0.001, window: int = 10) -> Bank:
    """The bank a user means.

    Parameters
    ----------
    text
        ``paper`` (constant velocity, then the anchored Gaussian process), or sub-models in order, joined by
        ``+``: ``cv``, ``gp-anchored``, ``gp-intercept``.
    noise_floor_m
        Smallest position noise the Gaussian processes may assume [m].
    window
        Samples they are fitted to.

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
        return Bank(members, "paper" if text == "paper" else "")
    except ValueError as error:
        raise ConfigError(f"--bank {text}: {error}") from error


def _member(name: str, noise_floor_m: float, window: int) -> AbstractSubModel:
    if name == "cv":
        return ConstantVelocity()
    if name == "gp-anchored":
        return GaussianProcess(form="anchored", noise_floor_m=noise_floor_m, samples=window)
    if name == "gp-intercept":
        return GaussianProcess(form="intercept", noise_floor_m=noise_floor_m, samples=window)
    raise ValueError(f"no sub-model is named '{name}'; there are cv, gp-anchored and gp-intercept")
