"""Drive one fleet over ns-3's IEEE 802.11p and over ours: what vehicles send, and what others hold of them.

Usage: python validation/closed_loop_ns3.py FOLDER [--python NS3_PYTHON] [--error-model nist|table]
       [--seeds N] [--processes N] [--write | --check]
NS3_PYTHON is the interpreter of a virtual environment with pip's ``ns3`` 3.44; where it is left out the
environment variable MODELCAST_NS3_PYTHON names it. Needs g++. FOLDER keeps what is done, so it can be called
again; give each version of modelcast its own.

The same traffic, sensors and stations meet both radios, which are set alike as in ``validation/ns3.py``; only
what the radios draw differs. Each figure is compared seed by seed. ``--error-model`` is that of both radios;
``table`` is ns-3's default. ``--write`` puts the tables into ``docs/channel.md`` (those of NIST errors), and
``--check`` tells by its exit code whether that page has them.
"""

import argparse
import json
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
from modelcast.study.network.rows import NetworkCase
from modelcast.world.named_sensors import named_sensor
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import filter_for
from ns3 import BIN_M, BINS, Air, folder_of, radio  # puts the example on the path
from ns3_radio import Ns3Radio
from ns3_radio.radio import ERROR_MODELS
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "channel.md"
LENGTH_M, DURATION_S = 1000.0, 20.0
DENSITIES_PER_KM = (100.0, 200.0)
POLICIES = ("j2945", "j2945-mbc", "mbc")
THRESHOLD_M = 0.2
RADIOS = ("ns-3", "modelcast")
COUNT_TARGET, ERROR_TARGET = 0.01, 0.05
SETTINGS = NetworkSettings(warm_up_s=5.0)
FIGURES = ("message_rate_hz", "pte_p90_m", "busy_ratio", "delivery_ratio")
"""Columns of `RunRow`."""


class Case(NamedTuple):
    """One drive of the fleet."""

    density_per_km: float
    policy: str
    over: str
    seed: int
    errors: str


class Run(NamedTuple):
    """What one run counted: `FIGURES`, what became of frames by distance (BINS, 5), what it took [s]."""

    figures: dict[str, float]
    outcomes: list[list[int]]
    wall_s: float


def drive(case: Case, ns3: str) -> Run:
    """Drive the fleet once."""
    start = time.perf_counter()
    model = named_sensor("default")
    sender = named_sender(case.policy, threshold_m=THRESHOLD_M, motion=filter_for(model))
    theirs = Ns3Radio(
        max_power_dbm=20.0, distance_bin_m=BIN_M, bins=BINS, error_model=case.errors, folder=ns3
    )
    frames = run_scenario(
        Highway(LENGTH_M, case.density_per_km),
        np.random.default_rng([case.seed, 17]),
        duration_s=DURATION_S,
    )
    found = run_network(
        frames,
        sender,
        theirs if case.over == "ns-3" else radio(Air(errors=case.errors)),
        SETTINGS,
        seed=case.seed,
        sensor=FleetSensor(model),
    )
    named = NetworkCase(case.density_per_km, case.over, case.policy, "default", case.seed)
    row = measure(found, named, SETTINGS, outcome_bin_m=BIN_M).run
    figures = {name: float(getattr(row, name)) for name in FIGURES}
    return Run(figures, found.outcomes.tolist(), time.perf_counter() - start)


def kept(case: Case, ns3: str, folder: str) -> Run:
    """What the folder has of a case, made where it has nothing."""
    name = f"{case.density_per_km:g}-{case.policy}-{case.over}-{case.errors}-{case.seed}.json"
    path = Path(folder) / name
    if not path.exists():
        done = drive(case, ns3)
        path.write_text(json.dumps(done._asdict()), encoding="utf-8")
        print(path.stem, done.figures, f"{done.wall_s:.0f} s", file=sys.stderr, flush=True)
    return Run(**json.loads(path.read_text(encoding="utf-8")))


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


Found = dict[tuple[float, str, str], list[Run]]
"""Runs of all seeds by density, policy and radio."""


def figure(found: Found, density: float, policy: str, name: str) -> Figure:
    """One of `FIGURES` of a policy at a density."""
    return Figure(*(np.array([one.figures[name] for one in found[density, policy, over]]) for over in RADIOS))


