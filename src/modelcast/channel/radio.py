"""What a radio does to the messages of a whole fleet: the second kind of channel.

`AbstractChannel` (`channel/base.py`) loses messages of one recorded trip, instant by instant. `AbstractRadio`
carries all transmissions of an interval together, so that they contend: who hears whom depends on who else
sends. State goes in and comes out; a lost message is an absent reception, counted by cause and distance.
"""

import abc
from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass, field, fields
from enum import IntEnum
from typing import Generic, Self, TypeVar

import numpy as np

from modelcast.channel.antennas import checked_gains
from modelcast.channel.frame_kernels import are_in_order
from modelcast.channel.propagation import Propagation
from modelcast.core.arrays import BoolArray, FloatArray, IntArray, owned
from modelcast.core.parts import WHOLE, Parts

__all__ = ["ORDINARY", "OUTCOMES", "AbstractRadio", "Grant", "Receptions", "Transmissions"]

OUTCOMES = ("received", "half-duplex", "below-sensitivity", "hidden", "concurrent")
"""What can become of a frame at a vehicle in reach: columns of `Receptions.outcomes`.

``half-duplex``: the receiver was sending. ``below-sensitivity``: too weak even without interference.
Otherwise interference decided: ``concurrent`` where most of it began in the same slot (or chose the same
resource at the same time), so that neither sender could have known, ``hidden`` where it began while the
other was on the air.
"""

ORDINARY = 5
"""Priority of a message of which nothing else is said: room above for what is urgent, two steps below."""

_SLACK_S = 1e-9
"""How much earlier than its interval a reception may be told, for rounding."""

State = TypeVar("State")


class Grant(IntEnum):
    """Which kind of resource a sender asks for, where a radio reserves resources at all."""

    ANY = 0
    """The sender does not say: the radio's own settings decide."""
    PERIODIC = 1
    """One that comes back, announced with the message: more will follow at even times."""
    ONE_SHOT = 2
    """One for this message alone."""


def _left_out() -> IntArray:
    return np.empty(0, dtype=np.int64)


def _never_said() -> FloatArray:
    return np.empty(0)


