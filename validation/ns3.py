"""Compare packet reception with ns-3, per 50 m of distance, for 50, 100 and 200 nodes on one kilometre.

Usage: python validation/ns3.py NS3_PYTHON [OUTPUT.md]
NS3_PYTHON is the interpreter of a virtual environment with pip's ``ns3`` 3.44; without an argument the
environment variable MODELCAST_NS3_PYTHON names it. Needs g++. Both simulators get the same places and phases.

Each run of ns-3 stands between two of ours, whose mean it is compared with. Counted are, of ns-3, the whole
process; of modelcast, the radio's construction and all steps, not the import and the compilation.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.radio import Transmissions
from modelcast.channel.radio_words import get_radio

sys.path.insert(0, str(Path(__file__).parents[1] / "examples" / "ns3_radio" / "src"))

from ns3_radio.program import build, environment
from ns3_radio.radio import ERROR_MODELS

LENGTH_M, PERIOD_S, BIN_M, BINS = 1000.0, 0.1, 50.0, 10
OVERHEAD = 36  # MAC header 24, FCS 4, LLC and SNAP 8
SEEDS = 3
PAIRS = {50: 3, 100: 3, 200: 9}
"""Timed pairs of runs by number of nodes: each seed as often as the next."""
TARGET = 0.05

Places = tuple[np.ndarray, np.ndarray]


class Air(NamedTuple):
    """What is set alike in both simulators.

    ``errors`` is the error model, a key of the example's `ERROR_MODELS`. Messages are sent for ``seconds``;
    what is under way then has ``tail_s`` more.
    """

    rate_mbps: float = 6.0
    payload: int = 300
    exponent: float = 2.4
    errors: str = "nist"
    seconds: float = 10.0
    tail_s: float = 0.0
    energy_dbm: float = -82.0
    """Of our radio alone: ns-3's is its default."""

    @property
    def turns(self) -> int:
        """Messages of a node."""
        return round(self.seconds / PERIOD_S)


NIST = Air()
"""As the tables of three numbers of nodes have it."""


NOTHING = Transmissions(
    np.empty(0, dtype=np.int64),
    np.empty(0),
    size_bytes=np.empty(0, dtype=np.int64),
    power_dbm=np.empty(0),
    message_id=np.empty(0, dtype=np.int64),
)


class Took(NamedTuple):
    """What a run took [s]."""

    wall_s: float
    processor_s: float


def spent(whose: int) -> Took:
    """Time so far, and processor time of this process or of its children (``resource.RUSAGE_...``)."""
    used = resource.getrusage(whose)
    return Took(time.perf_counter(), used.ru_utime + used.ru_stime)


def since(start: Took, whose: int) -> Took:
    """What went by since ``start``."""
    now = spent(whose)
    return Took(now.wall_s - start.wall_s, now.processor_s - start.processor_s)


def places(nodes: int, seed: int) -> Places:
    """Positions (N, 2) and phases (N,)."""
    rng = np.random.default_rng([seed, nodes])
    position_m = np.stack([rng.uniform(0.0, LENGTH_M, nodes), 4.0 * rng.integers(0, 4, nodes)], axis=1)
    return position_m, rng.uniform(0.0, PERIOD_S, nodes)


def radio(air: Air = NIST) -> Dsrc:
    """IEEE 802.11p as ns-3 has it; what is not its default validation/ns3_broadcast.cc sets too."""
    settings = {
        "preset": "ns3-default",
        "rate_mbps": air.rate_mbps,
        "error_model": air.errors,
        "sensitivity_dbm": -98.0,
        "decodable_dbm": -98.0,
        "preamble_db": 2.0,
        "capture_db": 2.0,
        "energy_dbm": air.energy_dbm,
        "exponent": air.exponent,
        "reference_loss_db": 47.86,
        "fading": "nakagami",
        "max_power_dbm": 20.0,
        "bin_m": BIN_M,
        "bins": BINS,
    }
    word = ",".join(f"{key}={value}" for key, value in settings.items())
    found = get_radio(f"dsrc:{word}")
    assert isinstance(found, Dsrc)
    return found


class Ours(NamedTuple):
    """Outcomes (BINS, 5), the mean busy ratio of all nodes after each period, and what it took."""

    outcomes: np.ndarray
    busy: float
    took: Took


def ours(position_m: np.ndarray, phase_s: np.ndarray, seed: int, air: Air = NIST) -> Ours:
    """Run our radio once."""
    start = spent(resource.RUSAGE_SELF)
    channel = radio(air)
    state = channel.init(phase_s.size, np.random.default_rng(seed))
    outcomes, busy = np.zeros((BINS, 5), dtype=np.int64), 0.0
    order = np.argsort(phase_s)
    for k in range(air.turns):
        batch = Transmissions(
            order,
            k * PERIOD_S + phase_s[order],
            size_bytes=np.full(order.size, air.payload + OVERHEAD),
            power_dbm=np.full(order.size, 20.0),
            message_id=order + k * order.size,
        )
        heard, state = channel.carry(state, batch, position_m, (k + 1) * PERIOD_S)
        outcomes += heard.outcomes
        busy += float(channel.channel_busy_ratio(state).mean()) / air.turns
    if air.tail_s > 0.0:
        heard, state = channel.carry(state, NOTHING, position_m, air.seconds + air.tail_s)
        outcomes += heard.outcomes
    return Ours(outcomes, busy, since(start, resource.RUSAGE_SELF))


