"""A simulated fleet as trips on one clock, as if every vehicle had recorded its drive."""

from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.scenario.base import STEP_S, FleetFrame

__all__ = ["fleet_trips"]


def fleet_trips(
    frames: Iterable[FleetFrame], name: str, *, least_s: float = 10.0, source: str = "simulated"
) -> list[Trajectory]:
    """One trip a vehicle, by rising identifier; who was there for less than ``least_s`` has none.

    Parameters
    ----------
    frames
        Of one run, `STEP_S` apart.
    name
        First part of the trips' identifiers; the vehicle's identifier is the second.
    least_s
        Shortest trip [s].
    source
        As in `Trajectory`.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.world.scenario.base import run_scenario
    >>> from modelcast.world.scenario.highway import Highway
    >>> road = Highway(1000.0, 10.0, form="ring", warm_up_s=0.0)
    >>> trips = fleet_trips(run_scenario(road, np.random.default_rng(1), duration_s=12.0), "ring")
    >>> len(trips), trips[3].trip_id, trips[3].t_s.size
    (10, 'ring/3', 120)
    """
    rows = [_rows(frame) for frame in frames]
    table = np.concatenate(rows) if rows else np.empty((0, 8))
    table = table[np.lexsort((table[:, 1], table[:, 0]))]
    bounds = np.flatnonzero(np.diff(table[:, 0], prepend=np.nan, append=np.nan) != 0.0)
    found: list[Trajectory] = []
    for a, b in pairwise(bounds.tolist()):
        own = table[a:b]
        if len(own) * STEP_S < least_s - 1e-9:
            continue
        found.append(
            build_trajectory(
                f"{name}/{int(own[0, 0])}",
                own[:, 1],
                own[:, 2:4],
                speed_mps=own[:, 4],
                heading_rad=own[:, 5],
                acceleration_mps2=own[:, 6],
                yaw_rate_radps=own[:, 7],
                clock_s=float(own[0, 1]),
                source=source,
            )
        )
    return found


def _rows(frame: FleetFrame) -> FloatArray:
    """The vehicles of a frame, (N, 8): identifier, time, place and motion."""
    here = np.flatnonzero(frame.active)
    return np.column_stack(
        (
            frame.vehicle_id[here],
            np.full(here.size, frame.t_s),
            frame.position_m[here],
            frame.speed_mps[here],
            frame.heading_rad[here],
            frame.acceleration_mps2[here],
            frame.yaw_rate_radps[here],
        )
    )
