"""The closed loop between two frames: what it owns, and the order of one step of 100 ms.

In each step every vehicle takes its sample; the tracks of all hosts are set against the truth; every vehicle
decides, at a time of its own within the step; the radio carries what was sent; hosts take in what they heard.
What they heard is what they count, so it changes what is sent in the next step.

Several threads share up to `PARTS` parts of the vehicles; one thread takes all in one. What a part sends is
put together in the order of slots, counts are whole numbers, and sums are kept by group of slots, whoever
works on them, so that the number of threads changes nothing.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from modelcast.channel.cells_kernels import build_cells
from modelcast.channel.radio import AbstractRadio, Receptions, Transmissions
from modelcast.core.arrays import BoolArray, FloatArray, IntArray, owned
from modelcast.core.chance import child_generator
from modelcast.core.parts import WHOLE, Parts
from modelcast.models.members import ReadyBank
from modelcast.runtime.fleet import mixed_kernels, reception_kernels, tracking_kernels
from modelcast.runtime.fleet.arrays import (
    Tally,
    pooled,
    tally,
    tracks,
)
from modelcast.runtime.fleet.belief_words_kernels import Tracking
from modelcast.runtime.fleet.believed import Believed, believe, check_slots, pairs_of
from modelcast.runtime.fleet.believed_kernels import Readers
from modelcast.runtime.fleet.coming import Coming, begins_of, measured_of, staying
from modelcast.runtime.fleet.hearing import Hearing, check_receptions
from modelcast.runtime.fleet.mix import Draw, Mix
from modelcast.runtime.fleet.mixed import MixedTally, mixed_tally, pooled_mixed, within
from modelcast.runtime.fleet.people import Devices, People, PeopleRun
from modelcast.runtime.fleet.reception_kernels import HearingLimits
from modelcast.runtime.fleet.roadside import Roadside, RoadsideUnits, with_slots
from modelcast.runtime.fleet.room import capacity_of, speakers_of, sub_intervals_of
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.runtime.fleet.speakers import Hosts
from modelcast.station.arrays import MEASURED
from modelcast.station.banks import BASELINE_BANK, free_bank
from modelcast.station.policy import j2945_kernels
from modelcast.station.policy.neighbours import neighbour_tables
from modelcast.station.policy.policy_numbers import RULE_J2945
from modelcast.station.receiver.reading import Reading, free_rule, goes_straight
from modelcast.station.sender import message_arrays
from modelcast.station.sender.message_arrays import (
    MESSAGES,
    MESSAGES_KEPT,
    POWER_DBM,
    SENDER_BITS,
    Outbox,
    SentTally,
    contents,
)
from modelcast.station.sender.octets import SentMessages, messages_of
from modelcast.station.sender.posting_kernels import SendingStations, StepInputs
from modelcast.station.sender.sender import Sender
from modelcast.station.sensing.sensing import Sensing
from modelcast.world.scenario.base import FleetFrame
from modelcast.world.scenario.sensed import FleetSensor, FleetSensorState

__all__ = ["PARTS", "SERIES", "Exchange", "FleetLoop"]

SERIES = (
    "vehicles",
    "messages",
    "receptions",
    "busy_ratio",
    "power_dbm",
    "density",
    "inter_transmit_time_s",
    "channel_quality",
)
"""Columns of `NetworkRun.series`: vehicles there, messages sent, receptions, means of channel busy ratio and
transmit power; and of J2945/1's state: smoothed density, longest time between messages, believed loss."""

PARTS = 8
"""Parts of a fleet that threads share at most; sums are kept for so many groups."""

_UNIT = 2**31 - 1
"""Number of the first roadside unit where vehicles have their identifiers; the others' count down from it."""


_RING_STEPS = MESSAGES_KEPT // 2 - 1
"""Steps within which no ring of messages comes round: a station sends two in a step at most."""

