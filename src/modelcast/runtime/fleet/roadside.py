"""Roadside units beside a fleet on the air: fixed stations that hear, keep the map, and may relay.

They take the slots behind those of the vehicles. They send nothing of their own: what leaves them are copies
of what they heard, real frames that contend with all others. Chance is drawn for the vehicles alone, so that
a fleet sends by the same random numbers with units and without.
"""

from dataclasses import KW_ONLY, dataclass, replace

import numpy as np

from modelcast.channel.radio import Grant, Receptions, Transmissions
from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.kinds import Kind
from modelcast.runtime.fleet.arrays import Tally, tally
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.relay import Overheard, RelayRule, RelayState
from modelcast.station.sender.message_arrays import SENDER_BITS
from modelcast.world.scenario.base import NOBODY, FleetFrame

__all__ = ["Roadside", "RoadsideRun", "RoadsideUnits", "with_slots"]

_MEMORY_S = 1.0
"""A message that a radio holds longer than this is not known to a relay, and not repeated [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Roadside:
    """Units at the roadside. Antennas are the radio's (`modelcast.channel.propagation.RaisedAntennas`).

    Parameters
    ----------
    places_m
        East and north, (R, 2) [m].
    relay
        What they repeat; None for nothing.
    power_dbm
        Transmit power of what they repeat [dBm].

    Raises
    ------
    ValueError
        Where there is no unit, or a place or power is not finite.
    """

    places_m: FloatArray
    relay: RelayRule | None = None
    _: KW_ONLY
    power_dbm: float = 20.0

    def __post_init__(self) -> None:
        if self.places_m.ndim != 2 or self.places_m.shape[1] != 2 or not len(self.places_m):
            raise ValueError(f"places_m must be (R, 2) with at least one unit, got {self.places_m.shape}")
        if not (np.isfinite(self.places_m).all() and np.isfinite(self.power_dbm)):
            raise ValueError("places_m and power_dbm must be finite")

    def __len__(self) -> int:
        return len(self.places_m)


@dataclass(frozen=True, slots=True)
class RoadsideRun:
    """What the units of a run counted, the warm-up left out.

    Parameters
    ----------
    tally
        What they hold of the vehicles, as hosts of a fleet count it.
    sent, delivered
        Frames of vehicles by their distance to a unit, and how many of them it heard from the vehicle itself,
        (distances,).
    busy_ratio
        Mean over units and time.
    unit_s
        Time observed, over all units [s].
    repeated, unsent, by_another, replaced, too_old, too_far
        Messages handed over again, of these never sent since the next took their place, and what was not
        repeated, as `modelcast.station.relay.RelayState` has it.
    repeated_bytes
        Bytes of the frames repeated.
    """

    tally: Tally
    _: KW_ONLY
    sent: IntArray
    delivered: IntArray
    busy_ratio: float
    unit_s: float
    repeated: int
    unsent: int
    by_another: int
    replaced: int
    too_old: int
    too_far: int
    repeated_bytes: int


@dataclass(frozen=True, slots=True, eq=False)
class _Made:
    """Messages that vehicles handed to their radios of late, by rising number, (N,)."""

    message_id: IntArray
    made_s: FloatArray
    size_bytes: IntArray
    place_m: FloatArray

    @classmethod
    def nothing(cls) -> "_Made":
        none: IntArray = np.zeros(0, dtype=np.int64)
        return cls(none, np.zeros(0), none, np.zeros((0, 2)))

    def joined(self, other: "_Made", *, since_s: float) -> "_Made":
        """These and others, made at a time or later."""
        message_id = np.concatenate([self.message_id, other.message_id])
        made_s = np.concatenate([self.made_s, other.made_s])
        rows = np.argsort(message_id, kind="stable")
        rows = rows[made_s[rows] >= since_s]
        return _Made(
            message_id[rows],
            made_s[rows],
            np.concatenate([self.size_bytes, other.size_bytes])[rows],
            np.concatenate([self.place_m, other.place_m])[rows],
        )

    def rows_of(self, message_id: IntArray) -> IntArray:
        """Row of each message, -1 where it is not among them."""
        if not self.message_id.size:
            return np.full(message_id.size, -1)
        at = np.minimum(np.searchsorted(self.message_id, message_id), self.message_id.size - 1)
        return np.where(self.message_id[at] == message_id, at, -1)


class RoadsideUnits:
    """The units of one run.

    Parameters
    ----------
    roadside
        Where they are, and what they do.
    first
        Slot of the first.
    settings
        Of the run.
    """

    def __init__(self, roadside: Roadside, first: int, settings: NetworkSettings) -> None:
        self.roadside, self.first, self.settings = roadside, first, settings
        self.slots = slice(first, first + len(roadside))
        self.tally = tally(settings.distances)
        self._sent, self._delivered = (np.zeros(settings.distances, dtype=np.int64) for _ in range(2))
        self._made = _Made.nothing()
        self._heard = Overheard.nothing()
        self._relay: RelayState | None = (
            None if roadside.relay is None else roadside.relay.init(len(roadside))
        )
        self._begun = self._relay
        self._busy, self._steps, self._bytes, self._unsent = 0.0, 0, 0, 0

    def count_pairs(self, truth_m: FloatArray) -> None:
        """Count the vehicles near every unit.

        Parameters
        ----------
        truth_m
            Where the vehicles are, NaN where nobody is, (V, 2) [m].
        """
        self.tally.pairs[:] += self._by_distance(self._distance_m(truth_m))

    def add(self, batch: Transmissions, place_m: FloatArray, now_s: float, until_s: float) -> Transmissions:
        """What vehicles hand over, and what the units repeat among it, by rising time.

        Parameters
        ----------
        batch
            Of the vehicles.
        place_m
            Where all stations are, (V + R, 2) [m].
        now_s, until_s
            Bounds of the step on the radio's clock [s].
        """
        sent_from = place_m[batch.sender]
        fresh = _Made(batch.message_id, batch.ready_s, batch.size_bytes, sent_from)
        self._made = self._made.joined(fresh, since_s=now_s - _MEMORY_S)
        self._sent += self._by_distance(self._distance_m(sent_from))
        if self.roadside.relay is None or self._relay is None:
            return batch
        repeats, self._relay = self.roadside.relay.turn(self._relay, self._heard, now_s, until_s)
        self._heard = Overheard.nothing()
        if not repeats.key.size:
            return batch
        size_bytes = self._made.size_bytes[self._made.rows_of(repeats.key)]
        self._bytes += int(size_bytes.sum())
        ready_s = np.concatenate([batch.ready_s, repeats.send_s])
        order = np.argsort(ready_s, kind="stable")
        power_dbm = np.full(repeats.key.size, self.roadside.power_dbm)
        return Transmissions(
            np.concatenate([batch.sender, self.first + repeats.unit])[order],
            ready_s[order],
            size_bytes=np.concatenate([batch.size_bytes, size_bytes])[order],
            power_dbm=np.concatenate([batch.power_dbm, power_dbm])[order],
            message_id=np.concatenate([batch.message_id, repeats.key])[order],
            next_s=np.concatenate([batch.next_s, np.full(repeats.key.size, np.inf)])[order],
            grant=np.concatenate([batch.grant, np.full(repeats.key.size, int(Grant.ANY))])[order],
        )

    def hear(self, received: Receptions, busy_ratio: FloatArray) -> Receptions:
        """Take in what units heard, and return receptions without copies that were never sent.

        Parameters
        ----------
        received
            By all stations, on the radio's clock.
        busy_ratio
            That units observe, (R,).
        """
        self._busy += float(busy_ratio.sum())
        self._steps += 1
        here = received.receiver >= self.first
        message_id, row = received.message_id[here], self._made.rows_of(received.message_id[here])
        known = row >= 0
        unit = received.receiver[here][known] - self.first
        is_copy = received.sender[here][known] >= self.first
        way_m = self._made.place_m[row[known]] - self.roadside.places_m[unit]
        distance_m = np.hypot(way_m[:, 0], way_m[:, 1])
        self._delivered += self._by_distance(distance_m[~is_copy])
        if self._relay is None:
            return received
        self._heard = Overheard(
            unit.astype(np.int64),
            message_id[known],
            message_id[known] & ((1 << SENDER_BITS) - 1),
            made_s=self._made.made_s[row[known]],
            heard_s=received.t_s[here][known],
            distance_m=distance_m,
            is_copy=is_copy,
        )
        # A message that was repeated was sent: what expired of it is the copy.
        held = self._relay.held
        copies = np.isin(received.expired, held.key[self._relay.done])
        self._unsent += int(copies.sum())
        return replace(received, expired=received.expired[~copies])

    def forget_counts(self) -> None:
        """Set all counts to zero."""
        for counts in (*self.tally, self._sent, self._delivered):
            counts[...] = 0
        self._busy, self._steps, self._bytes, self._unsent = 0.0, 0, 0, 0
        self._begun = self._relay

    def run(self) -> RoadsideRun:
        """What was counted since the counts were forgotten."""
        unit_s = self._steps * len(self.roadside) * self.settings.dt_s
        counts = dict.fromkeys(("repeated", "by_another", "replaced", "too_old", "too_far"), 0)
        if self._relay is not None and self._begun is not None:
            for name in counts:
                counts[name] = int((getattr(self._relay, name) - getattr(self._begun, name)).sum())
        return RoadsideRun(
            self.tally,
            sent=self._sent,
            delivered=self._delivered,
            busy_ratio=self._busy / max(self._steps * len(self.roadside), 1),
            unit_s=unit_s,
            unsent=self._unsent,
            repeated_bytes=self._bytes,
            **counts,
        )

    def _distance_m(self, place_m: FloatArray) -> FloatArray:
        """From every unit to places, (R, N) [m]."""
        way_m = place_m[None] - self.roadside.places_m[:, None]
        return np.hypot(way_m[..., 0], way_m[..., 1])

    def _by_distance(self, distance_m: FloatArray) -> IntArray:
        """How many distances are in each bin, (distances,)."""
        there = distance_m[distance_m < self.settings.distance_bin_m * self.settings.distances]
        bins = (there / self.settings.distance_bin_m).astype(np.int64)
        return np.bincount(bins, minlength=self.settings.distances)


def with_slots(frame: FleetFrame, more: int) -> FleetFrame:
    """A frame with more slots behind its own, in which no vehicle is.

    Parameters
    ----------
    frame
        The frame.
    more
        How many.
    """
    if not more:
        return frame
    nothing = np.zeros(more)
    return FleetFrame(
        frame.t_s,
        np.concatenate([frame.position_m, np.zeros((more, 2))]),
        speed_mps=np.append(frame.speed_mps, nothing),
        heading_rad=np.append(frame.heading_rad, nothing),
        acceleration_mps2=np.append(frame.acceleration_mps2, nothing),
        yaw_rate_radps=np.append(frame.yaw_rate_radps, nothing),
        length_m=np.append(frame.length_m, nothing),
        vehicle_id=np.append(frame.vehicle_id, np.full(more, NOBODY)),
        active=np.append(frame.active, nothing > 0.0),
        begins=None if frame.begins is None else np.append(frame.begins, nothing > 0.0),
        kind=None if frame.kind is None else np.append(frame.kind, np.full(more, Kind.ROADSIDE)),
        width_m=None if frame.width_m is None else np.append(frame.width_m, nothing),
    )
