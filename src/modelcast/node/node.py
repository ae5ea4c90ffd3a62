"""A station on the road, a step at a time: what a clock, sockets and files are put round.

It takes its motion, sends by a transport within an envelope, hears, keeps the map and warns. Time is an
argument here too: the same inputs at the same times give the same frames and map, byte for byte.
"""

import heapq
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass
from itertools import count
from typing import final

import numpy as np

from modelcast.apps.around import believed_motions, repeated
from modelcast.apps.base import AbstractApplication
from modelcast.apps.motions import Motions
from modelcast.apps.warnings import Level
from modelcast.core.arrays import IntArray
from modelcast.core.kinds import Kind
from modelcast.dashboard.meter import MessageMeter
from modelcast.node.envelope import AbstractEnvelope, Bare
from modelcast.node.inputs.motion import Motion
from modelcast.node.pseudonyms import Pseudonyms
from modelcast.node.recording.record import AbstractRecord
from modelcast.node.relaying import Relaying
from modelcast.runtime.transport.base import AbstractTransport
from modelcast.station.receiver.local_dynamic_map import Beliefs, Receipt
from modelcast.station.station import Station

__all__ = ["Node", "NodeState", "Warned"]

Watch = Callable[[str, Mapping[str, object]], None]
"""Takes an event by its name, with what belongs to it."""


@dataclass(frozen=True, slots=True)
class Warned:
    """What an application says of one remote.

    Parameters
    ----------
    application
        Its name.
    vehicle
        Temporary id of the remote.
    level
        How urgent.
    time_s, margin_m, certainty
        As in `modelcast.apps.warnings.Warnings`.
    """

    application: str
    vehicle: int
    level: Level
    _: KW_ONLY
    time_s: float
    margin_m: float
    certainty: float


@dataclass(frozen=True, slots=True)
class NodeState:
    """What there is to show of a node after a step.

    Parameters
    ----------
    t_s
        The step's instant [s].
    temporary_id
        Its name.
    motion
        Its own; None where it knows none.
    around
        What it believes of its remotes.
    warnings
        What it warns of, the most urgent first.
    """

    t_s: float
    temporary_id: int
    motion: Motion | None
    _: KW_ONLY
    around: Beliefs
    warnings: tuple[Warned, ...]


