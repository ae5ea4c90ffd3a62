"""Compare NR-V2X mode 2 with the figures of WiLabV2Xsim 6.2, per 50 m of distance.

Usage: python validation/wilab_nr.py [FOLDER] [--seeds N] [--keep RUNS] [--write | --check]
FOLDER holds the reference's ``wilab_nr_*.tsv``; left out, the environment variable MODELCAST_REFERENCE names
it. RUNS is a folder where runs are kept, so that an interruption costs one. ``--write`` puts the table into
``validation/README.md``, ``--check`` tells by its exit code whether that page has it.

A message that was dropped at its sender counts as not received by all who were in reach then, as the
reference counts it.
"""

import argparse
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from highway import Road, messages
from modelcast.channel.radio_words import get_radio
from modelcast.core.version import package_version
from page_blocks import put
from wilab import COARSE, FINE_M, ROAD, SECONDS, published

PAGE = Path(__file__).parent / "README.md"
TARGET, BINS = 0.03, 60
WORD = f"nr:preset=wilab,bin_m={FINE_M:g},bins={BINS}"
APERIODIC = replace(ROAD, rate_hz=20.0, mean_extra_s=0.05)


class Case(NamedTuple):
    """A file of the reference, the radio as ``--radio`` takes it and the traffic that it is of."""

    file: str
    title: str
    word: str
    road: Road


CASES = (
    Case("wilab_nr_mcs11_100_k04", "MCS 11, keep 0.4", WORD, ROAD),
    Case("wilab_nr_mcs11_100_k08", "MCS 11, keep 0.8", f"{WORD},keep_ratio=0.8", ROAD),
    Case("wilab_nr_mcs11_100_k04_aper", "MCS 11, keep 0.4, aperiodic", WORD, APERIODIC),
    Case("wilab_nr_mcs11_100_dyn", "MCS 11, dynamic grants", f"{WORD},dynamic=true", ROAD),
    Case("wilab_nr_mcs7_100_k04", "MCS 7, keep 0.4", f"{WORD},mcs=7", ROAD),
)


class Counts(NamedTuple):
    """Pairs in bins of `FINE_M`, (BINS,): received, lost on the air, dropped at the sender; busy ratio."""

    received: np.ndarray
    lost: np.ndarray
    dropped: np.ndarray
    busy: float

    def coarse(self) -> np.ndarray:
        """Received and all pairs in bins of 50 m, (bins, 2)."""
        total = self.received + self.lost + self.dropped
        return np.stack([self.received, total], axis=1).reshape(-1, COARSE, 2).sum(axis=1)


def run(case: Case, seed: int) -> Counts:
    """One drive of the fleet."""
    radio = get_radio(case.word)
    state: Any = radio.init(case.road.vehicles, np.random.default_rng([seed, 1]))
    outcomes: Any = 0
    dropped = np.zeros(BINS, dtype=np.int64)
    sender_of: dict[int, int] = {}
    ratios: list[float] = []
    for batch, position_m, until_s in messages(case.road, SECONDS, seed):
        sender_of.update(zip(batch.message_id.tolist(), batch.sender.tolist(), strict=True))
        heard, state = radio.carry(state, batch, position_m, round(until_s, 3))
        outcomes = outcomes + heard.outcomes
        ratios.append(float(np.median(radio.channel_busy_ratio(state))))
        for number in heard.expired.tolist():
            away_m = np.linalg.norm(position_m - position_m[sender_of[number]], axis=1)
            away_m[sender_of[number]] = np.inf
            at = (away_m[away_m < BINS * FINE_M] / FINE_M).astype(np.int64)
            dropped += np.bincount(at, minlength=BINS)
    return Counts(outcomes[:, 0], outcomes[:, 1:].sum(axis=1), dropped, float(np.mean(ratios)))


def kept(case: Case, seed: int, folder: Path | None) -> Counts:
    """What the folder has of a run, made where it has nothing."""
    path = folder / f"{case.file}-{seed}.npz" if folder is not None else None
    if path is not None and path.exists():
        with np.load(path) as held:
            return Counts(held["received"], held["lost"], held["dropped"], float(held["busy"]))
    found = run(case, seed)
    if path is not None:
        np.savez(path, **found._asdict())
        print(path.stem, file=sys.stderr, flush=True)
    return found


def shares(
    folder: Path, case: Case, seeds: int, keep: Path | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Theirs, ours seed by seed (seeds, bins), share dropped at the sender (seeds,), mean busy ratio."""
    reference = published(folder / f"{case.file}.tsv")
    theirs = reference[:, 1] / reference[:, 0]
    counts = [kept(case, seed, keep) for seed in range(seeds)]
    pairs = np.stack([one.coarse() for one in counts])[:, : theirs.size]
    whole = [one.dropped.sum() / (one.received + one.lost + one.dropped).sum() for one in counts]
    ours = pairs[:, :, 0] / pairs[:, :, 1]
    return theirs, ours, np.array(whole), float(np.mean([one.busy for one in counts]))


def table(folder: Path, seeds: int, keep: Path | None) -> list[str]:
    """Lines of Markdown."""
    found = {case.title: shares(folder, case, seeds, keep) for case in CASES}
    bins = max(theirs.size for theirs, *_ in found.values())
    heads = [f"{k * 50}-{k * 50 + 50}" for k in range(bins)]
    lines = [f"| distance m | {' | '.join(heads)} |", "|" + "---|" * (bins + 1)]
    notes: list[str] = []
    worst = 0.0
    for title, (theirs, ours, dropped, busy) in found.items():
        apart = ours.mean(axis=0) - theirs
        rows = (("WiLabV2Xsim", theirs, ".3f"), ("modelcast", ours.mean(axis=0), ".3f"))
        for name, row, form in (*rows, ("difference", apart, "+.3f")):
            shown = [format(one, form) for one in row] + [""] * (bins - row.size)
            lines.append(f"| {title}: {name} | {' | '.join(shown)} |")
        largest, spread = float(np.abs(apart).max()), float(ours.std(axis=0, ddof=1).max())
        worst = max(worst, largest)
        notes.append(
            f"- {title}: largest difference {largest:.3f}, standard deviation of seeds at most {spread:.3f}, "
            f"{dropped.mean():.3f} of the pairs dropped at the sender, median busy ratio {busy:.3f}."
        )
    said = "reached" if worst <= TARGET else "missed"
    whole = (
        f"Largest difference {worst:.3f}; target {TARGET}: {said}. Mean of {seeds} seeds of {SECONDS:.0f} s; "
        f"modelcast {package_version()}."
    )
    return [*lines, "", *notes, "", whole]


def main() -> int:
    """Run all, print the table, and write or check the page where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", nargs="?", default=os.environ.get("MODELCAST_REFERENCE", ""))
    parser.add_argument("--seeds", type=int, default=10, help="runs of each case")
    parser.add_argument("--keep", type=Path, help="folder of runs")
    parser.add_argument("--write", action="store_true", help="put the table into validation/README.md")
    parser.add_argument("--check", action="store_true", help="tell whether validation/README.md has it")
    given = parser.parse_args()
    if not given.folder:
        parser.error("name the folder of the reference figures, or set MODELCAST_REFERENCE")
    if given.keep is not None:
        given.keep.mkdir(parents=True, exist_ok=True)
    lines = table(Path(given.folder), given.seeds, given.keep)
    print("\n".join(lines))
    if given.write or given.check:
        return put({PAGE: {"wilab-nr": lines}}, check=given.check)
    return 0


if __name__ == "__main__":
    sys.exit(main())
