"""The tables of docs/capacity.md, from what ``modelcast capacity`` wrote.

``capacity.py FOLDER [--write | --check]``: a folder that holds the output of seven calls. Six of them are

    modelcast capacity --length 2000 --duration 7 --warm-up 4 --seeds 2 --ratio 1.15 --lowest 50
        --highest 800 --certificates always WORDS --out FOLDER/NAME

with NAME and WORDS

    loaded    --highest 1600 --policy bsm-10hz baseline free mbc j2945 j2945-mbc --threshold 0.02 0.5
    moving    --lanes 16 --policy bsm-10hz mbc j2945 j2945-mbc --threshold 0.02
    sidelink  --radio sidelink --policy bsm-10hz j2945-mbc
    ins       --sensor ins --position absolute relative --policy bsm-10hz j2945-mbc
    unshared  --highest 1600 --sensor gnss --latency 0 --position absolute relative
              --policy bsm-10hz j2945-mbc
    shared    as unshared, with --shared-bias 0.97

(``--highest`` once: where WORDS have it, that one), and the seventh is

    modelcast capacity --scenario braking --length 1500 --margin 0 --duration 25 --warm-up 5 --seeds 2
        --ratio 1.3 --lowest 30 --highest 240 --certificates always --radio ideal dsrc --missed 0.01 0.25
        --policy bsm-10hz mbc j2945 --threshold 0.02 --out FOLDER/warnings

How fast the traffic of those calls drives is worked out here. ``--write`` puts the tables into the page,
``--check`` tells by its exit code whether the page has them. ``--only NAME`` takes the tables of these alone,
so that one call can be made anew.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from modelcast.cli.fleet_options import FleetOptions
from modelcast.cli.options import SensorOptions
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.highway import Highway
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "capacity.md"
CALLS = ("loaded", "moving", "sidelink", "ins", "unshared", "shared", "warnings")
DENSITIES_PER_KM = (50.0, 100.0, 200.0, 400.0, 800.0, 1600.0)


def table(folder: Path) -> list[str]:
    """The table of one call, without the sentence above it, which the page has once."""
    lines = (folder / "table.md").read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line.startswith("|")]


def speeds() -> list[str]:
    """Mean speeds on the highway, with the lanes that its density needs and with 16 in each direction."""
    lines = ["| vehicles/km | lanes | m/s | m/s on 16 lanes |", "|---|---|---|---|"]
    for density in DENSITIES_PER_KM:
        plan = FleetOptions().plan(SensorOptions(), banks=("default",), thresholds_m=(0.5,))
        lanes = plan.lanes_for(density)
        found = [
            [frame.speed_mps.mean() for frame in run_scenario(road, np.random.default_rng(0), duration_s=1.0)]
            for road in (Highway(2000.0, density, lanes=number) for number in (lanes, 16))
        ]
        means = " | ".join(f"{np.mean(one):.1f}" for one in found)
        lines.append(f"| {density:g} | {lanes} | {means} |")
    return lines


def misses(folder: Path) -> list[str]:
    """What hosts missed of a warning, at the lowest and the highest density of one call."""
    runs = [json.loads(path.read_text(encoding="utf-8")) for path in sorted((folder / "runs").glob("*.json"))]
    densities = [run["run"][0]["density_per_km"] for run in runs]
    heads = (
        "vehicles/km",
        "radio",
        "policy",
        "warnings",
        "instants each",
        "of these missed",
        "never came",
        "late p50",
    )
    lines = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    keys = [
        (run["run"][0]["density_per_km"], run["run"][0]["radio"], run["run"][0]["policy"]) for run in runs
    ]
    for key in sorted({key for key in keys if key[0] in {min(densities), max(densities)}}):
        events = [
            event for run, own in zip(runs, keys, strict=True) if own == key for event in run["warned_events"]
        ]
        late_s = [np.inf if event["delay_s"] is None else event["delay_s"] for event in events]
        cells = (
            f"{key[0]:g}", key[1], key[2], f"{len(events)}",
            f"{np.mean([event['positives'] for event in events]):.1f}",
            f"{np.mean([event['missed'] for event in events]):.2f}",
            f"{100 * np.isinf(late_s).mean():.1f} %",
            f"{np.median(late_s):.1f} s",
        )  # fmt: skip
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def main() -> int:
    """Print the tables, and write or check them where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="+", choices=CALLS, help="make the tables of these calls alone")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    blocks = {name: table(given.folder / name) for name in given.only or CALLS}
    if given.only is None:
        blocks["speeds"] = speeds()
    if "warnings" in blocks:
        blocks["misses"] = misses(given.folder / "warnings")
    for name, lines in blocks.items():
        print(f"{name}\n", *lines, sep="\n")
    if given.write or given.check:
        return put({PAGE: blocks}, check=given.check)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
