"""Stations for other programs: a notebook, a loop over a traffic simulator, another simulator's callback.

`Fleet` holds many stations on one clock, `Station` one on its own. Both own their state; beneath them are the
compiled steps that evaluation and network run, so what they send is what is evaluated and simulated.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.chance import child_generator
from modelcast.core.geodesy import Origin
from modelcast.core.geodesy_kernels import FARTHEST_M
from modelcast.station.arrays import MEASURED
from modelcast.station.banks import calibrations_of, profile_number_of
from modelcast.station.context.knowledge import Knowledge
from modelcast.station.context.road import NO_ROADS
from modelcast.station.context.road_kernels import Roads
from modelcast.station.policy.neighbours import neighbour_tables
from modelcast.station.receiver.deliveries import Deliveries, deliveries_of
from modelcast.station.receiver.ears import Ears
from modelcast.station.receiver.local_dynamic_map import Beliefs, MapState
from modelcast.station.sender.deciding import Deciding, deciding_of
from modelcast.station.sender.message_arrays import MESSAGES_KEPT, SENDER_BITS, contents, outbox, sent_tally
from modelcast.station.sender.octets import StationOctets, messages_of
from modelcast.station.sender.posting_kernels import StepInputs
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.station.sender.sending_kernels import send_each
from modelcast.station.sender.stations import guards_of, sender_bank, sending_stations, widest
from modelcast.station.sensing.sensing import NOWHERE, Sensing
from modelcast.station.sensing.sensing_kernels import forget_each, sense
from modelcast.station.sensing.streaming import observe_newest
from modelcast.station.sensing.velocity import DEFAULT_FROM_POSITIONS, REPORTED

__all__ = ["Fleet", "Sending"]

_IDS = 2**32
"""Temporary ids there are: four octets."""

_FARTHEST_M = FARTHEST_M - 1000.0
"""A filter may place a station a little farther off than it measured, and messages state that place."""

_OPTIONAL = ("speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps")


@dataclass(frozen=True, slots=True)
class Sending:
    """One message on its way to the radio.

    Parameters
    ----------
    vehicle
        Who sends it.
    octets
        The message in its frame, without security header and lower layers.
    send_s
        When it is to be handed to the radio [s].
    frame_bytes
        Bytes of the frame on the air, security header and lower layers counted.
    power_dbm
        Transmit power [dBm].
    kind
        `modelcast.station.policy.base.MessageKind`.
    next_s
        When the sender expects its next message, infinite where it does not know [s].
    grant
        Which `modelcast.channel.radio.Grant` it asks for.
    """

    vehicle: int
    octets: bytes
    send_s: float
    frame_bytes: int
    power_dbm: float
    kind: int
    next_s: float
    grant: int


class Fleet:
    """Many stations that measure on one clock.

    Parameters
    ----------
    sender
        What every station sends, and when: a name of `modelcast.station.sender.sender.SENDERS`, or a
        `Sender`, which also says of which kind of road user they are.
    slots
        Most vehicles at a time.
    dt_s
        Time between measurements [s].
    origin
        Of the plane positions are on.
    seed
        Of all random numbers. Same seed, same bytes.
    minute_s
        Time at which some minute of UTC began [s].
    ears
        How stations hear; None for hosts that hold the sender's own bank.
    spread_s
        New stations of the first step begin to send within this time [s].
    roads
        Roads that all stations remember beside those they drove, for a bank that reads context.

    Raises
    ------
    ValueError
        Where a number is out of its range.

    Examples
    --------
    A loop over a simulator's vehicles; every message goes to the radio, and what arrives comes back by
    `hear`:

    >>> fleet = Fleet("mbc", slots=2)
    >>> for step in range(30):
    ...     east = np.array([15.0 * 0.1 * step, 12.0 * 0.1 * step])
    ...     sent = fleet.sense(
    ...         0.1 * step,
    ...         np.array([3, 8]),
    ...         np.stack([east, np.zeros(2)], axis=1),
    ...         speed_mps=np.array([15.0, 12.0]),
    ...         heading_rad=np.full(2, np.pi / 2),
    ...     )
    ...     for one in sent:
    ...         for host in {3, 8} - {one.vehicle}:
    ...             receipts = fleet.hear(host, [one.octets], received_s=[one.send_s])
    >>> fleet.believe(3, 3.0).vehicle.tolist(), fleet.believe(3, 3.0).position_m.round(1).tolist()
    ([8], [[36.0, 0.0]])
    """

    def __init__(
        self,
        sender: str | Sender = "mbc",
        *,
        slots: int,
        dt_s: float = 0.1,
        origin: Origin = NOWHERE,
        seed: int = 0,
        minute_s: float = 0.0,
        ears: Ears | None = None,
        spread_s: float = 0.0,
        roads: Roads = NO_ROADS,
    ) -> None:
        if slots < 1:
            raise ValueError(f"slots must be at least 1, got {slots}")
        self.sender = named_sender(sender) if isinstance(sender, str) else sender
        self.dt_s, self.origin = dt_s, origin
        self._rng = np.random.default_rng(seed)
        self._phase = self._rng.random(slots) if slots > 1 else np.zeros(slots)
        self._bank = sender_bank(self.sender, dt_s)
        self._guards = guards_of(self.sender, self._bank)
        self._seed = seed
        self._deciding: Deciding | None = None
        self._spread_s, self._minute_s = spread_s, minute_s
        self._writer = StationOctets.of(
            self._bank.bank,
            profile_number_of(self.sender.bank),
            self.sender.lanes.identify,
            origin,
            minute_s=minute_s,
            kind=self.sender.kind,
        )
        own = self.sender.bank
        self._ears = Ears((own,), dt_s=dt_s, calibrations=(calibrations_of(own),)) if ears is None else ears
        self._heard: dict[int, MapState] = {}
        self._before: dict[int, int] = {}
        self._tables = neighbour_tables(slots, min(self._ears.capacity, 2**15 - 1), phase_s=self._phase)
        self._outbox, self._tally = outbox(slots), sent_tally()
        self._contents = contents(slots, widest(self.sender, self._bank))
        self._vehicle = np.full(slots, -1, dtype=np.int64)
        self._measures = np.zeros(slots, dtype=np.bool_)
        self._new = np.zeros(slots, dtype=np.bool_)
        self._given: tuple[bool, ...] | None = None
        self._last_s = -np.inf
        self._knowledge = Knowledge(slots, shared=roads) if self._bank.ready.reads_context else None

    def sense(
        self,
        t_s: float,
        vehicle: IntArray,
        position_m: FloatArray,
        *,
        speed_mps: FloatArray | None = None,
        heading_rad: FloatArray | None = None,
        acceleration_mps2: FloatArray | None = None,
        yaw_rate_radps: FloatArray | None = None,
        channel_busy_ratio: FloatArray | None = None,
        begins: BoolArray | None = None,
    ) -> list[Sending]:
        """Take in what all vehicles measure at one time, and return what they send until the next.

        Parameters
        ----------
        t_s
            Now, later than the last call [s].
        vehicle
            Who they are, each once, (N,) in 0 to 2^32 - 1: their temporary ids. Who is missing has left.
        position_m
            East and north, (N, 2), within 499 km of the origin [m].
        speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps
            (N,) each, heading and yaw rate clockwise; the same ones in every call. What is not measured is
            estimated from past positions.
        channel_busy_ratio
            As each radio measured it, (N,); None for a free channel.
        begins
            Whose measurement does not connect with those before, (N,), as after a jump of the receiver; gaps
            are seen by themselves.

        Raises
        ------
        ValueError
            Where time does not increase, a value is missing or no number, a position is too far, vehicles
            repeat or are too many; nothing has changed then.
        """
        columns = (speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps)
        measured = self._measured(t_s, vehicle, position_m, columns)
        for name, column in (("channel_busy_ratio", channel_busy_ratio), ("begins", begins)):
            if column is not None and column.shape != vehicle.shape:
                raise ValueError(f"{name} must be ({vehicle.size},), got {column.shape}")
        self._check_room(vehicle)
        if self._given is None:
            self._start(tuple(column is not None for column in columns))
        slot, started = self._slots(vehicle)
        stations = self._stations._replace(models=self._bank.models(self._guards))
        stations.senders.vehicle[:] = np.where(self._measures, self._vehicle, -1)
        forget_each(stations.sensed, stations.fits, started)
        fresh = np.zeros(slot.size, dtype=np.bool_) if begins is None else np.ascontiguousarray(begins)
        sense(stations.sensed, slot, np.full(slot.size, t_s), measured, fresh, self._sensing)
        if self._knowledge is not None:
            self._know(self._knowledge, t_s, slot, started)
        observe_newest(stations.models.members, stations.sensed, slot)
        busy = np.zeros(started.size)
        busy[slot] = 0.0 if channel_busy_ratio is None else channel_busy_ratio
        inputs = StepInputs(
            t_s=t_s,
            dt_s=self.dt_s,
            spread_s=self._spread_s if self._last_s == -np.inf else 0.0,
            started=started,
            critical=stations.sensed.shown[:, MEASURED - 2] < -stations.policy.critical_mps2,
            busy_ratio=busy,
            uniforms=self._rng.random((started.size, 4)),
        )
        box, slots = (self._contents, self._outbox, self._tally), (0, started.size)
        if self._deciding is None:
            send_each(stations, inputs, self._tables, *box, *slots)
        else:
            self._deciding.decide(stations, inputs, self._tables)
            self._deciding.post(stations, inputs, box, slots)
        self._last_s = t_s
        return self._sent()

    def _know(self, knowledge: Knowledge, t_s: float, slot: IntArray, started: BoolArray) -> None:
        """Write what stations know of the road and of the vehicle ahead behind what they measured."""
        knowledge.forget(started)
        sensed = self._stations.sensed
        samples = knowledge.newest(sensed, slot)
        rows = knowledge.drive(t_s, slot, samples)
        for sample, row, host in zip(samples, rows, slot.tolist(), strict=True):
            who, motion = self._ears.map.motions(self._heard[host], t_s)
            knowledge.follow(t_s, host, sample, who=who, motion=motion, row=row)
        knowledge.lay(sensed, slot, rows)

    def hear(
        self, vehicle: int, octets: Sequence[bytes], *, received_s: Sequence[float] | FloatArray
    ) -> IntArray:
        """Take in messages that one vehicle received; returns a `Receipt` each, (K,).

        Parameters
        ----------
        vehicle
            The host.
        octets
            Frames, in order of arrival; whatever came, nothing in them is trusted.
        received_s
            When each arrived, (K,) [s].

        Raises
        ------
        ValueError
            Where the vehicle is not in the fleet.
        """
        return self.hear_each(np.full(len(octets), vehicle), octets, received_s=received_s)

    def hear_each(
        self, vehicle: IntArray, octets: Sequence[bytes], *, received_s: Sequence[float] | FloatArray
    ) -> IntArray:
        """Take in messages that several vehicles received, as `hear` for each; gives a `Receipt` each, (K,).

        Parameters
        ----------
        vehicle
            The host of each message, those of one host side by side, (K,).
        octets
            Frames, those of each host in order of arrival.
        received_s
            When each arrived, (K,) [s].

        Raises
        ------
        ValueError
            Where a vehicle is not in the fleet, or there is not one of each a message.
        """
        if vehicle.shape != (len(octets),):
            raise ValueError(f"vehicle must be ({len(octets)},), one a frame, got {vehicle.shape}")
        starts = np.flatnonzero(np.diff(vehicle, prepend=-1))
        hosts: list[int] = vehicle[starts].tolist()
        slots = [self._slot_of(host) for host in hosts]
        receipts, after = self._ears.hear_each(
            [self._heard[slot] for slot in slots],
            np.diff(starts, append=vehicle.size).tolist(),
            octets,
            received_s,
            origin=self.origin,
            minute_s=self._minute_s,
            tables=self._tables,
            hosts=slots,
            own=[(host, self._before.get(slot, host)) for host, slot in zip(hosts, slots, strict=True)],
        )
        self._heard.update(zip(slots, after, strict=True))
        return receipts

    def believe(self, vehicle: int, t_s: float) -> Beliefs:
        """What one vehicle believes of all its remotes: its local dynamic map.

        Parameters
        ----------
        vehicle
            The host.
        t_s
            Any time from the newest message on [s].
        """
        return self._ears.map.believe(self._heard[self._slot_of(vehicle)], t_s)

    def paths(self, vehicle: int, t_s: float, ahead_s: FloatArray) -> FloatArray:
        """Where one vehicle believes its remotes to be later, in the order of `believe`, (N, H, 2) [m].

        Parameters
        ----------
        vehicle
            The host.
        t_s
            Any time from the newest message on [s].
        ahead_s
            How much later, (H,) [s].
        """
        return self._ears.map.paths(self._heard[self._slot_of(vehicle)], t_s, ahead_s)

    def deliveries(self, vehicle: int, remotes: IntArray, t_s: float) -> Deliveries:
        """How many of the messages of some remotes one vehicle has heard of late.

        Parameters
        ----------
        vehicle
            The host.
        remotes
            Their temporary ids, (N,).
        t_s
            Now, from the newest message on [s].
        """
        return deliveries_of(self._tables, self._slot_of(vehicle), remotes, t_s)

    @property
    def model_names(self) -> tuple[tuple[str, ...], ...]:
        """Names of the sub-models that predict remotes, as in `LocalDynamicMap.model_names`."""
        return self._ears.map.model_names

    def admit(self, vehicle: int) -> None:
        """Let a station hear that has measured nothing, as a roadside unit; who measures is admitted by that.

        Parameters
        ----------
        vehicle
            Its temporary id, 0 to 2^32 - 1.

        Raises
        ------
        ValueError
            Where it is there already, or the fleet is full.
        """
        free = np.flatnonzero(self._vehicle < 0)
        if not 0 <= vehicle < _IDS or (self._vehicle == vehicle).any():
            raise ValueError(f"vehicle must be new and from 0 to 2^32 - 1, got {vehicle}")
        if not free.size:
            raise ValueError(self._full)
        self._vehicle[free[0]], self._new[free[0]] = vehicle, True
        self._heard[int(free[0])] = self._ears.init()
        self._before.pop(int(free[0]), None)

    def dismiss(self, vehicle: int) -> None:
        """Let go of a station that was admitted and measures nothing; who measures leaves by being missing.

        Parameters
        ----------
        vehicle
            Its temporary id.

        Raises
        ------
        ValueError
            Where it is not in the fleet, or measures.
        """
        slot = self._slot_of(vehicle)
        if self._measures[slot]:
            raise ValueError(f"vehicle {vehicle} measures: leave it out of the next step instead")
        self._vehicle[slot], self._new[slot] = -1, False
        del self._heard[slot]

    def own_motion(self, vehicle: int) -> FloatArray:
        """How one vehicle sees itself move at the last step, filtered where its sender filters, (6,).

        East, north [m], speed [m/s], heading [rad], acceleration along the course [m/s²] and yaw rate,
        clockwise [rad/s].

        Parameters
        ----------
        vehicle
            Its temporary id.

        Raises
        ------
        ValueError
            Where it is not in the fleet, or measured nothing.
        """
        slot = self._slot_of(vehicle)
        if not self._measures[slot]:
            raise ValueError(f"vehicle {vehicle} measured nothing")
        return self._stations.sensed.shown[slot, :MEASURED].copy()

    def rename(self, vehicle: int, temporary_id: int) -> None:
        """Give one vehicle another temporary id and message count, as they change from time to time.

        Its next message is an update, since nobody holds anything of the new id.

        Parameters
        ----------
        vehicle
            Its id now.
        temporary_id
            The new one, which no vehicle of the fleet has.

        Raises
        ------
        ValueError
            Where the vehicle is not in the fleet, or another has that id.
        """
        slot = self._slot_of(vehicle)
        if not 0 <= temporary_id < _IDS or (self._vehicle == temporary_id).any():
            raise ValueError(f"temporary_id must be free and from 0 to 2^32 - 1, got {temporary_id}")
        self._vehicle[slot] = temporary_id
        self._before[slot] = vehicle  # a relay may still repeat what it sent by that name
        if self._given is None:
            return
        stations = self._stations
        each = stations.rules.vehicle.size // stations.senders.vehicle.size
        own = slice(slot * each, (slot + 1) * each)
        stations.lanes.update[own] = stations.lanes.in_use[own] = -1
        stations.lanes.last_usable[own] = False
        stations.senders.number[slot] += int(self._rng.integers(1, MESSAGES_KEPT))

    def _slot_of(self, vehicle: int) -> int:
        here = (self._vehicle == vehicle).argmax()
        if self._vehicle[here] != vehicle or vehicle < 0:
            raise ValueError(
                f"vehicle {vehicle} is not in the fleet: it measured nothing, nor was it admitted"
            )
        return int(here)

    def _measured(
        self,
        t_s: float,
        vehicle: IntArray,
        position_m: FloatArray,
        columns: tuple[FloatArray | None, ...],
    ) -> FloatArray:
        """Return the measurements as compiled sensing takes them, (N, 6), or say what is wrong with them."""
        if not t_s > self._last_s:
            raise ValueError(f"t_s must increase, got {t_s} after {self._last_s}")
        given = tuple(column is not None for column in columns)
        if self._given is not None and given != self._given:
            wanted = ", ".join(name for name, there in zip(_OPTIONAL, self._given, strict=True) if there)
            raise ValueError(f"the columns measured must stay the same: {wanted or 'positions alone'}")
        measured = np.full((vehicle.size, MEASURED), np.nan)
        if position_m.shape != (vehicle.size, 2):
            raise ValueError(f"position_m must be ({vehicle.size}, 2), got {position_m.shape}")
        measured[:, :2] = position_m
        for at, (name, column) in enumerate(zip(_OPTIONAL, columns, strict=True), start=2):
            if column is not None:
                if column.shape != vehicle.shape:
                    raise ValueError(f"{name} must be ({vehicle.size},), got {column.shape}")
                measured[:, at] = column
        known = [0, 1, *(at for at, there in enumerate(given, start=2) if there)]
        bad = ~np.isfinite(measured[:, known])
        if bad.any():
            row, at = (int(one) for one in np.argwhere(bad)[0])
            name = ("position_m", "position_m", *_OPTIONAL)[known[at]]
            raise ValueError(
                f"{name} of vehicle {vehicle[row]} must be finite, got {measured[row, known[at]]}"
            )
        far_m = np.hypot(*measured[:, :2].T)
        if (far_m > _FARTHEST_M).any():
            row = int(far_m.argmax())
            raise ValueError(
                f"position_m of vehicle {vehicle[row]} (row {row}) must be within {_FARTHEST_M / 1e3:g} km "
                f"of the origin, got {far_m[row] / 1e3:.1f} km: choose an origin near the vehicles"
            )
        return measured

    def _check_room(self, vehicle: IntArray) -> None:
        """Refuse vehicles that repeat, that have no such id, or that there are no slots for."""
        inside = (vehicle >= 0) & (vehicle < _IDS)
        if np.unique(vehicle).size != vehicle.size or not inside.all():
            raise ValueError(f"vehicles must be distinct and from 0 to 2^32 - 1, got {vehicle}")
        held = self._vehicle
        stays = (held >= 0) & (~self._measures | np.isin(held, vehicle))
        if int(stays.sum()) + int((~np.isin(vehicle, held)).sum()) > held.size:
            raise ValueError(self._full)

    @property
    def _full(self) -> str:
        return f"the fleet has {self._vehicle.size} slots, and all are taken: give it more"

    def _start(self, given: tuple[bool, ...]) -> None:
        """Make the arrays, now that it is known what is measured."""
        reported = given[0] and given[1]
        sensing = Sensing(
            velocity=REPORTED if reported else DEFAULT_FROM_POSITIONS,
            has_acceleration=given[2],
            has_yaw_rate=given[3],
            motion=self.sender.motion,
            origin=self.origin,
            minute_s=self._minute_s,
        )
        self._sensing = sensing.numbers(self.dt_s)
        self._stations = sending_stations(self.sender, self._bank, self._phase, sensing=sensing)
        rng = child_generator(self._seed, "policy")
        self._deciding = deciding_of(self.sender, self._stations, rng)
        self._given = given

    def _slots(self, vehicle: IntArray) -> tuple[IntArray, BoolArray]:
        """Slot of each vehicle that measures, (N,), and which slots measure for the first time, (V,)."""
        before, held = self._measures, self._vehicle
        held[before & ~np.isin(held, vehicle)] = -1
        for one in vehicle[~np.isin(vehicle, held)].tolist():
            self.admit(one)
        order = np.argsort(held, kind="stable")
        slot = order[np.searchsorted(held, vehicle, sorter=order)].astype(np.int64)
        self._measures = np.zeros(held.size, dtype=np.bool_)
        self._measures[slot] = True
        started = self._measures & ~(before & ~self._new)
        self._new[:] = False
        return slot, started

    def _sent(self) -> list[Sending]:
        """Messages of the outbox as octets, in order of time."""
        box = self._outbox
        order = np.argsort(box.ready_s[: int(box.filled[0])], kind="stable")
        messages = messages_of(
            self._stations, self._contents, box.sender[order], box.message_id[order] >> SENDER_BITS
        )
        columns = (messages.vehicle, box.ready_s[order], box.size_bytes[order], box.power_dbm[order])
        return [
            Sending(vehicle, octets, send_s, frame_bytes, power_dbm, kind, next_s, grant)
            for octets, vehicle, send_s, frame_bytes, power_dbm, kind, next_s, grant in zip(
                self._writer.encode(messages),
                *(
                    column.tolist()
                    for column in (*columns, messages.kind, box.next_s[order], box.grant[order])
                ),
                strict=True,
            )
        ]
