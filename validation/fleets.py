"""What models earn in dense traffic beside the best free receiver, under J2945/1's timers.

``fleets.py run FOLDER`` runs `modelcast network` over every density, policy and seed, and keeps what is done,
so it can be called again. ``fleets.py table FOLDER`` prints the models' senders over the free ones, seed by
seed on the same traffic; with ``--write`` it puts the table into ``docs/results.md``, with ``--check`` it
tells by its exit code whether that page has it.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import polars as pl
from scipy import stats

from modelcast.cli.app import run
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "results.md"
DENSITIES_PER_KM = ("50", "100", "200", "400", "800")
PAIRS = (("j2945-mbc", "j2945-free"), ("j2945-mbc-relaxed", "j2945-free-relaxed"))
COLUMNS = ("message_rate_hz", "bytes_per_s", "pte_p90_m", "pte_p99_m")


def simulate(folder: Path, seeds: int) -> int:
    """Run all that is not done yet."""
    policies = [policy for pair in PAIRS for policy in pair]
    words = ["network", "--density", *DENSITIES_PER_KM, "--policy", *policies, "--length", "1000"]
    words += ["--duration", "15", "--warm-up", "5", "--seeds", str(seeds)]
    return run([*words, "--out", str(folder)])


def _ratios(runs: pl.DataFrame, density: float, own: str, rival: str, column: str) -> np.ndarray:
    at = runs.filter(pl.col("density_per_km") == density).sort("run")
    first, second = (at.filter(pl.col("policy") == name)[column].to_numpy() for name in (own, rival))
    return first / second


def _cell(ratios: np.ndarray) -> str:
    half = stats.t.ppf(0.975, ratios.size - 1) * ratios.std(ddof=1) / np.sqrt(ratios.size)
    return f"{ratios.mean():.3f} ± {half:.3f}"


def table(runs: pl.DataFrame) -> Iterator[str]:
    """Lines of the table."""
    yield "| vehicles/km | sender | over | messages | bytes | p90 | p99 | free's p90 / p99, cm |"
    yield "|---|---|---|---|---|---|---|---|"
    for own, rival in PAIRS:
        for density in sorted(runs["density_per_km"].unique()):
            cells = [_cell(_ratios(runs, density, own, rival, column)) for column in COLUMNS]
            free = runs.filter((pl.col("density_per_km") == density) & (pl.col("policy") == rival))
            tails = " / ".join(f"{100 * free[name].to_numpy().mean():.2f}" for name in COLUMNS[2:])
            yield f"| {density:g} | `{own}` | `{rival}` | {' | '.join(cells)} | {tails} |"


def main() -> int:
    """Run or print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=("run", "table"))
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    if given.what == "run":
        return simulate(given.folder, given.seeds)
    lines = list(table(pl.read_parquet(given.folder / "runs.parquet")))
    print("\n".join(lines))
    if given.write or given.check:
        return put({PAGE: {"fleets": lines}}, check=given.check)
    return 0


if __name__ == "__main__":
    sys.exit(main())
