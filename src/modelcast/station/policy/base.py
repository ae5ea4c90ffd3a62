"""What a transmit policy is: ``init`` and ``decide`` over a batch of vehicles, state passed in and out."""

import abc
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, fields, is_dataclass, replace
from enum import IntEnum
from types import MappingProxyType
from typing import Any, Generic, TypeVar, cast

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.station.policy import dcc_kernels
from modelcast.station.policy import error_driven_kernels as kernels
from modelcast.station.policy.j2945_parameters import J2945Parameters
from modelcast.station.policy.policy_numbers import RULE_PLAIN, PolicyNumbers

__all__ = [
    "MOST_POWER_DBM",
    "AbstractTransmitPolicy",
    "Air",
    "Decisions",
    "MessageKind",
    "Motion",
    "TransmitInputs",
    "at_threshold",
    "required",
    "takes_threshold",
]

MOST_POWER_DBM = J2945Parameters().max_power_dbm
"""Most that a policy may ask for: the most of SAE J2945/1 [dBm]."""

State = TypeVar("State")


class MessageKind(IntEnum):
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
class Motion:
    """What B vehicles measure of themselves.

    Parameters
    ----------
    position_m
        East and north, (B, 2) [m].
    speed_mps
        (B,) [m/s].
    heading_rad
        Clockwise from north, (B,) [rad].
    critical
        Whether a critical event goes on, as `J2945Parameters.is_critical` says, (B,).
    """

    position_m: FloatArray
    speed_mps: FloatArray
    _: KW_ONLY
    heading_rad: FloatArray
    critical: BoolArray


@dataclass(frozen=True, slots=True)
class Air:
    """What B vehicles know of the channel and of those they hear.

    Parameters
    ----------
    channel_busy_ratio
        As the radio measured it over its last interval, (B,).
    neighbours
        Remotes heard of late within range, as `Neighbours.survey` counts them, (B,).
    packet_error_ratio
        Mean over those remotes, NaN where there is none to count, (B,).
    airtime_s
        Of the message that would be sent, (B,) [s].
    """

    channel_busy_ratio: FloatArray
    neighbours: FloatArray
    _: KW_ONLY
    packet_error_ratio: FloatArray
    airtime_s: FloatArray


@dataclass(frozen=True, slots=True)
class TransmitInputs:
    """What B vehicles know when they decide. A policy that needs a part that is None refuses it.

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
    until_s
        End of the interval that is decided on, when `decide` is asked next, (B,) [s]; None leaves it to the
        policy.
    legacy_error_m
        Error of receivers that coast place, speed and heading of the last update's Part I at constant
        velocity, (B,) [m]; None where no policy asks.
    motion
        What the vehicles measure of themselves.
    air
        What they know of the channel.
    in_use
        Sub-model of the last update, -1 before the first, (B,); None where the policy keeps it itself.
    """

    t_s: FloatArray
    age_s: FloatArray
    _: KW_ONLY
    silence_s: FloatArray
    tracking_error_m: FloatArray
    available: BoolArray
    predicted_life: FloatArray | None = None
    until_s: FloatArray | None = None
    legacy_error_m: FloatArray | None = None
    motion: Motion | None = None
    air: Air | None = None
    in_use: IntArray | None = None

    @property
    def error_in_use_m(self) -> FloatArray:
        """Tracking error of the sub-model of the last update, infinite before the first, (B,) [m].

        Raises
        ------
        ValueError
            Where `in_use` is None.
        """
        in_use = required(self.in_use, "in_use", "error_in_use_m")
        error_m = self.tracking_error_m[np.arange(in_use.size), np.maximum(in_use, 0)]
        return np.where(in_use >= 0, error_m, np.inf)


Part = TypeVar("Part", Motion, Air, FloatArray, IntArray)


def required(part: Part | None, name: str, policy: str) -> Part:
    """Return a part of the inputs that a policy cannot do without.

    Raises
    ------
    ValueError
        Where it is None.
    """
    if part is None:
        raise ValueError(f"{policy} needs TransmitInputs.{name}, got None: fill it in")
    return part


