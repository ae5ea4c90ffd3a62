"""What people cost in the closed loop: 1,000 vehicles alone, and with 1,000 people beside them.

A grid of 8 x 8 junctions, 45 vehicles a kilometre, 700 pedestrians and 300 cyclists; IEEE 802.11p with
buildings. Every person is a station in all arms: it moves, measures, decides, sends, contends, disturbs,
receives and tracks. In the arms of phones, as ``network --pedestrians`` has them, an antenna is 9.9 dB
weaker than a vehicle's (1.2 m high, 3 dB less gain), people keep a map of vehicles and pass over people
unread, and nobody tracks over more than 150 m where one is a person. Links of phones whose median is below
the noise are left out, those of vehicles at 10 dB. Processor times, the traffic apart, best of the turns
that arms take; the aim is 1.6 times the cost, for phones whose errors call for messages. ``people_loop.py
[POLICY]``
"""

import sys
import time
from collections.abc import Mapping

import numpy as np

from measured import record
from modelcast.channel.dsrc import Dsrc
from modelcast.channel.path_loss import ManhattanNlos, WinnerB1
from modelcast.channel.propagation import Propagation, Shadowing, StreetGrid
from modelcast.core.kinds import Kind
from modelcast.models.profile import people_profile
from modelcast.runtime.fleet.engine import NetworkRun, run_network
from modelcast.runtime.fleet.people import People
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.sender.names import MODEL_SENDERS
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.world.scenario.base import AbstractScenario, FleetFrame, run_scenario
from modelcast.world.scenario.grid import Grid
from modelcast.world.scenario.peopled_grid import PeopledGrid
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import SensorModel

SECONDS, TURNS = 2.0, 8
TOWN = Grid(8, 8, 45.0, warm_up_s=10.0)
AIM = 1.6
SETTINGS = NetworkSettings(warm_up_s=0.0)
RADIO = Dsrc(
    propagation=Propagation(
        shadowing=Shadowing(decorrelation_m=10.0), streets=StreetGrid(200.0, 30.0), nlos=ManhattanNlos()
    )
)
ALONE, AS_VEHICLES, PHONES = "vehicles alone", "people as vehicles", "phones, error-driven"

Arm = tuple[list[FleetFrame], People | None]


def traffic(scenario: AbstractScenario[object]) -> tuple[list[FleetFrame], float]:
    """Frames, and the processor time of a step [s]."""
    state = scenario.init(np.random.default_rng(0))
    begun = time.process_time()
    for _ in range(20):
        state = scenario.step(state)
    step_s = (time.process_time() - begun) / 20
    return list(run_scenario(scenario, np.random.default_rng(0), duration_s=SECONDS)), step_s


def phones(policy: str) -> People:
    """Phones that send by a policy, as ``network --pedestrians`` has them."""
    gain_db = WinnerB1().height_gain_db(1.2) - 3.0
    bank = people_profile().bank if policy in MODEL_SENDERS else None
    sender = named_sender(policy, bank=bank).of_kind(Kind.PEDESTRIAN).at_power(20.0)
    return People(sender, gain_db=gain_db, reach_m=150.0)


def timed(arm: Arm, sender: Sender) -> tuple[NetworkRun, float]:
    """A run, and its processor time a simulated second [s]."""
    frames, people = arm
    begun = time.process_time()
    run = run_network(
        frames, sender, RADIO, SETTINGS, seed=0, sensor=FleetSensor(SensorModel()), people=people
    )
    return run, (time.process_time() - begun) / SECONDS


def told(run: NetworkRun) -> str:
    """What a run did, in a second."""
    tracks, sent = float(run.tally.held.sum()) / SECONDS, float(run.sent.causes.sum()) / SECONDS
    line = f"{sent:.0f} messages/s, {tracks / 1e6:.2f} million tracks/s"
    if run.people is None:
        return line
    own, person_s = run.people, run.people.person_s
    return (
        f"{line}; a person sends {own.sent.causes.sum() / person_s:.2f}/s, receives "
        f"{own.received / person_s:.0f}/s and reads {own.read / person_s:.0f}/s"
    )


def measured(arms: Mapping[str, Arm], sender: Sender) -> dict[str, float]:
    """Least processor time of every arm [s]; they take turns, so that all meet the same machine."""
    runs: dict[str, NetworkRun] = {}
    least_s = dict.fromkeys(arms, np.inf)
    for turn in range(TURNS + 1):
        for name, arm in arms.items():
            runs[name], took_s = timed(arm, sender)
            if turn:  # the first compiles
                least_s[name] = min(least_s[name], took_s)
    for name, run in runs.items():
        ratio = least_s[name] / least_s[ALONE]
        peer = None if name == ALONE else (ALONE, least_s[ALONE])
        record(name, least_s[name], "s a simulated second", peer=peer)
        print(f"{name}: {least_s[name]:.3f} s a simulated second, {ratio:.2f}; {told(run)}", flush=True)
    return least_s


def main() -> int:
    """Print the costs; 1 where phones cost more than the aim."""
    policy = sys.argv[1] if len(sys.argv) > 1 else "j2945-mbc"
    frames: dict[str, list[FleetFrame]] = {}
    for name, scenario in (("vehicles", TOWN), ("with people", PeopledGrid(TOWN, 700, 300))):
        frames[name], step_s = traffic(scenario)
        print(f"{name}: {len(frames[name][0])} stations, {1e3 * step_s:.2f} ms a step of traffic", flush=True)
    arms: dict[str, Arm] = {
        ALONE: (frames["vehicles"], None),
        AS_VEHICLES: (frames["with people"], None),
        PHONES: (frames["with people"], phones("mbc")),
        f"phones, {policy}": (frames["with people"], phones(policy)),
    }
    least_s = measured(arms, named_sender(policy))
    return int(least_s[PHONES] / least_s[ALONE] > AIM)


if __name__ == "__main__":
    raise SystemExit(main())
