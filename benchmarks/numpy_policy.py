"""What a policy in NumPy costs beside the same rule compiled: the error-driven policy, both ways.

Prints processor times of both and their ratio: a step of the sending stations of a fleet, by the number of
vehicles, a step of the whole loop of a network, by vehicle, and a sample of an evaluation. Rounds of both
alternate; the shortest of each counts.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from modelcast.channel.dsrc import Dsrc
from modelcast.core.arrays import FloatArray
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.runtime.trip.runtime import TripRuntime, sense_trip
from modelcast.station.fleet import Fleet
from modelcast.station.policy.base import AbstractTransmitPolicy, Decisions, TransmitInputs
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sender.sender import Sender
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.world.drive import generate_drive
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import SensorModel
from numpy_sub_model import show

FLEETS, STEPS, DT_S = (1, 10, 100, 1000), 50, 0.1
VEHICLES_PER_KM, LENGTH_M, SECONDS = 100.0, 500.0, 5.0
COMPILED = ErrorDriven(0.3, identify="never")
BANK = Bank((ConstantVelocity(),))


@dataclass(frozen=True, slots=True)
class Asked(AbstractTransmitPolicy[Any]):
    """The compiled rule's words in NumPy, asked by `decide` as another package's policy is."""

    rule: ErrorDriven = COMPILED

    @property
    def longest_silence_s(self) -> float:
        """Of the rule [s]."""
        return self.rule.longest_silence_s

    def init(self, vehicles: int, sub_models: int) -> Any:
        """Of the rule."""
        return self.rule.init(vehicles, sub_models)

    def decide(self, state: Any, inputs: TransmitInputs, rng: np.random.Generator) -> tuple[Decisions, Any]:
        """By the rule."""
        return self.rule.decide(state, inputs, rng)


def stations(policy: AbstractTransmitPolicy[Any], vehicles: int) -> Callable[[], object]:
    """Vehicles that drive straight on and brake by turns, each with a station that sends by this policy."""
    sender = Sender("policy", policy, BANK)
    rng, car = np.random.default_rng(1), np.arange(vehicles)
    place_m, speed, still = (
        1000.0 * rng.normal(size=(vehicles, 2)),
        rng.uniform(5.0, 20.0, vehicles),
        0.0 * car,
    )
    steps: list[tuple[FloatArray, FloatArray, FloatArray]] = []
    for step in range(STEPS):
        acceleration = np.sin(0.3 * step + car)
        steps.append((place_m, speed, acceleration))
        place_m = place_m + np.stack([still, DT_S * speed], axis=1)
        speed = np.maximum(speed + DT_S * acceleration, 0.0)

    def run() -> None:
        fleet = Fleet(sender, slots=vehicles, seed=3)
        for step, (place, driven, acceleration) in enumerate(steps):
            fleet.sense(
                DT_S * step,
                car,
                place,
                speed_mps=driven,
                heading_rad=still,
                acceleration_mps2=acceleration,
                yaw_rate_radps=still,
            )

    return run


def evaluation(decides: Asked | None) -> Callable[[], object]:
    """The rule over a drive of ten minutes, compiled or asked."""
    drive = generate_drive(seed=0, duration_s=600.0).input
    estimator = velocity_estimator_for(drive)
    sensed = sense_trip(drive, estimator)
    return lambda: TripRuntime(drive, BANK, estimator, sensed=sensed, decides=decides).run(COMPILED)


def network(policy: AbstractTransmitPolicy[Any]) -> Callable[[], object]:
    """Vehicles on a road that send by this policy and track one another."""
    road = Highway(LENGTH_M, VEHICLES_PER_KM, warm_up_s=10.0)
    frames = list(run_scenario(road, np.random.default_rng(0), duration_s=SECONDS))
    sender, settings = Sender("policy", policy, BANK), NetworkSettings(warm_up_s=0.0)
    return lambda: run_network(frames, sender, Dsrc(), settings, seed=0, sensor=FleetSensor(SensorModel()))


def main() -> None:
    """Print the table."""
    for vehicles in FLEETS:
        what = f"step of {vehicles} stations"
        show(what, STEPS, stations(COMPILED, vehicles), stations(Asked(), vehicles))
    steps = VEHICLES_PER_KM * LENGTH_M / 1000.0 * SECONDS / DT_S
    show("network, a vehicle and step", steps, network(COMPILED), network(Asked()))
    show("evaluation, a sample", 600.0 / DT_S, evaluation(None), evaluation(Asked()))


if __name__ == "__main__":
    main()