@dataclass(frozen=True, slots=True)
class Transmissions:
    """Messages that vehicles hand to their radios within one interval.

    Parameters
    ----------
    sender
        Index of the sending vehicle, (N,).
    ready_s
        When the message is ready, (N,), not falling [s].
    size_bytes
        Bytes handed to the physical layer, MAC header included, (N,).
    power_dbm
        Transmit power at the antenna connector, (N,) [dBm].
    message_id
        The caller's number of the message, not negative; receptions carry it, (N,).
    priority
        0, the most urgent, to 7, as ProSe per-packet priorities count; left out: `ORDINARY`, (N,).
    next_s
        When the sender expects its next message to be ready, after this one; infinite where it does not know,
        or left out, (N,) [s].
    grant
        A `Grant` for each message; left out: `Grant.ANY`, (N,).

    Raises
    ------
    ValueError
        Where lengths differ, times fall, or a size, number, priority or grant is out of range.

    Notes
    -----
    Radios see ``priority``, ``next_s`` and ``grant`` as full columns, whether left out or not. Each says
    which of them it heeds; `Sidelink` and `Nr` heed the last two.
    """

    sender: IntArray
    ready_s: FloatArray
    _: KW_ONLY
    size_bytes: IntArray
    power_dbm: FloatArray
    message_id: IntArray
    priority: IntArray = field(default_factory=_left_out)
    next_s: FloatArray = field(default_factory=_never_said)
    grant: IntArray = field(default_factory=_left_out)

    def __post_init__(self) -> None:
        for name, default in (("priority", ORDINARY), ("next_s", np.inf), ("grant", int(Grant.ANY))):
            if getattr(self, name).size == 0:
                object.__setattr__(self, name, np.full(self.sender.size, default))
        sizes = {getattr(self, one.name).size for one in fields(self)}
        if len(sizes) != 1:
            raise ValueError(f"all columns must have one length, got {sorted(sizes)}")
        if self.sender.size == 0:
            return
        if not np.all(np.diff(self.ready_s) >= 0):
            raise ValueError("ready_s must not fall: sort the transmissions by time")
        if int(self.size_bytes.min()) < 1:
            raise ValueError(f"size_bytes must be at least 1, got {int(self.size_bytes.min())}")
        if int(self.message_id.min()) < 0 or int(self.sender.min()) < 0:
            raise ValueError("sender and message_id must not be negative")
        if not np.all(np.isfinite(self.power_dbm)):
            raise ValueError("power_dbm must be finite")
        self._check_wishes()

    def _check_wishes(self) -> None:
        for name, most in (("priority", 7), ("grant", max(Grant))):
            low, high = int(getattr(self, name).min()), int(getattr(self, name).max())
            if low < 0 or high > most:
                raise ValueError(f"{name} must lie within 0..{int(most)}, got {low}..{high}")
        if not np.all(self.next_s > self.ready_s):
            raise ValueError("next_s must lie after ready_s; infinite where it is not known")

    @property
    def size(self) -> int:
        """Number of messages."""
        return self.sender.size

    def check(
        self, t_s: float, until_t_s: float, position_m: FloatArray, vehicles: int, max_power_dbm: float
    ) -> None:
        """Refuse what does not fit a step of a radio.

        Parameters
        ----------
        t_s, until_t_s
            Bounds of the interval [s].
        position_m
            What should be (V, 2).
        vehicles
            V.
        max_power_dbm
            The radio's limit [dBm].

        Raises
        ------
        ValueError
            Where positions, times, senders or powers are out of bounds.
        """
        if position_m.shape != (vehicles, 2):
            raise ValueError(f"position_m must be ({vehicles}, 2), got {position_m.shape}")
        if not until_t_s >= t_s:
            raise ValueError(f"until_t_s must not lie before the state's {t_s} s, got {until_t_s}")
        if self.size == 0:
            return
        if self.ready_s[0] < t_s or self.ready_s[-1] >= until_t_s:
            raise ValueError(f"ready_s must lie within {t_s} s..{until_t_s} s, the end excluded")
        if int(self.sender.max()) >= vehicles:
            raise ValueError(f"sender must be below {vehicles}, got {int(self.sender.max())}")
        loudest_dbm = float(self.power_dbm.max())
        if loudest_dbm > max_power_dbm:
            raise ValueError(f"power_dbm must not exceed max_power_dbm = {max_power_dbm}, got {loudest_dbm}")


