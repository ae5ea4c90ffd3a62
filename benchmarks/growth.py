"""How an evaluation's cost grows with trips, and how a fleet's run shrinks with threads.

Generated drives of two minutes, 1 to 16 of them, at the defaults: processor time a trip. The closed loop of
500 vehicles by 1, 2 and 4 threads: time by the clock on the wall, which other work on the machine lengthens;
results are the same whatever their number. How cost grows with vehicles is in `network_loop` and `traffic`,
with remotes in `local_dynamic_map`, with rows in `corpus`.
"""

import time

import numpy as np

from measured import record
from modelcast.channel.dsrc import Dsrc
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.sender.sender import named_sender
from modelcast.study.case import SensedTrip
from modelcast.study.evaluate import evaluate
from modelcast.study.settings import EvaluationSettings
from modelcast.world.drive import generate_drive
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import SensorModel

DRIVE_S = 120.0
TRIPS, THREADS = (1, 2, 4, 8, 16), (1, 2, 4)
VEHICLES, DENSITY_PER_KM, SECONDS, TURNS = 500, 200.0, 3.0, 3


def by_trips() -> None:
    """Print processor time a trip."""
    drives = [generate_drive(seed=seed, duration_s=DRIVE_S) for seed in range(max(TRIPS))]
    trips = [SensedTrip(drive.truth, drive.input) for drive in drives]
    settings = EvaluationSettings(seeds=1)
    evaluate(trips[:1], settings)  # compiles
    for count in TRIPS:
        begun_s = time.process_time()
        evaluate(trips[:count], settings)
        took_s = (time.process_time() - begun_s) / count
        record("evaluation of drives of two minutes, one seed", took_s, "s a trip", sizes={"trips": count})
        print(f"{count} trips: {took_s:.3f} s a trip", flush=True)


def by_threads() -> None:
    """Print the least time of a run, threads in turn."""
    road = Highway(1000.0 * VEHICLES / DENSITY_PER_KM, DENSITY_PER_KM, warm_up_s=10.0)
    frames = list(run_scenario(road, np.random.default_rng(0), duration_s=SECONDS))
    settings, sender = NetworkSettings(warm_up_s=0.0), named_sender("j2945-mbc")
    least_s = dict.fromkeys(THREADS, np.inf)
    for turn in range(TURNS + 1):
        for threads in THREADS:
            begun_s = time.perf_counter()
            run_network(
                frames, sender, Dsrc(), settings, seed=0, sensor=FleetSensor(SensorModel()), threads=threads
            )
            if turn:  # the first compiles
                least_s[threads] = min(least_s[threads], time.perf_counter() - begun_s)
    for threads, took_s in least_s.items():
        record(
            f"closed loop of {VEHICLES} vehicles, wall clock",
            took_s / SECONDS,
            "s a simulated second",
            sizes={"threads": threads},
        )
        print(f"{threads} threads: {took_s / SECONDS:.3f} s a simulated second")


def main() -> None:
    """Print both."""
    by_trips()
    by_threads()


if __name__ == "__main__":
    main()