@dataclass(frozen=True, slots=True)
class Decisions:
    """What B vehicles do: a `MessageKind` each, the sub-model in use afterwards, and how it is sent.

    Parameters
    ----------
    kind
        `MessageKind` values, (B,).
    in_use
        Index of the sub-model, (B,); of a policy in NumPy -1 where the station chooses, by its start rule.
    send_s
        When the message is handed to the radio, infinite where there is none, (B,) [s].
    power_dbm
        Radiated power, NaN where the policy leaves it to the radio or nothing is sent, (B,) [dBm].
    believed
        Whether the sender takes the message for received, and measures its tracking error against it from now
        on, (B,).
    """

    kind: IntArray
    in_use: IntArray
    _: KW_ONLY
    send_s: FloatArray
    power_dbm: FloatArray
    believed: BoolArray

    def check(self, inputs: TransmitInputs) -> None:
        """Refuse what a station cannot do.

        Parameters
        ----------
        inputs
            What was known.

        Raises
        ------
        ValueError
            Where there is not one decision a vehicle; an array holds fractions where whole numbers or truth
            values are meant; a kind is neither nothing, an update nor a keep-alive;
            a sub-model named for a message is out of range or has no full window; a message is to leave
            before now or after the interval; or a power is above `MOST_POWER_DBM`.
        """
        rows, members = inputs.available.shape
        for name, wanted in _DECIDED.items():
            given: Any = getattr(self, name)
            shape = np.shape(given)
            if not isinstance(given, np.ndarray) or shape != (rows,):
                raise ValueError(f"{name} must be an array of shape {(rows,)}, got {shape}")
            found = cast("FloatArray", given).dtype
            if not np.can_cast(found, wanted, "same_kind"):
                raise ValueError(f"{name} must be an array of {wanted.__name__}, got {found}")
        allowed = (MessageKind.NOTHING, MessageKind.UPDATE, MessageKind.KEEP_ALIVE)
        _refuse(~np.isin(self.kind, allowed), "kind", self.kind, "nothing, an update or a keep-alive")
        sends = self.kind != MessageKind.NOTHING
        outside = sends & ((self.in_use < -1) | (self.in_use >= members))
        expected = f"-1, for the station's choice, or a sub-model below {members}"
        _refuse(outside, "in_use", self.in_use, expected)
        serves = inputs.available[np.arange(rows), np.clip(self.in_use, 0, members - 1)]
        lacks = sends & (self.in_use >= 0) & ~serves
        _refuse(lacks, "in_use", self.in_use, "a sub-model that is available")
        until_s = np.inf if inputs.until_s is None else inputs.until_s
        late = sends & ~((self.send_s >= inputs.t_s) & (self.send_s < until_s))
        _refuse(late, "send_s", self.send_s, "within t_s and until_s, the end excluded")
        loud = sends & (np.isinf(self.power_dbm) | (self.power_dbm > MOST_POWER_DBM))
        _refuse(loud, "power_dbm", self.power_dbm, f"NaN or at most {MOST_POWER_DBM:g} dBm")

    @classmethod
    def at_once(cls, kind: IntArray, in_use: IntArray, t_s: FloatArray) -> "Decisions":
        """Messages that leave now, at the radio's own power, and are taken for received.

        Parameters
        ----------
        kind
            `MessageKind` of each vehicle, (B,).
        in_use
            Sub-model of each vehicle afterwards, (B,).
        t_s
            Now, by the clock of each vehicle, (B,) [s].
        """
        sends = kind != MessageKind.NOTHING
        return cls(
            kind,
            in_use,
            send_s=np.where(sends, t_s, np.inf),
            power_dbm=np.full(kind.size, np.nan),
            believed=sends,
        )


_DECIDED: Mapping[str, type[np.generic]] = MappingProxyType(
    {
        "kind": np.int64,
        "in_use": np.int64,
        "send_s": np.float64,
        "power_dbm": np.float64,
        "believed": np.bool_,
    }
)
"""What the arrays of a decision hold."""


def _refuse(wrong: BoolArray, name: str, values: IntArray | FloatArray, expected: str) -> None:
    """Refuse the first value that is wrong."""
    if wrong.any():
        raise ValueError(f"{name} must be {expected}, got {values[np.flatnonzero(wrong)[0]]}")


class AbstractTransmitPolicy(abc.ABC, Generic[State]):
    """Decides what each of B vehicles transmits, from its own past alone.

    Who writes one gives `longest_silence_s`, `init` and `decide`, in NumPy over all vehicles at once. Another
    package adds its own in the entry-point group ``modelcast.policies``
    (`modelcast.station.sender.registry`). A state is None, an array with a row a vehicle, or a tuple or
    dataclass of such arrays: stations take rows out and put them back as vehicles come and go.

    A policy with a setting `threshold_m` is run at each threshold that a command is given.
    """

    __slots__ = ()

    @property
    def numbers(self) -> PolicyNumbers:
        """The rule as the compiled station takes it: here that `decide` is asked."""
        nothing, standard = np.zeros(1), J2945Parameters()
        critical_mps2 = standard.critical_deceleration_mps2
        return PolicyNumbers(
            RULE_PLAIN, standard.constants(), dcc_kernels.NONE, nothing, 0.0, 0.0, critical_mps2
        )

    @property
    @abc.abstractmethod
    def longest_silence_s(self) -> float:
        """Longest time between two messages that the rule allows [s]."""

    @abc.abstractmethod
    def init(self, vehicles: int, sub_models: int) -> State:
        """Return the state of that many vehicles before their first sample.

        Parameters
        ----------
        vehicles
            How many, B.
        sub_models
            How many sub-models each may name.
        """

    @abc.abstractmethod
    def decide(
        self, state: State, inputs: TransmitInputs, rng: np.random.Generator
    ) -> tuple[Decisions, State]:
        """Return the decisions of one instant and the state after it.

        Parameters
        ----------
        state
            As `init` or `decide` gave it; it is left alone.
        inputs
            What B vehicles know at this instant.
        rng
            Where chance comes from.
        """


def takes_threshold(policy: AbstractTransmitPolicy[Any]) -> bool:
    """Whether a policy has a setting `threshold_m`.

    Parameters
    ----------
    policy
        The policy.
    """
    return is_dataclass(policy) and any(one.name == "threshold_m" for one in fields(policy))


def at_threshold(policy: AbstractTransmitPolicy[Any], threshold_m: float) -> AbstractTransmitPolicy[Any]:
    """Return a policy at a threshold; itself where it has none.

    Parameters
    ----------
    policy
        The policy.
    threshold_m
        The threshold [m].

    Raises
    ------
    ValueError
        Where it refuses the threshold.
    """
    return replace(cast("Any", policy), threshold_m=threshold_m) if takes_threshold(policy) else policy
