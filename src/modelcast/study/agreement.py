"""Whether what is evaluated, simulated and driven is the same: three runtimes, one trip, byte for byte.

The trip runtime, the fleet runtime on an ideal channel, and a lone `Station` fed sample by sample get the
same samples, origin, time base and step. They must send the same octets at the same samples; a host that
hears them over a lossy channel must believe what the replay of the evaluation says, to the last bit; and the
motion that hosts of the fleet hold of Part I must be what the octets state.
"""

from dataclasses import dataclass

import numpy as np

from modelcast.channel.tabulated import ReceptionTable, TabulatedRadio
from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.core.chance import child_generator
from modelcast.messages.bsm import decode_bsm
from modelcast.messages.code_table import MOTION_FIELDS
from modelcast.models.bank import Bank
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.runtime.trip.replay import replay, schedules_of
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.station.banks import profile_number_of
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.error_driven_kernels import IDENTIFICATION
from modelcast.station.receiver.ears import Ears
from modelcast.station.sender.message_arrays import CONTENT_SPEED_MPS, MESSAGES_KEPT
from modelcast.station.sender.motion_kernels import MOTION
from modelcast.station.sender.octets import StationOctets
from modelcast.station.sender.sender import Sender
from modelcast.station.sensing.sensing import NOWHERE, Sensing, measurements, part_begins
from modelcast.station.station import Station
from modelcast.study.case import TripCase
from modelcast.trips.trajectory import Trajectory
from modelcast.world.scenario.base import FleetFrame

__all__ = ["Agreement", "TripDrive", "agreement", "drive_by_trip", "first_difference", "replayed_places"]

_ID = 1
_LOSS_RATIO = 0.4
_EVERYTHING = TabulatedRadio(ReceptionTable(np.array([0.0, 1e6]), np.ones((2, 20)), bin_m=500.0))

Events = list[tuple[int, bytes]]
"""Sample and octets of each message."""


@dataclass(frozen=True, slots=True)
class Agreement:
    """What three runtimes made of one trip.

    Parameters
    ----------
    messages
        How many the trip runtime sent.
    fleet, station
        First difference of the fleet runtime and of the lone station from the trip runtime; empty for none.
    host
        First difference between the host's beliefs and the replay; empty for none.
    motion
        First difference between what hosts of the fleet hold of Part I's motion and what the octets state;
        empty for none.
    """

    messages: int
    fleet: str
    station: str
    host: str
    motion: str = ""

    @property
    def agrees(self) -> bool:
        """Whether there is no difference."""
        return not (self.fleet or self.station or self.host or self.motion)


def agreement(case: TripCase, bank: Bank, policy: ErrorDriven, *, seed: int = 0) -> Agreement:
    """Drive one trip three times and compare.

    Parameters
    ----------
    case
        The trip, made ready.
    bank
        The sender's sub-models.
    policy
        Its rules.
    seed
        Of the losses that the host meets.

    Raises
    ------
    ValueError
        Where the rules do not go with the bank.
    """
    trip, drive = case.seen, drive_by_trip(case, bank, policy, temporary_id=_ID)
    sender = Sender("agreement", policy, bank)
    posted, motion = _fleet_events(case, sender, drive.writer)
    ears = Ears((bank,), np.inf, None, dt_s=trip.dt_s, capacity=4)
    return Agreement(
        len(drive.events),
        first_difference(drive.events, posted),
        first_difference(drive.events, _station_events(case, sender)),
        _host_difference(case, ears, drive, seed),
        motion=motion,
    )


@dataclass(frozen=True, slots=True)
class TripDrive:
    """What the trip runtime makes of a trip.

    Parameters
    ----------
    runtime, walked
        The runtime, and what it sent.
    writer
        Turns it into octets.
    events
        Sample and octets of each message.
    """

    runtime: TripRuntime
    walked: TripMessages
    writer: StationOctets
    events: Events


def drive_by_trip(case: TripCase, bank: Bank, policy: ErrorDriven, *, temporary_id: int) -> TripDrive:
    """Drive one trip by the trip runtime.

    Parameters
    ----------
    case, bank, policy
        As for `agreement`.
    temporary_id
        Of the vehicle.
    """
    trip = case.seen
    runtime = TripRuntime(trip, bank, case.estimator, quantised=True)
    walked = runtime.run(policy)
    writer = _writer(runtime.bank, bank, policy, trip)
    octets = writer.encode(runtime.sent(walked, temporary_id=temporary_id))
    samples = np.flatnonzero(walked.transmits).tolist()
    return TripDrive(runtime, walked, writer, list(zip(samples, octets, strict=True)))


def _writer(whole: Bank, bank: Bank, policy: ErrorDriven, trip: Trajectory) -> StationOctets:
    identify = policy.identify if len(whole.members) > 1 else "never"
    return StationOctets.of(whole, profile_number_of(bank), identify, trip.origin or NOWHERE)


