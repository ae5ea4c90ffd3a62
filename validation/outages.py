"""How far dead reckoning goes astray on real trips, and how often within its own ellipse.

Trips of the folder that ``MODELCAST_DATA`` names are replayed. From every seventh second on the fixes are
withheld; the bus goes on. At whole seconds of the outage the motion that `MotionSource` gives is compared
with the recorded place. The recorded place is where the outage begins, so the ellipse that counts is that
of the growth alone, without the fix's own.

Two of the trips have a bus that measures. The third (`HELD`) has speed, heading and yaw rate of a receiver,
smoothed over seconds and held for one, and places on a grid of half a metre: what such a bus is worth is
shown, not judged. ``--write`` puts the table into ``docs/node-inputs.md``, ``--check`` returns 1 where the
page has another.
"""

import argparse
import math
import os
import sys
from pathlib import Path

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.io.trips import read_trips
from modelcast.node.inputs.motion_source import MotionSource
from modelcast.node.inputs.reckoning import DEFAULT_AXIS_M
from modelcast.node.inputs.replay import TripReplay
from modelcast.node.inputs.samples import GnssFix
from modelcast.trips.trajectory import Trajectory
from page_blocks import put

__all__ = ["main", "outage_errors"]

PAGE = Path(__file__).parents[1] / "docs" / "node-inputs.md"

TRIPS = ("comma2k19", "smartloc")
HELD = ("spmd/bsm_p1_dev.csv",)
EVERY_S = 7.0
LEARN_S = 12.0
WITHIN_95 = -2.0 * math.log(0.05)
"""Square of the standard deviations within which 95 % of a normal error on a plane lie."""


def outage_errors(trip: Trajectory, ages_s: FloatArray) -> FloatArray:
    """Errors in outages of a trip, (N, 4): age [s], distance [m], 95 % radius [m], and whether it is within.

    Parameters
    ----------
    trip
        With speed and yaw rate.
    ages_s
        When it is looked at after the last fix, rising, (A,) [s].
    """
    rows: list[tuple[float, float, float, float]] = []
    begin_s = LEARN_S
    while begin_s + ages_s[-1] < float(trip.t_s[-1]):
        rows += _one_outage(trip, begin_s, ages_s)
        begin_s += EVERY_S
    return np.array(rows).reshape(-1, 4)


def _one_outage(
    trip: Trajectory, begin_s: float, ages_s: FloatArray
) -> list[tuple[float, float, float, float]]:
    replay = TripReplay(trip)
    source = MotionSource(replay.origin, dead_reckoning_s=float(ages_s[-1]) + 1.0)
    samples = replay.take(begin_s + float(ages_s[-1]) + 0.1)
    kept = [one for one in samples if not (isinstance(one, GnssFix) and one.measured_s > begin_s)]
    last_s = max(one.measured_s for one in kept if isinstance(one, GnssFix))
    if begin_s - last_s > 0.3:
        return []  # in a gap of the trip
    source.feed(one for one in kept if one.measured_s >= begin_s - LEARN_S)
    rows: list[tuple[float, float, float, float]] = []
    for age_s in ages_s.tolist():
        motion = source.at(last_s + age_s)
        if motion is None or motion.mode != "can":
            break
        place_m = [np.interp(motion.t_s, trip.t_s, trip.position_m[:, axis]) for axis in (0, 1)]
        error_m = np.array(motion.position_m) - np.array(place_m)
        growth = motion.covariance_m2 - DEFAULT_AXIS_M**2 * np.eye(2) + 1e-6 * np.eye(2)
        distance = float(error_m @ np.linalg.solve(growth, error_m))
        radius_m = math.sqrt(WITHIN_95 * float(np.linalg.eigvalsh(growth)[1]))
        rows.append((age_s, float(np.hypot(*error_m)), radius_m, float(distance <= WITHIN_95)))
    return rows


def main(arguments: list[str] | None = None) -> int:
    """Print a table; returns 1 where fewer than nine in ten are within."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    parser.add_argument(
        "--ages", type=float, nargs="+", default=[1.0, 2.0, 3.0, 5.0], help="after the last fix [s]"
    )
    given = parser.parse_args(arguments)
    ages_s = np.array(given.ages)
    lines = [
        "| trip | after | outages | error p50 | p95 | 95 % radius p50 | within |",
        "|---|---|---|---|---|---|---|",
    ]
    within: list[float] = []
    for name in TRIPS + HELD:
        for trip in read_trips(Path(os.environ["MODELCAST_DATA"]) / name):
            errors = outage_errors(trip, ages_s)
            for age_s in ages_s:
                here = errors[errors[:, 0] == age_s]
                p50, p95 = np.quantile(here[:, 1], [0.5, 0.95])
                lines.append(
                    f"| {name} | {age_s:g} s | {len(here)} | {p50:.2f} m | {p95:.2f} m | "
                    f"{np.median(here[:, 2]):.2f} m | {100 * here[:, 3].mean():.0f} % |"
                )
            if name in TRIPS:
                within.append(float(errors[:, 3].mean()))
    print("\n".join(lines))
    stale = put({PAGE: {"outages": lines}}, check=given.check) if given.write or given.check else 0
    return stale or int(min(within) < 0.9)


if __name__ == "__main__":
    sys.exit(main())
