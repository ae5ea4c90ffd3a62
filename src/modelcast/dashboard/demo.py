"""A drive to try the page with: simulated traffic, real stations and octets, a medium that loses."""

from collections.abc import Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import Any

import numpy as np

from modelcast.apps.around import believed_motions, repeated
from modelcast.apps.registry import APPLICATIONS
from modelcast.apps.warnings import Level
from modelcast.channel.erasure import IndependentErasure
from modelcast.core.chance import child_generator
from modelcast.dashboard.meter import MessageMeter
from modelcast.dashboard.snapshot import Host, Snapshot, WarningShown, snapshot_of
from modelcast.runtime.transport.virtual import VirtualMedium, VirtualTransport
from modelcast.station.banks import named_bank
from modelcast.station.fleet import Fleet
from modelcast.station.receiver.ears import Ears
from modelcast.station.receiver.local_dynamic_map import Beliefs, Receipt
from modelcast.station.sender.sender import named_sender
from modelcast.station.station import Station
from modelcast.world.named_sensors import named_sensor
from modelcast.world.scenario.base import AbstractScenario, FleetFrame, run_scenario
from modelcast.world.scenario.grid import Grid
from modelcast.world.scenario.peopled_grid import PeopledGrid
from modelcast.world.scenario.sensed import sensed

__all__ = ["DemoDrive"]

_TOWN = PeopledGrid(
    Grid(columns=3, rows=3, density_per_km=14.0, junctions="priority", misjudged_ratio=0.1), 24, 12
)
_BANK = "learned+ctra+gp-vehicle+cv"
_DELAY_S = 0.01


@dataclass(frozen=True, slots=True)
class DemoDrive:
    """One vehicle's map of the others around it; same seed, same snapshots.

    The host is the vehicle of the first slot, which must stay. Each other vehicle has its own way to it, on
    which each message is lost by itself. All vehicles measure themselves as the named sensor does.

    Parameters
    ----------
    scenario
        Who drives.
    loss_ratio
        Share of messages that a way loses.
    bank
        Sub-models of all, as `modelcast network --bank` takes them.
    sensor
        How they measure, by name.
    seed
        Of all randomness.
    """

    scenario: AbstractScenario[Any] = _TOWN
    loss_ratio: float = 0.3
    _: KW_ONLY
    bank: str = _BANK
    sensor: str = "default"
    seed: int = 0

    def snapshots(self, duration_s: float) -> Iterator[Snapshot]:
        """A snapshot every 0.1 s.

        Parameters
        ----------
        duration_s
            Length of the drive [s].
        """
        frames = run_scenario(
            self.scenario, child_generator(self.seed, "page", "traffic"), duration_s=duration_s
        )
        frames = sensed(frames, named_sensor(self.sensor), child_generator(self.seed, "page", "sensor"))
        drive: _Drive | None = None
        for truth, seen in frames:
            drive = _Drive(self, truth) if drive is None else drive
            yield drive.step(truth, seen)


@dataclass(slots=True)
class _Way:
    """What is known of one remote's way to the host."""

    transport: VirtualTransport
    sent: int = 0
    """Messages that arrived or were lost."""
    heard: int = 0
    frames: dict[bytes, tuple[float, int]] = field(default_factory=dict[bytes, tuple[float, int]])
    """Time and length of those on their way."""


