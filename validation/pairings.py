"""How each reading tracks each sender in a mixed fleet, and what senders that mind legacy receivers pay.

``pairings.py FOLDER`` runs `modelcast mixed` with no legacy threshold, one of twice the senders' own and one
of their own, keeps what is done, and prints a table of means over the seeds; ``--write`` puts it into
``docs/mixed.md``, ``--check`` returns 1 where the page has another.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import polars as pl

from modelcast.cli.app import run
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "mixed.md"
LEGACY_M = (0.0, 1.0, 0.5)
"""Legacy thresholds; 0 is none."""
WORDS = (
    "mixed", "--density", "100", "--policy", "baseline", "free", "mbc", "--penetration", "50",
    "--keep-alive", "5", "--approach", "0", "--threshold", "0.5", "--believe", "sent", "--sensor", "ins",
    "--duration", "40", "--seeds", "2",
)  # fmt: skip
"""A quarter of the vehicles each sends by ``baseline`` and ``free``, half by ``mbc``."""
ERRORS = ("pte_p50_m", "pte_p90_m", "pte_p99_m")
READINGS = ("legacy", "free", "model")


def _place(folder: Path, legacy_m: float) -> Path:
    return folder / f"legacy-{legacy_m:g}"


def simulate(folder: Path) -> None:
    """Run what is not done yet."""
    for legacy_m in LEGACY_M:
        words = [*WORDS, "--legacy-threshold", f"{legacy_m:g}", "--out", str(_place(folder, legacy_m))]
        if run(words):
            raise SystemExit(f"failed: modelcast {' '.join(words)}")


def table(found: dict[float, pl.DataFrame]) -> Iterator[str]:
    """Lines of the table, of the pairings by legacy threshold."""
    yield (
        "| sender | messages a vehicle [1/s] | "
        + " | ".join(f"{reading}: p50 / p90 / p99 [m]" for reading in READINGS)
        + " |"
    )
    yield "|---|---|---|---|---|"
    for legacy_m, pairings in found.items():
        means = pairings.group_by("sender", "reading").agg(pl.col("message_rate_hz", *ERRORS).mean())
        for sender in ("baseline", "free", "mbc") if not legacy_m else ("free", "mbc"):
            of = {row["reading"]: row for row in means.filter(pl.col("sender") == sender).to_dicts()}
            errors = (" / ".join(f"{of[reading][name]:.2f}" for name in ERRORS) for reading in READINGS)
            minds = f", legacy threshold {legacy_m:g} m" if legacy_m else ""
            rate_hz = of["legacy"]["message_rate_hz"]
            yield f"| {sender}{minds} | {rate_hz:.3f} | {' | '.join(errors)} |"


def main() -> int:
    """Run and print, write or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    simulate(given.folder)
    lines = list(table({m: pl.read_parquet(_place(given.folder, m) / "pairings.parquet") for m in LEGACY_M}))
    print("\n".join(lines))
    return put({PAGE: {"pairings": lines}}, check=given.check) if given.write or given.check else 0


if __name__ == "__main__":
    sys.exit(main())
