"""Run benchmarks, each in a process of its own on one thread, and keep what they measured.

``make bench`` runs all that take seconds or minutes. Arguments choose (``BENCH_ARGUMENTS`` of make):

    run_all.py                        seconds and minutes
    run_all.py --hours                those that take hours too
    run_all.py --quick                smaller sizes, for a look: kept in out/bench, not beside the others
    run_all.py --only gp_fit traffic  these, however long they take
    run_all.py --list                 what each shows, its peer, what it needs and how long it takes

What a benchmark measured goes into ``benchmarks/results.json`` as soon as it has ended, in place of its
earlier results: a run that is stopped loses only the benchmark that was running. Beside the numbers stand
machine, versions, date, and the load average just before: far above the number of cores it means that other
work ran, and then only ratios of the same run say much. A benchmark that lacks something is left out, and the
end says which and why. Exit code 1 where one failed, or where one that ``--only`` names was left out.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from machine import load_average, machine, versions
from measured import VARIABLE
from registry import BENCHMARKS, HOURS, Benchmark

__all__ = ["RESULTS", "chosen", "left_out", "main", "measure", "merged", "read_results", "table"]

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
RESULTS = HERE / "results.json"
WORK = ROOT / "out" / "bench"
THREADS = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "POLARS_MAX_THREADS",
)
PEERS = ("scikit-learn", "asn1tools", "GPy", "gpytorch", "tinygp", "cryptography")


def chosen(*, only: Sequence[str], quick: bool, hours: bool) -> list[Benchmark]:
    """Return the benchmarks to run: those named, or all that are quick enough."""
    if only:
        return [one for one in BENCHMARKS if one.name in only]
    if quick:
        return [one for one in BENCHMARKS if one.quick is not None]
    return [one for one in BENCHMARKS if hours or one.takes != HOURS]


def left_out(benchmark: Benchmark, environment: Mapping[str, str]) -> str:
    """Return why a benchmark cannot run; empty where it can."""
    unset = [name for name in benchmark.needs if not environment.get(name)]
    if unset:
        return f"{' and '.join(unset)} is not set"
    if benchmark.packages and not any(map(find_spec, benchmark.packages)):
        names = " ".join(benchmark.packages)
        return f"none of {names} is installed" if len(benchmark.packages) > 1 else f"{names} is not installed"
    return ""


def measure(benchmark: Benchmark, *, quick: bool = False) -> dict[str, Any]:
    """Run one in a process of its own; return its records and what they were made on.

    What it prints goes to the terminal as it comes.
    """
    words = benchmark.quick if quick and benchmark.quick is not None else benchmark.words
    own = [str(WORK / benchmark.name) if word == "FOLDER" else word for word in words]
    with tempfile.TemporaryDirectory() as folder:
        records = Path(folder) / "records"
        environment = {**os.environ, **dict.fromkeys(THREADS, "1"), VARIABLE: str(records)}
        before, begun_s = load_average(), time.perf_counter()
        command = [sys.executable, str(HERE / f"{benchmark.name}.py"), *own]
        ended = subprocess.run(command, check=False, env=environment)  # noqa: S603 - our own scripts
        lines = records.read_text(encoding="utf-8").splitlines() if records.is_file() else []
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "machine": machine(),
        "versions": versions(*PEERS),
        "load_average": before,
        "took_s": round(time.perf_counter() - begun_s, 1),
        "arguments": list(words),
        "exit_code": ended.returncode,
        "records": [json.loads(line) for line in lines],
    }


def read_results(path: Path) -> dict[str, Any]:
    """Return what earlier runs kept, by benchmark."""
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}


def merged(path: Path, name: str, result: Mapping[str, Any]) -> None:
    """Put one benchmark's result into the file, at once and whole, in the order of the registry."""
    found = {**read_results(path), name: result}
    ordered = {one.name: found[one.name] for one in BENCHMARKS if one.name in found}
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_suffix(".part")
    text = json.dumps(ordered, indent=1, ensure_ascii=False)
    beside.write_text(text + "\n", encoding="utf-8", newline="\n")
    beside.replace(path)


def table(results: Mapping[str, Any]) -> list[str]:
    """Return a line for every number: benchmark, what, value, peer and ratio."""
    rows = [
        (
            name,
            " ".join((one["what"], *(f"{key}={size:.10g}" for key, size in one.get("sizes", {}).items()))),
            f"{one['value']:g} {one['unit']}",
            f"{one['ratio']:g} times for {one['peer']}" if "peer" in one else "",
        )
        for name, result in results.items()
        for one in result["records"]
    ]
    widths = [max((len(row[column]) for row in rows), default=0) for column in range(3)]
    return [
        "  ".join((*(cell.ljust(width) for cell, width in zip(row, widths, strict=False)), row[3])).rstrip()
        for row in rows
    ]


def main() -> int:
    """Run them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--only", nargs="+", default=[], choices=[one.name for one in BENCHMARKS])
    parser.add_argument("--list", action="store_true", help="say what each shows")
    parser.add_argument("--quick", action="store_true", help="smaller sizes")
    parser.add_argument("--hours", action="store_true", help="also those that take hours")
    parser.add_argument("--results", type=Path, help="file to keep results in")
    given = parser.parse_args()
    if given.list:
        for one in BENCHMARKS:
            peer = f"; beside it: {one.peer}" if one.peer else ""
            needs = " ".join((*one.needs, *one.packages, *(f"[{name}]" for name in one.wants)))
            print(f"{one.name}: {one.shows}{peer}; {one.takes}" + (f"; needs {needs}" if needs else ""))
        return 0
    path = given.results or (WORK / "quick.json" if given.quick else RESULTS)
    without, failed, made = dict[str, str](), list[str](), dict[str, Any]()
    for one in chosen(only=given.only, quick=given.quick, hours=given.hours):
        why = left_out(one, os.environ)
        if why:
            without[one.name] = why
            continue
        print(f"== {one.name}: {one.shows}", flush=True)
        made[one.name] = measure(one, quick=given.quick)
        if made[one.name]["records"]:
            merged(path, one.name, made[one.name])
        if made[one.name]["exit_code"]:
            failed.append(one.name)
    print("\n".join(("", *table(made), f"kept in {path}")))
    for name, why in without.items():
        print(f"{name}: left out: {why}")
    for name in failed:
        print(f"{name}: failed, or missed its aim (exit code {made[name]['exit_code']})")
    return int(bool(failed or (given.only and without)))


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        print("stopped; what had ended is kept", file=sys.stderr)
        sys.exit(130)
