"""Fuzz profiles and ``run.json``: mutants by the hundred thousand, in a process of their own.

::

    python fuzz/profiles.py --seconds 1200 --runs-every 20

Mutant number i of a seed is always the same file. A worker process writes the number down before it looks at
the mutant; where the worker dies (a segmentation fault), hangs or meets what it should not, this process says
which mutant it was, keeps it in ``out/fuzz`` and goes on behind it. The exit code is the number of faults.
"""

import argparse
import random
import subprocess
import sys
import tempfile
import time
import traceback
from pathlib import Path
from typing import Any

from mutating import mutant

__all__ = ["main"]

_PATIENCE_S = 300.0
_BIG_SHARE, _RUN_SHARE = 0.1, 0.25


def main() -> int:
    """Fuzz until a limit; return the number of faults."""
    options = _options()
    options.keep.mkdir(parents=True, exist_ok=True)
    if options.worker is not None:
        return _work(options)
    faults, first, begun = 0, options.first, time.monotonic()
    totals = [0, 0, 0]
    while first < options.first + options.mutants and time.monotonic() - begun < options.seconds:
        left_s = options.seconds - (time.monotonic() - begun)
        with tempfile.TemporaryDirectory() as folder:
            code, at, counts = _watch(options, Path(folder), first, left_s)
        totals = [one + other for one, other in zip(totals, counts, strict=True)]
        if code == 0:
            break
        faults += 1
        print(
            f"FAULT: mutant {at} of seed {options.seed} (exit code {code}), kept in {options.keep}",
            flush=True,
        )
        first = at + 1
    print(
        f"{totals[0]} mutants, {totals[1]} read, {totals[2]} of these run, {faults} faults, "
        f"{time.monotonic() - begun:.0f} s"
    )
    return min(faults, 100)


def _options() -> Any:
    parser = argparse.ArgumentParser(description="Fuzz profiles and run.json.")
    parser.add_argument("--mutants", type=int, default=10_000_000)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first mutant")
    parser.add_argument("--runs-every", type=int, default=20, help="one in so many that are read is run")
    parser.add_argument("--keep", type=Path, default=Path("out/fuzz"))
    parser.add_argument("--worker", type=Path, help=argparse.SUPPRESS)
    return parser.parse_args()


def _watch(options: Any, folder: Path, first: int, left_s: float) -> tuple[int, int, list[int]]:
    """Run one worker to its end; return its exit code, the mutant it was at, and its counts."""
    state = folder / "state"
    state.write_text(f"{first} 0 0 0")
    last = options.first + options.mutants
    command = [sys.executable, __file__, "--worker", str(folder), "--seed", str(options.seed)]
    command += ["--first", str(first), "--mutants", str(last - first), "--seconds", str(left_s)]
    command += ["--runs-every", str(options.runs_every), "--keep", str(options.keep)]
    worker = subprocess.Popen(command)  # noqa: S603 - this very file
    seen, since = "", time.monotonic()
    while True:
        try:
            code = worker.wait(timeout=1.0)
            break
        except subprocess.TimeoutExpired:
            now = state.read_text()
            if now != seen:
                seen, since = now, time.monotonic()
            elif time.monotonic() - since > _PATIENCE_S:
                worker.kill()
                worker.wait()
                code = -9
                break
    at, *counts = (int(word) for word in state.read_text().split())
    if code:
        for made in folder.glob("mutant*.json"):
            (options.keep / f"{options.seed}-{at}-{made.name}").write_bytes(made.read_bytes())
    return code, at, counts


def _work(options: Any) -> int:
    """Look at mutants one after another; 1 at the first fault."""
    # The watching process compiles nothing and lives on where this one dies.
    from hostile import check_profile, check_run, profile_documents, run_document  # noqa: PLC0415

    folder: Path = options.worker
    small, shipped = profile_documents()
    asked = run_document(folder)
    state = (folder / "state").open("r+b", buffering=0)
    profile_path, run_path = folder / "mutant-profile.json", folder / "mutant-run.json"
    mutants = read = ran = 0
    begun = time.monotonic()
    for at in range(options.first, options.first + options.mutants):
        if time.monotonic() - begun > options.seconds:
            break
        state.seek(0)
        state.write(f"{at} {mutants} {read} {ran}".ljust(60).encode())
        rng = random.Random(f"{options.seed}:{at}")  # noqa: S311 - no secret
        kind, runs = rng.random(), rng.randrange(options.runs_every) == 0
        path = run_path if kind < _RUN_SHARE else profile_path
        document = asked if kind < _RUN_SHARE else shipped if kind > 1.0 - _BIG_SHARE else small
        try:
            path.write_bytes(mutant(document, rng))
            if kind < _RUN_SHARE:
                good = check_run(path, folder / "out", runs=runs)
            else:
                good = check_profile(path, runs=runs)
        except Exception:  # noqa: BLE001 - whatever it is, it is the fault looked for
            traceback.print_exc()
            return 1
        path.unlink()
        mutants, read, ran = mutants + 1, read + good, ran + (good and runs)
    state.seek(0)
    state.write(f"{options.first + options.mutants} {mutants} {read} {ran}".ljust(60).encode())
    return 0


if __name__ == "__main__":
    sys.exit(main())
