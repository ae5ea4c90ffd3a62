"""The host vehicle: it holds what arrived, and predicts where every remote is at any time.

The host never sees the truth. An update replaces the remote's models; an identification that names an update
the host does not hold changes nothing; a remote that falls silent expires.
"""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from enum import Enum
from types import MappingProxyType

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.messages.mbc import ModelUpdate, SubModelIdentification
from modelcast.models.bank import Bank
from modelcast.station.receiver.plausibility import Finding, Plausibility, PlausibilityState
from modelcast.station.receiver.statements import Statements

__all__ = ["Host", "HostState", "Receipt", "RemoteTrack", "Tracks"]

_CLOCK_ERROR_S = 1.0
"""A message dated later than its arrival by more than this is refused: it would lock out all that follow."""

_REACH_M = 2e7
"""No place on Earth is farther than this from another."""

_IDS = 2**32
"""Temporary ids have four bytes, as in SAE J2735."""

_VELOCITY = ("velocity_east_mps", "velocity_north_mps")
"""Parameters of a sub-model that states the velocity outright."""

_INTERVALS_S = (1e-3, 10.0)
_LONGEST_LOOK_S = 60.0


class Receipt(Enum):
    """What became of a received message."""

    ACCEPTED = "accepted"
    OLDER = "older than what is held"
    UNKNOWN_UPDATE = "names an update that never arrived"
    MALFORMED = "not a possible message"
    IN_FUTURE = "dated in the future"
    STALE = "too old on arrival, as if replayed"
    REPEATED = "of an instant already told"
    POSITION_JUMP = "farther from the last position than a vehicle gets"
    SPEED_MISMATCH = "states a speed that its positions contradict"
    STUCK_SPEED = "states the same speed on and on, and its positions contradict it"


_RECEIPTS = {
    Finding.IN_FUTURE: Receipt.IN_FUTURE,
    Finding.STALE: Receipt.STALE,
    Finding.REPEATED: Receipt.REPEATED,
    Finding.OVERTAKEN: Receipt.OLDER,
    Finding.POSITION_JUMP: Receipt.POSITION_JUMP,
    Finding.SPEED_MISMATCH: Receipt.SPEED_MISMATCH,
    Finding.STUCK_SPEED: Receipt.STUCK_SPEED,
}


@dataclass(frozen=True, slots=True)
class RemoteTrack:
    """What the host holds of one remote.

    Parameters
    ----------
    update
        The newest model update received.
    in_use
        Sub-model in use, by the newest message that named one.
    named_s
        When that message was sent [s].
    received_s
        When its last message arrived [s].
    """

    update: ModelUpdate
    in_use: int
    _: KW_ONLY
    named_s: float
    received_s: float


def _no_remotes() -> Mapping[int, RemoteTrack]:
    return MappingProxyType({})


@dataclass(frozen=True, slots=True)
class HostState:
    """Everything the host holds.

    Parameters
    ----------
    remotes
        One track a remote, by temporary id.
    plausibility
        What the remotes said before and what was found, where the host checks that; None before the first.
    """

    remotes: Mapping[int, RemoteTrack] = field(default_factory=_no_remotes)
    plausibility: PlausibilityState | None = None


@dataclass(frozen=True, slots=True)
class Tracks:
    """Where the remotes are believed to be at one time; V of them, by rising id.

    Parameters
    ----------
    vehicle
        Temporary ids, (V,).
    position_m
        East and north, (V, 2) [m].
    information_age_s
        Age of each remote's models, (V,) [s].
    in_use
        Sub-model that predicts each, (V,).
    """

    vehicle: IntArray
    position_m: FloatArray
    _: KW_ONLY
    information_age_s: FloatArray
    in_use: IntArray


