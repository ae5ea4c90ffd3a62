"""Compare packet reception with the figures of WiLabV2Xsim 6.1, per 50 m of distance, over ten seeds.

The reference holds ``wilab_80211p_100_per_km.tsv`` and ``wilab_ltev2x_mode4_100_per_km.tsv``; its folder is
the argument, or what MODELCAST_REFERENCE names. Four parts: both radios as that simulator has them, what each
of its ways alone moves, two settings of 802.11p that it does not have, and with ``--density`` what is
predicted for other densities, for which no figures are here. Runs are kept in the folder of ``--keep``, so
that an interruption costs one. ``--write`` puts the tables into ``validation/README.md``, ``--check`` tells
by the exit code whether it has them.
"""

import argparse
import os
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from highway import Road, count_outcomes
from modelcast.channel.radio import OUTCOMES
from modelcast.channel.radio_words import get_radio
from page_blocks import put

PAGE = Path(__file__).with_name("README.md")
ROAD = Road(2000.0, 200, 3, 4.0, 240.0 / 3.6, 10.0, 300, 23.0)
SECONDS, SEEDS, FINE_M, COARSE, BINS = 15.0, 10, 10.0, 5, 11
HERE_PER_KM, KM = 100, 2
TARGET = 0.03


class Radio(NamedTuple):
    """One radio of the reference.

    ``title``, ``word`` as ``--radio`` takes it, ``file`` of the figures, their median busy ``ratio``, and the
    ``ways``: settings of the preset that are that simulator's alone, each with the value it replaces.
    """

    title: str
    word: str
    file: str
    ratio: float
    ways: Mapping[str, Mapping[str, str]]


RADIOS = {
    "80211p": Radio(
        "IEEE 802.11p",
        "dsrc:preset=wilab",
        "wilab_80211p_100_per_km.tsv",
        0.195,
        {
            "frames that begin at once spoil each other": {"ties_spoil": "false"},
            "AIFS from the arrival of a message": {"aifs_on_arrival": "false"},
            "1 to 15 slots, not 0 to 15": {"aifsn": "6", "window": "15"},
            "signals down to 20 dB below the noise, not 10": {"margin_db": "10"},
        },
    ),
    "mode4": Radio(
        "LTE-V2X mode 4",
        "sidelink:preset=wilab",
        "wilab_ltev2x_mode4_100_per_km.tsv",
        0.540,
        {
            "all power on the data, none on the control pairs": {"control_blocks": "2"},
            "what is sensed below the noise is zero": {"noise_counts": "true"},
            "reservations by the mean power of a second": {"reserved_by_mean": "false"},
            "the first resource by chance": {"first_by_chance": "false"},
            "the best fifth of those sensed, not of all": {"best_of_possible": "false"},
        },
    ),
}

OTHERS = {
    "802.11p, preambles found from -2 dB": "dsrc:preset=wilab,preamble_db=-2.02,capture_db=-2.02",
    "802.11p, PER curve highway LOS, preambles from -2 dB": (
        "dsrc:preset=wilab,preamble_db=-2.02,capture_db=-2.02,error_model=highway-los"
    ),
}


def published(path: Path) -> np.ndarray:
    """Counts of pairs and of receptions in bins of 50 m, (bins, 2)."""
    rows = np.loadtxt(path, skiprows=1)
    whole = rows.shape[0] // COARSE * COARSE
    return rows[:whole, [4, 1]].reshape(-1, COARSE, 2).sum(axis=1)


