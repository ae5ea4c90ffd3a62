"""Make the published network table: every sender at every density, by receiver, radio and load.

Usage: python validation/network_table.py [--keep FOLDER] [--only CALL ...] [--seeds N] [--minutes M]
       [--quick] [--anew] [--again N] [--no-runs] [--write | --check]
CALL is of headline, receivers, loaded, coverage, radios, cams. FOLDER keeps every run in a file of its
own, so that the script can be stopped and called again. What is there is not run again; with ``--anew`` it is
where other sources made it. ``--again N`` runs N of those once more and tells whether they still come out the
same, to the last digit. ``--quick`` runs the first density and two seeds of each call, and only prints.

Every run is one of ``modelcast network`` with the options in `plan`. ``--write`` puts tables and sentences
into ``docs/network-table.md``, ``--check`` tells by its exit code whether that page has them: all numbers
there come from here.
"""

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import modelcast
from modelcast.cli.fleet_options import FleetOptions
from modelcast.cli.network_case import run_case
from modelcast.cli.network_plan import NetworkPlan
from modelcast.cli.options import SensorOptions
from modelcast.core.arrays import IntArray
from modelcast.core.version import package_version
from modelcast.station.sender.names import has_threshold, sends_models
from modelcast.study.network.rows import NO_BANK, NO_THRESHOLD, NetworkCase
from network_table_cells import CALLS, FIGURES, Cell, Kept, cells_of, keep, kept, sources
from network_table_page import PAGE, blocks
from network_table_rows import Found
from page_blocks import put

BANK, THRESHOLD_M = "default", 0.2


def plan(scenario: str, receiver: str) -> NetworkPlan:
    """The options of ``modelcast network`` that all runs of a scenario and a receiver share."""
    options = FleetOptions(scenario=scenario, length=1500.0, duration=22.0, warm_up=8.0)
    sensor = SensorOptions(
        sensor=receiver.removesuffix("-timed"), latency=0.0 if receiver.endswith("-timed") else None
    )
    return options.plan(sensor, banks=(BANK,), thresholds_m=(THRESHOLD_M,))


def run(cell: Cell, state: str) -> Kept:
    """Run one cell."""
    start = time.process_time()
    case = NetworkCase(
        cell.density_per_km,
        cell.radio,
        cell.policy,
        BANK if sends_models(cell.policy) else NO_BANK,
        threshold_m=THRESHOLD_M if has_threshold(cell.policy) else NO_THRESHOLD,
        run=cell.seed,
    )
    row = run_case(plan(cell.scenario, cell.receiver), case).run
    figures = {name: float(getattr(row, name)) for name in FIGURES}
    return Kept(figures, time.process_time() - start, package_version(), state)


def run_all(cells: Sequence[Cell], folder: Path, *, minutes: float, anew: bool) -> None:
    """Run what the folder does not have, for so long at most."""
    state = sources(Path(modelcast.__file__).parent)
    end = time.monotonic() + 60.0 * minutes
    for number, cell in enumerate(cells, 1):
        done = kept(folder, cell)
        if done is not None and not (anew and done.sources != state):
            continue
        if time.monotonic() > end:
            print(f"stopped at {number} of {len(cells)} runs; call it again for the others", file=sys.stderr)
            return
        done = run(cell, state)
        keep(folder, cell, done)
        print(f"{number}/{len(cells)} {cell.stem} {done.processor_s:.1f} s", file=sys.stderr, flush=True)


def run_again(cells: Sequence[Cell], folder: Path, count: int) -> int:
    """Run some kept runs of other sources once more, drawn at random; 1 where a figure differs."""
    state = sources(Path(modelcast.__file__).parent)
    held = [(cell, done) for cell in cells if (done := kept(folder, cell)) is not None]
    older = [(cell, done) for cell, done in held if done.sources != state]
    differ = 0
    order: IntArray = np.random.default_rng(0).permutation(len(older))
    for at in order[:count]:
        cell, done = older[int(at)]
        now = run(cell, state)
        moved = [name for name in FIGURES if repr(now.figures[name]) != repr(done.figures[name])]
        differ += bool(moved)
        print(f"{cell.stem}: {', '.join(moved) if moved else 'the same'}", flush=True)
    return int(differ > 0)


def main() -> int:
    """Run what is asked for, print the tables, and write or check the page where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--keep", type=Path, default=Path("out/network-table"), help="folder of the runs")
    kinds = list(dict.fromkeys(call.kind for call in CALLS))
    parser.add_argument("--only", nargs="+", choices=kinds, default=[], help="run these calls alone")
    parser.add_argument("--seeds", type=int, help="run at most so many seeds of each call")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="begin no run after so long")
    parser.add_argument("--quick", action="store_true", help="first densities, two seeds; prints alone")
    parser.add_argument("--anew", action="store_true", help="run again what other sources have made")
    parser.add_argument("--again", type=int, default=0, help="compare so many runs of other sources")
    parser.add_argument("--no-runs", action="store_true", help="take what the folder has")
    asked = parser.add_mutually_exclusive_group()
    asked.add_argument("--write", action="store_true", help="put tables and sentences into the page")
    asked.add_argument("--check", action="store_true", help="tell whether the page has them")
    given = parser.parse_args()
    if given.quick and (given.write or given.check):
        parser.error("--quick only prints")
    given.keep.mkdir(parents=True, exist_ok=True)
    cells = cells_of(CALLS, given.only, most_seeds=given.seeds, quick=given.quick)
    if given.again:
        return run_again(cells, given.keep, given.again)
    if not given.no_runs:
        run_all(cells, given.keep, minutes=given.minutes, anew=given.anew)
    found: Found = {
        cell: done for cell in cells_of(CALLS, ()) if (done := kept(given.keep, cell)) is not None
    }
    made = blocks(found)
    if given.write or given.check:
        return put({PAGE: made}, check=given.check)
    print("\n".join(line for lines in made.values() for line in [*lines, ""]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