_SUB_INTERVAL_S = 1.0
"""Of the neighbour tables: vPERSubInterval of SAE J2945/1 [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Exchange:
    """What went over the air in one step; times are those of frames.

    Parameters
    ----------
    sent
        What the radio was handed, by rising time; what roadside units repeat too.
    received
        What it delivered: of this step's messages, and of earlier ones that were still on the air.
    """

    sent: Transmissions
    received: Receptions


class FleetLoop:
    """A fleet on the air between two frames; it owns its arrays, and `step` writes them.

    Parameters
    ----------
    first
        The first frame, from which sizes are taken; it is not stepped.
    sender, radio, settings
        As for `run_network`.
    seed
        Of all random numbers.
    sensor
        What the vehicles see of themselves; None for the truth.
    threads
        How many work on the parts of the fleet.
    sensing
        How stations read their measurements; None for all columns measured, and the sender's filter.
    roadside
        Units beside the vehicles, in the slots behind theirs; None for none.
    people
        What the devices of people do; None for what vehicles do.
    """

    _exchange: Exchange | None
    _ahead: Coming | None

    def __init__(
        self,
        first: FleetFrame,
        sender: Sender | Mix,
        radio: AbstractRadio[Any],
        settings: NetworkSettings,
        *,
        seed: int,
        sensor: FleetSensor | None = None,
        threads: int = 1,
        sensing: Sensing | None = None,
        roadside: Roadside | None = None,
        people: People | None = None,
    ) -> None:
        moving = len(first)
        self.units = None if roadside is None else RoadsideUnits(roadside, moving, settings)
        self._fixed = 0 if roadside is None else len(roadside)
        vehicles = moving + self._fixed
        if vehicles >= 1 << SENDER_BITS:
            raise ValueError(f"a fleet has fewer than {1 << SENDER_BITS} slots, got {vehicles}")
        if threads < 1:
            raise ValueError(f"threads must be at least 1, got {threads}")
        rng = child_generator(seed, "senders")
        phase = np.append(rng.random(moving), np.zeros(self._fixed))
        self.mix = sender if isinstance(sender, Mix) else Mix((sender,))
        if roadside is not None and not self.mix.is_one:
            raise ValueError("roadside units read messages of one sender: a mixed fleet has none")
        if people is not None and not self.mix.is_one:
            raise ValueError("people speak beside vehicles of one sender: a mixed fleet has none")
        self.devices = None if people is None else Devices(people, settings)
        self.senders = self.mix.senders if people is None else (*self.mix.senders, people.sender)
        self.sender, self.radio, self.settings = self.mix.senders[0], radio, settings
        self.expiry_s = max(settings.expiry_s, 2.0 * max(one.longest_silence_s for one in self.senders))
        if not np.isfinite(self.expiry_s):
            self.expiry_s = np.inf
        pool = ThreadPoolExecutor(threads) if threads > 1 else None
        # Two parts a thread even out; a power of two of them begin where groups of sums do.
        number = min(PARTS, 1 << (2 * threads - 1).bit_length())
        self._work = WHOLE if pool is None else Parts(number, pool)
        # A part begins with the first slot of a group of `SentTally`.
        edges = [-(-moving * part // self._work.number) for part in range(self._work.number + 1)]
        self._parts = list(pairwise(edges))
        self.speakers = speakers_of(
            self.senders, settings, phase, parts=self._parts, groups=PARTS, sensing=sensing, seed=seed
        )
        self._ready = ReadyBank.joined([one.bank.ready for one in self.speakers])
        self._members = self._ready.members
        shared = len(self.speakers) == 1 and self.units is None
        self.vehicle = self.stations.senders.vehicle if shared else np.full(vehicles, -1, dtype=np.int64)
        self.group, self.reading = (np.zeros(vehicles, dtype=np.int64) for _ in range(2))
        self.reading[:] = Reading.MODEL
        # Who speaks: the group of a mixed fleet; of people with a sender of their own, the last.
        self._speaker = np.zeros(vehicles, dtype=np.int64) if self.mix.is_one else self.group
        self._draw = None if self.mix.is_one else Draw(self.mix, seed)
        columns = message_arrays.BELIEF_COLUMNS if self.mix.is_one else mixed_kernels.COLUMNS
        self.contents = contents(vehicles, max(one.widest for one in self.speakers), beliefs=columns)
        capacity = capacity_of(first, settings, self.devices)
        self.tables = neighbour_tables(
            vehicles,
            capacity,
            sub_intervals=max(sub_intervals_of(one) for one in self.senders),
            phase_s=phase * 1.0,
        )
        self.tracks = tracks(vehicles, capacity)
        self._tallies = [tally(settings.distances) for _ in self._parts]
        self._mixed = [mixed_tally(self.mix, settings) for _ in self._parts]
        self._rng = rng
        self._radio_state: Any = radio.init(vehicles, child_generator(seed, "radio"))
        self._sensor = sensor
        self._sensor_state: FleetSensorState | None = None
        if sensor is not None:
            self._sensor_state = sensor.init(moving, child_generator(seed, "sensor"))
        self._counted, self._nobody = np.ones(vehicles, dtype=np.bool_), np.zeros(vehicles, dtype=np.bool_)
        self.number, self._last_s, self._exchange, self._ahead = 0, -np.inf, None, None

    @property
    def _hears_beside(self) -> bool:
        """Whether hosts hear beside the radio; what units repeat and devices read is known after it."""
        return self._work.pool is not None and self.units is None and self.devices is None

    @property
    def stations(self) -> SendingStations:
        """All that the stations of the first sender hold."""
        return self.speakers[0].stations

    @property
    def exchange(self) -> Exchange:
        """What went over the air in the last step.

        Raises
        ------
        ValueError
            Before the first.
        """
        if self._exchange is None:
            raise ValueError("nothing went over the air yet: step the fleet first")
        return self._exchange

    def origins(self, message_id: IntArray) -> FloatArray:
        """Contents of messages of late, a row each, as `modelcast.station.sender.message_arrays` has columns.

        Parameters
        ----------
        message_id
            As radios carry them, (N,); of each sender its last `MESSAGES_KEPT` messages.
        """
        slot, number = message_id & ((1 << SENDER_BITS) - 1), message_id >> SENDER_BITS
        found: FloatArray = self.contents.rows[slot, number % MESSAGES_KEPT]
        return found

    @property
    def model_names(self) -> tuple[str, ...]:
        """Sub-models of all senders, by the numbers in contents (`CONTENT_MEMBER`)."""
        return tuple(member.name for one in self.speakers for member in one.bank.bank.members)

    @property
    def senses_ahead(self) -> bool:
        """Whether a step has a use for the frame that comes next."""
        return self._hears_beside and not any(one.knows_road for one in self.speakers)

    def step(self, frame: FleetFrame, coming: FleetFrame | None = None) -> tuple[Receptions, FloatArray]:
        """Carry one step; returns what was received in it, and its row of `SERIES`.

        Parameters
        ----------
        frame
            The truth, one step after the last.
        coming
            The frame that the next step will be given: where the fleet `senses_ahead`, vehicles measure it
            beside the radio, and `own_motion` is then that at it. None where it is not there yet; what is
            carried and counted is the same.

        Raises
        ------
        ValueError
            Where the frame is not one step later, or another one than was to come.
        """
        settings = self.settings
        dt_s, t_s = settings.dt_s, frame.t_s
        if np.isfinite(self._last_s) and abs(t_s - self._last_s - dt_s) > settings.step_slack_s:
            raise ValueError(
                f"frames must be {dt_s} s apart, got one at {t_s} s after {self._last_s} s: resample them"
            )
        # The radio's clock counts steps, so that both ends of every interval are the same numbers.
        now_s, until_s = round(self.number * dt_s, 6), round((self.number + 1) * dt_s, 6)
        ahead, self._ahead = self._ahead, None
        if ahead is not None and ahead.frame is not frame:
            raise ValueError(f"the frame at {ahead.frame.t_s} s was to come, got another one at {t_s} s")
        seen = self._see(frame) if ahead is None else ahead.seen
        if self.devices is not None and self.devices.place(frame, self.vehicle.size):
            self._radio_state = self.radio.fit_antennas(self._radio_state, self.devices.gains_db())
            self._speaker[:] = self.devices.person
        frame, seen = with_slots(frame, self._fixed), with_slots(seen, self._fixed)
        before = self.sent.total
        busy_ratio = _busy_ratio(self.radio, self._radio_state, self.vehicle.size)
        truth_m = np.where(frame.active[:, None], frame.position_m, np.nan)
        started = self._sense(frame, seen, None if ahead is None else ahead.taken)
        if settings.counted_m is not None:
            low_m, high_m = settings.counted_m
            self._counted = (frame.position_m[:, 0] >= low_m) & (frame.position_m[:, 0] <= high_m)
        self._track(truth_m, t_s)
        if self.units is not None:
            truth_m[self.units.slots] = self.units.roadside.places_m
            self._counted[self.units.slots] = True
            self._track_units(self.units, truth_m, t_s)
        self._send(started, t_s, busy_ratio)
        if coming is not None and self.senses_ahead:
            self._work.hand_over(partial(self._sense_ahead, coming))
        received = self._carry(truth_m, (now_s, until_s), now_s - t_s, busy_ratio)
        self._work.finish()
        if not self._hears_beside:
            self._hear(received, truth_m)
        self.number += 1
        self._last_s = t_s
        return received, self._series_row(frame, busy_ratio, before, received)

    def _see(self, frame: FleetFrame) -> FleetFrame:
        """What vehicles see of a frame, the next one."""
        if self._sensor is None or self._sensor_state is None:
            return frame
        seen, self._sensor_state = self._sensor.sense(self._sensor_state, frame)
        return seen

    def _sense_ahead(self, coming: FleetFrame) -> None:
        """Take measurements of the next frame in, of those who stay."""
        seen, taken = self._see(coming), staying(self.vehicle, coming)
        self._ahead = Coming(coming, seen, taken)
        measured = measured_of(seen), begins_of(coming)

        def work(part: int) -> None:
            for one in self.speakers:
                one.sense_ahead(part, coming.t_s, measured, taken)

        self._work.put_off(work)

    def _sense(self, frame: FleetFrame, seen: FleetFrame, taken: BoolArray | None) -> BoolArray:
        """Take measurements in and let new vehicles begin anew; returns whose slot has one, (V,)."""
        started = frame.active & (self.vehicle != frame.vehicle_id)
        self.vehicle[:] = np.where(frame.active, frame.vehicle_id, -1)
        if self._draw is not None:
            self._draw.place(self.vehicle, started, self.group, self.reading)
        for number, one in enumerate(self.speakers):
            one.begin(frame, frame.active & (self._speaker == number), started)
        if self.units is not None:
            self.vehicle[self.units.slots] = _UNIT - np.arange(self._fixed)
        one = len(self.speakers) == 1
        self._members = self.stations.models.members if one else self._ready.members
        reception_kernels.clear_hosts(started, self.tables, self.tracks)
        measured = measured_of(seen), begins_of(frame)
        hosts = Hosts(
            self._members,
            self.expiry_s,
            self.vehicle,
            lambda: self._shown(_HEADING),
            self.tables,
            self.tracks,
            self.contents,
        )

        def work(part: int) -> None:
            for one in self.speakers:
                one.sense(part, frame.t_s, measured, hosts, taken)

        if taken is None:
            self._work.each(work)
        else:  # few are left
            for part in range(len(self._parts)):
                work(part)
        return started

    def _shown(self, columns: int | slice) -> FloatArray:
        """Columns of what each vehicle takes its own state to be, (V,) or (V, C)."""
        shown = self.stations.sensed.shown[:, columns]
        for number, one in enumerate(self.speakers[1:], start=1):
            own = self._speaker == number
            shown = np.where(
                own if shown.ndim == 1 else own[:, None], one.stations.sensed.shown[:, columns], shown
            )
        return np.ascontiguousarray(shown)

    def _track(self, truth_m: FloatArray, now_s: float) -> None:
        """Set all tracks against the truth."""
        settings = self.settings
        tracking = self._tracking(truth_m, now_s)
        if self._draw is not None:
            self._track_mixed(tracking)
            return

        def sample(part: int) -> None:
            tracking_kernels.sample_tracks(
                tracking,
                self.tables.hosts,
                self.contents,
                self.tracks.held,
                self._tallies[part],
                *self._parts[part],
            )

        if self.devices is not None:
            self._work.each(sample)
            self.devices.count_pairs(truth_m, self._counted, self._tallies, self._work)
            return
        cells, counted = (
            build_cells(truth_m, settings.distance_bin_m * self._tallies[0].pairs.size),
            self._counted,
        )

        def sample_and_count(part: int) -> None:
            sample(part)
            tracking_kernels.count_pairs(
                cells, (part, self._work.number), settings.distance_bin_m, counted, self._tallies[part].pairs
            )

        # Beside the radio, unless what is sent may take the place of a message that somebody still holds.
        if self.units is None and self.expiry_s < _RING_STEPS * settings.dt_s:
            self._work.put_off(sample_and_count)
        else:
            self._work.each(sample_and_count)

    def _tracking(self, truth_m: FloatArray, now_s: float) -> Tracking:
        return Tracking(
            members=self._members,
            t_s=now_s,
            step=self.number,
            expiry_s=self.expiry_s,
            distance_bin_m=self.settings.distance_bin_m,
            middle=self.settings.middle_bins,
            vehicle=self.vehicle,
            truth_m=truth_m,
            own_error_m=np.ascontiguousarray(self._places(truth_m) - truth_m),
            counted=self._counted,
            person=self._nobody if self.devices is None else self.devices.person,
            people_m2=np.inf if self.devices is None else self.devices.reach_m**2,
        )

    def _places(self, truth_m: FloatArray) -> FloatArray:
        """Where stations take themselves to be: units know their place, (V, 2) [m]."""
        shown_m = self._shown(slice(2))
        if self.units is not None:
            shown_m = shown_m.copy()
            shown_m[self.units.slots] = truth_m[self.units.slots]
        return shown_m

    def _track_units(self, units: RoadsideUnits, truth_m: FloatArray, now_s: float) -> None:
        """Set the tracks of roadside units against the truth."""
        tracking_kernels.sample_tracks(
            self._tracking(truth_m, now_s),
            self.tables.hosts,
            self.contents,
            self.tracks.held,
            units.tally,
            units.slots.start,
            units.slots.stop,
        )
        units.count_pairs(truth_m[: units.first])

    def _track_mixed(self, tracking: Tracking) -> None:
        """Set all tracks against the truth, each as its host reads."""
        bins = self.settings.distances
        cells = build_cells(tracking.truth_m, self.settings.distance_bin_m * bins)
        readers = mixed_kernels.MixedReaders(
            free_rule(free_bank() if self.mix.free is None else self.mix.free, self.settings.dt_s),
            self.group,
            self.reading,
        )

        def work(part: int) -> None:
            mixed_kernels.sample_mixed(
                tracking, readers, self.tables.hosts, self.contents, self.tracks.held, self._mixed[part],
                *self._parts[part],
            )  # fmt: skip
            mixed_kernels.count_mixed(
                cells,
                readers,
                (part, self._work.number),
                self.settings.distance_bin_m,
                self._counted,
                self._mixed[part].pairs,
            )

        self._work.each(work)

    def _send(self, started: BoolArray, now_s: float, busy_ratio: FloatArray) -> None:
        """Fill the outboxes."""
        given = StepInputs(
            t_s=now_s,
            dt_s=self.settings.dt_s,
            spread_s=0.0,
            started=started,
            critical=started,
            busy_ratio=owned(busy_ratio),
            uniforms=np.append(
                self._rng.random((started.size - self._fixed, 4)), np.zeros((self._fixed, 4)), axis=0
            ),
        )
        inputs = [one.inputs(given, first=self.number == 0) for one in self.speakers]
        for one, own in zip(self.speakers, inputs, strict=True):
            one.decide(own, self.tables)

        def work(part: int) -> None:
            for one, own in zip(self.speakers, inputs, strict=True):
                one.send(part, own, self.tables, self.contents)

        self._work.each(work)

    def handed_over(self) -> Outbox:
        """Messages of the last step as the radio gets them, in order of slots."""
        boxes = [one.outboxes[part] for part in range(len(self._parts)) for one in self.speakers]
        columns = [
            np.concatenate([getattr(box, name)[: int(box.filled[0])] for box in boxes])
            for name in Outbox._fields[:-1]
        ]
        if len(self.speakers) > 1:
            order = np.argsort(columns[0], kind="stable")
            columns = [column[order] for column in columns]
        return Outbox(*columns, filled=np.array([columns[0].size]))

    def _carry(
        self, truth_m: FloatArray, span_s: tuple[float, float], shift_s: float, busy_ratio: FloatArray
    ) -> Receptions:
        """Give the outboxes to the radio, in order of time; its clock, of the span, is ahead by a shift."""
        now_s, until_s = span_s
        every = self.handed_over()
        order = np.argsort(every.ready_s, kind="stable")
        batch = Transmissions(
            every.sender[order],
            np.minimum(every.ready_s[order] + shift_s, np.nextafter(until_s, 0.0)),
            size_bytes=every.size_bytes[order],
            power_dbm=every.power_dbm[order],
            message_id=every.message_id[order],
            next_s=every.next_s[order] + shift_s,
            grant=every.grant[order],
        )
        if self.units is not None:
            batch = self.units.add(batch, truth_m, now_s, until_s)
        given = (self._radio_state, batch, truth_m, until_s, self._work)
        vehicles, name = self.vehicle.size, type(self.radio).__name__
        if self._hears_beside:
            hearing = self._hearing(truth_m)

            def told(some: Receptions) -> None:
                check_receptions(some, vehicles, now_s, name)
                self._work.put_off(hearing.taking(_later(some, -shift_s), self._parts, self._tallies))

            received, self._radio_state = self.radio.carry_and_tell(*given, told)
        else:
            received, self._radio_state = self.radio.carry(*given)
            check_receptions(received, vehicles, now_s, name)
        if self.units is not None:
            received = self.units.hear(received, busy_ratio[self.units.slots])
        if shift_s != 0.0:
            batch = replace(batch, ready_s=batch.ready_s - shift_s, next_s=batch.next_s - shift_s)
        received = _later(received, -shift_s)
        self._exchange = Exchange(batch, received)
        return received

    def posted(self, group: int = 0) -> SentMessages:
        """Content of the messages of the last step, as their receivers decode it, in order of slots.

        Parameters
        ----------
        group
            Of which sender.
        """
        own = self.speakers[group]
        each = [(box, int(box.filled[0])) for box in own.outboxes]
        slot = np.concatenate([box.sender[:count] for box, count in each])
        number = np.concatenate([box.message_id[:count] for box, count in each]) >> SENDER_BITS
        return messages_of(own.stations, self.contents, slot, number)

    def _hearing(self, truth_m: FloatArray) -> Hearing:
        """The hosts of this step."""
        return Hearing(
            HearingLimits(
                self.settings.reach_m, self.expiry_s, _SUB_INTERVAL_S, self.settings.distance_bin_m
            ),
            tables=self.tables,
            tracks=self.tracks,
            contents=self.contents,
            vehicle=self.vehicle,
            seen_m=self._places(truth_m),
            truth_m=truth_m,
            reading=self.reading,
            counted=self._counted,
            first_unit=self.vehicle.size - self._fixed,
        )

    def _hear(self, received: Receptions, truth_m: FloatArray) -> None:
        """Let hosts take in what they heard."""
        hearing = self._hearing(truth_m)
        if self.devices is not None:
            received = self.devices.read(received, hearing.seen_m, self.contents.rows)
        self._work.each(hearing.taking(received, self._parts, self._tallies))
        if self.units is not None:
            slots = self.units.slots
            hearing.taking(received, [(slots.start, slots.stop)], [self.units.tally])(0)

    def believed(
        self,
        hosts: IntArray,
        remotes: IntArray,
        *,
        reading: Reading | IntArray | None = None,
        t_s: float | None = None,
    ) -> Believed:
        """What hosts believe of remotes after a step, by the messages that they have heard in it and before.

        A remote that is believed by Part I alone (`Reading.LEGACY`), or by a sub-model of constant velocity,
        is believed to accelerate and to turn as Part I states: going straight on denies neither. Vehicles are
        those of the last frame.

        Parameters
        ----------
        hosts, remotes
            Slots of each pair, (N,).
        reading
            How the hosts read messages, one for all or (N,); None for each in its own way.
        t_s
            For which instant [s]; None for the end of the step, that of the next frame.

        Raises
        ------
        ValueError
            Where the arrays differ in shape, a slot is none of the fleet's, or a reading is unknown.
        """
        host, remote, how = pairs_of(hosts, remotes, reading, self.reading)
        free = self.mix.free
        if free is None:
            free = free_bank() if (how == Reading.FREE).any() else BASELINE_BANK
        readers = Readers(
            self._ready.members,
            np.concatenate([goes_straight(one.bank.bank) for one in self.speakers]),
            free_rule(free, self.settings.dt_s),
            self._last_s + self.settings.dt_s if t_s is None else t_s,
            self.expiry_s,
            self.vehicle,
        )
        return believe(readers, self.tables, self.tracks, self.contents, (host, remote, how))

    def own_motion(self, hosts: IntArray) -> FloatArray:
        """How vehicles see themselves move at the last frame, filtered where their sender filters, (N, 6).

        Columns are `modelcast.station.arrays.MEASURED`: east, north [m], speed [m/s], heading [rad],
        acceleration along the course [m/s²] and yaw rate, clockwise [rad/s].

        Parameters
        ----------
        hosts
            Slots, (N,).

        Raises
        ------
        ValueError
            Where a slot is none of the fleet's.
        """
        check_slots("hosts", hosts, self.vehicle.size)
        return self._shown(slice(MEASURED))[hosts]

    def _series_row(
        self, frame: FleetFrame, busy_ratio: FloatArray, before: FloatArray, received: Receptions
    ) -> FloatArray:
        here = frame.active
        gained = self.sent.total - before
        timed = [
            one.stations.timers.rows[here & (self._speaker == number)]
            for number, one in enumerate(self.speakers)
            if one.stations.policy.rule == RULE_J2945
        ]
        rows = np.concatenate(timed) if timed else None
        row = np.full(len(SERIES), np.nan)
        heard = received.size if self.units is None else (received.receiver < self.units.first).sum()
        row[0], row[1], row[2] = here.sum(), gained[MESSAGES], heard
        found = here & self._counted
        row[3] = busy_ratio[found].mean() if found.any() else np.nan
        row[4] = gained[POWER_DBM] / gained[MESSAGES] if gained[MESSAGES] > 0 else np.nan
        if rows is not None and len(rows):
            row[5] = rows[:, j2945_kernels.DENSITY].mean()
            row[6] = rows[:, j2945_kernels.INTER_TRANSMIT_TIME_S].mean()
            row[7] = rows[:, j2945_kernels.CHANNEL_QUALITY].mean()
        return row

    @property
    def sent(self) -> SentTally:
        """What was sent since the counts were forgotten."""
        parts = [tally for one in self.speakers for tally in one.tallies]
        return SentTally(*(np.sum(columns, axis=0) for columns in zip(*parts, strict=True)))

    def people_run(self) -> PeopleRun | None:
        """What the devices of people did since the counts were forgotten; None where they do as vehicles."""
        return None if self.devices is None else self.devices.run(self.speakers[-1].sent)

    @property
    def tally(self) -> Tally:
        """What was counted since the counts were forgotten."""
        counts = pooled(self._tallies)
        return counts if self._draw is None else within(self.mixed, counts)

    @property
    def mixed(self) -> MixedTally:
        """What was counted by sender and reading since the counts were forgotten; no rows for one."""
        return pooled_mixed(self._mixed)

    def take_recent(self) -> IntArray:
        """Return the tracking errors near the middle distances since the last call, (BINS,)."""
        parts = self._tallies if self._draw is None else self._mixed
        recent: IntArray = np.sum([part.recent for part in parts], axis=0)
        for part in parts:
            part.recent[...] = 0
        return recent

    def forget_counts(self) -> None:
        """Set all counts to zero: the warm-up is over."""
        for part in (*self._tallies, *self._mixed):
            for counts in part:
                counts[...] = 0
        for one in self.speakers:
            one.forget_counts()
        if self.units is not None:
            self.units.forget_counts()
        if self.devices is not None:
            self.devices.forget_counts()


_HEADING = MEASURED - 3


def _busy_ratio(radio: AbstractRadio[Any], state: Any, vehicles: int) -> FloatArray:
    """The busy ratio that a radio measured; refused where it is not one a vehicle."""
    found = radio.channel_busy_ratio(state)
    if found.shape != (vehicles,) or not ((found >= 0.0) & (found <= 1.0)).all():
        raise ValueError(
            f"{type(radio).__name__}: channel_busy_ratio must be ({vehicles},) within 0..1, got {found}"
        )
    return found


def _later(received: Receptions, shift_s: float) -> Receptions:
    """The same so much later."""
    return received if shift_s == 0.0 else replace(received, t_s=received.t_s + shift_s)