def delivered(runs: Iterable[Run]) -> np.ndarray:
    """Share of pairs in reach that received, by distance, (BINS,)."""
    outcomes = np.sum([one.outcomes for one in runs], axis=0)
    return outcomes[:, 0] / outcomes.sum(axis=1)


def tables(found: Found) -> dict[str, list[str]]:
    """Lines of Markdown by block of the page."""
    heads = ("vehicles/km", "policy")
    compared = ("modelcast", "differ by")
    closed_heads = (*heads, "messages/s, ns-3", *compared, "p90 cm, ns-3", *compared)
    air_heads = (*heads, "busy, ns-3", "modelcast", "received, ns-3", "modelcast", "most in 50 m")
    closed, air = ([f"| {' | '.join(one)} |", "|" + "---|" * len(one)] for one in (closed_heads, air_heads))
    missed: list[str] = []
    for density, policy in product(DENSITIES_PER_KM, POLICIES):
        head = f"| {density:g} | `{policy}` |"
        counts, errors, busy, heard = (figure(found, density, policy, name) for name in FIGURES)
        closed.append(f"{head} {counts.cells(1.0, '.3f')} | {errors.cells(100.0, '.2f')} |")
        for named, one, target in (("messages", counts, COUNT_TARGET), ("p90", errors, ERROR_TARGET)):
            if abs(one.relative.mean()) > target:
                missed.append(f"{named} of `{policy}` at {density:g}")
        theirs, ours = (delivered(found[density, policy, over]) for over in RADIOS)
        worst = int(np.abs(ours - theirs).argmax())
        cells = [*busy, *heard]
        air.append(
            f"{head} {' | '.join(f'{one.mean():.3f}' for one in cells)} | "
            f"{ours[worst] - theirs[worst]:+.3f} at {worst * BIN_M:.0f}-{(worst + 1) * BIN_M:.0f} m |"
        )
    said = "all reached" if not missed else f"missed by {', '.join(missed)}"
    seeds = len(found[DENSITIES_PER_KM[0], POLICIES[0], RADIOS[0]])
    note = (
        f"Messages of a vehicle; mean of {seeds} seeds, the difference with its 95 % interval. Targets, "
        f"{100 * COUNT_TARGET:.0f} % of messages and {100 * ERROR_TARGET:.0f} % of the p90: {said}. "
        f"ns-3 3.44, modelcast {package_version()}."
    )
    return {"closed-loop-ns3": [*closed, "", note], "closed-loop-ns3-air": air}


def main() -> int:
    """Run all, print the tables, and write or check the page where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--python", default=os.environ.get("MODELCAST_NS3_PYTHON", ""))
    parser.add_argument("--error-model", choices=list(ERROR_MODELS), default="nist", help="of both radios")
    parser.add_argument("--seeds", type=int, default=4, help="runs of each policy over each radio")
    parser.add_argument("--processes", type=int, default=1, help="runs at a time")
    asked = parser.add_mutually_exclusive_group()
    asked.add_argument("--write", action="store_true", help="put the tables into docs/channel.md")
    asked.add_argument("--check", action="store_true", help="tell whether docs/channel.md has them")
    given = parser.parse_args()
    if not given.python:
        parser.error("name the interpreter that has ns3, with --python or in MODELCAST_NS3_PYTHON")
    if given.error_model != "nist" and (given.write or given.check):
        parser.error("the page has the tables of NIST errors: --write and --check go with --error-model nist")
    given.folder.mkdir(parents=True, exist_ok=True)
    ns3 = str(folder_of(given.python))
    cases = [
        Case(density, policy, over, seed, given.error_model)
        for seed, density, policy, over in product(range(given.seeds), DENSITIES_PER_KM, POLICIES, RADIOS)
    ]
    found: Found = {}
    with ProcessPoolExecutor(given.processes) as pool:
        runs = pool.map(kept, cases, [ns3] * len(cases), [str(given.folder)] * len(cases))
        for case, done in zip(cases, runs, strict=True):
            found.setdefault((case.density_per_km, case.policy, case.over), []).append(done)
    blocks = tables(found)
    print("\n".join(line for lines in blocks.values() for line in [*lines, ""]))
    if given.write or given.check:
        return put({PAGE: blocks}, check=given.check)
    return 0


if __name__ == "__main__":
    sys.exit(main())