class _Drive:
    """The stations between two frames."""

    def __init__(self, demo: DemoDrive, first: FleetFrame) -> None:
        self._host = int(first.vehicle_id[0])
        named = named_bank(demo.bank)
        sender = named_sender("mbc", bank=named.bank, start=named.start, identify=named.identify)
        self._others = Fleet(
            sender, slots=len(first), seed=demo.seed + 1, ears=Ears((), capacity=1), spread_s=0.5
        )
        self._station = Station(sender, temporary_id=self._host, seed=demo.seed + 2)
        self._medium = VirtualMedium(IndependentErasure(demo.loss_ratio), delay_s=_DELAY_S, seed=demo.seed)
        self._own = self._medium.join()
        self._ways: dict[int, _Way] = {}
        self._meter = MessageMeter()
        self._applications = {name: APPLICATIONS.made(name) for name in APPLICATIONS.own}
        self._begun_s: dict[tuple[str, int], float] = {}

    def step(self, truth: FleetFrame, seen: FleetFrame) -> Snapshot:
        """Send, hear and look."""
        t_s = truth.t_s
        slot = int(np.flatnonzero(truth.vehicle_id == self._host)[0])
        own = Host(
            self._host,
            (float(seen.position_m[slot, 0]), float(seen.position_m[slot, 1])),
            heading_rad=float(seen.heading_rad[slot]),
            speed_mps=float(seen.speed_mps[slot]),
            inputs="simulated GNSS and CAN",
        )
        self._hear(t_s)
        beliefs = self._station.believe(t_s)
        here = truth.active & (truth.vehicle_id != self._host)
        snapshot = snapshot_of(
            self._station,
            t_s,
            own,
            counters=self._meter.counters(t_s, loss_ratio=self._loss(list(self._ways.values()))),
            warnings=self._warnings(t_s, own, seen, slot, beliefs),
            messages={vehicle: way.heard for vehicle, way in self._ways.items()},
            loss_ratio={vehicle: self._loss([way]) for vehicle, way in self._ways.items()},
            truth_m={
                int(one): (float(place[0]), float(place[1]))
                for one, place in zip(truth.vehicle_id[here], truth.position_m[here], strict=True)
            },
            kinds=None
            if truth.kind is None
            else {
                int(one): int(kind)
                for one, kind in zip(truth.vehicle_id[here], truth.kind[here], strict=True)
            },
        )
        self._send(t_s, own, seen, slot)
        return snapshot

    def _hear(self, t_s: float) -> None:
        """Take in what arrived; each frame is one that a way carried."""
        arrived = self._own.receive(t_s)
        octets = [one.octets for one in arrived]
        receipts = self._station.hear(octets, received_s=[one.received_s for one in arrived])
        for one, receipt in zip(arrived, receipts.tolist(), strict=True):
            for way in self._ways.values():
                if one.octets in way.frames:
                    way.sent, way.heard = way.sent + 1, way.heard + 1
                    self._meter.received(one.received_s, way.frames.pop(one.octets)[1])
                    break
            if receipt != Receipt.ACCEPTED:
                self._meter.refused(Receipt(receipt).reason)
        for way in self._ways.values():
            lost = [octets for octets, (sent_s, _) in way.frames.items() if sent_s + _DELAY_S <= t_s]
            for octets in lost:
                del way.frames[octets]
            way.sent += len(lost)
            way.transport.receive(t_s)

    def _send(self, t_s: float, own: Host, seen: FleetFrame, slot: int) -> None:
        """What all send until the next frame."""
        rows = np.flatnonzero(seen.active & (seen.vehicle_id != self._host))
        for message in self._others.sense(
            t_s,
            seen.vehicle_id[rows],
            seen.position_m[rows],
            speed_mps=seen.speed_mps[rows],
            heading_rad=seen.heading_rad[rows] % (2.0 * np.pi),
            acceleration_mps2=seen.acceleration_mps2[rows],
            yaw_rate_radps=seen.yaw_rate_radps[rows],
        ):
            way = self._ways.get(message.vehicle)
            if way is None:
                way = self._ways[message.vehicle] = _Way(self._medium.join())
            way.frames[message.octets] = (message.send_s, message.frame_bytes)
            way.transport.send(message.octets, sent_s=message.send_s)
        for message in self._station.sense(
            t_s,
            own.position_m,
            speed_mps=own.speed_mps,
            heading_rad=own.heading_rad % (2.0 * np.pi),
            acceleration_mps2=float(seen.acceleration_mps2[slot]),
            yaw_rate_radps=float(seen.yaw_rate_radps[slot]),
        ):
            self._own.send(message.octets, sent_s=message.send_s)
            self._meter.sent(message.send_s, message.frame_bytes)

    def _warnings(
        self, t_s: float, own: Host, seen: FleetFrame, slot: int, beliefs: Beliefs
    ) -> list[WarningShown]:
        """What the applications say of the remotes, with the time since when they say it."""
        count = beliefs.vehicle.size
        if not count:
            return []
        mine = repeated(
            own.position_m,
            count,
            speed_mps=own.speed_mps,
            heading_rad=own.heading_rad,
            acceleration_mps2=float(seen.acceleration_mps2[slot]),
            yaw_rate_radps=float(seen.yaw_rate_radps[slot]),
        )
        theirs = believed_motions(beliefs)
        said: dict[tuple[str, int], int] = {}
        for kind, application in self._applications.items():
            level = application.assess(mine, theirs).level
            for row in np.flatnonzero(level > Level.NONE):
                said[kind, int(beliefs.vehicle[row])] = int(level[row])
        self._begun_s = {key: self._begun_s.get(key, t_s) for key in said}
        return [
            WarningShown(level, kind, vehicle, self._begun_s[kind, vehicle])
            for (kind, vehicle), level in said.items()
        ]

    @staticmethod
    def _loss(ways: Sequence[_Way]) -> float:
        sent = sum(way.sent for way in ways)
        return 1.0 - sum(way.heard for way in ways) / sent if sent else float("nan")