class Runs:
    """Outcomes by seed, each worked out once and kept.

    Parameters
    ----------
    seeds
        How many.
    folder
        Where they are kept; None for nowhere.
    """

    def __init__(self, seeds: int, folder: Path | None) -> None:
        self.seeds, self.folder = seeds, folder
        self._held: dict[str, tuple[np.ndarray, float]] = {}

    def of(self, word: str, per_km: int = HERE_PER_KM) -> tuple[np.ndarray, float]:
        """Outcomes of a radio in bins of 50 m, (seeds, bins, 5), and the mean of the median busy ratios."""
        runs = [self._one(word, per_km, seed) for seed in range(self.seeds)]
        fine = np.stack([run[0] for run in runs])[:, : BINS * COARSE]
        coarse = fine.reshape(self.seeds, BINS, COARSE, fine.shape[2]).sum(axis=2)
        return coarse, float(np.mean([run[1] for run in runs]))

    def _one(self, word: str, per_km: int, seed: int) -> tuple[np.ndarray, float]:
        name = f"{word}-{per_km}-{seed}".replace(":", "-").replace(",", "-")
        if name not in self._held:
            path = self.folder / f"{name}.npz" if self.folder else None
            if path is not None and path.exists():
                with np.load(path) as kept:
                    self._held[name] = kept["outcomes"], float(kept["ratio"])
            else:
                road = replace(ROAD, vehicles=KM * per_km)
                radio = get_radio(f"{word},bin_m={FINE_M:g},bins={BINS * COARSE}")
                self._held[name] = count_outcomes(radio, road, SECONDS, seed)
                if path is not None:
                    outcomes, ratio = self._held[name]
                    np.savez(path, outcomes=outcomes, ratio=ratio)
        return self._held[name]


def delivered(outcomes: np.ndarray) -> np.ndarray:
    """Share received by bin over all seeds, (bins,)."""
    total = outcomes.sum(axis=0)
    return total[:, 0] / np.maximum(total.sum(axis=1), 1)


def spread(outcomes: np.ndarray) -> np.ndarray:
    """Standard deviation of one seed by bin, (bins,)."""
    each = outcomes[:, :, 0] / np.maximum(outcomes.sum(axis=2), 1)
    apart = each - each.mean(axis=0)
    return np.sqrt((apart**2).sum(axis=0) / max(each.shape[0] - 1, 1))


def span(k: int) -> str:
    """A bin in words."""
    return f"{k * FINE_M * COARSE:.0f}-{(k + 1) * FINE_M * COARSE:.0f}"


def compared(radio: Radio, folder: Path, runs: Runs) -> Iterator[str]:
    """Lines of the table of one radio beside its figures."""
    counts = published(folder / radio.file)
    outcomes, ratio = runs.of(radio.word)
    ours, one_seed = delivered(outcomes), spread(outcomes)
    theirs = counts[:, 1] / counts[:, 0]
    yield f"Median channel busy ratio {ratio:.3f} (theirs {radio.ratio:.3f})."
    yield ""
    yield (
        "| distance m | WiLabV2Xsim | modelcast | difference | one seed ± | "
        + " | ".join(OUTCOMES[1:])
        + " |"
    )
    yield "|" + "---|" * (len(OUTCOMES) + 4)
    shares = outcomes.sum(axis=0) / np.maximum(outcomes.sum(axis=(0, 2))[:, None], 1)
    for k, ratio_there in enumerate(theirs):
        causes = " | ".join(f"{share:.3f}" for share in shares[k, 1:])
        yield (
            f"| {span(k)} | {ratio_there:.3f} | {ours[k]:.3f} | {ours[k] - ratio_there:+.3f} | "
            f"{one_seed[k]:.3f} | {causes} |"
        )
    worst = float(np.abs(ours[: theirs.size] - theirs).max())
    yield ""
    yield f"Largest difference {worst:.3f}; target {TARGET}. {runs.seeds} seeds; the reference is one run."


def _without(radio: Radio) -> dict[str, str]:
    """Settings that replace all ways of that simulator."""
    return {key: value for instead in radio.ways.values() for key, value in instead.items()}


def _settings(settings: Mapping[str, str]) -> str:
    """Settings as a radio's word takes them."""
    return ",".join(f"{key}={value}" for key, value in settings.items())


