"""Time ``modelcast --help`` and ``modelcast evaluate`` as a user meets them, from a warm cache."""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from measured import record

FILE = "openacc_zalazone/no_ACC__handling_part22.csv"
ROUNDS = 5


def timed(*words: str) -> list[float]:
    """Wall times of a command after one run that warms the cache [s]."""
    command = [sys.executable, "-m", "modelcast", *words]
    times: list[float] = []
    for _ in range(ROUNDS + 1):
        start = time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)  # noqa: S603 - our own command
        times.append(time.perf_counter() - start)
    return times[1:]


def main() -> None:
    """Time both commands."""
    shown = timed("--help")
    record("modelcast --help", statistics.median(shown), "s")
    print(f"modelcast --help: median {statistics.median(shown):.2f} s (under 0.3)")
    trip = str(Path(os.environ["MODELCAST_DATA"]) / FILE)
    with tempfile.TemporaryDirectory() as folder:
        whole = timed("evaluate", trip, "--out", str(Path(folder) / "out"), "--quiet")
    median, best = statistics.median(whole), min(whole)
    record("modelcast evaluate, 9 cars, 320 s, warm cache", median, "s")
    print(f"modelcast evaluate, 9 cars, 320 s: median {median:.2f} s, best {best:.2f} s (under 8)")


if __name__ == "__main__":
    main()
