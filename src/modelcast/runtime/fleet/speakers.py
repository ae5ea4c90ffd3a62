"""The vehicles of one sender in a fleet: what they measure, what they hold to send, what they count.

Arrays have a row a slot of the fleet; a group works on the slots of its own vehicles. Message numbers are
the fleet's: a slot that changes hands goes on counting.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.models.member_kernels import Members
from modelcast.runtime.fleet import ahead_kernels
from modelcast.runtime.fleet.arrays import Tracks
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.arrays import MEASURED
from modelcast.station.context.knowledge import Knowledge
from modelcast.station.policy.neighbours_kernels import NeighbourTables
from modelcast.station.sender import sending_kernels
from modelcast.station.sender.deciding import deciding_of
from modelcast.station.sender.message_arrays import Contents, Senders, SentTally, outbox, sent_tally
from modelcast.station.sender.posting_kernels import StepInputs
from modelcast.station.sender.sender import Sender
from modelcast.station.sender.stations import guards_of, sender_bank, sending_stations, widest
from modelcast.station.sensing.sensing import NOWHERE, Sensing
from modelcast.station.sensing.sensing_kernels import forget_each, sense
from modelcast.station.sensing.streaming import observe_newest
from modelcast.world.scenario.base import FleetFrame

__all__ = ["Hosts", "Speakers"]

_ACCELERATION = MEASURED - 2
_CELLS = 1_000


class Hosts(NamedTuple):
    """What all hosts of a fleet hold: members of all senders, who is where, their tracks, and what they read.

    ``heading`` returns the newest heading of each slot, (V,) [rad].
    """

    members: Members
    expiry_s: float
    vehicle: IntArray
    heading: Callable[[], FloatArray]
    tables: NeighbourTables
    tracks: Tracks
    contents: Contents


class Speakers:
    """The vehicles of one sender.

    Parameters
    ----------
    sender
        What they send, and when.
    settings
        What is tracked and counted.
    phase
        Where in a step each slot decides, (V,) in [0, 1).
    parts
        First and end slot of each part of the fleet.
    groups
        For how many groups of slots sums are kept.
    rng
        Of a policy in NumPy.
    sensing
        How they read their measurements; None for all columns measured, and the sender's filter.
    first_member
        Where their bank begins among the members of all senders.
    shared
        What all stations hold of their messages, whoever is in the slot; None for a fleet of one sender.
    """

    def __init__(
        self,
        sender: Sender,
        settings: NetworkSettings,
        phase: FloatArray,
        *,
        parts: list[tuple[int, int]],
        groups: int,
        rng: np.random.Generator,
        sensing: Sensing | None,
        first_member: int = 0,
        shared: Senders | None = None,
    ) -> None:
        self.sender, self.bank = sender, sender_bank(sender, settings.dt_s)
        self._guards = guards_of(sender, self.bank)
        self.stations = sending_stations(sender, self.bank, phase, sensing=sensing, first_member=first_member)
        if shared is not None:
            own = self.stations.senders.vehicle
            self.stations = self.stations._replace(senders=shared._replace(vehicle=own))
        self._deciding = deciding_of(sender, self.stations, rng)
        self.outboxes = [outbox(end - begin) for begin, end in parts]
        self.tallies = [sent_tally(groups) for _ in parts]
        self.vehicle_steps = 0
        own_sensing = Sensing(motion=sender.motion, origin=NOWHERE) if sensing is None else sensing
        self._sensing = own_sensing.numbers(settings.dt_s)
        reads = self.bank.ready.reads_context
        self._knowledge = Knowledge(phase.size, cells=_CELLS) if reads else None
        self._spread_s = min(sender.longest_silence_s, settings.expiry_s)
        if settings.start_spread_s is not None:
            self._spread_s = settings.start_spread_s
        self._dt_s, self._parts = settings.dt_s, parts

    @property
    def widest(self) -> int:
        """Most parameters that a message holds."""
        return widest(self.sender, self.bank)

    @property
    def sent(self) -> SentTally:
        """What was sent since the counts were forgotten."""
        return SentTally(*(np.sum(columns, axis=0) for columns in zip(*self.tallies, strict=True)))

    def begin(self, frame: FleetFrame, here: BoolArray, started: BoolArray) -> None:
        """Take the vehicles of a frame over.

        Parameters
        ----------
        frame
            The truth.
        here, started
            Slots with a vehicle of this group, and with any new vehicle, (V,).
        """
        self.stations = self.stations._replace(models=self.bank.models(self._guards))
        self.stations.senders.vehicle[:] = np.where(here, frame.vehicle_id, -1)
        self.vehicle_steps += int(here.sum())
        forget_each(self.stations.sensed, self.stations.fits, started)
        if self._knowledge is not None:
            self._knowledge.forget(started)

    @property
    def knows_road(self) -> bool:
        """Whether vehicles know of the road and of who is ahead: by what they heard, so not ahead of it."""
        return self._knowledge is not None

    def sense(
        self,
        part: int,
        t_s: float,
        measured: tuple[FloatArray, BoolArray],
        hosts: "Hosts",
        taken: BoolArray | None,
    ) -> None:
        """Take measurements of a part in.

        Parameters
        ----------
        part
            Its number.
        t_s
            When they were made [s].
        measured
            What vehicles see, (V, MEASURED), and where measurements begin anew, (V,).
        hosts
            What the hosts of the fleet hold, for those who follow the vehicle ahead.
        taken
            Whose are taken in already, (V,); None for nobody's.
        """
        first, end = self._parts[part]
        due = self.stations.senders.vehicle[first:end] >= 0
        here: IntArray = first + np.flatnonzero(due if taken is None else due & ~taken[first:end])
        if here.size == 0:
            return
        self._take(here, t_s, measured)
        if self._knowledge is not None:
            self._know(self._knowledge, here, t_s, hosts)
        observe_newest(self.stations.models.members, self.stations.sensed, here)

    def sense_ahead(
        self, part: int, t_s: float, measured: tuple[FloatArray, BoolArray], whose: BoolArray
    ) -> None:
        """Take measurements of the next frame in, of vehicles of a part that are there now.

        Parameters
        ----------
        part, t_s, measured
            As for `sense`.
        whose
            Slots, (V,).

        Notes
        -----
        Not where they know of the road (`knows_road`).
        """
        first, end = self._parts[part]
        there = self.stations.senders.vehicle[first:end] >= 0
        here: IntArray = first + np.flatnonzero(there & whose[first:end])
        self._take(here, t_s, measured)
        observe_newest(self.stations.models.members, self.stations.sensed, here)

    def _take(self, here: IntArray, t_s: float, measured: tuple[FloatArray, BoolArray]) -> None:
        """Take the measurements of some slots in."""
        seen, begins = measured
        times = np.full(here.size, t_s)
        sense(self.stations.sensed, here, times, seen[here], begins[here], self._sensing)

    def _know(self, knowledge: Knowledge, here: IntArray, t_s: float, hosts: "Hosts") -> None:
        """Write what vehicles know of the road and of who is ahead behind what they measured."""
        stations = self.stations
        samples = knowledge.newest(stations.sensed, here)
        rows = knowledge.drive(t_s, here, samples)
        believing = ahead_kernels.Believing(
            hosts.members, t_s, hosts.expiry_s, hosts.vehicle, hosts.heading()
        )
        ahead_kernels.follow_each(
            believing, hosts.tables.hosts, hosts.tracks.held, hosts.contents.rows, knowledge.followers, here,
            samples, rows,
        )  # fmt: skip
        knowledge.lay(stations.sensed, here, rows)

    def send(
        self,
        part: int,
        inputs: StepInputs,
        tables: NeighbourTables,
        contents: Contents,
    ) -> None:
        """Fill the outbox of a part.

        Parameters
        ----------
        part
            Its number.
        inputs
            What stations know.
        tables, contents
            The fleet's.
        """
        box, slots = (contents, self.outboxes[part], self.tallies[part]), self._parts[part]
        if self._deciding is None:
            sending_kernels.send_each(self.stations, inputs, tables, *box, *slots)
        else:
            self._deciding.post(self.stations, inputs, box, slots)

    def decide(self, inputs: StepInputs, tables: NeighbourTables) -> None:
        """Ask a policy in NumPy about all stations at once; others are asked as they send.

        Parameters
        ----------
        inputs
            What stations know.
        tables
            The fleet's.
        """
        if self._deciding is not None:
            self._deciding.decide(self.stations, inputs, tables)

    def inputs(self, given: StepInputs, *, first: bool) -> StepInputs:
        """Return what stations of a step know, with what only these do.

        Parameters
        ----------
        given
            What all know.
        first
            Whether the step is the fleet's first, whose vehicles begin to send one after another.
        """
        shown = self.stations.sensed.shown
        critical = shown[:, _ACCELERATION] < -self.stations.policy.critical_mps2
        return given._replace(spread_s=self._spread_s if first else 0.0, critical=critical)

    def forget_counts(self) -> None:
        """Set all counts to zero."""
        self.vehicle_steps = 0
        for tally in self.tallies:
            for counts in tally:
                counts[...] = 0
