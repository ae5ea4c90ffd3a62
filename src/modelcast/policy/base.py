"""What a transmit policy is: ``init`` and ``decide`` over a batch of vehicles, state passed in and out."""

import abc
from dataclasses import KW_ONLY, dataclass
from enum import IntEnum
from typing import Generic, TypeVar

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.policy import error_driven_kernels as kernels

__all__ = ["AbstractTransmitPolicy", "Decisions", "Message", "TransmitInputs"]

State = TypeVar("State")


class Message(IntEnum):
    """What a vehicle transmits at an instant."""

    NOTHING = kernels.NOTHING
    UPDATE = kernels.UPDATE
    IDENTIFICATION = kernels.IDENTIFICATION
    KEEP_ALIVE = kernels.KEEP_ALIVE

    @property
    def label(self) -> str:
        """Name in tables and traces."""
        return self.name.lower().replace("_", "-")


@dataclass(frozen=True, slots=True)
class TransmitInputs:
    """What B vehicles know when they decide.

    Parameters
    ----------
    t_s
        Now, (B,) [s].
    age_s
        Time since the last model update, (B,) [s].
    silence_s
        Time since the last message of any kind, infinite before the first, (B,) [s].
    tracking_error_m
        Error of every sub-model fitted at the last update, infinite where it had no full window then or
        nothing was sent yet, (B, M) [m].
    available
        Which sub-models have a full window now, (B, M).
    predicted_life
        How long each sub-model is predicted to last if it were sent now, in any unit that rises with it,
        (B, M); NaN where nothing is predicted, None where no policy asks.
    """

    t_s: FloatArray
    age_s: FloatArray
    _: KW_ONLY
    silence_s: FloatArray
    tracking_error_m: FloatArray
    available: BoolArray
    predicted_life: FloatArray | None = None


@dataclass(frozen=True, slots=True)
class Decisions:
    """What B vehicles do: a `Message` each, and the sub-model in use afterwards.

    Parameters
    ----------
    kind
        `Message` values, (B,).
    in_use
        Index of the sub-model, (B,).
    """

    kind: IntArray
    in_use: IntArray


class AbstractTransmitPolicy(abc.ABC, Generic[State]):
    """Decides what each of B vehicles transmits, from its own past alone."""

    @abc.abstractmethod
    def init(self, vehicles: int, sub_models: int) -> State:
        """Return the state of that many vehicles before their first sample."""

    @abc.abstractmethod
    def decide(
        self, state: State, inputs: TransmitInputs, rng: np.random.Generator
    ) -> tuple[Decisions, State]:
        """Return the decisions of one instant and the state after it; the given state is left alone."""
