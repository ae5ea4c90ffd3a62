"""How many changes of name a simple tracker joins again, in traffic that sends ten times a second.

All vehicles change their names at once and are silent for a while. The tracker heard every message before and
hears every one after; it matches each new name to the one that ended whose predicted place (last place and
velocity) is nearest, one to one, by the least sum of distances; with a profile's name in messages only within
equal profiles. ``linkage.py`` prints the table;
``--write`` puts it into ``docs/security.md``, ``--check`` tells by its exit code whether that page has it.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy import optimize, stats

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.world.scenario.base import NOBODY, STEP_S, FleetFrame, run_scenario
from modelcast.world.scenario.highway import Highway
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "security.md"
SEEDS = 10
LENGTH_M, WARM_UP_S = 2000.0, 10.0
DENSITIES_PER_KM = (50.0, 200.0)
SILENCES_S = (0.1, 1.0, 5.0, 10.0)
PROFILES = 4
"""Kinds of profile in the fleet, evenly drawn: a profile is shared by a quarter of the stations."""

_FAR_M = 1e6


def _velocity(frame: FleetFrame) -> FloatArray:
    course = np.column_stack((np.sin(frame.heading_rad), np.cos(frame.heading_rad)))
    return frame.speed_mps[:, None] * course


def rejoined(before: FleetFrame, after: FleetFrame, silence_s: float, profiles: IntArray | None) -> float:
    """Share of the vehicles heard before and after whose new name is joined to its old one."""
    ids = np.intersect1d(before.vehicle_id, after.vehicle_id)
    ids = ids[ids != NOBODY]
    old = np.array([np.flatnonzero(before.vehicle_id == one)[0] for one in ids.tolist()])
    new = np.array([np.flatnonzero(after.vehicle_id == one)[0] for one in ids.tolist()])
    predicted = (before.position_m + silence_s * _velocity(before))[old]
    cost = np.linalg.norm(predicted[:, None, :] - after.position_m[new][None, :, :], axis=2)
    if profiles is not None:
        cost[profiles[old][:, None] != profiles[old][None, :]] = _FAR_M
    rows, columns = optimize.linear_sum_assignment(cost)
    return float((rows == columns).mean())


def _share(density: float, silence_s: float, *, named: bool) -> str:
    found: list[float] = []
    for seed in range(SEEDS):
        rng = np.random.default_rng(seed)
        frames = list(
            run_scenario(Highway(LENGTH_M, density, warm_up_s=WARM_UP_S), rng, duration_s=silence_s + STEP_S)
        )
        profiles = rng.integers(PROFILES, size=frames[0].vehicle_id.size) if named else None
        found.append(rejoined(frames[0], frames[round(silence_s / STEP_S)], silence_s, profiles))
    half = stats.t.ppf(0.975, SEEDS - 1) * np.std(found, ddof=1) / np.sqrt(SEEDS)
    return f"{100 * np.mean(found):.1f} ± {100 * half:.1f} %"


def table() -> Iterator[str]:
    """Lines of the table."""
    yield "| vehicles/km | silence at the change, s | joined again | with profiles that a quarter shares |"
    yield "|---|---|---|---|"
    for density in DENSITIES_PER_KM:
        for silence_s in SILENCES_S:
            shares = (_share(density, silence_s, named=named) for named in (False, True))
            yield f"| {density:g} | {silence_s:g} | {' | '.join(shares)} |"


def main() -> int:
    """Print or put into the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    asked = parser.parse_args()
    lines = list(table())
    if asked.write or asked.check:
        return put({PAGE: {"linkage": lines}}, check=asked.check)
    sys.stdout.write("\n".join(lines) + "\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
