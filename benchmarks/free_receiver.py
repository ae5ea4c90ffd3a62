"""What does the free receiver cost an evaluation? Prints processor time with and without it, by bank.

A generated drive of four minutes at the defaults; the least of several runs, the two in turn.
"""

import argparse
import time
from dataclasses import replace

from measured import record
from modelcast.station.banks import PAPER_BANK
from modelcast.study.case import SensedTrip
from modelcast.study.evaluate import evaluate
from modelcast.study.settings import EvaluationSettings
from modelcast.world.drive import generate_drive


def main() -> None:
    """Time both banks."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--runs", type=int, default=4)
    asked = options.parse_args()
    drive = generate_drive(seed=0, duration_s=240.0)
    trip = SensedTrip(drive.truth, drive.input)
    for name, settings in (
        ("default", EvaluationSettings()),
        ("paper", EvaluationSettings(bank=PAPER_BANK)),
    ):
        best_s = {True: float("inf"), False: float("inf")}
        for _ in range(asked.runs):
            for beside in (True, False):
                given = settings if beside else replace(settings, free=None)
                begin_s = time.process_time()
                evaluate([trip], given)
                best_s[beside] = min(best_s[beside], time.process_time() - begin_s)
        ratio = best_s[True] / best_s[False]
        told = f"evaluation with the free receiver, {name} bank"
        record(told, best_s[True], "s", peer=("without it", best_s[False]))
        print(f"{name}: {best_s[True]:.2f} s with, {best_s[False]:.2f} s without, {ratio:.2f} times")


if __name__ == "__main__":
    main()