@dataclass(frozen=True, slots=True)
class Receptions:
    """What arrived in one interval, in order of time.

    Parameters
    ----------
    message_id, sender, receiver
        Which message, from and to which vehicle, (R,).
    t_s
        When its last bit arrived, (R,) [s].
    rssi_dbm
        Received power, (R,) [dBm].
    outcomes
        Pairs of frame and vehicle in reach by distance bin and cause, (bins, len(OUTCOMES)). A frame counts
        in the interval in which it ends.
    expired
        Numbers of the messages never sent: a newer message of the same vehicle took their place, or the
        vehicle was not there, (E,).
    """

    message_id: IntArray
    sender: IntArray
    _: KW_ONLY
    receiver: IntArray
    t_s: FloatArray
    rssi_dbm: FloatArray
    outcomes: IntArray
    expired: IntArray

    @property
    def size(self) -> int:
        """Number of receptions."""
        return self.receiver.size

    @classmethod
    def of_pairs(
        cls,
        transmissions: Transmissions,
        heard: BoolArray,
        *,
        distance_m: FloatArray,
        range_m: float,
        end_s: FloatArray,
        bin_m: float,
    ) -> "Receptions":
        """What arrived where each pair of message and vehicle is decided by itself, without received power.

        A pair that is not heard counts as ``below-sensitivity``.

        Parameters
        ----------
        transmissions
            N messages.
        heard
            Who hears which, (N, V); beyond the range nobody does.
        distance_m
            From sender to vehicle, (N, V) [m]; NaN for the sender itself and who is not there.
        range_m
            Pairs farther apart count as none [m].
        end_s
            When the last bit of each arrives, (N,) [s].
        bin_m
            Width of the bins of distance of the outcomes [m].

        Examples
        --------
        >>> one = Transmissions(
        ...     np.array([0]),
        ...     np.array([0.01]),
        ...     size_bytes=np.array([300]),
        ...     power_dbm=np.array([20.0]),
        ...     message_id=np.array([7]),
        ... )
        >>> found = Receptions.of_pairs(
        ...     one,
        ...     np.array([[False, True, False]]),
        ...     distance_m=np.array([[np.nan, 30.0, 60.0]]),
        ...     range_m=100.0,
        ...     end_s=np.array([0.0104]),
        ...     bin_m=50.0,
        ... )
        >>> found.receiver.tolist(), found.outcomes[:, :3].tolist()
        ([1], [[1, 0, 0], [0, 0, 1]])
        """
        near = distance_m <= range_m
        message, receiver = np.nonzero(heard & near)
        order = np.argsort(end_s[message], kind="stable")
        message, receiver = message[order], receiver[order]
        bins = int(np.ceil(range_m / bin_m))
        outcomes: IntArray = np.zeros((bins, len(OUTCOMES)), dtype=np.int64)
        at = np.minimum((distance_m[near] / bin_m).astype(np.int64), bins - 1)
        lost = np.where(heard[near], OUTCOMES.index("received"), OUTCOMES.index("below-sensitivity"))
        np.add.at(outcomes, (at, lost), 1)
        return cls(
            transmissions.message_id[message],
            transmissions.sender[message],
            receiver=receiver,
            t_s=end_s[message],
            rssi_dbm=np.full(order.size, np.nan),
            outcomes=outcomes,
            expired=transmissions.message_id[:0],
        )

    @classmethod
    def joined(cls, pieces: Sequence["Receptions"], *, outcomes: IntArray, expired: IntArray) -> "Receptions":
        """What arrived in an interval, from what arrived in its spans, one after another.

        Parameters
        ----------
        pieces
            One a span, at least one.
        outcomes, expired
            Of the interval.
        """
        columns = {
            name: np.concatenate([getattr(one, name) for one in pieces])
            for name in ("message_id", "sender", "receiver", "t_s", "rssi_dbm")
        }
        return cls(**columns, outcomes=outcomes, expired=expired)

    def check(self, vehicles: int, since_s: float = -np.inf) -> None:
        """Refuse what no fleet can take in.

        Parameters
        ----------
        vehicles
            Number V of vehicles.
        since_s
            When the interval began [s].

        Raises
        ------
        ValueError
            Where columns differ in length or times fall, something arrived before the interval, a vehicle is
            not there or hears itself, a number is negative, or outcomes have another shape.
        """
        columns = ("message_id", "sender", "receiver", "t_s", "rssi_dbm")
        shapes = {getattr(self, name).shape for name in columns}
        if shapes != {(self.size,)}:
            raise ValueError(f"receptions must have columns of one length, got {sorted(shapes)}")
        if self.outcomes.ndim != 2 or self.outcomes.shape[1] != len(OUTCOMES):
            raise ValueError(f"outcomes must be (bins, {len(OUTCOMES)}), got {self.outcomes.shape}")
        if self._are_in_order(vehicles, since_s):
            return
        for name in ("sender", "receiver"):
            low, high = int(getattr(self, name).min()), int(getattr(self, name).max())
            if low < 0 or high >= vehicles:
                raise ValueError(f"{name} must lie within 0..{vehicles - 1}, got {low}..{high}")
        if int(self.message_id.min()) < 0:
            raise ValueError(f"message_id must not be negative, got {int(self.message_id.min())}")
        if not np.all(np.diff(self.t_s) >= 0.0):
            raise ValueError("t_s must not fall, nor be NaN: sort receptions by time")
        if self.t_s[0] < since_s - _SLACK_S:
            raise ValueError(f"t_s must lie after the interval's start, {since_s} s, got {self.t_s[0]}")
        own = self.sender == self.receiver
        if own.any():
            raise ValueError(f"vehicle {int(self.sender[own][0])} must not receive what it sends itself")

    def _are_in_order(self, vehicles: int, since_s: float) -> bool:
        """Whether nothing is wrong with any row, found out in one go; what is wrong, `check` says."""
        message, sender, receiver = (
            owned(one, np.int64) for one in (self.message_id, self.sender, self.receiver)
        )
        return bool(are_in_order(message, sender, receiver, owned(self.t_s), vehicles, since_s - _SLACK_S))