def _fleet_events(case: TripCase, sender: Sender, writer: StationOctets) -> tuple[Events, str]:
    """Messages of a fleet of one on an ideal channel; where its hosts hold another motion than they state."""
    trip = case.seen
    sensing = Sensing.of(trip, case.estimator, quantised=True)
    settings = NetworkSettings(warm_up_s=0.0, dt_s=trip.dt_s, start_spread_s=0.0, step_slack_s=np.inf)
    frames = _frames(trip)
    loop = FleetLoop(frames[0], sender, _EVERYTHING, settings, seed=0, sensing=sensing)
    events: Events = []
    stated, off = np.zeros(MOTION), ""
    for number, frame in enumerate(frames):
        loop.step(frame)
        posted = loop.posted()
        for which, kind, octets in zip(posted.number, posted.kind, writer.encode(posted), strict=True):
            row = loop.contents.rows[0, which % MESSAGES_KEPT]
            if kind != IDENTIFICATION:  # which states no motion: that of its update stands
                stated = _stated_motion(octets)
            held = row[CONTENT_SPEED_MPS : CONTENT_SPEED_MPS + MOTION]
            if not off and not np.array_equal(held, stated, equal_nan=True):
                off = f"sample {number}: {held.tolist()}, not {stated.tolist()}"
            events.append((number, octets))
    return events, off


def _stated_motion(octets: bytes) -> FloatArray:
    """Motion that Part I of a frame states, as anybody decodes it, (MOTION,)."""
    core = decode_bsm(octets).core
    return np.array([core.value(name) for name in MOTION_FIELDS], dtype=np.float64)  # None is not a number


def _frames(trip: Trajectory) -> list[FleetFrame]:
    table, begins = measurements(trip), part_begins(trip)
    one = np.ones(1)
    return [
        FleetFrame(
            float(trip.t_s[i]),
            table[i : i + 1, :2].copy(),
            speed_mps=table[i, 2] * one,
            heading_rad=table[i, 3] * one,
            acceleration_mps2=table[i, 4] * one,
            yaw_rate_radps=table[i, 5] * one,
            length_m=4.0 * one,
            vehicle_id=np.array([_ID]),
            active=np.ones(1, dtype=np.bool_),
            begins=begins[i : i + 1],
        )
        for i in range(len(trip))
    ]


def _station_events(case: TripCase, sender: Sender) -> Events:
    """Messages of a lone station."""
    trip = case.seen
    station = Station(sender, temporary_id=_ID, dt_s=trip.dt_s, origin=trip.origin or NOWHERE)
    table, begins = measurements(trip), part_begins(trip)
    reported = case.estimator.window == 0

    def given(i: int, column: int) -> float | None:
        known = not np.isnan(table[i, column]) and (reported or column > 3)
        return float(table[i, column]) if known else None

    events: Events = []
    for i in range(len(trip)):
        sent = station.sense(
            float(trip.t_s[i]),
            (float(table[i, 0]), float(table[i, 1])),
            speed_mps=given(i, 2),
            heading_rad=given(i, 3),
            acceleration_mps2=given(i, 4),
            yaw_rate_radps=given(i, 5),
            begins=bool(begins[i]),
        )
        events += [(i, one.octets) for one in sent]
    return events


def first_difference(expected: Events, found: Events) -> str:
    """The first message that differs, and the first byte in it; empty where all are equal.

    Parameters
    ----------
    expected, found
        Sample and octets of each message.

    Examples
    --------
    >>> first_difference([(0, b"ab"), (7, b"cd")], [(0, b"ab"), (7, b"cx")])
    'message 1: byte 1 of 2 (sample 7)'
    """
    for number, (one, other) in enumerate(zip(expected, found, strict=False)):
        if one[0] != other[0]:
            return f"message {number}: sample {other[0]}, not {one[0]}"
        if one[1] != other[1]:
            pairs = zip(one[1], other[1], strict=False)
            at = next((k for k, (a, b) in enumerate(pairs) if a != b), min(len(one[1]), len(other[1])))
            return f"message {number}: byte {at} of {len(one[1])} (sample {one[0]})"
    if len(expected) != len(found):
        return f"{len(found)} messages, not {len(expected)}"
    return ""


def _host_difference(case: TripCase, ears: Ears, drive: TripDrive, seed: int) -> str:
    """The first sample at which a host that hears the octets believes something else than the replay."""
    trip, count = case.seen, len(case.seen)
    lost = child_generator(seed, trip.trip_id, "agreement").random((1, count)) < _LOSS_RATIO
    replayed = replayed_places(trip, drive, lost)
    state, frames = ears.init(), dict(drive.events)
    for i in range(count):
        t_s = float(trip.t_s[i])
        if i in frames and not lost[0, i]:
            _, state = ears.hear(state, [frames[i]], [t_s], origin=trip.origin or NOWHERE)
        _, believed = ears.map.positions(state, t_s)
        wanted = replayed[:, i]
        if believed.size == 0 and np.isnan(wanted).all():
            continue
        if believed.shape != (1, 2) or not np.array_equal(believed[0], wanted):
            return f"sample {i}: {believed.tolist()}, not {wanted.tolist()}"
    return ""


def replayed_places(trip: Trajectory, drive: TripDrive, lost: BoolArray) -> FloatArray:
    """Where the replay of an evaluation puts the sender at each sample, (2, T) [m].

    Parameters
    ----------
    trip
        What the sender saw.
    drive
        What was sent.
    lost
        Samples whose message the host misses, (1, T).
    """
    count = len(trip)
    still, east = np.zeros((count, 2)), np.tile([1.0, 0.0], (count, 1))
    return replay(drive.runtime, schedules_of([drive.walked]), lost, still, east).errors[2:4, 0]
