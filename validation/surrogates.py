"""Do the surrogate safety measures agree with a public implementation? Differences over random pairs.

Takes the path of ``TwoDimSSM.py`` of github.com/Yiru-Jiao/Two-Dimensional-Time-To-Collision, or of a checkout
of it (needs pandas). How conventions differ, and what is done about it:

- Overlapping rectangles: there -1, and at times a small positive number, as its text warns; here a time of 0.
  Such pairs are counted and left out.
- MTTC: the acceleration is that of vehicle i along the way to the contact. Of two contacts it gives the later
  one; the earlier follows, since their times add up to 2 Δv / -a.

``--write`` puts its values into the table of the tests.
"""

import argparse
import csv
import importlib.util
import sys
from pathlib import Path
from typing import Any

import numpy as np

from modelcast.apps.motions import Motions
from modelcast.apps.surrogates import (
    deceleration_to_avoid_2d_mps2,
    modified_time_to_collision_s,
    time_to_collision_2d_s,
)
from modelcast.core.arrays import BoolArray, FloatArray

GOLDEN = Path(__file__).parents[1] / "tests" / "apps" / "surrogates_golden.csv"
TOLERANCE = 1e-9
Pairs = tuple[Motions, Motions]


def peer_of(path: Path) -> Any:
    """Import the implementation."""
    if path.is_dir():
        path = next(iter(sorted(path.rglob("TwoDimSSM.py"))), path / "TwoDimSSM.py")
    spec = importlib.util.spec_from_file_location("peer", path)
    if spec is None or spec.loader is None or not path.is_file():
        raise SystemExit(f"no TwoDimSSM.py at {path}")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def random_pairs(count: int, seed: int) -> Pairs:
    """Pairs within 100 m, half of them with courses a right angle or none apart."""
    rng = np.random.default_rng(seed)
    heading = rng.uniform(-np.pi, np.pi, (2, count))
    heading[1, ::2] = heading[0, ::2] + rng.choice([0.0, np.pi / 2], heading[0, ::2].size)
    host, remote = (
        Motions.of(
            rng.uniform(-50.0, 50.0, (count, 2)),
            speed_mps=rng.uniform(0.0, 35.0, count),
            heading_rad=one,
            acceleration_mps2=rng.uniform(-4.0, 4.0, count),
            length_m=rng.uniform(3.5, 18.0, count),
            width_m=rng.uniform(1.5, 2.6, count),
        )
        for one in heading
    )
    return host, remote


def theirs(peer: Any, host: Motions, remote: Motions) -> dict[str, FloatArray]:
    """Its values: TTC, DRAC, MTTC as it states them."""
    import pandas as pd  # noqa: PLC0415 - only the other implementation needs it

    columns: dict[str, FloatArray] = {"acc_i": host.acceleration_mps2}
    for name, one in (("i", host), ("j", remote)):
        velocity = one.velocity_mps
        columns |= {
            f"x_{name}": one.position_m[:, 0], f"y_{name}": one.position_m[:, 1],
            f"vx_{name}": velocity[:, 0], f"vy_{name}": velocity[:, 1],
            f"hx_{name}": np.sin(one.heading_rad), f"hy_{name}": np.cos(one.heading_rad),
            f"length_{name}": one.length_m, f"width_{name}": one.width_m,
        }  # fmt: skip
    samples = pd.DataFrame(columns)
    with np.errstate(all="ignore"):
        return {
            name: np.array(getattr(peer, name)(samples, "values"), dtype=np.float64)
            for name in ("TTC", "DRAC", "MTTC")
        }


def ours(host: Motions, remote: Motions) -> dict[str, FloatArray]:
    """The same measures; MTTC of the way to the contact along the relative velocity."""
    time = time_to_collision_2d_s(host, remote)
    relative = np.linalg.norm(host.velocity_mps - remote.velocity_mps, axis=1)
    finite = np.isfinite(time) & (time > 0.0)
    way = np.where(finite, time, 1.0) * relative
    gain = host.acceleration_mps2
    return {
        "TTC": time,
        "DRAC": deceleration_to_avoid_2d_mps2(host, remote),
        "MTTC": np.where(finite, modified_time_to_collision_s(way, relative, gain), time),
    }


def earlier(mttc: FloatArray, host: Motions, remote: Motions) -> FloatArray:
    """The first contact, where the later one is stated."""
    relative = np.linalg.norm(host.velocity_mps - remote.velocity_mps, axis=1)
    gain = host.acceleration_mps2
    return np.where(
        (gain < -1e-6) & np.isfinite(mttc), 2.0 * relative / -np.minimum(gain, -1e-6) - mttc, mttc
    )


def worst(mine: FloatArray, other: FloatArray, which: BoolArray) -> tuple[float, int]:
    """Greatest relative difference above 1 (absolute below), and rows of which one alone is infinite."""
    mine, other = mine[which], other[which]
    both = np.isfinite(mine) & np.isfinite(other)
    apart = np.abs(mine[both] - other[both]) / np.maximum(np.abs(other[both]), 1.0)
    return float(apart.max(initial=0.0)), int((np.isfinite(mine) != np.isfinite(other)).sum())


def golden_pairs(rows: list[dict[str, str]]) -> Pairs:
    """The hand-picked pairs of the tests."""

    def of(name: str) -> Motions:
        column = {key: np.array([float(row[f"{name}_{key}"]) for row in rows])
                  for key in ("x", "y", "speed", "heading", "length", "width")}  # fmt: skip
        gain = [float(row.get(f"{name}_acceleration", 0.0)) for row in rows]
        return Motions.of(
            np.stack([column["x"], column["y"]], axis=1), speed_mps=column["speed"],
            heading_rad=column["heading"], acceleration_mps2=np.array(gain), length_m=column["length"],
            width_m=column["width"],
        )  # fmt: skip

    return of("host"), of("remote")


def write_golden(peer: Any) -> None:
    """Put its values into the table of the tests."""
    with GOLDEN.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    found = theirs(peer, *golden_pairs(rows))
    for i, row in enumerate(rows):
        row |= {name.lower(): repr(float(values[i])) for name, values in found.items()}
    with GOLDEN.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def main() -> int:
    """Compare, print, and end with 1 where something differs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("path", type=Path)
    parser.add_argument("--pairs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    peer = peer_of(arguments.path)
    host, remote = random_pairs(arguments.pairs, arguments.seed)
    mine, other = ours(host, remote), theirs(peer, host, remote)
    overlap = mine["TTC"] == 0.0
    said = int((other["TTC"][overlap] == -1.0).sum())
    print(f"{arguments.pairs} pairs: {int(np.isfinite(mine['TTC'][~overlap]).sum())} touch later, "
          f"{int(overlap.sum())} overlap (it says so of {said})")  # fmt: skip
    failed = bool((other["TTC"][~overlap] == -1.0).any())
    other["MTTC"] = earlier(other["MTTC"], host, remote)
    touch = ~overlap & np.isfinite(mine["TTC"])
    for name, which in (("TTC", ~overlap), ("DRAC", ~overlap), ("MTTC", touch)):
        apart, split = worst(mine[name], other[name], which)
        print(
            f"{name}: {int(which.sum())} compared, greatest difference {apart:.2e}, "
            f"infinite in one only: {split}"
        )
        failed |= apart > TOLERANCE or split > 0
    if arguments.write:
        write_golden(peer)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
