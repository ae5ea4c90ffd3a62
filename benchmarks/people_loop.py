"""What people cost in the closed loop: 1,000 vehicles alone, and with 1,000 people beside them.

A grid of 8 x 8 junctions, 45 vehicles a kilometre; 700 pedestrians and 300 cyclists, all of them stations
that send, hear and track as vehicles do; IEEE 802.11p with buildings. Processor times, the traffic apart; the
aim is 1.6 times the cost. ``people_loop.py [POLICY ...]``
"""

import sys
import time

import numpy as np

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.path_loss import ManhattanNlos
from modelcast.channel.propagation import Propagation, Shadowing, StreetGrid
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.sender.sender import named_sender
from modelcast.world.scenario.base import AbstractScenario, FleetFrame, run_scenario
from modelcast.world.scenario.grid import Grid
from modelcast.world.scenario.peopled_grid import PeopledGrid
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import SensorModel

SECONDS = 3.0
TOWN = Grid(8, 8, 45.0, warm_up_s=10.0)
AIM = 1.6
RADIO = Dsrc(
    propagation=Propagation(
        shadowing=Shadowing(decorrelation_m=10.0), streets=StreetGrid(200.0, 30.0), nlos=ManhattanNlos()
    )
)


def traffic(scenario: AbstractScenario[object]) -> tuple[list[FleetFrame], float]:
    """Frames, and the processor time of a step [s]."""
    state = scenario.init(np.random.default_rng(0))
    begun = time.process_time()
    for _ in range(20):
        state = scenario.step(state)
    step_s = (time.process_time() - begun) / 20
    return list(run_scenario(scenario, np.random.default_rng(0), duration_s=SECONDS)), step_s


def main() -> int:
    """Print the costs; 1 where people cost more than the aim."""
    found: dict[str, list[float]] = {}
    for name, scenario in (("vehicles", TOWN), ("with people", PeopledGrid(TOWN, 700, 300))):
        frames, step_s = traffic(scenario)
        print(f"{name}: {len(frames[0])} stations, {1e3 * step_s:.2f} ms a step of traffic", flush=True)
        for policy in sys.argv[1:] or ["j2945-mbc"]:
            sender, settings, sensor = (
                named_sender(policy),
                NetworkSettings(warm_up_s=0.0),
                FleetSensor(SensorModel()),
            )
            run_network(frames[:12], sender, RADIO, settings, seed=0, sensor=sensor)  # compiles
            begun = time.process_time()
            run = run_network(frames, sender, RADIO, settings, seed=0, sensor=sensor)
            took_s = (time.process_time() - begun) / SECONDS
            tracks = float(run.tally.held.sum()) / SECONDS
            found.setdefault(policy, []).append(took_s)
            print(
                f"  {policy}: {took_s:.3f} s a simulated second, {tracks / 1e6:.2f} million tracks",
                flush=True,
            )
    ratios = {policy: both[1] / both[0] for policy, both in found.items()}
    print("with people over vehicles alone:", ", ".join(f"{name} {one:.2f}" for name, one in ratios.items()))
    return int(max(ratios.values()) > AIM)


if __name__ == "__main__":
    raise SystemExit(main())
