"""Time the closed loop on one core: against real time, and what a vehicle costs in fleets of many sizes.

1,000 vehicles on 5 km, J2945/1 with models, IEEE 802.11p, all pairs within 300 m tracked at 10 Hz; then the
same density on longer roads. Times are processor times, so that other work on the machine counts less; a
second factor is by the clock on the wall. The traffic is made beforehand and is not counted; it costs 0.3 ms
a step of 1,000 vehicles (`traffic.py`).
"""

import time

import numpy as np

from measured import record
from modelcast.channel.dsrc import Dsrc
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.sender.sender import named_sender
from modelcast.world.scenario.base import FleetFrame, run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import SensorModel
from paired_scenarios import STAGES, added_up

DENSITY_PER_KM = 200.0
SECONDS = 10.0


def frames_of(vehicles: int, seconds: float) -> list[FleetFrame]:
    """Traffic of so many vehicles at the density."""
    road = Highway(1000.0 * vehicles / DENSITY_PER_KM, DENSITY_PER_KM, warm_up_s=10.0)
    return list(run_scenario(road, np.random.default_rng(0), duration_s=seconds))


def run_s(frames: list[FleetFrame], policy: str) -> tuple[float, float, float]:
    """Processor time and wall time of a run, and how many tracks were sampled a simulated second."""
    settings = NetworkSettings(warm_up_s=0.0)
    sensor = FleetSensor(SensorModel())
    begun, begun_wall = time.process_time(), time.perf_counter()
    run = run_network(frames, named_sender(policy), Dsrc(), settings, seed=0, sensor=sensor)
    took_s, wall_s = time.process_time() - begun, time.perf_counter() - begun_wall
    return took_s, wall_s, float(run.tally.held.sum()) / (0.1 * len(frames))


def main() -> None:
    """Print the times."""
    few = frames_of(40, 2.0)
    for policy in ("j2945-mbc", "j2945"):
        run_s(few, policy)  # compiles
    for vehicles in (250, 500, 1000, 2000, 5000):
        seconds = SECONDS if vehicles <= 1000 else 4.0
        frames = frames_of(vehicles, seconds)
        took_s, wall_s, tracks = run_s(frames, "j2945-mbc")
        each_us = 1e6 * took_s / (10.0 * seconds * vehicles)
        record("closed loop, 200/km", each_us, "µs a vehicle and step", sizes={"vehicles": vehicles})
        print(
            f"{vehicles} vehicles: {seconds / took_s:.1f} x real time ({seconds / wall_s:.1f} on the wall), "
            f"{each_us:.1f} us a vehicle and step, "
            f"{tracks / 1e6:.2f} million tracks sampled a second",
            flush=True,
        )
    frames = frames_of(1000, SECONDS)
    spent: dict[str, float] = {}
    for name in STAGES:
        setattr(FleetLoop, name, added_up(spent, name, getattr(FleetLoop, name), time.process_time))
    for policy in ("j2945-mbc", "j2945"):
        spent.clear()
        took_s, _, _ = run_s(frames, policy)
        shares = ", ".join(f"{name.strip('_')} {share / SECONDS:.3f}" for name, share in spent.items())
        print(f"{policy}, 1000 vehicles: {took_s / SECONDS:.3f} s a simulated second: {shares}")


if __name__ == "__main__":
    main()
