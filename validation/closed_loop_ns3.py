"""Drive one fleet over ns-3's IEEE 802.11p and over ours: what vehicles send, and what others hold of them.

Usage: python validation/closed_loop_ns3.py NS3_PYTHON [--seeds N] [--processes N] [--write | --check]
NS3_PYTHON is the interpreter of a virtual environment with pip's ``ns3`` 3.44; where it is left out the
environment variable MODELCAST_NS3_PYTHON names it. Needs g++.

The same traffic, sensors and stations meet both radios, which are set alike as in ``validation/ns3.py``; only
what the radios draw differs. Each figure is compared seed by seed. ``--write`` puts the tables into
``docs/channel.md``, ``--check`` tells by its exit code whether that page has them.
"""

import argparse
import os
import sys
import time
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy import stats

from modelcast.core.version import package_version
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.sender.sender import named_sender
from modelcast.study.network.measure import measure
from modelcast.study.network.rows import NetworkCase, RunRow
from modelcast.world.named_sensors import named_sensor
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import filter_for
from ns3 import BIN_M, BINS, folder_of, radio  # puts the example on the path
from ns3_radio import Ns3Radio
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "channel.md"
LENGTH_M, DENSITY_PER_KM, DURATION_S = 1000.0, 100.0, 25.0
POLICIES = ("j2945", "j2945-mbc", "mbc")
THRESHOLD_M = 0.2
RADIOS = ("ns-3", "modelcast")
COUNT_TARGET, ERROR_TARGET = 0.01, 0.05
SETTINGS = NetworkSettings(warm_up_s=5.0)


class Run(NamedTuple):
    """What one run counted, what became of frames by distance (BINS, 5), and what it took [s]."""

    row: RunRow
    outcomes: np.ndarray
    wall_s: float


def run(policy: str, seed: int, over: str, ns3: str) -> Run:
    """Drive the fleet once."""
    start = time.perf_counter()
    model = named_sensor("default")
    sender = named_sender(policy, threshold_m=THRESHOLD_M, motion=filter_for(model))
    chosen = Ns3Radio(max_power_dbm=20.0, bin_m=BIN_M, bins=BINS, ns3=ns3) if over == "ns-3" else radio()
    road = Highway(LENGTH_M, DENSITY_PER_KM)
    frames = run_scenario(road, np.random.default_rng([seed, 17]), duration_s=DURATION_S)
    found = run_network(frames, sender, chosen, SETTINGS, seed=seed, sensor=FleetSensor(model))
    case = NetworkCase(DENSITY_PER_KM, over, policy, "default", seed)
    row = measure(found, case, SETTINGS, outcome_bin_m=BIN_M).run
    return Run(row, found.outcomes, time.perf_counter() - start)


class Figure(NamedTuple):
    """A figure over both radios, seed by seed, (N,) each."""

    theirs: np.ndarray
    ours: np.ndarray

    @property
    def relative(self) -> np.ndarray:
        """How far ours is from theirs, as a share of it."""
        return self.ours / self.theirs - 1.0

    def cells(self, scale: float, form: str) -> str:
        """Both means, and the mean relative difference with its 95 % interval over seeds."""
        means = " | ".join(format(scale * one.mean(), form) for one in (self.theirs, self.ours))
        half = stats.t.ppf(0.975, self.ours.size - 1) * self.relative.std(ddof=1) / np.sqrt(self.ours.size)
        return f"{means} | {100 * self.relative.mean():+.2f} ± {100 * half:.2f} %"


def figure(found: dict[tuple[str, str], list[Run]], policy: str, name: str) -> Figure:
    """A column of `RunRow` of one policy."""
    theirs, ours = (np.array([getattr(one.row, name) for one in found[policy, over]]) for over in RADIOS)
    return Figure(theirs, ours)


def delivered(runs: Iterable[Run]) -> np.ndarray:
    """Share of pairs in reach that received, by distance, (BINS,)."""
    outcomes = np.sum([one.outcomes for one in runs], axis=0)
    return outcomes[:, 0] / outcomes.sum(axis=1)