def ways(radio: Radio, folder: Path, runs: Runs) -> Iterator[str]:
    """Lines that say what each way of that simulator moves: the preset less the preset without it."""
    counts = published(folder / radio.file)
    theirs = counts[:, 1] / counts[:, 0]
    whole = delivered(runs.of(radio.word)[0])[: theirs.size]
    yield (
        "| of the preset | "
        + " | ".join(span(k) for k in range(theirs.size))
        + " | largest difference without |"
    )
    yield "|---|" + "---|" * (theirs.size + 1)
    for name, instead in radio.ways.items():
        yield _moved(name, radio.word, instead, whole, theirs, runs)
    yield _moved("all of these", radio.word, _without(radio), whole, theirs, runs)


def _moved(name: str, word: str, instead: Mapping[str, str], whole: np.ndarray, *rest: Any) -> str:
    theirs, runs = rest
    without = delivered(runs.of(f"{word},{_settings(instead)}")[0])[: theirs.size]
    moved = " | ".join(f"{share:+.3f}" for share in whole - without)
    return f"| {name} | {moved} | {np.abs(without - theirs).max():.3f} |"


def others(folder: Path, runs: Runs) -> Iterator[str]:
    """Lines of settings that the reference does not have."""
    counts = published(folder / RADIOS["80211p"].file)
    theirs = counts[:, 1] / counts[:, 0]
    yield "| difference | " + " | ".join(span(k) for k in range(theirs.size)) + " |"
    yield "|---|" + "---|" * theirs.size
    for name, word in OTHERS.items():
        apart = delivered(runs.of(word)[0])[: theirs.size] - theirs
        yield f"| {name} | " + " | ".join(f"{one:+.3f}" for one in apart) + " |"


def predicted(densities: list[int], runs: Runs) -> Iterator[str]:
    """Lines of what is expected at other densities, for comparison by whoever has figures."""
    yield "| radio, vehicles a km | busy | " + " | ".join(span(k) for k in range(BINS)) + " | one seed ± |"
    yield "|---|" + "---|" * (BINS + 2)
    standard = RADIOS["mode4"]
    words = {radio.title: radio.word for radio in RADIOS.values()}
    words[f"{standard.title} without these ways"] = f"{standard.word},{_settings(_without(standard))}"
    for title, word in words.items():
        for per_km in densities:
            outcomes, ratio = runs.of(word, per_km)
            cells = " | ".join(f"{share:.3f}" for share in delivered(outcomes))
            yield f"| {title}, {per_km} | {ratio:.3f} | {cells} | {spread(outcomes).max():.3f} |"
    yield ""
    yield f"{runs.seeds} seeds; the last column is the largest standard deviation of one seed in a bin."


def main() -> int:
    """Print the tables, and write them where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", nargs="?", default=os.environ.get("MODELCAST_REFERENCE", ""))
    parser.add_argument("--density", type=int, nargs="*", default=[], help="vehicles a km to predict for")
    parser.add_argument("--seeds", type=int, default=SEEDS)
    parser.add_argument("--keep", type=Path, help="folder of runs")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    if not given.folder:
        print("name the folder of the reference figures, as an argument or in MODELCAST_REFERENCE")
        return 2
    if given.keep is not None:
        given.keep.mkdir(parents=True, exist_ok=True)
    runs, folder = Runs(given.seeds, given.keep), Path(given.folder)
    blocks: dict[str, list[str]] = {}
    for name, radio in RADIOS.items():
        blocks[f"wilab-{name}"] = list(compared(radio, folder, runs))
        print("\n".join(blocks[f"wilab-{name}"]), flush=True)
        blocks[f"wilab-{name}-ways"] = list(ways(radio, folder, runs))
        print("\n".join(blocks[f"wilab-{name}-ways"]), flush=True)
    blocks["wilab-others"] = list(others(folder, runs))
    print("\n".join(blocks["wilab-others"]), flush=True)
    if given.density:
        blocks["wilab-densities"] = list(predicted(given.density, runs))
        print("\n".join(blocks["wilab-densities"]))
    return put({PAGE: blocks}, check=given.check) if given.write or given.check else 0


if __name__ == "__main__":
    sys.exit(main())