class AbstractRadio(abc.ABC, Generic[State]):
    """A radio technology shared by a fleet.

    Another package adds its own in the entry-point group ``modelcast.radios`` (`modelcast.channel.registry`).
    """

    __slots__ = ()

    @property
    def bin_m(self) -> float:
        """Width of the bins of distance of `Receptions.outcomes`, 50 m where a radio does not say [m]."""
        return 50.0

    def within(self, propagation: Propagation) -> Self:
        """The radio where waves get from vehicle to vehicle like this.

        Parameters
        ----------
        propagation
            As a scenario has it: buildings along its streets, heights of antennas.

        Notes
        -----
        A radio with a propagation of its own returns itself.
        """
        del propagation
        return self

    @abc.abstractmethod
    def init(self, vehicles: int, rng: np.random.Generator) -> State:
        """State of a silent channel at time 0.

        Parameters
        ----------
        vehicles
            Number V of vehicles; places are given with every step.
        rng
            Seeds the channel's own random numbers; nothing else is drawn from it.
        """

    def fit_antennas(self, state: State, gain_db: FloatArray) -> State:
        """The state with weaker antennas than vehicles have, from here on.

        Parameters
        ----------
        state
            Do not use it again.
        gain_db
            What the antenna of each station adds to a vehicle's, as it hears and as it sends, not above 0,
            (V,) [dB].

        Raises
        ------
        ValueError
            Where gains are not one a station, not finite, or above 0.

        Notes
        -----
        A radio that knows no powers heeds no antennas: this one returns the state as it is.
        """
        checked_gains(gain_db, gain_db.size)
        return state

    @abc.abstractmethod
    def step(
        self, state: State, transmissions: Transmissions, position_m: FloatArray, until_t_s: float
    ) -> tuple[Receptions, State]:
        """Carry one interval, from the state's time to ``until_t_s``; the given state is left alone.

        Parameters
        ----------
        state
            What `init` or the last step returned.
        transmissions
            Messages ready within the interval.
        position_m
            East and north of all vehicles, held for the interval, (V, 2) [m]. A vehicle at NaN is absent: it
            neither sends nor hears.
        until_t_s
            End of the interval [s]. Frames on the air and messages that wait stay in the state.
        """

    def carry(
        self,
        state: State,
        transmissions: Transmissions,
        position_m: FloatArray,
        until_t_s: float,
        parts: Parts = WHOLE,
    ) -> tuple[Receptions, State]:
        """Carry one interval like `step`, and use the given state up where that is faster.

        Parameters
        ----------
        state
            Do not use it again.
        transmissions, position_m, until_t_s
            As for `step`.
        parts
            What may be worked on by several threads; what comes out does not depend on it.
        """
        del parts
        return self.step(state, transmissions, position_m, until_t_s)

    def carry_and_tell(  # noqa: PLR0917 - as `carry`, and whom to tell
        self,
        state: State,
        transmissions: Transmissions,
        position_m: FloatArray,
        until_t_s: float,
        parts: Parts,
        told: Callable[[Receptions], None],
    ) -> tuple[Receptions, State]:
        """Carry one interval like `carry`, and tell of receptions as they come: hosts may read them beside.

        Parameters
        ----------
        state
            Do not use it again.
        transmissions, position_m, until_t_s, parts
            As for `carry`.
        told
            Given receptions of one span of the interval after another, which together are those returned.
            Of a span, ``outcomes`` and ``expired`` say nothing. Called in any thread of the parts; it may put
            work off to them, and all of it is done before this returns.

        Notes
        -----
        A radio that carries the interval as one tells of all at its end.
        """
        received, after = self.carry(state, transmissions, position_m, until_t_s, parts)
        told(received)
        parts.finish()
        return received, after

    @abc.abstractmethod
    def channel_busy_ratio(self, state: State) -> FloatArray:
        """Busy share of the last full measuring window of every vehicle, 0..1, (V,).

        Parameters
        ----------
        state
            As `init` or `step` gave it.
        """
