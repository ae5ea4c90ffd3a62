"""How much there is to do for safety applications in the built-in traffic, and what it costs to drive it."""

import time

import numpy as np

from measured import record
from modelcast.world.scenario.base import STEP_S
from modelcast.world.scenario.braking import BrakingStreams
from modelcast.world.scenario.grid import Grid

DURATION_S = 600.0
SEEDS = (1, 2, 3)


def streams(name: str, scenario: BrakingStreams) -> None:
    """Print the events of some seeds of streams together."""
    totals, took = np.zeros(4, dtype=np.int64), 0.0
    for seed in SEEDS:
        state = scenario.init(np.random.default_rng(seed))
        begun = time.process_time()
        for _ in range(round(DURATION_S / STEP_S)):
            state = scenario.step(state)
        took += time.process_time() - begun
        totals += [state.brakings, state.cut_ins, state.near_collisions, state.contacts]
    record(name, len(SEEDS) * DURATION_S / took, "times real time", sizes={"vehicles": scenario.slots})
    print(
        f"{name:34s} {scenario.slots:4d} vehicles: {totals[0]:4d} brakings, {totals[1]:4d} cut-ins, "
        f"{totals[2]:4d} near-collisions, {totals[3]:3d} contacts, "
        f"{len(SEEDS) * DURATION_S / took:6.0f} x real time (CPU)"
    )


def crossings(name: str, scenario: Grid) -> None:
    """Print the crossings of some seeds of a grid together."""
    crossed, misjudged, speed, took = 0, 0, 0.0, 0.0
    for seed in SEEDS:
        state = scenario.init(np.random.default_rng(seed))
        begun = time.process_time()
        for _ in range(round(DURATION_S / STEP_S)):
            state = scenario.step(state)
        took += time.process_time() - begun
        crossed, misjudged = crossed + state.crossings, misjudged + state.misjudged
        speed += float(scenario.frame(state).speed_mps.mean()) / len(SEEDS)
    print(
        f"{name:34s} {scenario.slots:4d} vehicles: {crossed:5d} crossings, {misjudged:4d} misjudged, "
        f"{speed:4.1f} m/s at the end, {len(SEEDS) * DURATION_S / took:6.0f} x real time (CPU)"
    )


def main() -> None:
    """Drive each scenario for 10 minutes with three seeds."""
    for density, lanes in ((25.0, 3), (60.0, 3), (100.0, 3), (200.0, 4), (400.0, 6)):
        shape = f"{density:g}/km, {lanes} lanes"
        streams(f"braking, {shape}", BrakingStreams(2000.0, density, lanes=lanes))
    calm = BrakingStreams(2000.0, 60.0, brakings_per_minute=0.0, cut_ins_per_minute=20.0)
    streams("cut-in, 60/km, 3 lanes", calm)
    streams("neither, 60/km, 3 lanes", BrakingStreams(2000.0, 60.0, brakings_per_minute=0.0))
    streams("neither, 400/km, 6 lanes", BrakingStreams(2000.0, 400.0, lanes=6, brakings_per_minute=0.0))
    for density in (15.0, 25.0):
        for ratio in (0.0, 0.5, 1.0):
            grid = Grid(6, 6, density, junctions="priority", straight_ratio=0.8, misjudged_ratio=ratio)
            crossings(f"priority, {density:g}/km, misjudged {ratio:g}", grid)
    crossings("signals, 20/km, misjudged 0.5", Grid(5, 5, 20.0, misjudged_ratio=0.5))


if __name__ == "__main__":
    main()