def folder_of(python: str) -> Path:
    """Folder of the wheel that an interpreter has."""
    query = [python, "-c", "import sysconfig; print(sysconfig.get_paths()['purelib'])"]
    asked = subprocess.run(query, capture_output=True, text=True, check=True)  # noqa: S603 - named by the caller
    return Path(asked.stdout.strip()) / "ns3"


def theirs(
    program: Path, ns3: Path, where: Places, seed: int, folder: Path, *, air: Air = NIST
) -> tuple[np.ndarray, Took]:
    """Pairs and receptions by bin (BINS, 2), and what it took."""
    position_m, phase_s = where
    nodes = folder / "nodes.txt"
    np.savetxt(nodes, np.column_stack([position_m, phase_s]))
    start = spent(resource.RUSAGE_CHILDREN)
    command = [
        str(program),
        f"--nodes={nodes}",
        f"--seconds={air.seconds}",
        f"--tail={air.tail_s}",
        f"--bytes={air.payload}",
        f"--mode=OfdmRate{air.rate_mbps:g}MbpsBW10MHz",
        f"--exponent={air.exponent}",
        f"--errors={ERROR_MODELS[air.errors]}",
        f"--seed={seed + 1}",
    ]
    run = subprocess.run(command, capture_output=True, text=True, check=True, env=environment(ns3))  # noqa: S603
    took = since(start, resource.RUSAGE_CHILDREN)
    distance_m = np.hypot(*(position_m[:, None] - position_m[None]).transpose(2, 0, 1))
    group = (distance_m / BIN_M).astype(int)
    counts = np.zeros((BINS + 1, 2))
    off = ~np.eye(phase_s.size, dtype=bool)
    np.add.at(counts[:, 0], np.minimum(group[off], BINS), air.turns)
    for line in run.stdout.splitlines():
        sender, receiver, received = map(int, line.split())
        counts[min(group[sender, receiver], BINS), 1] += received
    return counts[:BINS], took


class Pair(NamedTuple):
    """A run of ns-3 between two of ours, of one seed."""

    outcomes: np.ndarray
    counts: np.ndarray
    ours: Took
    theirs: Took


def pair(nodes: int, seed: int, run_theirs: Callable[[Places, int], tuple[np.ndarray, Took]]) -> Pair:
    """Run both; our times are the mean of the run before and the run after."""
    where = places(nodes, seed)
    before = ours(*where, seed)
    counts, took = run_theirs(where, seed)
    after = ours(*where, seed)
    return Pair(before.outcomes, counts, Took(*(0.5 * np.add(before.took, after.took))), took)


def spread(values: list[float], form: str) -> str:
    """Least, median and largest."""
    return " / ".join(format(value, form) for value in (min(values), float(np.median(values)), max(values)))


def tables(nodes: int, pairs: list[Pair]) -> list[str]:
    """Lines of Markdown: reception by distance, and times."""
    lines = [f"### {nodes} nodes", "", "| distance m | ns-3 | modelcast | difference |", "|---|---|---|---|"]
    mine = np.sum([one.outcomes for one in pairs[:SEEDS]], axis=0)
    reference = np.sum([one.counts for one in pairs[:SEEDS]], axis=0)
    ratio, own = reference[:, 1] / reference[:, 0], mine[:, 0] / mine.sum(axis=1)
    lines += [
        f"| {k * BIN_M:.0f}-{(k + 1) * BIN_M:.0f} | {one:.3f} | {other:.3f} | {other - one:+.3f} |"
        for k, (one, other) in enumerate(zip(ratio, own, strict=True))
    ]
    worst = np.abs(own - ratio).max()
    lines += ["", f"Largest difference {worst:.3f}; target {TARGET}. Sum of {SEEDS} seeds.", ""]
    lines += [
        f"| {NIST.seconds:.0f} s, {len(pairs)} pairs: min / median / max | ns-3 s | modelcast s | ratio |",
        "|---|---|---|---|",
    ]
    for k, title in enumerate(("wall time", "processor time")):
        theirs_s, ours_s = [one.theirs[k] for one in pairs], [one.ours[k] for one in pairs]
        ratios = [a / b for a, b in zip(theirs_s, ours_s, strict=True)]
        lines.append(
            f"| {title} | {spread(theirs_s, '.2f')} | {spread(ours_s, '.3f')} | {spread(ratios, '.0f')} |"
        )
    return [*lines, ""]


def main() -> int:
    """Print the tables, and write them where asked."""
    python = sys.argv[1] if len(sys.argv) > 1 else os.environ.get("MODELCAST_NS3_PYTHON", "")
    if not python:
        print("name the interpreter that has ns3, as an argument or in MODELCAST_NS3_PYTHON")
        return 2
    ns3 = folder_of(python)
    program = build(Path(__file__).with_name("ns3_broadcast.cc"), ns3)
    lines: list[str] = []
    ours(*places(10, 0), 0)  # compiles
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)

        def run_theirs(where: Places, seed: int) -> tuple[np.ndarray, Took]:
            return theirs(program, ns3, where, seed, folder)

        for nodes, number in PAIRS.items():
            pairs: list[Pair] = []
            for k in range(number):
                pairs.append(pair(nodes, k % SEEDS, run_theirs))
                print(f"{nodes} nodes, seed {k % SEEDS}:", *pairs[-1][2:], file=sys.stderr, flush=True)
            part = tables(nodes, pairs)
            print("\n".join(part), flush=True)
            lines += part
    if len(sys.argv) > 2:
        Path(sys.argv[2]).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
