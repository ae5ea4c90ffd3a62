"""Compare packet reception with ns-3 under load: rates, sizes, exponents, numbers of nodes, error models.

Usage: python validation/ns3_load.py NS3_PYTHON --keep DIR [--kept] [--seeds N] [--write | --check]
NS3_PYTHON is the interpreter of a virtual environment with pip's ``ns3`` 3.44. Needs g++. DIR keeps each run
of ns-3 in a file of its own, so that an interrupted call is taken up. With ``--kept`` no run is made:
compared is what DIR has; the table says how many seeds that are. Ours is always run anew. ``--write`` puts
the tables into ``validation/README.md``, ``--check`` tells by its exit code whether it has them.

Nodes stand at random places on one kilometre, and each sends 10 times a second for two seconds. Both
simulators get the same places and phases; half a second more lets them finish.
"""

import argparse
import json
import sys
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from modelcast.core.version import package_version
from ns3 import BIN_M, BINS, Air, folder_of, ours, places, theirs  # puts the example on the path
from ns3_radio.program import build
from page_blocks import put

PAGE = Path(__file__).with_name("README.md")
SETTINGS: tuple[tuple[int, float, int, float], ...] = (
    (75, 6.0, 300, 2.4),
    (150, 6.0, 300, 2.4),
    (300, 6.0, 300, 2.4),
    (300, 12.0, 500, 2.4),
    (75, 3.0, 500, 2.4),
    (170, 3.0, 500, 2.4),
    (150, 3.0, 150, 2.8),
    (200, 3.0, 500, 2.8),
    (400, 6.0, 500, 2.8),
)
"""Nodes, Mb/s, bytes of payload, exponent of path loss."""
ERRORS = ("nist", "table")
SECONDS, TAIL_S = 2.0, 0.5
TARGET, STANDARD_DBM = 0.03, -65.0
TIMES = "ns3-load-times"


class Case(NamedTuple):
    """One run of ns-3."""

    nodes: int
    air: Air
    seed: int

    @property
    def stem(self) -> str:
        """Name of the file that keeps it."""
        air = self.air
        return f"{self.nodes}-{air.rate_mbps:g}-{air.payload}-{air.exponent:g}-{air.errors}-{self.seed}"


class Run(NamedTuple):
    """Pairs and receptions by distance (BINS, 2), and what the whole process took [s]."""

    counts: list[list[float]]
    processor_s: float


def make(case: Case, folder: Path, program: Path, ns3: Path) -> None:
    """Run ns-3 where the folder has no such run."""
    path = folder / f"{case.stem}.json"
    if path.exists():
        return
    with TemporaryDirectory() as scratch:
        where = places(case.nodes, case.seed)
        counts, took = theirs(program, ns3, where, case.seed, Path(scratch), air=case.air)
    whole = path.with_suffix(".part")
    whole.write_text(json.dumps(Run(counts.tolist(), took.processor_s)._asdict()), encoding="utf-8")
    whole.replace(path)
    print(case.stem, f"{took.processor_s:.1f} s of processor time", file=sys.stderr, flush=True)


def kept(case: Case, folder: Path) -> Run | None:
    """What the folder has of a run."""
    path = folder / f"{case.stem}.json"
    return Run(**json.loads(path.read_text(encoding="utf-8"))) if path.exists() else None


class Compared(NamedTuple):
    """One setting over all its seeds."""

    nodes: int
    air: Air
    seeds: int
    theirs: np.ndarray
    """Share that received, by distance, (BINS,)."""
    ours: np.ndarray
    spread: float
    """Largest standard error over seeds of the difference in a bin."""
    busy: float
    theirs_s: float
    ratio: float
    """Processor time of a run of ns-3, and that by ours."""
    standard: np.ndarray
    """As ``ours``, where the medium is busy from the standard's -65 dBm of all power on, (BINS,)."""

    def most(self, own: np.ndarray) -> str:
        """The largest difference from theirs, and where."""
        k = int(np.abs(own - self.theirs).argmax())
        return f"{own[k] - self.theirs[k]:+.3f} at {k * BIN_M:.0f}-{(k + 1) * BIN_M:.0f} m"