def tables(found: dict[tuple[str, str], list[Run]]) -> dict[str, list[str]]:
    """Lines of Markdown by block of the page."""
    seeds = len(found[POLICIES[0], RADIOS[0]])
    closed = [
        "| policy | messages/s, ns-3 | modelcast | difference | p90 cm, ns-3 | modelcast | difference |",
        "|---|---|---|---|---|---|---|",
    ]
    air = [
        "| policy | busy ratio, ns-3 | modelcast | received 50-150 m, ns-3 | modelcast | largest in 50 m |",
        "|---|---|---|---|---|---|",
    ]
    missed: list[str] = []
    for policy in POLICIES:
        counts, errors = (figure(found, policy, name) for name in ("message_rate_hz", "pte_p90_m"))
        closed.append(f"| `{policy}` | {counts.cells(1.0, '.3f')} | {errors.cells(100.0, '.2f')} |")
        for named, one, target in (("messages", counts, COUNT_TARGET), ("p90", errors, ERROR_TARGET)):
            if abs(one.relative.mean()) > target:
                missed.append(f"{named} of `{policy}`")
        busy, heard = (figure(found, policy, name) for name in ("busy_ratio", "delivery_ratio"))
        theirs, ours = (delivered(found[policy, over]) for over in RADIOS)
        worst = int(np.abs(ours - theirs).argmax())
        air.append(
            f"| `{policy}` | {busy.theirs.mean():.3f} | {busy.ours.mean():.3f} | {heard.theirs.mean():.3f} | "
            f"{heard.ours.mean():.3f} | {ours[worst] - theirs[worst]:+.3f} at "
            f"{worst * BIN_M:.0f}-{(worst + 1) * BIN_M:.0f} m |"
        )
    said = "all reached" if not missed else f"missed by {', '.join(missed)}"
    note = (
        f"Messages of a vehicle; mean of {seeds} seeds, the difference with its 95 % interval. Targets, "
        f"{100 * COUNT_TARGET:.0f} % of messages and {100 * ERROR_TARGET:.0f} % of the p90: {said}. "
        f"ns-3 3.44, modelcast {package_version()}."
    )
    closed += ["", note]
    return {"closed-loop-ns3": closed, "closed-loop-ns3-air": air}


def main() -> int:
    """Run all, print the tables, and write or check the page where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("python", nargs="?", default=os.environ.get("MODELCAST_NS3_PYTHON", ""))
    parser.add_argument("--seeds", type=int, default=5, help="runs of each policy over each radio")
    parser.add_argument("--processes", type=int, default=1, help="runs at a time")
    asked = parser.add_mutually_exclusive_group()
    asked.add_argument("--write", action="store_true", help="put the tables into docs/channel.md")
    asked.add_argument("--check", action="store_true", help="tell whether docs/channel.md has them")
    given = parser.parse_args()
    if not given.python:
        parser.error("name the interpreter that has ns3, as an argument or in MODELCAST_NS3_PYTHON")
    ns3 = str(folder_of(given.python))
    found: dict[tuple[str, str], list[Run]] = {key: [] for key in product(POLICIES, RADIOS)}
    cases = [(policy, seed, over) for seed in range(given.seeds) for policy in POLICIES for over in RADIOS]
    with ProcessPoolExecutor(given.processes) as pool:
        runs = pool.map(run, *zip(*cases, strict=True), [ns3] * len(cases))
        for (policy, seed, over), done in zip(cases, runs, strict=True):
            found[policy, over].append(done)
            row = done.row
            print(
                f"{policy}, seed {seed}, {over}: {row.message_rate_hz:.3f} Hz, "
                f"p90 {100 * row.pte_p90_m:.2f} cm, busy {row.busy_ratio:.3f}, "
                f"received {row.delivery_ratio:.3f}, {done.wall_s:.0f} s",
                file=sys.stderr,
                flush=True,
            )
    blocks = tables(found)
    print("\n".join(line for lines in blocks.values() for line in [*lines, ""]))
    if given.write or given.check:
        return put({PAGE: blocks}, check=given.check)
    return 0


if __name__ == "__main__":
    sys.exit(main())
