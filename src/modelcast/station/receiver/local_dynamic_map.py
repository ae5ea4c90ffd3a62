"""The local dynamic map: what a host holds of all remotes, and where it believes them to be at any time.

It never sees the truth. Messages go in as arrays (`Heard`), beliefs come out as arrays (`Beliefs`); no
remote and no message is looked at one by one outside a compiled loop.
"""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, replace
from enum import IntEnum
from functools import cached_property
from types import MappingProxyType

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray, owned
from modelcast.core.exceptions import SubModelError
from modelcast.core.kinds import Kind
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.calibration import Calibration
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.heard_functions import heard_functions, tell_failure
from modelcast.models.members import ReadyBank
from modelcast.models.payload import CORE_PARAMETERS
from modelcast.models.profile import people_plain_bank
from modelcast.station.receiver import belief_kernels, hearing_kernels, slot_kernels
from modelcast.station.receiver.heard import Heard
from modelcast.station.receiver.heard_kernels import Messages
from modelcast.station.receiver.plausibility import Plausibility
from modelcast.station.receiver.plausibility_kernels import COLUMNS
from modelcast.station.receiver.plausibility_limits import DEFAULT_LIMITS
from modelcast.station.receiver.track_kernels import HELD_FIT_S, HELD_MEMBER, HELD_RECEIVED_S, TRACK_COLUMNS

__all__ = ["Beliefs", "LocalDynamicMap", "MapState", "Receipt"]

_INTERVALS_S = (1e-3, 10.0)
_AGES_S = np.concatenate([[0.0], np.geomspace(0.1, 3600.0, 111)])
_COASTING = ConstantVelocity()


class Receipt(IntEnum):
    """What became of a received message."""

    ACCEPTED = 0
    OLDER = 1
    UNKNOWN_UPDATE = 2
    IN_FUTURE = 3
    STALE = 4
    REPEATED = 5
    MALFORMED = 6
    POSITION_JUMP = 7
    SPEED_MISMATCH = 8
    STUCK_SPEED = 9
    OTHER_KIND = 10

    @property
    def reason(self) -> str:
        """In words."""
        return _REASONS[self]


_REASONS = (
    "accepted",
    "older than what is held",
    "names an update that never arrived",
    "dated in the future",
    "too old on arrival, as if replayed",
    "of an instant already told",
    "not a possible message",
    "farther from the last position than a vehicle gets",
    "states a speed that its positions contradict",
    "states the same speed on and on, and its positions contradict it",
    "of a person under a tracked vehicle's temporary id, or of a vehicle under a person's",
)


@dataclass(frozen=True, slots=True, eq=False)
class MapState:
    """Everything a map holds, C slots of one remote each; `LocalDynamicMap.hear` writes into it.

    Parameters
    ----------
    held, told, facts, parameters, judged, lookup, ends
        As `slot_kernels.Slots` has them.
    receipts
        Messages of each `Receipt`, (10,).
    events
        Updates taken by Part I alone, live tracks that gave way, tracks that ended by a new id, (3,).
    """

    held: FloatArray
    told: FloatArray
    facts: IntArray
    _: KW_ONLY
    parameters: FloatArray
    judged: FloatArray
    lookup: IntArray
    ends: IntArray
    receipts: IntArray
    events: IntArray

    @property
    def slots(self) -> slot_kernels.Slots:
        """The tables, as compiled loops take them."""
        return slot_kernels.Slots(
            self.held, self.told, self.facts, self.parameters, self.judged, self.lookup, self.ends
        )

    @property
    def by_receipt(self) -> Mapping[Receipt, int]:
        """Messages of each receipt that occurred."""
        return MappingProxyType({one: int(self.receipts[one]) for one in Receipt if self.receipts[one]})

    @property
    def by_part_i(self) -> int:
        """Updates accepted whose profile is not held here, and plain messages: Part I alone predicts."""
        return int(self.events[hearing_kernels.BY_PART_I])

    @property
    def gave_way(self) -> int:
        """Live tracks that gave their slot to another remote: the map is too small."""
        return int(self.events[hearing_kernels.GAVE_WAY])

    @property
    def renamed(self) -> int:
        """Tracks that ended since their remote goes on under another temporary id."""
        return int(self.events[hearing_kernels.RENAMED])


