"""How many of the manoeuvres of generated drives are found, and how many found ones are true.

Usage: python validation/manoeuvres.py [--drives 40] [--first-seed 1000] [--minutes 20]

Each drive is counted without errors, through named sensors, and as a coarse recorder writes it. Prints a
table in Markdown: known manoeuvres, then recall / precision of each kind in percent.
"""

import argparse
from collections import Counter
from collections.abc import Callable

import numpy as np

from modelcast.core.chance import child_generator
from modelcast.trips.manoeuvres.base import KINDS, ManoeuvreKind
from modelcast.trips.manoeuvres.matching import match_manoeuvres
from modelcast.trips.manoeuvres.rank import count_manoeuvres
from modelcast.trips.trajectory import Trajectory
from modelcast.world.manoeuvre_drive import coarsened, generate_known_drive
from modelcast.world.named_sensors import named_sensor
from modelcast.world.sensors import sense

_GRID_M = (0.63, 0.42)
_HELD_S = 1.0


def _through(name: str) -> Callable[[Trajectory, int], Trajectory]:
    sensor = named_sensor(name)
    return lambda trip, seed: sense(trip, sensor, child_generator(seed, 0, trip.trip_id, "sensor"))


RECORDINGS: dict[str, Callable[[Trajectory, int], Trajectory]] = {
    "no errors": _through("ideal"),
    "RTK (`gnss-rtk`)": _through("gnss-rtk"),
    "1 cm white (`default`)": _through("default"),
    "plain receiver (`gnss`)": _through("gnss"),
    "grid 0.63 m x 0.42 m, 1 Hz values": lambda trip, _seed: coarsened(trip, _GRID_M, _HELD_S),
    "`phone`": _through("phone"),
}
"""How a drive is recorded."""


def main() -> None:
    """Generate, count, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drives", type=int, default=40)
    parser.add_argument("--first-seed", type=int, default=1000)
    parser.add_argument("--minutes", type=float, default=20.0)
    asked = parser.parse_args()
    seeds = range(asked.first_seed, asked.first_seed + asked.drives)
    drives = {seed: generate_known_drive(seed, 60.0 * asked.minutes) for seed in seeds}
    known = Counter(one.kind for drive in drives.values() for one in drive.manoeuvres)
    hours = sum(drive.truth.duration_s for drive in drives.values()) / 3600.0
    print(f"{asked.drives} drives, {hours:.1f} h, seeds {seeds[0]} to {seeds[-1]}\n")
    print("| recording | " + " | ".join(kind.value for kind in KINDS) + " | shift of lane changes, rms |")
    print("|---" * (len(KINDS) + 2) + "|")
    print("| known | " + " | ".join(str(known[kind]) for kind in KINDS) + " | |")
    for name, record in RECORDINGS.items():
        hits, found = Counter[ManoeuvreKind](), Counter[ManoeuvreKind]()
        shifts = list[float]()
        for seed, drive in drives.items():
            counts = count_manoeuvres(record(drive.truth, seed))
            match = match_manoeuvres(drive.manoeuvres, counts.manoeuvres)
            hits.update(one.kind for one, _ in match.hits)
            found.update(one.kind for one in counts.manoeuvres)
            pairs = [pair for pair in match.hits if pair[0].kind is ManoeuvreKind.LANE_CHANGE]
            shifts += [other.size - one.size for one, other in pairs]
        cells = [f"{_percent(hits[k], known[k])} / {_percent(hits[k], found[k])}" for k in KINDS]
        error_m = float(np.sqrt(np.mean(np.square(shifts)))) if shifts else float("nan")
        print(f"| {name} | " + " | ".join(cells) + f" | {error_m:.2f} m |", flush=True)


def _percent(part: int, whole: int) -> str:
    return f"{100.0 * part / whole:.1f}" if whole else "-"


if __name__ == "__main__":
    main()
