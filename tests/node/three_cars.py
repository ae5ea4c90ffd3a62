"""Three cars that hear each other over a lossy medium on a clock of their own, some of them recorded."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from modelcast.channel.erasure import IndependentErasure
from modelcast.core.geodesy import Origin
from modelcast.node.building import envelope_of, node_of
from modelcast.node.config import NodeConfig, Pseudonyms
from modelcast.node.credentials import Credentials
from modelcast.node.inputs.motion_source import MotionSource
from modelcast.node.inputs.replay import TripReplay
from modelcast.node.node import Node
from modelcast.node.recording.making import about_node
from modelcast.node.recording.recorder import Recorder
from modelcast.node.showing import Showing
from modelcast.runtime.transport.virtual import VirtualMedium
from modelcast.station.sender.sender import named_sender
from modelcast.world.drive import generate_drive

__all__ = ["SEEDS", "UTC_S", "Car", "drive"]

UTC_S = 1_764_000_000.0
SEEDS = (11, 12)


@dataclass
class Car:
    """A node, what it measures by, and what records it."""

    node: Node
    trip: TripReplay
    motion: MotionSource
    recorder: Recorder | None


def drive(
    folder: Path,
    *,
    steps: int = 80,
    recorded: int = 1,
    config: NodeConfig | None = None,
    most_octets: float = 1e9,
    credentials: Credentials | None = None,
    after: Callable[[list[Car]], None] | None = None,
) -> list[Path]:
    """Drive three cars side by side; returns what was recorded of the first so many."""
    asked = config or NodeConfig(pseudonyms=Pseudonyms(least_s=2.0, most_s=3.0))
    medium = VirtualMedium(IndependentErasure(0.3), delay_s=0.02, jitter_s=0.03, seed=5)
    sender = named_sender(asked.sending.policy)
    cars: list[Car] = []
    origin = Origin(48.0, 11.0, 500.0)
    for number in range(3):
        truth = generate_drive(4 + number, 90.0).truth
        trip = TripReplay(replace(truth, position_m=truth.position_m + 5.0 * number, origin=origin))
        names_seed, station_seed = SEEDS[0] + 2 * number, SEEDS[1] + 2 * number
        recorder = None
        if number < recorded:
            about = about_node(
                asked,
                sender,
                utc_at_zero_s=UTC_S,
                origin=origin,
                names_seed=names_seed,
                station_seed=station_seed,
                credentials=credentials,
            )
            recorder = Recorder(folder, about, begin_s=0.0, most_octets=most_octets)
        envelope = envelope_of(credentials, asked.security, utc_at_zero_s=UTC_S, names_seed=names_seed)
        node = node_of(
            asked,
            sender,
            medium.join(),
            envelope,
            origin=origin,
            names_seed=names_seed,
            station_seed=station_seed,
            record=recorder,
        )
        cars.append(Car(node, trip, MotionSource(origin), recorder))
    shows = [Showing(car.node) for car in cars]
    for step in range(steps):
        now_s = 0.1 * step
        for car, show in zip(cars, shows, strict=True):
            car.node.hear(now_s)
            samples = car.trip.take(now_s)
            car.motion.feed(samples)
            state = car.node.step(now_s, None if 40 <= step < 44 else car.motion.at(now_s))
            car.node.send(now_s + 0.004)
            if car.recorder is not None:
                car.recorder.sampled(now_s, samples)
                if car.recorder.wants_page:
                    car.recorder.shown(show.snapshot(state))
        for car in cars:
            car.node.hear(now_s + 0.03)
            car.node.send(now_s + 0.05)
        if after is not None:
            after(cars)
    found = [car.recorder for car in cars if car.recorder is not None]
    for recorder in found:
        recorder.close()
    return [recorder.path for recorder in found]