@dataclass(frozen=True, slots=True, eq=False)
class Beliefs:
    """What is believed of the remotes at one time; N of them, by rising id.

    Parameters
    ----------
    vehicle
        Temporary ids, (N,).
    position_m, velocity_mps
        East and north, (N, 2) [m], [m/s].
    speed_mps, heading_rad
        Heading clockwise from north, 0 to 2π; as stated where the remote stands, NaN where it stated none,
        (N,).
    acceleration_mps2, yaw_rate_radps
        Along the course; clockwise, (N,).
    covariance_m2
        Of the position, (N, 2, 2) [m²].
    information_age_s
        Since the fit, (N,) [s].
    received_s
        Arrival of the last message that renewed the track, (N,) [s].
    in_use, profile
        Sub-model that predicts, of which profile held; profile -1 is Part I alone, (N,).
    length_m, width_m
        NaN where unknown, (N,) [m].
    kind
        Of road user as heard, values of `modelcast.core.kinds.Kind`; who did not say is a vehicle, (N,).
    """

    vehicle: IntArray
    position_m: FloatArray
    velocity_mps: FloatArray
    _: KW_ONLY
    speed_mps: FloatArray
    heading_rad: FloatArray
    acceleration_mps2: FloatArray
    yaw_rate_radps: FloatArray
    covariance_m2: FloatArray
    information_age_s: FloatArray
    received_s: FloatArray
    in_use: IntArray
    profile: IntArray
    length_m: FloatArray
    width_m: FloatArray
    kind: IntArray


