"""Compare packet reception with the figures of WiLabV2Xsim 6.1, per 50 m of distance.

Usage: python validation/wilab.py FOLDER [OUTPUT.md]
The folder holds ``wilab_80211p_100_per_km.tsv`` and ``wilab_ltev2x_mode4_100_per_km.tsv``; without an
argument the environment variable MODELCAST_REFERENCE names it.
"""

import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

from highway import Road, count_outcomes
from modelcast.channel.dsrc import Dsrc
from modelcast.channel.dsrc_parameters import DsrcParameters
from modelcast.channel.error_models import AbstractErrorModel, TabulatedErrorModel, ThresholdErrorModel
from modelcast.channel.propagation import Propagation, Shadowing
from modelcast.channel.radio import OUTCOMES, AbstractRadio
from modelcast.channel.sidelink import Sidelink
from modelcast.channel.sidelink_parameters import BITS_PER_BLOCK, SidelinkParameters

ROAD = Road(2000.0, 200, 3, 4.0, 240.0 / 3.6, 10.0, 300, 23.0)
SECONDS, SEEDS, FINE_M, COARSE = 15.0, 4, 10.0, 5
TARGET = 0.05


def published(path: Path) -> np.ndarray:
    """Counts of pairs and of receptions in bins of 50 m, (bins, 2)."""
    rows = np.loadtxt(path, skiprows=1)
    whole = rows.shape[0] // COARSE * COARSE
    return rows[:whole, [4, 1]].reshape(-1, COARSE, 2).sum(axis=1)


def dsrc(error_model: AbstractErrorModel, preamble_db: float) -> Dsrc:
    """IEEE 802.11p as that simulator has it, with the SINR at which it finds a preamble."""
    parameters = DsrcParameters(
        noise_figure_db=6.0,
        antenna_gain_db=3.0,
        sensitivity_dbm=-100.0,
        decodable_dbm=-100.0,  # whoever receives holds the medium busy
        preamble_db=preamble_db,
        capture_s=1.0,  # a later frame takes a receiver over at any time, if its own SINR is enough
        capture_db=preamble_db,
        sensing_s=13e-6,  # a countdown that ends within the slot goes on
        immediate_access=False,
        extended_s=0.0,
        bin_m=FINE_M,
        bins=60,
    )
    return Dsrc(parameters, Propagation(shadowing=Shadowing(3.0, 4.0), fading=None), error_model)


def sidelink() -> Sidelink:
    """LTE-V2X mode 4 as that simulator has it.

    300 bytes take 20 resource-block pairs and 2 for control, so 3 of the 5 sub-channels of 10: one message a
    subframe. Its SINR threshold is 2^(rate/0.4) - 1 with the rate of 20 pairs, 8 of 14 symbols usable.
    """
    code_rate = BITS_PER_BLOCK[7] / (8 * 12 * 2)
    rate = 12 * 14 * 2 * code_rate / (1e-3 * 180e3)
    threshold_db = 10.0 * np.log10(2.0 ** (rate / 0.4) - 1.0)
    parameters = SidelinkParameters(
        7,
        3,
        overlapping=False,
        keep_ratio=0.4,
        noise_figure_db=6.0,
        antenna_gain_db=3.0,
        sensitivity_dbm=-120.0,
        bin_m=FINE_M,
        bins=60,
    )
    propagation = Propagation(shadowing=Shadowing(3.0, 4.0), fading=None)
    return Sidelink(parameters, propagation, ThresholdErrorModel(round(float(threshold_db), 2)))


def measured(radio: AbstractRadio[Any]) -> tuple[np.ndarray, float]:
    """Outcomes in bins of 50 m, (bins, 5), summed over seeds; mean of the median channel busy ratios."""
    runs = [count_outcomes(radio, ROAD, SECONDS, seed) for seed in range(SEEDS)]
    fine = np.sum([run[0] for run in runs], axis=0)
    return fine.reshape(-1, COARSE, fine.shape[1]).sum(axis=1), float(np.mean([run[1] for run in runs]))


def table(title: str, reference: np.ndarray, outcomes: np.ndarray, busy: str) -> tuple[list[str], float]:
    """Lines of a Markdown table, and the largest difference."""
    lines = [f"### {title}", "", busy, ""]
    lines += ["| distance m | WiLabV2Xsim | modelcast | difference | " + " | ".join(OUTCOMES[1:]) + " |"]
    lines += ["|" + "---|" * (len(OUTCOMES) + 3)]
    worst = 0.0
    for k in range(reference.shape[0]):
        theirs = reference[k, 1] / reference[k, 0]
        shares = outcomes[k] / outcomes[k].sum()
        worst = max(worst, abs(shares[0] - theirs))
        causes = " | ".join(f"{share:.3f}" for share in shares[1:])
        near, far = k * FINE_M * COARSE, (k + 1) * FINE_M * COARSE
        lines.append(
            f"| {near:.0f}-{far:.0f} | {theirs:.3f} | {shares[0]:.3f} | {shares[0] - theirs:+.3f} | "
            f"{causes} |"
        )
    return [*lines, "", f"Largest difference {worst:.3f}; target {TARGET}.", ""], worst


def main() -> int:
    """Print the tables, and write them where asked."""
    folder = sys.argv[1] if len(sys.argv) > 1 else os.environ.get("MODELCAST_REFERENCE", "")
    if not folder:
        print("name the folder of the reference figures, as an argument or in MODELCAST_REFERENCE")
        return 2
    lines: list[str] = []
    reference = published(Path(folder) / "wilab_80211p_100_per_km.tsv")
    for title, model, preamble_db in (
        ("IEEE 802.11p, SINR threshold 6.5 dB, preambles found from 6.5 dB", ThresholdErrorModel(6.5), 6.5),
        ("IEEE 802.11p, SINR threshold 6.5 dB, preambles found from -2 dB", ThresholdErrorModel(6.5), -2.02),
        ("IEEE 802.11p, PER curve highway LOS", TabulatedErrorModel.highway_los(), -2.02),
    ):
        outcomes, ratio = measured(dsrc(model, preamble_db))
        part, _ = table(title, reference, outcomes, f"Median channel busy ratio {ratio:.3f} (theirs .195).")
        lines += part
    reference = published(Path(folder) / "wilab_ltev2x_mode4_100_per_km.tsv")
    outcomes, ratio = measured(sidelink())
    busy = f"Median channel busy ratio {ratio:.3f} (theirs .540)."
    part, _ = table("LTE-V2X mode 4, MCS 7, SINR threshold", reference, outcomes, busy)
    lines += part
    print("\n".join(lines))
    if len(sys.argv) > 2:
        Path(sys.argv[2]).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
