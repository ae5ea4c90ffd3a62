"""How fast `modelcast ingest` is, whether it grows linearly, and what memory it takes.

``python benchmarks/corpus.py --work FOLDER``: makes 1, 2, 4 and 8 million rows (`corpus_rows`, kept in the
folder), ingests them with one process and with two, and prints the table of docs/corpora.md. Rows a second
and core are rows over processor time of all processes, start of the interpreters included. Memory is the most
that the resident sets of all processes together held, looked at 20 times a second; pages that they share
count for each. With ``--kill`` a run is killed when half its sources are read, resumed, and its octets are
compared with those of a run in one go.
"""

import argparse
import hashlib
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from corpus_rows import write_rows
from measured import record

__all__ = ["Run", "digests", "family", "ingest", "main", "measured"]

MILLION = 1_000_000
COMMAND = (sys.executable, "-m", "modelcast", "ingest")
LOOK_S = 0.05
PAGE = resource.getpagesize()


@dataclass(frozen=True, slots=True)
class Run:
    """What an ingest took: wall and processor time [s], and memory [octets]."""

    wall_s: float
    processor_s: float
    resident_bytes: int


def ingest(source: Path, out: Path, jobs: int, more: tuple[str, ...] = ()) -> Run:
    """Ingest a folder and measure it."""
    shutil.rmtree(out, ignore_errors=True)
    return measured([*COMMAND, str(source), "--out", str(out), "--jobs", str(jobs), "--quiet", *more])


def measured(command: Sequence[str], meanwhile: Callable[[int], None] = lambda _: None) -> Run:
    """Run a command and measure it; a function is called with its process now and then."""
    before = _processor_s()
    begin = time.perf_counter()
    process = subprocess.Popen(command)  # noqa: S603 - our own command
    most = 0
    while process.poll() is None:
        most = max(most, sum(family(process.pid).values()))
        meanwhile(process.pid)
        time.sleep(LOOK_S)
    if process.returncode:
        raise SystemExit(f"{' '.join(command[3:5])} ended with {process.returncode}")
    return Run(time.perf_counter() - begin, _processor_s() - before, most)


def digests(corpus: Path) -> dict[str, str]:
    """Return the hash of every file."""
    return {
        str(file.relative_to(corpus)): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in sorted(corpus.rglob("*"))
        if file.is_file()
    }


def kill_and_resume(source: Path, work: Path, jobs: int) -> str:
    """Kill an ingest in the middle, run it again, and say whether the octets are those of one go."""
    ingest(source, work / "whole", jobs)
    out = work / "killed"
    shutil.rmtree(out, ignore_errors=True)
    sources = len(list(source.iterdir()))
    command = [*COMMAND, str(source), "--out", str(out), "--jobs", str(jobs), "--json"]
    process = subprocess.Popen(command, start_new_session=True)  # noqa: S603 - our own command
    while len(list(out.glob("staging/source-*"))) < sources // 2:
        if process.poll() is not None:
            raise SystemExit("it ended before it was killed")
        time.sleep(LOOK_S)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    again = subprocess.run(command, capture_output=True, check=True)  # noqa: S603 - our own command
    kept = json.loads(again.stdout)["kept"]
    same = digests(out) == digests(work / "whole")
    for folder in (out, work / "whole"):
        shutil.rmtree(folder)
    return (
        f"killed with {kept} of {sources} sources read, run again: {kept} were not read again, and the "
        f"corpus is {'the same to the octet' if same else 'ANOTHER'}"
    )


def _processor_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def family(root: int) -> dict[int, int]:
    """Return a process and all below it, with their resident sets [octets] (Linux)."""
    parents: dict[int, int] = {}
    resident: dict[int, int] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                fields = (entry / "stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue
            parents[int(entry.name)] = int(fields[1])
            resident[int(entry.name)] = int(fields[21]) * PAGE
    found = {root}
    while more := {one for one, parent in parents.items() if parent in found} - found:
        found |= more
    return {one: resident.get(one, 0) for one in found}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--millions", type=int, nargs="+", default=[1, 2, 4, 8])
    parser.add_argument("--jobs", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--memory")
    parser.add_argument("--kill", action="store_true")
    asked = parser.parse_args()
    more = () if asked.memory is None else ("--memory", asked.memory)
    print("| rows | text, MB | processes | wall, s | rows/s | rows/s and core | memory, MiB | corpus, MB |")
    print("|--:|--:|--:|--:|--:|--:|--:|--:|")
    for millions in asked.millions:
        source = asked.work / f"rows-{millions}m"
        if not source.is_dir():
            write_rows(millions * MILLION, source)
        text_mb = sum(file.stat().st_size for file in source.iterdir()) / 1e6
        for jobs in asked.jobs:
            out = asked.work / "corpus"
            run = ingest(source, out, jobs, more)
            corpus_mb = sum(file.stat().st_size for file in out.rglob("*") if file.is_file()) / 1e6
            rows = millions * MILLION
            sizes = {"rows": rows, "processes": jobs}
            record("ingest", rows / run.processor_s, "rows/s and core", sizes=sizes)
            record("ingest, memory", run.resident_bytes / 2**20, "MiB", sizes=sizes)
            print(
                f"| {rows:,} | {text_mb:,.0f} | {jobs} | {run.wall_s:.1f} | {rows / run.wall_s:,.0f} | "
                f"{rows / run.processor_s:,.0f} | {run.resident_bytes / 2**20:,.0f} | {corpus_mb:,.0f} |",
                flush=True,
            )
            shutil.rmtree(out)
    if asked.kill:
        print(kill_and_resume(asked.work / f"rows-{asked.millions[-1]}m", asked.work, asked.jobs[-1]))


if __name__ == "__main__":
    main()
