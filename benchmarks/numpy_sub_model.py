"""What a sub-model in plain NumPy costs beside the same one compiled: constant velocity, both ways.

Prints processor times of both and their ratio: a fit and a prediction inside a compiled loop, the fit of a
predicted path, a row of a large batch, a sample of an evaluation, and a step of a vehicle in a network,
where messages carry the predicted path or the sub-model's own parameters. Rounds of both alternate; the
shortest of each counts.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from measured import record
from modelcast.channel.dsrc import Dsrc
from modelcast.core.arrays import FloatArray
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel, Windows
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.numpy_model import AbstractNumpySubModel
from modelcast.models.payload import PayloadLayout
from modelcast.models.predicted_path import PredictedPath
from modelcast.models.row_independence import made_up_windows
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.runtime.trip.runtime import TripRuntime, sense_trip
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sender.sender import Sender
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.world.drive import generate_drive
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import SensorModel

ROUNDS, ROWS, BATCH = 5, 1000, 10_000
VEHICLES_PER_KM, LENGTH_M, SECONDS = 100.0, 500.0, 5.0
DT_S = 0.1
HORIZON_S = np.array([0.5])
LOOP = AbstractSubModel
"""Its methods go through the compiled loops."""


@dataclass(frozen=True, slots=True)
class Coasting(AbstractNumpySubModel):
    """Constant velocity in NumPy; messages carry its parameters in Part I."""

    name = "coasting"
    window = 1
    parameter_names = ("velocity_east_mps", "velocity_north_mps")
    payload_layout = PayloadLayout()

    def fit_batch(self, windows: Windows) -> FloatArray:
        """Newest velocities."""
        return windows.velocities_mps[:, -1]

    def predict_batch(
        self,
        parameters: FloatArray,
        horizons_s: FloatArray,
        *,
        dt_s: float,  # noqa: ARG002 - coasting knows no interval
    ) -> FloatArray:
        """Straight on."""
        return parameters[:, None, :] * horizons_s[:, None]


def shortest_s(first: Callable[[], object], second: Callable[[], object]) -> tuple[float, float]:
    """Shortest processor times of two that alternate, after one round that warms up."""
    times: tuple[list[float], list[float]] = ([], [])
    for turn in range(ROUNDS + 1):
        for into, one in zip(times, (first, second), strict=True):
            begun = time.process_time()
            one()
            if turn:
                into.append(time.process_time() - begun)
    return min(times[0]), min(times[1])


def show(what: str, count: float, compiled: Callable[[], object], numpy: Callable[[], object]) -> None:
    """Print a line: microseconds a piece of both, and the ratio."""
    fast_s, slow_s = shortest_s(compiled, numpy)
    record(what, 1e6 * fast_s / count, "µs", peer=("the same in NumPy", 1e6 * slow_s / count))
    print(
        f"{what:42s} compiled {1e6 * fast_s / count:9.3f} us   NumPy {1e6 * slow_s / count:9.3f} us   "
        f"{slow_s / fast_s:7.1f} times",
        flush=True,
    )


def evaluation(model: AbstractSubModel) -> Callable[[], object]:
    """A policy over a drive of ten minutes."""
    drive = generate_drive(seed=0, duration_s=600.0).input
    estimator = velocity_estimator_for(drive)
    sensed = sense_trip(drive, estimator)
    bank = Bank((model,))
    return lambda: TripRuntime(drive, bank, estimator, sensed=sensed).run(ErrorDriven(0.3))


def network(model: AbstractSubModel) -> Callable[[], object]:
    """Vehicles on a road that send with this sub-model and track one another with it."""
    road = Highway(LENGTH_M, VEHICLES_PER_KM, warm_up_s=10.0)
    frames = list(run_scenario(road, np.random.default_rng(0), duration_s=SECONDS))
    sender = Sender(model.name, ErrorDriven(0.3, identify="never"), Bank((model,)))
    settings = NetworkSettings(warm_up_s=0.0)
    return lambda: run_network(frames, sender, Dsrc(), settings, seed=0, sensor=FleetSensor(SensorModel()))


def main() -> None:
    """Print the table."""
    compiled, numpy = ConstantVelocity(), Coasting()
    windows, many = (made_up_windows(1, dt_s=DT_S, rows=rows) for rows in (ROWS, BATCH))
    parameters = compiled.fit(windows)
    show(
        "fit, in a compiled loop",
        ROWS,
        lambda: LOOP.fit(compiled, windows),
        lambda: LOOP.fit(numpy, windows),
    )
    show(
        "predict, in a compiled loop",
        ROWS,
        lambda: LOOP.predict(compiled, parameters, HORIZON_S, dt_s=DT_S),
        lambda: LOOP.predict(numpy, parameters, HORIZON_S, dt_s=DT_S),
    )
    paths = PredictedPath(compiled), PredictedPath(numpy)
    show("fit of the predicted path", ROWS, lambda: paths[0].fit(windows), lambda: paths[1].fit(windows))
    show(f"fit, a row of a batch of {BATCH}", BATCH, lambda: compiled.fit(many), lambda: numpy.fit(many))
    steps = 600.0 / DT_S
    show("evaluation, a sample", steps, evaluation(compiled), evaluation(numpy))
    show("evaluation of the path, a sample", steps, evaluation(paths[0]), evaluation(paths[1]))
    steps = VEHICLES_PER_KM * LENGTH_M / 1000.0 * SECONDS / DT_S
    show("network, a vehicle and step", steps, network(compiled), network(numpy))
    show("network by the path, a vehicle and step", steps, network(paths[0]), network(paths[1]))


if __name__ == "__main__":
    main()