@dataclass(frozen=True, slots=True)
class Host:
    """Tracks all remotes from their messages alone.

    Parameters
    ----------
    bank
        The sub-models that the remotes broadcast.
    expiry_s
        Silence after which a remote is dropped [s]; infinite for never.
    plausibility
        Refuse what it finds implausible, and count it; None for no such checks.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> host = Host(Bank((ConstantVelocity(),)), expiry_s=3.0)
    >>> moving = ModelUpdate(
    ...     7, 0, 0.0, position_m=np.zeros(2), in_use=0, parameters=np.array([10.0, 0.0]), dt_s=0.1
    ... )
    >>> receipt, state = host.receive(HostState(), moving, received_s=0.0)
    >>> host.predict(state, 1.5).position_m.tolist(), host.predict(state, 4.0).vehicle.size
    ([[15.0, 0.0]], 0)
    """

    bank: Bank
    expiry_s: float = 5.0
    plausibility: Plausibility | None = None

    def __post_init__(self) -> None:
        if not self.expiry_s > 0:
            raise ValueError(f"expiry_s must be positive, got {self.expiry_s}")

    def receive(
        self, state: HostState, message: ModelUpdate | SubModelIdentification, *, received_s: float
    ) -> tuple[Receipt, HostState]:
        """Take one message in; returns what became of it and the new state.

        Parameters
        ----------
        state
            What is held.
        message
            As decoded from the air; nothing in it is trusted before it is checked.
        received_s
            When it arrived [s].
        """
        if not self._is_possible(message, received_s):
            return Receipt.MALFORMED, state
        if self.plausibility is not None:
            finding, state = self._judge(self.plausibility, state, message, received_s)
            if finding is not Finding.PLAUSIBLE:
                return _RECEIPTS[finding], state
        # An expired remote is forgotten: an identification does not bring it back.
        live = self._live(state, received_s)
        if isinstance(message, ModelUpdate):
            receipt, taken = self._update(live, message, received_s)
        else:
            receipt, taken = self._identify(live, message, received_s)
        return receipt, state if taken is live else taken

    def predict(self, state: HostState, t_s: float) -> Tracks:
        """Where every remote is believed to be; expired ones are left out.

        Parameters
        ----------
        state
            What is held.
        t_s
            Any time from the newest message on [s].
        """
        live = {
            vehicle: track
            for vehicle, track in sorted(state.remotes.items())
            if t_s - track.received_s <= self.expiry_s
        }
        position_m = np.empty((len(live), 2))
        age_s = np.empty(len(live))
        for row, track in enumerate(live.values()):
            update = track.update
            age_s[row] = t_s - update.t_s
            parameters = np.concatenate([[track.in_use], update.parameters])[None]
            moved = self.bank.predict_at(parameters, age_s[row : row + 1], dt_s=update.dt_s)
            position_m[row] = update.position_m + moved[0]
        return Tracks(
            np.array(list(live), dtype=np.int64),
            position_m,
            information_age_s=age_s,
            in_use=np.array([track.in_use for track in live.values()], dtype=np.int64),
        )

    def _update(self, state: HostState, message: ModelUpdate, received_s: float) -> tuple[Receipt, HostState]:
        held = state.remotes.get(message.vehicle)
        if held is not None and message.t_s <= held.update.t_s:
            return Receipt.OLDER, state
        track = RemoteTrack(message, message.in_use, named_s=message.t_s, received_s=received_s)
        return Receipt.ACCEPTED, _with(state, message.vehicle, track)

    def _identify(
        self, state: HostState, message: SubModelIdentification, received_s: float
    ) -> tuple[Receipt, HostState]:
        held = state.remotes.get(message.vehicle)
        if held is None:
            return Receipt.UNKNOWN_UPDATE, state
        if message.sequence != held.update.sequence:
            # It still tells that the remote is alive.
            return Receipt.UNKNOWN_UPDATE, _with(state, message.vehicle, replace(held, received_s=received_s))
        if message.t_s <= held.named_s:
            return Receipt.OLDER, state
        if not self._predicts(held.update, message.in_use):
            return Receipt.MALFORMED, state
        named = replace(held, in_use=message.in_use, named_s=message.t_s, received_s=received_s)
        return Receipt.ACCEPTED, _with(state, message.vehicle, named)

    def _is_possible(self, message: ModelUpdate | SubModelIdentification, received_s: float) -> bool:
        """Whether the message is one that a sender of this bank can send at all."""
        if not (
            0 <= message.vehicle < _IDS
            and 0 <= message.in_use < len(self.bank.members)
            and np.isfinite(message.t_s)
            and message.t_s <= received_s + _CLOCK_ERROR_S
        ):
            return False
        if isinstance(message, SubModelIdentification):
            return True
        return bool(
            message.parameters.shape == (len(self.bank.parameter_names) - 1,)
            and np.isfinite(message.parameters).all()
            and message.position_m.shape == (2,)
            and (np.abs(message.position_m) <= _REACH_M).all()
            and _INTERVALS_S[0] <= message.dt_s <= _INTERVALS_S[1]
            and self._predicts(message, message.in_use)
        )

    def _predicts(self, update: ModelUpdate, member: int) -> bool:
        """Whether the sub-model gives a place on Earth for as long as it may be asked."""
        ages_s = np.array([0.0, min(self.expiry_s, _LONGEST_LOOK_S)])
        parameters = np.concatenate([[member], update.parameters])[None]
        moved = self.bank.predict(parameters, ages_s, dt_s=update.dt_s)
        return bool((np.abs(moved) <= _REACH_M).all())

    def _judge(
        self,
        plausibility: Plausibility,
        state: HostState,
        message: ModelUpdate | SubModelIdentification,
        received_s: float,
    ) -> tuple[Finding, HostState]:
        """What is found of a possible message, and the state that remembers it."""
        before = state.plausibility or PlausibilityState()
        t_s, arrived_s = np.array([message.t_s]), np.array([received_s])
        if isinstance(message, SubModelIdentification):
            found, after = plausibility.check_times(before, t_s, arrived_s)
        else:
            reports = Statements(
                np.array([message.vehicle]),
                t_s,
                position_m=message.position_m[None],
                velocity_mps=self._velocity_mps(message)[None],
                received_s=arrived_s,
            )
            found, after = plausibility.check(before, reports)
        return Finding(found[0]), replace(state, plausibility=after)

    def _velocity_mps(self, update: ModelUpdate) -> FloatArray:
        """Velocity stated outright, or that in use over the first sampling interval, (2,) [m/s]."""
        for member, begin in zip(self.bank.members, self.bank.offsets, strict=False):
            if member.parameter_names == _VELOCITY:
                return update.parameters[begin : begin + 2]
        parameters = np.concatenate([[update.in_use], update.parameters])[None]
        moved = self.bank.predict_at(parameters, np.array([update.dt_s]), dt_s=update.dt_s)
        return moved[0] / update.dt_s

    def _live(self, state: HostState, t_s: float) -> HostState:
        """The state without the remotes that have expired."""
        live = {
            vehicle: track
            for vehicle, track in state.remotes.items()
            if t_s - track.received_s <= self.expiry_s
        }
        return replace(state, remotes=MappingProxyType(live))


def _with(state: HostState, vehicle: int, track: RemoteTrack) -> HostState:
    return replace(state, remotes=MappingProxyType({**state.remotes, vehicle: track}))