@final
class Node:
    """Remote and host in one.

    Parameters
    ----------
    station
        What it sends, and what it makes of what it hears.
    transport
        How frames leave and arrive.
    envelope
        What goes round messages; None for nothing.
    applications
        What it warns of, by name.
    size_m
        Length and width of the road user [m].
    kind
        Of the road user: what applications warn of differs.
    pseudonyms
        When its names change; None for never.
    relaying
        Which messages it repeats; None for none. A node that does stands at the origin of its plane.
    watch
        Takes what happens: ``motion`` (what it is made of changed), ``renamed``, ``warning`` (one begins or
        ends); None for nobody.
    record
        Takes what it does, so that it can be done again; None for nobody.

    Notes
    -----
    Call `hear` whenever frames have arrived, `step` at every instant of the station, and `send` when
    `next_send_s` has come.
    """

    def __init__(
        self,
        station: Station,
        transport: AbstractTransport,
        envelope: AbstractEnvelope | None = None,
        *,
        applications: Mapping[str, AbstractApplication] | None = None,
        size_m: tuple[float, float] = (4.6, 1.8),
        kind: Kind = Kind.VEHICLE,
        pseudonyms: Pseudonyms | None = None,
        relaying: Relaying | None = None,
        watch: Watch | None = None,
        record: AbstractRecord | None = None,
    ) -> None:
        self.station, self._transport = station, transport
        self._envelope = Bare() if envelope is None else envelope
        self._size_m, self._kind, self._pseudonyms = size_m, kind, pseudonyms
        self._applications = dict(applications or {})
        self._events, self._record = watch, record
        self._relaying = relaying
        self._waiting: list[tuple[float, int, bytes]] = []
        self._order = count()
        self._made_of: str | None = None
        self._warned: dict[tuple[str, int], Level] = {}
        self.counts: Counter[str] = Counter()
        """``sent``, ``heard``, their ``_octets``, ``unsent``, and ``refused: WHY``, ``opened: HOW``,
        ``receipt: WHAT``."""
        self.meter = MessageMeter()
        """The same as rates, for who looks."""

    @property
    def next_send_s(self) -> float:
        """When the next frame is to leave, infinite where none waits [s]."""
        return self._waiting[0][0] if self._waiting else float("inf")

    def step(self, now_s: float, motion: Motion | None) -> NodeState:
        """Take the own motion in, decide what is sent until the next step, and look around.

        Parameters
        ----------
        now_s
            Now, later than the last step [s].
        motion
            The own motion now, on the station's plane; None where it is not known: nothing is sent then.
        """
        if self._pseudonyms is not None and self._pseudonyms.due(now_s):
            self.station.rename(self._pseudonyms.temporary_id)
            self._envelope.rename()
            self._waiting.clear()  # a message of the old name would tie the two together
            self._watch("renamed", {"temporary_id": self._pseudonyms.temporary_id})
        made_of = "silent" if motion is None else motion.mode
        if made_of != self._made_of:
            self._watch("motion", {"mode": made_of, "before": self._made_of})
            self._made_of = made_of
        if motion is not None:
            self._sense(now_s, motion)
        around = self.station.believe(now_s)
        if self._relaying is not None:
            self._relay(self._relaying, now_s, around)
        state = NodeState(
            now_s,
            self.station.temporary_id,
            motion,
            around=around,
            warnings=self._warnings(motion, around),
        )
        if self._record is not None:
            self._record.stepped(state)
        return state

    def _watch(self, name: str, what: Mapping[str, object]) -> None:
        if self._events is not None:
            self._events(name, what)

    def _sense(self, now_s: float, motion: Motion) -> None:
        sent = self.station.sense(
            now_s,
            motion.position_m,
            speed_mps=motion.speed_mps,
            heading_rad=motion.heading_rad,
            acceleration_mps2=motion.acceleration_mps2,
            yaw_rate_radps=motion.yaw_rate_radps,
            begins=motion.begins,
        )
        for one in sent:
            heapq.heappush(self._waiting, (one.send_s, next(self._order), one.octets))

    def send(self, now_s: float) -> None:
        """Hand over the frames whose time has come.

        Parameters
        ----------
        now_s
            Now [s].
        """
        while self._waiting and self._waiting[0][0] <= now_s:
            _, _, octets = heapq.heappop(self._waiting)
            frame = self._envelope.wrap(octets, sent_s=now_s)
            if frame is None:
                self.counts["unsent"] += 1
                self._watch("unsent", {"why": "no certificate is good now"})
                continue
            self._transport.send(frame, sent_s=now_s)
            if self._record is not None:
                self._record.sent(now_s, octets, frame)
            self.meter.sent(now_s, len(frame))
            self.counts["sent"] += 1
            self.counts["sent_octets"] += len(frame)

    def hear(self, now_s: float) -> int:
        """Take in what has arrived, and return how many frames that were.

        Parameters
        ----------
        now_s
            Now, not before the last call [s].
        """
        arrived = self._transport.receive(now_s)
        if not arrived:
            return 0
        octets: list[bytes] = []
        received_s: list[float] = []
        opened_as: Counter[str] = Counter()
        refused_as: Counter[str] = Counter()
        outcomes: list[str] = []
        opened_at: list[int] = []
        for one in arrived:
            self.meter.received(one.received_s, len(one.octets))
            self.counts["heard_octets"] += len(one.octets)
            opened = self._envelope.open(one.octets, received_s=one.received_s)
            outcomes.append(opened.why)
            if opened.octets is None:
                refused_as[opened.why] += 1
            else:
                opened_as[opened.why] += 1
                opened_at.append(len(outcomes) - 1)
                octets.append(opened.octets)
                received_s.append(one.received_s)
        self.counts["heard"] += len(arrived)
        for why, times in opened_as.items():
            self.counts[f"opened: {why}"] += times
        for why, times in refused_as.items():
            self.counts[f"refused: {why}"] += times
            self.meter.refused(why, times)
        receipts = self.station.hear(octets, received_s=received_s)
        self._count(receipts)
        if self._relaying is not None:
            self._relaying.hear(octets, received_s, receipts)
        if self._record is not None:
            for at, receipt in zip(opened_at, receipts.tolist(), strict=True):
                outcomes[at] = Receipt(receipt).reason
            self._record.heard(now_s, arrived, outcomes)
        return len(arrived)

    def _relay(self, relaying: Relaying, now_s: float, around: Beliefs) -> None:
        """Repeat what is to be repeated until the next step."""
        for send_s, octets in relaying.turn(now_s, around):
            heapq.heappush(self._waiting, (send_s, next(self._order), octets))
        for why, times in relaying.counts.items():
            self.counts[f"relay: {why.replace('_', ' ')}"] = times

    def _count(self, receipts: IntArray) -> None:
        """Count what became of messages."""
        for receipt, times in enumerate(np.bincount(receipts).tolist()):
            if not times:
                continue
            reason = Receipt(receipt).reason
            self.counts[f"receipt: {reason}"] += times
            if receipt != Receipt.ACCEPTED:
                self.meter.refused(reason, times)

    def _warnings(self, motion: Motion | None, around: Beliefs) -> tuple[Warned, ...]:
        """What applications say; begins and ends are told."""
        found: list[Warned] = []
        remotes = around.vehicle.size
        if motion is not None and remotes:
            own = _rows(motion, self._size_m, self._kind, remotes)
            others = believed_motions(around)
            for name, application in self._applications.items():
                said = application.assess(own, others)
                found += [
                    Warned(
                        name,
                        int(around.vehicle[row]),
                        Level(int(said.level[row])),
                        time_s=float(said.time_s[row]),
                        margin_m=float(said.margin_m[row]),
                        certainty=float(said.certainty[row]),
                    )
                    for row in np.flatnonzero(said.level > Level.NONE).tolist()
                ]
        found.sort(key=lambda one: (-one.level, one.margin_m))
        now = {(one.application, one.vehicle): one.level for one in found}
        for key in now.keys() | self._warned.keys():
            if now.get(key, Level.NONE) != self._warned.get(key, Level.NONE):
                level = now.get(key, Level.NONE)
                told = {"application": key[0], "vehicle": key[1], "level": level.name.lower()}
                self._watch("warning", told)
        self._warned = now
        return tuple(found)


def _rows(motion: Motion, size_m: tuple[float, float], kind: Kind, rows: int) -> Motions:
    """The host's own motion, once for every remote."""
    return repeated(
        motion.position_m,
        rows,
        speed_mps=motion.speed_mps,
        heading_rad=motion.heading_rad,
        acceleration_mps2=motion.acceleration_mps2,
        yaw_rate_radps=motion.yaw_rate_radps,
        length_m=size_m[0],
        width_m=size_m[1],
        kind=kind,
    )
