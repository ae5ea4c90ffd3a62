"""How busy the abstract radio finds the channel, against 802.11p: same places, sizes, powers and instants.

Vehicles stand still on 3 km of road, those 600 m from its ends count. Each sends 10 times a second. The rows
are densities, sizes and powers beside those that the table of the abstract radio was made at. ``--write``
puts the table into `docs/channel.md`.
"""

import argparse
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.radio import AbstractRadio, Transmissions
from modelcast.channel.tabulated import TabulatedRadio
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "channel.md"
LENGTH_M, END_M = 3000.0, 600.0
STEPS, WARM_UP, SEEDS = 10, 3, 10

CASES = (
    (25, 168, 20.0),
    (100, 168, 20.0),
    (250, 168, 20.0),
    (400, 168, 20.0),
    (100, 400, 20.0),
    (250, 400, 20.0),
    (400, 400, 20.0),
    (600, 300, 20.0),
    (250, 250, 10.0),
    (600, 250, 10.0),
    (400, 250, 15.0),
    (150, 800, 23.0),
)
"""Vehicles a kilometre, bytes, power [dBm]."""


@dataclass(frozen=True, slots=True)
class Traffic:
    """One placement and its messages."""

    place_m: np.ndarray
    phase_s: np.ndarray
    jitter_s: np.ndarray
    size_bytes: int
    power_dbm: float

    def busy(self, radio: AbstractRadio[Any], seed: int) -> float:
        """Mean busy ratio of the vehicles that count."""
        vehicles = len(self.place_m)
        middle = np.abs(self.place_m[:, 0] - 0.5 * LENGTH_M) < 0.5 * LENGTH_M - END_M
        state, found = radio.init(vehicles, np.random.default_rng([seed, 1])), []
        for k, (from_s, until_s) in enumerate(pairwise(np.round(0.1 * np.arange(STEPS + 1), 6))):
            ready_s = from_s + self.phase_s + self.jitter_s[k]
            order = np.argsort(ready_s)
            sent = Transmissions(
                order,
                ready_s[order],
                size_bytes=np.full(vehicles, self.size_bytes),
                power_dbm=np.full(vehicles, self.power_dbm),
                message_id=k * vehicles + order,
            )
            _, state = radio.carry(state, sent, self.place_m, float(until_s))
            if k >= WARM_UP:
                found.append(radio.channel_busy_ratio(state)[middle].mean())
        return float(np.mean(found))


def traffic(density_per_km: float, size_bytes: int, power_dbm: float, seed: int) -> Traffic:
    """A placement."""
    rng = np.random.default_rng(seed)
    vehicles = round(density_per_km * LENGTH_M / 1000.0)
    place_m = np.column_stack([rng.uniform(0.0, LENGTH_M, vehicles), 4.0 * rng.integers(0, 6, vehicles)])
    phase_s, jitter_s = rng.uniform(0.0, 0.095, vehicles), rng.uniform(0.0, 0.005, (STEPS, vehicles))
    return Traffic(place_m, phase_s, jitter_s, size_bytes, power_dbm)


def main() -> None:
    """Print or write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="put the table into docs/channel.md")
    given = parser.parse_args()
    lines = [
        "| vehicles/km | bytes | dBm | busy, 802.11p | abstract | differ by |",
        "|---|---|---|---|---|---|",
    ]
    worst = 0.0
    for case in CASES:
        made = [traffic(*case, seed) for seed in range(SEEDS)]
        ratios = [
            np.mean([one.busy(radio, k) for k, one in enumerate(made)])
            for radio in (Dsrc(), TabulatedRadio())
        ]
        gap = ratios[1] - ratios[0]
        worst = max(worst, abs(gap))
        lines.append(
            f"| {case[0]} | {case[1]} | {case[2]:g} | {ratios[0]:.3f} | {ratios[1]:.3f} | {gap:+.3f} |"
        )
        print(lines[-1], flush=True)
    lines += ["", f"Means of {SEEDS} placements; largest difference {worst:.3f}."]
    print(lines[-1])
    if given.write:
        put({PAGE: {"busy-ratio": lines}}, check=False)


if __name__ == "__main__":
    main()