def compare(nodes: int, air: Air, runs: list[tuple[int, Run]]) -> Compared:
    """Run ours with the places and phases of all runs of ns-3."""
    counts, outcomes, busy, theirs_s, ours_s = [], [], [], 0.0, 0.0
    standard = np.zeros((BINS, 5))
    for seed, run in runs:
        where = places(nodes, seed)
        found = ours(*where, seed, air)
        standard += ours(*where, seed, air._replace(energy_dbm=STANDARD_DBM)).outcomes
        counts.append(np.array(run.counts))
        outcomes.append(found.outcomes)
        busy.append(found.busy)
        theirs_s, ours_s = theirs_s + run.processor_s, ours_s + found.took.processor_s
    heard, own = np.stack(counts), np.stack(outcomes)
    gaps = own[:, :, 0] / own.sum(axis=2) - heard[:, :, 1] / heard[:, :, 0]
    error = gaps.std(axis=0, ddof=1) / np.sqrt(len(runs)) if len(runs) > 1 else np.full(BINS, np.nan)
    total, all_own = heard.sum(axis=0), own.sum(axis=0)
    return Compared(
        nodes,
        air,
        len(runs),
        total[:, 1] / total[:, 0],
        all_own[:, 0] / all_own.sum(axis=1),
        float(error.max()),
        float(np.mean(busy)),
        theirs_s / len(runs),
        theirs_s / ours_s,
        standard[:, 0] / standard.sum(axis=1),
    )


def tables(found: list[Compared]) -> dict[str, list[str]]:
    """Lines of Markdown by block of the page."""
    first = ("nodes", "Mb/s", "bytes", "exponent", "errors")
    heads = (*first, "busy", "seeds", "most in 50 m", "standard error", "from -65 dBm")
    bins = [f"{k * BIN_M:.0f}-{(k + 1) * BIN_M:.0f}" for k in range(BINS)]
    lines, fine = (
        [f"| {' | '.join(one)} |", "|" + "---|" * len(one)] for one in (heads, (", ".join(first), *bins))
    )
    times = [f"| {', '.join(first)} | ns-3 s a run | times ours |", "|---|---|---|"]
    for one in found:
        air = one.air
        head = (one.nodes, f"{air.rate_mbps:g}", air.payload, f"{air.exponent:g}", air.errors)
        cells = (
            *head,
            f"{one.busy:.2f}",
            one.seeds,
            one.most(one.ours),
            f"{one.spread:.3f}",
            one.most(one.standard),
        )
        times.append(f"| {', '.join(map(str, head))} | {one.theirs_s:.1f} | {one.ratio:.0f} |")
        lines.append(f"| {' | '.join(map(str, cells))} |")
        gaps = (f"{a:.3f} {b - a:+.3f}" for a, b in zip(one.theirs, one.ours, strict=True))
        fine.append(f"| {', '.join(map(str, head))} | {' | '.join(gaps)} |")
    most = max(float(np.abs(one.ours - one.theirs).max()) for one in found)
    said = "reached" if most <= TARGET else "missed"
    versions = f"ns-3 3.44, modelcast {package_version()}"
    lines += ["", f"Largest difference {most:.3f}; target {TARGET}: {said}. {versions}."]
    return {"ns3-load": lines, "ns3-load-bins": fine, TIMES: times}


def main() -> int:
    """Run what is missing, print the tables, and write or check the page where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("python")
    parser.add_argument("--keep", type=Path, required=True, help="folder of the runs of ns-3")
    parser.add_argument("--kept", action="store_true", help="compare what there is, run no more of ns-3")
    parser.add_argument("--seeds", type=int, default=10)
    asked = parser.add_mutually_exclusive_group()
    asked.add_argument("--write", action="store_true", help="put the tables into validation/README.md")
    asked.add_argument("--check", action="store_true", help="tell whether validation/README.md has them")
    given = parser.parse_args()
    given.keep.mkdir(parents=True, exist_ok=True)
    airs = [
        (nodes, Air(rate, payload, exponent, errors, SECONDS, TAIL_S))
        for (nodes, rate, payload, exponent), errors in product(SETTINGS, ERRORS)
    ]
    if not given.kept:
        ns3 = folder_of(given.python)
        program = build(Path(__file__).with_name("ns3_broadcast.cc"), ns3)
        cases = [Case(nodes, air, seed) for seed, (nodes, air) in product(range(given.seeds), airs)]
        # An interrupted call has more seeds of what is quickly done, and of all a few.
        for case in sorted(cases, key=lambda one: (one.seed + 1) * one.nodes):
            make(case, given.keep, program, ns3)
    ours(*places(10, 0), 0)  # compiles
    found: list[Compared] = []
    for nodes, air in airs:
        runs = [(seed, kept(Case(nodes, air, seed), given.keep)) for seed in range(given.seeds)]
        there = [(seed, run) for seed, run in runs if run is not None]
        if not there:
            raise SystemExit(f"{given.keep} has no run of {Case(nodes, air, 0).stem}")
        found.append(compare(nodes, air, there))
    blocks = tables(found)
    print("\n".join(line for lines in blocks.values() for line in [*lines, ""]))
    if given.check:
        del blocks[TIMES]  # they are others each time
    return put({PAGE: blocks}, check=given.check) if given.write or given.check else 0


if __name__ == "__main__":
    sys.exit(main())