@dataclass(frozen=True)
class LocalDynamicMap:
    """Tracks all remotes from their messages alone.

    Parameters
    ----------
    profiles
        Bank of each profile held, in the forms that messages carry (`Bank.carried`).
        Plain messages, and those of any other profile, are taken by Part I alone. They are coasted as the
        first of these banks says (`Bank.plain_place`); at constant velocity where none does.
    expiry_s
        Silence after which a remote is dropped [s]; infinite for never.
    plausibility
        Refuse what it finds implausible; None for no such checks.
    capacity
        Remotes that there is room for. When full, the one longest unheard gives way.
    dt_s
        Sampling interval of the profiles [s].
    max_ahead_s
        Messages dated later than their arrival by more than this are refused [s].
    max_age_s
        So are those older than this on arrival [s]; infinite for none. Ours: no queue lasts so long.
    calibrations
        Calibrations of each profile's sub-models by name; empty for none at all.

    Raises
    ------
    ValueError
        Where a setting is out of its range.

    Examples
    --------
    >>> from modelcast.messages.mbc import ModelUpdate
    >>> from modelcast.station.receiver.heard import heard_messages
    >>> around = LocalDynamicMap((Bank((ConstantVelocity(),)),), expiry_s=3.0)
    >>> moving = ModelUpdate(
    ...     7, 0, 0.0, position_m=np.zeros(2), in_use=0, parameters=np.array([10.0, 0.0]), dt_s=0.1
    ... )
    >>> receipts, state = around.hear(around.init(), heard_messages([moving], [0.0]))
    >>> Receipt(receipts[0]).name, around.believe(state, 1.5).position_m.tolist()
    ('ACCEPTED', [[15.0, 0.0]])
    >>> around.believe(state, 4.0).vehicle.size
    0
    """

    profiles: tuple[Bank, ...] = ()
    expiry_s: float = 5.0
    plausibility: Plausibility | None = None
    _: KW_ONLY
    capacity: int = 2000
    dt_s: float = 0.1
    max_ahead_s: float = 1.0
    max_age_s: float = 10.0
    calibrations: tuple[Mapping[str, Calibration], ...] = ()

    def __post_init__(self) -> None:
        for name in ("expiry_s", "max_ahead_s", "max_age_s"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        if not _INTERVALS_S[0] <= self.dt_s <= _INTERVALS_S[1]:
            raise ValueError(f"dt_s must be from {_INTERVALS_S[0]} to {_INTERVALS_S[1]}, got {self.dt_s}")
        if self.capacity < 1:
            raise ValueError(f"capacity must be at least 1, got {self.capacity}")
        if self.calibrations and len(self.calibrations) != len(self.profiles):
            raise ValueError(
                f"calibrations must be none or one for each of {len(self.profiles)} profiles, "
                f"got {len(self.calibrations)}"
            )

    def init(self) -> MapState:
        """A map that holds nothing."""
        count = self.capacity
        receipts, events = (
            np.zeros(many, dtype=np.int64) for many in (hearing_kernels.STATUSES, hearing_kernels.EVENTS)
        )
        return MapState(
            np.full((count, TRACK_COLUMNS), -1.0),
            np.full((count, slot_kernels.TOLD_COLUMNS), np.nan),
            np.full((count, slot_kernels.FACT_COLUMNS), -1, dtype=np.int64),
            parameters=np.zeros((count, self._widest)),
            judged=np.full((count, COLUMNS), np.nan),
            lookup=np.full(2 << (count - 1).bit_length(), -1, dtype=np.int64),
            ends=np.array([0, -1, -1]),
            receipts=receipts,
            events=events,
        )

    def hear(self, state: MapState, heard: Heard) -> tuple[IntArray, MapState]:
        """Take messages in: the `Receipt` of each, (K,), and the new state. The given state is used up.

        To keep a state, hear with a copy of it (`modelcast.channel.frame_radio.copied`).

        Parameters
        ----------
        state
            What is held.
        heard
            As decoded from the air. New ids among them compete for the tracks that have fallen silent.
        """
        parameters = heard.parameters
        if parameters.shape[1] < self._widest:
            parameters = np.full((heard.kind.size, self._widest), np.nan)
            parameters[:, : heard.parameters.shape[1]] = heard.parameters
        out = np.empty(heard.kind.size, dtype=np.int64)
        hearing_kernels.hear_each(
            Messages(
                owned(heard.codes, np.int64), owned(heard.numbers), owned(parameters[:, : self._widest])
            ),
            state.slots,
            self.known,
            self.rules,
            state.receipts,
            state.events,
            out,
        )
        return out, state

    def fit_s(self, state: MapState, vehicle: IntArray) -> FloatArray:
        """Instant of the fit that is held of remotes, NaN where nothing is, (K,) [s].

        Parameters
        ----------
        state
            What is held.
        vehicle
            Temporary ids, (K,).
        """
        out = np.empty(vehicle.size)
        slot_kernels.fit_times(state.slots, owned(vehicle, np.int64), out)
        return out

    def positions(self, state: MapState, t_s: float) -> tuple[IntArray, FloatArray]:
        """Temporary ids of all live remotes, rising, (N,), and where they are believed to be, (N, 2) [m].

        Parameters
        ----------
        state
            What is held.
        t_s
            Any time from the newest message on [s].
        """
        which = self._live(state, t_s)
        out = np.empty((which.size, 2))
        belief_kernels.predict_places(state.slots, self.known, which, t_s, out)
        return state.facts[which, slot_kernels.FACT_VEHICLE], out

    def motions(self, state: MapState, t_s: float) -> tuple[IntArray, FloatArray]:
        """Temporary ids of all live remotes, rising, (N,), and how they are believed to move, (N, 8).

        Parameters
        ----------
        state
            What is held.
        t_s
            Any time from the newest message on [s].

        Returns
        -------
        tuple[IntArray, FloatArray]
            East, north [m], their velocities [m/s], and from column `belief_kernels.BELIEF_SPEED` on speed
            [m/s], heading [rad], acceleration [m/s²] and yaw rate [rad/s].
        """
        which = self._live(state, t_s)
        motion = np.empty((which.size, belief_kernels.BELIEF_COLUMNS))
        belief_kernels.predict_motions(state.slots, self.known, which, t_s, motion)
        return state.facts[which, slot_kernels.FACT_VEHICLE], motion

    def paths(self, state: MapState, t_s: float, ahead_s: FloatArray) -> FloatArray:
        """Where all remotes that are live at a time are believed to be later, by rising id, (N, H, 2) [m].

        Parameters
        ----------
        state
            What is held.
        t_s
            Any time from the newest message on [s].
        ahead_s
            How much later, (H,) [s].
        """
        which = self._live(state, t_s)
        out, places = np.empty((which.size, ahead_s.size, 2)), np.empty((which.size, 2))
        for at, later_s in enumerate(ahead_s.tolist()):
            belief_kernels.predict_places(state.slots, self.known, which, t_s + later_s, places)
            out[:, at] = places
        return out

    def believe(self, state: MapState, t_s: float) -> Beliefs:
        """What is believed of all live remotes.

        Velocity, acceleration and yaw rate are central differences of the sub-model's own path.

        Parameters
        ----------
        state
            What is held.
        t_s
            Any time from the newest message on [s].
        """
        which = self._live(state, t_s)
        motion = np.empty((which.size, belief_kernels.BELIEF_COLUMNS))
        belief_kernels.predict_motions(state.slots, self.known, which, t_s, motion)
        held, told, facts = state.held[which], state.told[which], state.facts[which]
        in_use, profile = held[:, HELD_MEMBER].astype(np.int64), facts[:, slot_kernels.FACT_PROFILE]
        age_s = t_s - held[:, HELD_FIT_S]
        return Beliefs(
            facts[:, slot_kernels.FACT_VEHICLE],
            motion[:, :2],
            motion[:, 2:4],
            speed_mps=motion[:, belief_kernels.BELIEF_SPEED],
            heading_rad=motion[:, belief_kernels.BELIEF_HEADING],
            acceleration_mps2=motion[:, belief_kernels.BELIEF_ACCELERATION],
            yaw_rate_radps=motion[:, belief_kernels.BELIEF_YAW_RATE],
            covariance_m2=self._covariance(state.parameters[which], profile, in_use, age_s),
            information_age_s=age_s,
            received_s=held[:, HELD_RECEIVED_S],
            in_use=in_use,
            profile=profile,
            length_m=told[:, slot_kernels.TOLD_LENGTH],
            width_m=told[:, slot_kernels.TOLD_WIDTH],
            kind=np.maximum(facts[:, slot_kernels.FACT_USER], Kind.VEHICLE),
        )

    @cached_property
    def model_names(self) -> tuple[tuple[str, ...], ...]:
        """Names of the sub-models of Part I alone, then of each profile: of `Beliefs.profile` + 1."""
        return tuple(tuple(member.name for member in bank.members) for bank in self._banks)

    @cached_property
    def _banks(self) -> tuple[Bank, ...]:
        """Part I, then the profiles held."""
        return (Bank((self._part_i,)), *self.profiles)

    @cached_property
    def _teaches(self) -> int:
        """Place of the profile that says what a vehicle's plain message is coasted by, -1 for none."""
        theirs = people_plain_bank()
        taught = (at for at, bank in enumerate(self.profiles) if bank.plain_place >= 0 and bank is not theirs)
        return next(taught, -1)

    @cached_property
    def _part_i(self) -> AbstractSubModel:
        """What a plain message is coasted by."""
        if self._teaches < 0:
            return _COASTING
        bank = self.profiles[self._teaches]
        return bank.members[bank.plain_place]

    @cached_property
    def _widest(self) -> int:
        return max(int(bank.offsets[-1]) for bank in self._banks)

    @cached_property
    def _ready(self) -> ReadyBank:
        """The members of all banks in one table."""
        ready = ReadyBank.joined([ReadyBank.of(bank, self.dt_s) for bank in self._banks])
        return replace(ready, functions=tuple(heard_functions(one) for one in ready.functions))

    @cached_property
    def _first(self) -> IntArray:
        return np.cumsum([0] + [len(bank.members) for bank in self._banks], dtype=np.int64)

    @property
    def known(self) -> slot_kernels.KnownProfiles:
        """Sub-models of all profiles as compiled loops take them, in this process alone."""
        names = self._part_i.parameter_names
        stated = [CORE_PARAMETERS.index(name) if name in CORE_PARAMETERS else -1 for name in names]
        return slot_kernels.KnownProfiles(self._ready.members, self._first, np.array(stated))

    @cached_property
    def rules(self) -> hearing_kernels.Rules:
        """Settings as compiled loops take them."""
        checks = self.plausibility
        return hearing_kernels.Rules(
            float(self.expiry_s),
            float(self.max_ahead_s),
            float(self.max_age_s),
            float(self.dt_s),
            checks is not None,
            np.inf if checks is None else float(checks.memory_s),
            (DEFAULT_LIMITS if checks is None else checks.limits).numbers,
        )

    def _live(self, state: MapState, t_s: float) -> IntArray:
        """Slots of the live remotes, by rising id."""
        which = belief_kernels.live_slots(state.slots, float(t_s), float(self.expiry_s))
        return which[np.argsort(state.facts[which, slot_kernels.FACT_VEHICLE], kind="stable")]

    def _covariance(
        self, parameters: FloatArray, profile: IntArray, in_use: IntArray, age_s: FloatArray
    ) -> FloatArray:
        """Covariance of each place, (N, 2, 2) [m²]; that of constant velocity where a model's own is none."""
        spread_m = 0.5 * _COASTING.acceleration_spread_mps2 * age_s**2
        coasting = spread_m[:, None, None] ** 2 * np.eye(2)
        out = np.empty((age_s.size, 2, 2))
        member = self._first[profile + 1] + in_use
        for m in np.unique(member):
            rows = np.flatnonzero(member == m)
            out[rows] = self._spread(
                int(profile[rows[0]]), int(in_use[rows[0]]), parameters[rows], age_s[rows]
            )
        least_m2 = np.minimum(out[:, 0, 0], out[:, 1, 1])
        unsound: BoolArray = ~(np.isfinite(out.sum(axis=(1, 2))) & (least_m2 >= 0.0))
        out[unsound] = coasting[unsound]
        return out

    def _spread(self, profile: int, in_use: int, parameters: FloatArray, age_s: FloatArray) -> FloatArray:
        """Covariances by one sub-model at the age of each row, (B, 2, 2) [m²].

        A sub-model gives those of all rows at given ages. It is asked at the least and the greatest age
        within each interval of a geometric row of ages (a tenth apart); between them it is interpolated.
        """
        bank = self._banks[profile + 1]
        model, own = bank.members[in_use], parameters[:, bank.offsets[in_use] : bank.offsets[in_use + 1]]
        source = profile if profile >= 0 else self._teaches
        calibrated = self.calibrations[source].get(model.name) if self.calibrations and source >= 0 else None
        out = np.empty((age_s.size, 2, 2))
        ages_s = np.maximum(age_s, 0.0)
        interval = np.searchsorted(_AGES_S, ages_s, side="right")
        for one in np.unique(interval):
            rows = np.flatnonzero(interval == one)
            ends_s = np.array([ages_s[rows].min(), ages_s[rows].max()])
            asked = np.ascontiguousarray(own[rows])
            with np.errstate(all="ignore"):
                try:
                    if calibrated is None:
                        at_ends = model.covariance(asked, ends_s, dt_s=self.dt_s)
                    else:
                        at_ends = calibrated.covariance(model, asked, ends_s, dt_s=self.dt_s)
                except SubModelError as error:
                    tell_failure(error)
                    out[rows] = np.nan
                    continue
                share = (ages_s[rows] - ends_s[0]) / max(ends_s[1] - ends_s[0], 1e-12)
                # Where both ends are infinite this is no number, and the caller sees that.
                out[rows] = at_ends[:, 0] + share[:, None, None] * (at_ends[:, 1] - at_ends[:, 0])
        return out
