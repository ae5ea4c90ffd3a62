"""Simulated streams of ``modelcast safety --streams``: hard braking, as if every vehicle had recorded it."""

from collections.abc import Callable

from modelcast.core.chance import child_generator
from modelcast.trips.trajectory import Trajectory
from modelcast.world.scenario.as_trips import fleet_trips
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.braking import BrakingStreams

__all__ = ["STREAM_S", "stream_trips"]

STREAM_S = 120.0
"""How long a road of streams is driven [s]."""

_ROAD = BrakingStreams(1500.0, 30.0, lanes=2, brakings_per_minute=12.0)


def stream_trips(count: int, seed: int, *, progress: Callable[[int, int], None]) -> list[Trajectory]:
    """Trips of so many roads on which leaders brake hard now and then.

    Parameters
    ----------
    count
        How many roads.
    seed
        Of all random numbers.
    progress
        Takes roads done and roads to do.
    """
    found: list[Trajectory] = []
    for number in range(count):
        frames = run_scenario(_ROAD, child_generator(seed, number, "streams"), duration_s=STREAM_S)
        found += fleet_trips(frames, f"stream {number}")
        progress(number + 1, count)
    return found
