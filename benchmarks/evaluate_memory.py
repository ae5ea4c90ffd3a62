"""How much memory does an evaluation take as the hours go by? Prints the peak after each hour of driving.

Drives of half an hour are generated one after another, and evaluated at the defaults. Messages and samples
go to files, as ``modelcast evaluate`` does it; ``--keep`` keeps them in the result.
"""

import argparse
import resource
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

from measured import record
from modelcast.io.record_files import RecordFiles
from modelcast.study.evaluate import evaluate
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory
from modelcast.world.drive import generate_drive

DRIVE_S = 1800.0


def peak_mib() -> float:
    """The most memory that was resident so far [MiB]; on Linux."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def drives(hours: int) -> Iterator[Trajectory]:
    """Two generated drives an hour; tells the peak after each hour."""
    for at in range(round(hours * 3600.0 / DRIVE_S)):
        if at % 2 == 0:
            record("peak of an evaluation", peak_mib(), "MiB", sizes={"hours": at // 2})
            print(f"  after {at // 2} h: {peak_mib():.0f} MiB", flush=True)
        yield generate_drive(seed=at, duration_s=DRIVE_S).truth


def main() -> None:
    """Evaluate some hours."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--hours", type=int, default=5)
    options.add_argument("--keep", action="store_true")
    asked = options.parse_args()
    print("peak of resident memory, evaluate at the defaults, 10 Hz:")
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        records = None if asked.keep else stack.enter_context(RecordFiles(Path(folder)))
        result = evaluate(drives(asked.hours), EvaluationSettings(), records=records)
        record("peak of an evaluation", peak_mib(), "MiB", sizes={"hours": asked.hours})
        print(f"  after {asked.hours} h: {peak_mib():.0f} MiB, {len(result.trips)} trips")


if __name__ == "__main__":
    main()
