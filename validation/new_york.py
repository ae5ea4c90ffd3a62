"""The New York event replayed: what the stated speed and the positions say of the same vehicle ahead.

``new_york.py [--write | --check]``, with ``MODELCAST_DATA`` set. The event is a forward collision warning
that a real device gave. The host followed the target; the target's messages state one speed throughout. The
warning range of every algorithm is set against the gap twice: with the speed as stated, and with the speed
that the stated positions make. ``--write`` puts the table into docs/safety.md, ``--check`` tells by its exit
code whether the page has it.
"""

import argparse
import os
from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np

from modelcast.apps.forward_collision import ForwardCollisionWarning
from modelcast.apps.motions import Motions
from modelcast.apps.warning_ranges import WARNING_RANGES
from modelcast.core.arrays import FloatArray
from modelcast.io.trips import read_trips
from modelcast.study.safety.pairs import recordings_of
from modelcast.study.safety.scene import SMOOTH_S
from modelcast.world.true_motion import true_motion
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "safety.md"


def _motions(columns: FloatArray) -> Motions:
    return Motions.of(
        columns[:, :2], speed_mps=columns[:, 2], heading_rad=columns[:, 3],
        acceleration_mps2=columns[:, 4], yaw_rate_radps=columns[:, 5],
    )  # fmt: skip


def main() -> int:
    """Print the table, and write or check it where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    event = Path(os.environ["MODELCAST_DATA"]) / "nyc_cvpd" / "nycdot-fcw-event.json"
    (recording,) = recordings_of(list(read_trips(event)))
    (pair,) = recording.pairs
    target, host = recording.trips[pair.leader], recording.trips[pair.follower]
    moved = replace(target, speed_mps=None, acceleration_mps2=None)
    stated = true_motion(target)[pair.samples]
    placed = true_motion(moved, smooth_s=SMOOTH_S)[pair.samples]
    own = _motions(pair.at_follower(true_motion(host)))
    gap_m = np.hypot(*(stated[:, :2] - own.position_m).T)
    speeds = [f"{speed.min():.1f} to {speed.max():.1f} m/s" for speed in (stated[:, 2], placed[:, 2])]
    lines = [
        (
            f"{pair.samples.size} instants; the target is {gap_m.min():.0f} to {gap_m.max():.0f} m ahead. "
            f"Its messages state {speeds[0]}, its positions make {speeds[1]}, the host drives "
            f"{own.speed_mps.min():.1f} to {own.speed_mps.max():.1f} m/s."
        ),
        "",
        "| algorithm | as stated: warned | least margin | by positions: warned | least margin |",
        "|---|---|---|---|---|",
    ]
    for name, algorithm in WARNING_RANGES.items():
        application = ForwardCollisionWarning(algorithm, lane_half_width_m=inf)
        cells: list[str] = []
        for columns in (stated, placed):
            found = application.assess(own, _motions(columns))
            cells += [f"{100 * found.warned.mean():.0f} %", f"{found.margin_m.min():.0f} m"]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    print(*lines, sep="\n")
    if given.write or given.check:
        return put({PAGE: {"new-york": lines}}, check=given.check)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
