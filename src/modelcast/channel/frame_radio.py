"""Radios that simulate every frame at every receiver: what `Dsrc`, `Sidelink` and `Nr` have in common.

Their states hold arrays that a compiled loop writes into. `step` gives the loop a copy, `carry` the state
itself.
"""

import abc
import warnings
from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np

from modelcast.channel.error_models import AbstractErrorModel
from modelcast.channel.frame_kernels import Asked, Heard
from modelcast.channel.propagation import Propagation
from modelcast.channel.radio import AbstractRadio, Receptions, Transmissions
from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import ModelcastWarning
from modelcast.core.parts import WHOLE, Parts

__all__ = [
    "AbstractFrameRadio",
    "asked",
    "copied",
    "error_units",
    "has_shadowing",
    "receptions_of",
    "told_of_fading_twice",
    "without_second_fading",
]

State = TypeVar("State")


def copied(state: Any) -> Any:
    """Return the same state in arrays of its own.

    Parameters
    ----------
    state
        A dataclass; what is no array stays.
    """
    held = {one.name: getattr(state, one.name) for one in fields(state)}
    return replace(
        state, **{name: value.copy() for name, value in held.items() if isinstance(value, np.ndarray)}
    )


def asked(transmissions: Transmissions) -> Asked:
    """Columns of transmissions as compiled loops take them."""
    return Asked(*(getattr(transmissions, one) for one in Asked._fields))


def receptions_of(heard: Heard) -> Receptions:
    """What a compiled loop heard, in columns of its own."""
    message_id, sender, receiver = np.ascontiguousarray(heard.who.T)
    t_s, power_mw = np.ascontiguousarray(heard.when.T)
    return Receptions(
        message_id,
        sender,
        receiver=receiver,
        t_s=t_s,
        rssi_dbm=10.0 * np.log10(power_mw),
        outcomes=heard.outcomes,
        expired=heard.expired,
    )


def error_units(error_model: AbstractErrorModel) -> tuple[float, float]:
    """Units of hazard of a frame without a byte, and of every byte."""
    units = error_model.units(np.array([0.0, 1.0]))
    return float(units[0]), float(units[1]) - float(units[0])


def has_shadowing(propagation: Propagation) -> bool:
    """Whether pairs have shadowing that must be kept."""
    shadowing = propagation.shadowing
    return shadowing is not None and (shadowing.los_db > 0 or shadowing.nlos_db > 0)


def without_second_fading(propagation: Propagation, error_model: AbstractErrorModel) -> Propagation:
    """The propagation beside an error model: without fast fading where the model's curve holds it already."""
    return replace(propagation, fading=None) if error_model.holds_fading else propagation


def told_of_fading_twice(propagation: Propagation, error_model: AbstractErrorModel) -> None:
    """Warn where fast fading is drawn beside a curve that holds it.

    Warns
    -----
    ModelcastWarning
        Then frames are lost to it twice.
    """
    if error_model.holds_fading and propagation.fading is not None:
        warnings.warn(
            "Fast fading is drawn beside an error model whose curve holds it already, so frames are lost to "
            "it twice: give the propagation no fading (fading=none), or a curve made without (faded=False)",
            ModelcastWarning,
            stacklevel=4,
        )


class AbstractFrameRadio(AbstractRadio[State]):
    """A radio whose state is arrays that a compiled loop writes into."""

    __slots__ = ()

    @abc.abstractmethod
    def silent(self, vehicles: int, random: np.ndarray[tuple[int], np.dtype[np.uint64]]) -> State:
        """State at time 0 of V vehicles; ``random`` (2,): word of its generator, seed of shadowing."""

    @abc.abstractmethod
    def advance(
        self,
        state: State,
        transmissions: Transmissions,
        position_m: FloatArray,
        until_t_s: float,
        parts: Parts,
    ) -> tuple[Heard, State]:
        """Check what is asked for and carry one interval, in parts; the state is used up."""

    def init(self, vehicles: int, rng: np.random.Generator) -> State:
        """State of a silent channel at time 0."""
        if vehicles < 1:
            raise ValueError(f"vehicles must be at least 1, got {vehicles}")
        return self.silent(vehicles, rng.integers(0, 2**64, size=2, dtype=np.uint64))

    def step(
        self, state: State, transmissions: Transmissions, position_m: FloatArray, until_t_s: float
    ) -> tuple[Receptions, State]:
        """Carry one interval; the given state is left alone."""
        return self.carry(copied(state), transmissions, position_m, until_t_s)

    def carry(
        self,
        state: State,
        transmissions: Transmissions,
        position_m: FloatArray,
        until_t_s: float,
        parts: Parts = WHOLE,
    ) -> tuple[Receptions, State]:
        """Carry one interval and use the given state up: faster than `step`."""
        place_m = np.ascontiguousarray(position_m, dtype=np.float64)
        heard, after = self.advance(state, transmissions, place_m, until_t_s, parts)
        return receptions_of(heard), after
