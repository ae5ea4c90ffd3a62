"""How much faster one checkout is than another, on the same machine at the same time.

``paired.py BASE HEAD``: folders, or revisions, for which worktrees are made for the time of the run. A
scenario of `paired_scenarios.py` runs in processes of its own, in the order base, head, head, base, so that a
drift of the machine falls out; each process compiles first and reports its least processor time, or by the
clock on the wall where two threads share the work (``-threads``; the base may know of one only). The ratio is
base over head, above 1 where head is faster, with the 95 % interval of Student's t over the logarithms of the
rounds. The verdict is against ``--limit``: ``ok`` where the interval is above it, ``slower`` where below,
else ``unclear``. Exit code 1 where something is slower.

Where the closed loop tells its stages, they are printed for both.
"""

import argparse
import contextlib
import json
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Generator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from paired_scenarios import SCENARIOS

HERE = Path(__file__).resolve().parent
NAMES = (*SCENARIOS, "demo-cold")
THREADS = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "POLARS_MAX_THREADS",
)


def git(*words: str) -> str:
    """Run git beside the benchmarks and return what it says."""
    command = ["git", "-C", str(HERE), *words]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()  # noqa: S603


@contextlib.contextmanager
def checkout(named: str, folder: Path) -> Generator[Path]:
    """Give the folder of a checkout; a worktree that is removed afterwards where a revision is named."""
    if (Path(named) / "src" / "modelcast").is_dir():
        yield Path(named).resolve()
        return
    git("worktree", "add", "--quiet", "--detach", str(folder), git("rev-parse", f"{named}^{{commit}}"))
    try:
        yield folder
    finally:
        git("worktree", "remove", "--force", str(folder))


def once(name: str, where: Path, cache: Path) -> dict[str, Any]:
    """Time a scenario on a checkout in a process of its own."""
    environment = {**os.environ, **dict.fromkeys(THREADS, "1"), "PYTHONHASHSEED": "0"}
    environment |= {"PYTHONPATH": str(where / "src"), "MODELCAST_CACHE_DIR": str(cache)}
    command = [sys.executable, str(HERE / "paired_scenarios.py"), name]
    ran = subprocess.run(  # noqa: S603 - our own script
        command, check=False, env=environment, capture_output=True, text=True, cwd=cache.parent
    )
    if ran.returncode:
        return {"absent": f"fails on {where.name}: {ran.stderr.strip().splitlines()[-1:]}"}
    return json.loads(ran.stdout.strip().splitlines()[-1])


def interval(logarithms: list[float]) -> tuple[float, float, float]:
    """Return the ratio and its 95 % interval."""
    middle = statistics.fmean(logarithms)
    if len(logarithms) < 2:
        return float(np.exp(middle)), 0.0, float("inf")
    error = statistics.stdev(logarithms) / len(logarithms) ** 0.5
    reach = float(stats.t.ppf(0.975, len(logarithms) - 1)) * error
    return float(np.exp(middle)), float(np.exp(middle - reach)), float(np.exp(middle + reach))


def compared(name: str, sides: tuple[tuple[Path, Path], ...], rounds: int, limit: float) -> dict[str, Any]:
    """Run a scenario for some rounds; its ratio, or why there is none."""
    for where, cache in sides if name != "demo-cold" else ():
        first = once(name, where, cache)  # fills the cache of compiled code
        if "absent" in first:
            return {"scenario": name, **first}
    logarithms: list[float] = []
    took: tuple[list[float], list[float]] = ([], [])
    told: list[Mapping[str, float]] = [{}, {}]
    for _ in range(rounds):
        balance = 0.0
        for side in (0, 1, 1, 0):
            one = once(name, *sides[side])
            if "absent" in one:
                return {"scenario": name, **one}
            took[side].append(one["seconds"])
            told[side] = one["stages"]
            balance += (0.5, -0.5)[side] * float(np.log(one["seconds"]))
        logarithms.append(balance)
    ratio, low, high = interval(logarithms)
    verdict = "ok" if low >= limit else "slower" if high < limit else "unclear"
    return {
        "scenario": name,
        "base_s": statistics.median(took[0]),
        "head_s": statistics.median(took[1]),
        "ratio": ratio,
        "low": low,
        "high": high,
        "verdict": verdict,
        "base_stages": dict(told[0]),
        "head_stages": dict(told[1]),
    }


def show(row: dict[str, Any]) -> None:
    """Print a scenario's line, and the stages where there are any."""
    if "absent" in row:
        print(f"{row['scenario']:20s} left out: {row['absent']}", flush=True)
        return
    print(
        f"{row['scenario']:20s} {row['base_s']:8.3f} {row['head_s']:8.3f} {row['ratio']:7.3f} "
        f"[{row['low']:.3f}, {row['high']:.3f}]  {row['verdict']}",
        flush=True,
    )
    stages: tuple[dict[str, float], ...] = (row["base_stages"], row["head_stages"])
    totals = [sum(one.values()) for one in stages]
    for stage in dict.fromkeys([*stages[0], *stages[1]]):
        cells = (
            f"{one[stage]:8.3f} s {one[stage] / total:6.1%}" if stage in one and total else f"{'-':>17s}"
            for one, total in zip(stages, totals, strict=True)
        )
        print(f"    {stage:24s} {'   '.join(cells)}", flush=True)


def main() -> int:
    """Compare and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("base", help="folder or revision")
    parser.add_argument("head", help="folder or revision")
    parser.add_argument(
        "--only", nargs="+", choices=NAMES, default=NAMES, metavar="NAME", help=", ".join(NAMES)
    )
    parser.add_argument("--rounds", type=int, default=6, help="of four processes each")
    parser.add_argument("--limit", type=float, default=0.95, help="least ratio of base over head")
    parser.add_argument("--json", action="store_true", help="one JSON object a scenario")
    parser.add_argument("--caches", type=Path, help="keep compiled code here, for the next run")
    given = parser.parse_args()
    slower = 0
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as kept:
        folder = Path(name)
        sides: list[tuple[Path, Path]] = []
        for side, named in (("base", given.base), ("head", given.head)):
            cache = (folder if given.caches is None else given.caches.resolve()) / f"{side}-cache"
            cache.mkdir(parents=True, exist_ok=True)
            sides.append((kept.enter_context(checkout(named, folder / side)), cache))
        if not given.json:
            print(
                f"{'':20s} {'base [s]':>8s} {'head [s]':>8s} {'ratio':>7s} 95 % interval, limit {given.limit}"
            )
        for scenario in given.only:
            row = compared(scenario, tuple(sides), given.rounds, given.limit)
            slower += row.get("verdict") == "slower"
            if given.json:
                print(json.dumps(row), flush=True)
            else:
                show(row)
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main())
