"""How fast a fleet on the air runs and where its time goes; ``--write`` puts the tables into docs/network.md.

Highway of 200 vehicles/km, J2945/1 with models, default bank, filter and sensors, every live track within
300 m set against the truth at 10 Hz. The first seconds, in which all send at 10 Hz, are counted; traffic is
made beforehand and is not. Times are processor times of one thread, the least of some runs. With
``--threads`` the runs of many sizes are timed by the clock on the wall: on a machine with other work they say
little.

``--paired FILE`` puts in what ``benchmarks/paired.py --json`` has printed into that file.
"""

import argparse
import importlib
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.nr import Nr
from modelcast.channel.radio import AbstractRadio
from modelcast.channel.sidelink import Sidelink
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.sender.sender import named_sender
from modelcast.world.scenario.base import FleetFrame, run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import SensorModel
from page_blocks import put

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))

from paired_scenarios import added_up

PAGE = Path(__file__).resolve().parents[1] / "docs" / "network.md"
DENSITY_PER_KM = 200.0
RADIOS: dict[str, type[AbstractRadio[Any]]] = {"802.11p": Dsrc, "mode 4": Sidelink, "NR": Nr}
METHODS = ("_sense", "_track", "_send", "_carry", "_hear", "step")
BLOCKS = ("fleet-stages", "fleet-sizes", "fleet-paired")
PAIRS = ("find_reach", "lay_out", "renew_pairs")
"""What a radio calls before its events, by their names in its module."""


def frames_of(vehicles: int, seconds: float) -> list[FleetFrame]:
    """Traffic of so many vehicles."""
    road = Highway(1000.0 * vehicles / DENSITY_PER_KM, DENSITY_PER_KM, warm_up_s=10.0)
    return list(run_scenario(road, np.random.default_rng(0), duration_s=seconds))


def least_s(frames: list[FleetFrame], radio: AbstractRadio[Any], threads: int, repeats: int) -> float:
    """Least time of a run, by the clock on the wall where threads share it [s]."""
    clock = time.process_time if threads == 1 else time.perf_counter
    least = np.inf
    for _ in range(repeats):
        begun = clock()
        run_network(
            frames, named_sender("j2945-mbc"), radio, NetworkSettings(warm_up_s=0.0), seed=0,
            sensor=FleetSensor(SensorModel()), threads=threads,
        )  # fmt: skip
        least = min(least, clock() - begun)
    return float(least)


def stages_of(frames: list[FleetFrame], radio: AbstractRadio[Any], seconds: float) -> dict[str, float]:
    """Processor time by stage, of the quickest of three runs [ms a simulated second]."""
    home = importlib.import_module(type(radio).__module__)
    places = [(FleetLoop, name) for name in METHODS] + [(home, name) for name in (*PAIRS, "advance")]
    kept: list[Callable[..., Any]] = [getattr(where, name) for where, name in places]
    spent, least = dict[str, float](), dict[str, float]()
    try:
        for (where, name), function in zip(places, kept, strict=True):
            setattr(where, name, added_up(spent, name, function, time.process_time))
        for _ in range(3):
            spent.clear()
            least_s(frames, radio, 1, 1)
            if not least or spent["step"] < least["step"]:
                least = dict(spent)
    finally:
        for (where, name), function in zip(places, kept, strict=True):
            setattr(where, name, function)
    told = {name: 1e3 * value / seconds for name, value in least.items()}
    pairs = sum(told[name] for name in PAIRS)
    return {
        "sensors, filter": told["_sense"],
        "senders: fit, own error, decide, compose": told["_send"],
        "radio: pairs and their shadowing": pairs,
        "radio: events": told["advance"],
        "radio: messages in and out": told["_carry"] - pairs - told["advance"],
        "receivers": told["_hear"],
        "tracks against the truth": told["_track"],
        "rest": told["step"] - sum(told[name] for name in METHODS[:-1]),
        "**all**": told["step"],
    }


def stage_lines(seconds: float) -> list[str]:
    """Table of stages of 1,000 vehicles, a column a radio."""
    frames = frames_of(1000, seconds)
    columns = [stages_of(frames, radio(), seconds) for radio in RADIOS.values()]
    return [
        f"| stage, ms a simulated second | {' | '.join(RADIOS)} |",
        "|---|" + "---|" * len(RADIOS),
        *(f"| {stage} | {' | '.join(f'{one[stage]:.0f}' for one in columns)} |" for stage in columns[0]),
    ]


def size_lines(seconds: float, threads: int) -> list[str]:
    """Table of runs by radio and size."""
    sizes = {1000: 4, 5000: 2}
    head = " | ".join(f"{vehicles:,} vehicles" for vehicles in sizes)
    lines = [f"| times real time, threads: {threads} | {head} |", "|---|" + "---|" * len(sizes)]
    frames = {vehicles: frames_of(vehicles, seconds) for vehicles in sizes}
    for name, radio in RADIOS.items():
        took_s = [least_s(frames[vehicles], radio(), threads, repeats) for vehicles, repeats in sizes.items()]
        lines.append(f"| {name} | {' | '.join(f'{seconds / one:.2f}' for one in took_s)} |")
    return lines


def paired_lines(file: Path) -> list[str]:
    """Table of what `paired.py` found."""
    lines = [
        "| scenario | before [s] | now [s] | before over now, with its 95 % interval |",
        "|---|---|---|---|",
    ]
    for text in file.read_text(encoding="utf-8").splitlines():
        row = json.loads(text)
        ratio = f"{row['ratio']:.2f} ({row['low']:.2f} to {row['high']:.2f})"
        lines.append(f"| `{row['scenario']}` | {row['base_s']:.2f} | {row['head_s']:.2f} | {ratio} |")
    return lines


def main() -> int:
    """Measure, print, and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seconds", type=float, default=3.0, help="simulated")
    parser.add_argument("--threads", type=int, default=1, help="of the runs of many sizes")
    parser.add_argument("--paired", type=Path, help="what paired.py --json has printed")
    parser.add_argument("--only", nargs="+", choices=BLOCKS, help="blocks to make; all by default")
    parser.add_argument("--write", action="store_true", help="put the tables into docs/network.md")
    given = parser.parse_args()
    if given.only != ["fleet-paired"]:
        few = frames_of(40, 2.0)
        for radio in RADIOS.values():
            least_s(few, radio(), 1, 1)  # compiles
    made: dict[str, Callable[[], list[str]]] = {
        "fleet-stages": lambda: stage_lines(given.seconds),
        "fleet-sizes": lambda: size_lines(given.seconds, given.threads),
    }
    if given.paired is not None:
        made["fleet-paired"] = lambda: paired_lines(given.paired)
    blocks: dict[str, list[str]] = {}
    for name in given.only or made:
        blocks[name] = made[name]()
        print("\n".join([*blocks[name], ""]), flush=True)
    return put({PAGE: blocks}, check=False) if given.write else 0


if __name__ == "__main__":
    sys.exit(main())
