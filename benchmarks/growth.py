"""How cost grows with trips and with density, and how a fleet's run shrinks with threads.

Generated drives of two minutes, 1 to 16 of them, at the defaults: processor time a trip. The closed loop of
500 vehicles on shorter and shorter roads: processor time a vehicle and step. The same at 200/km by 1, 2 and 4
threads: time by the clock on the wall, which other work on the machine lengthens; results are the same
whatever their number. How cost grows with vehicles is in `network_loop` and `traffic`, with remotes in
`local_dynamic_map`, with rows in `corpus`.
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
from modelcast.world.scenario.base import FleetFrame, run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import SensorModel

DRIVE_S = 120.0
TRIPS, THREADS = (1, 2, 4, 8, 16), (1, 2, 4)
VEHICLES, DENSITY_PER_KM, SECONDS, TURNS = 500, 200.0, 3.0, 3
DENSITIES_PER_KM = (50.0, 100.0, 200.0, 400.0)


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


def frames_of(density_per_km: float) -> list[FleetFrame]:
    """Traffic of the vehicles at a density."""
    road = Highway(1000.0 * VEHICLES / density_per_km, density_per_km, warm_up_s=10.0)
    return list(run_scenario(road, np.random.default_rng(0), duration_s=SECONDS))


def run(frames: list[FleetFrame], threads: int = 1) -> None:
    """The closed loop, J2945/1 with models, IEEE 802.11p."""
    settings, sensor = NetworkSettings(warm_up_s=0.0), FleetSensor(SensorModel())
    run_network(frames, named_sender("j2945-mbc"), Dsrc(), settings, seed=0, sensor=sensor, threads=threads)


def by_density() -> None:
    """Print the least processor time of a vehicle and step, densities in turn."""
    frames = {density: frames_of(density) for density in DENSITIES_PER_KM}
    least_s = dict.fromkeys(DENSITIES_PER_KM, np.inf)
    run(frames[DENSITIES_PER_KM[0]])  # compiles
    for _ in range(TURNS):
        for density in DENSITIES_PER_KM:
            begun_s = time.process_time()
            run(frames[density])
            least_s[density] = min(least_s[density], time.process_time() - begun_s)
    for density, took_s in least_s.items():
        each_us = 1e6 * took_s / (len(frames[density]) * VEHICLES)
        record(
            f"closed loop of {VEHICLES} vehicles", each_us, "µs a vehicle and step", sizes={"per km": density}
        )
        print(f"{density:g} vehicles/km: {each_us:.1f} us a vehicle and step", flush=True)


def by_threads() -> None:
    """Print the least time of a run, threads in turn."""
    frames = frames_of(DENSITY_PER_KM)
    least_s = dict.fromkeys(THREADS, np.inf)
    for turn in range(TURNS + 1):
        for threads in THREADS:
            begun_s = time.perf_counter()
            run(frames, threads)
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
    """Print all."""
    by_trips()
    by_density()
    by_threads()


if __name__ == "__main__":
    main()
