"""Compare mode 4 with the delivery ratios of Molina-Masegosa and Gozalvez (2017).

``--write`` puts the table into ``validation/README.md``, ``--check`` tells whether it has it.
120 vehicles a km, 10 messages a second. The publication's receiver is not known to us. The run uses its
traffic, size and power, WINNER+ B1 with an effective antenna height of 1.5 m, and two SINR thresholds that
enclose what QPSK at rate 0.7 may need: 6 dB, and the 11 dB of 2^(rate/0.4) - 1.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

from highway import Road, count_outcomes
from modelcast.channel.error_models import ThresholdErrorModel
from modelcast.channel.path_loss import WinnerB1
from modelcast.channel.propagation import Propagation, Shadowing
from modelcast.channel.sidelink import Sidelink
from modelcast.channel.sidelink_parameters import SidelinkParameters
from page_blocks import put

PAGE = Path(__file__).with_name("README.md")

PUBLISHED = {0: 0.97, 100: 0.95, 200: 0.90, 300: 0.79, 400: 0.66, 500: 0.45}
ROAD = Road(5000.0, 600, 2, 4.0, 70.0 / 3.6, 10.0, 190, 23.0)
THRESHOLDS_DB = (6.0, 11.0)
BIN_M, SEEDS = 20.0, 6


def ratios(threshold_db: float) -> np.ndarray:
    """Delivery ratio by seed at the published distances, mean of the bins on either side, (SEEDS, 6)."""
    parameters = SidelinkParameters(
        9, 4, blocks=12, overlapping=False, keep_ratio=0.0, sensitivity_dbm=-120.0, bin_m=BIN_M, bins=28
    )
    propagation = Propagation(WinnerB1(antenna_m=2.5), Shadowing(3.0, 4.0), None)
    radio = Sidelink(parameters, propagation, ThresholdErrorModel(threshold_db))
    edges = [round(at / BIN_M) for at in PUBLISHED]
    found = np.empty((SEEDS, len(edges)))
    for seed in range(SEEDS):
        outcomes, _ = count_outcomes(radio, ROAD, 6.0, seed, 2.0)
        near = np.array([outcomes[max(edge - 1, 0) : edge + 1].sum(axis=0) for edge in edges])
        found[seed] = near[:, 0] / near.sum(axis=1)
    return found


def main() -> int:
    """Print the table, and write it where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    low, high = (ratios(threshold_db) for threshold_db in THRESHOLDS_DB)
    lines = ["| distance m | published | modelcast, 6 dB | modelcast, 11 dB |", "|---|---|---|---|"]
    for (at, ratio), one, other in zip(PUBLISHED.items(), low.mean(axis=0), high.mean(axis=0), strict=True):
        lines.append(f"| {at} | {ratio:.2f} | {one:.3f} | {other:.3f} |")
    worst = np.abs(low.mean(axis=0) - list(PUBLISHED.values())).max()
    spread = max(runs.std(axis=0, ddof=1).max() for runs in (low, high))
    lines += [
        "",
        f"Largest difference at 6 dB {worst:.3f}. Mean of {SEEDS} seeds; standard deviation {spread:.3f}",
    ]
    lines[-1] += " at most."
    print("\n".join(lines))
    blocks = {"mode4-published": lines}
    return put({PAGE: blocks}, check=given.check) if given.write or given.check else 0


if __name__ == "__main__":
    sys.exit(main())
