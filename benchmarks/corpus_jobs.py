"""How a job over a corpus shares its work, and what a lost worker and a killed run cost.

``python benchmarks/corpus_jobs.py --work FOLDER [--rows N] [--write]``: makes N rows (`corpus_rows`, kept in
the folder) and a corpus of them, compares two banks over it with one process, two, and a local cluster of
two, kills a worker of both kinds in the middle, kills a whole run and resumes it, and compares the octets
that come out. With ``--write`` the table goes into docs/corpora-cluster.md. Rows a second and core are rows
over the processor time of all processes, their start and the report included.
"""

import argparse
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from corpus import Run, digests, family, ingest, measured
from corpus_rows import write_rows
from measured import record

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "validation"))

from page_blocks import put  # noqa: E402 - the folder is put on the path above

PAGE = ROOT / "docs" / "corpora-cluster.md"
PARTITIONS = 8
OPTIONS = (
    *("--rates-only", "--route-by", "trip", "--bank", "cv", "ctra+cv", "--threshold", "0.5"),
    *("--protocol", "recorded", "--resamples", "100", "--quiet"),
)
WORDS = ("--multiprocessing-fork", "spawn_main")


def compare(
    corpus: Path, out: Path, *where: str, meanwhile: Callable[[int], None] = lambda _: None
) -> tuple[Run, dict[str, str]]:
    """Compare over a corpus, measured, and the hashes of what comes out but for run.json."""
    command = [sys.executable, "-m", "modelcast", "compare", str(corpus), "--out", str(out), *OPTIONS, *where]
    run = measured(command, meanwhile)
    found = digests(out)
    shutil.rmtree(out)
    return run, {name: digest for name, digest in found.items() if name != "run.json"}


class Killer:
    """Kills a worker, once, when the first part is done."""

    def __init__(self, out: Path) -> None:
        self._parts = out.with_name(f"{out.name}.unfinished") / "parts"
        self.killed = 0

    def __call__(self, root: int) -> None:
        """Kill one."""
        if self.killed or not list(self._parts.glob("[0-9]*")):
            return
        for one in sorted(family(root), reverse=True):
            words = Path(f"/proc/{one}/cmdline").read_bytes().decode().split("\0")
            if one != root and any(word in text for text in words for word in WORDS):
                os.kill(one, signal.SIGKILL)
                self.killed = one
                return


def killed_and_resumed(corpus: Path, out: Path) -> tuple[int, dict[str, str]]:
    """Kill a whole run when two parts are done, run it again; parts kept, and the hashes."""
    command = [sys.executable, "-m", "modelcast", "compare", str(corpus), "--out", str(out), *OPTIONS]
    process = subprocess.Popen(command, start_new_session=True)  # noqa: S603 - our own command
    parts = out.with_name(f"{out.name}.unfinished") / "parts"
    while len(list(parts.glob("[0-9]*"))) < 2 and process.poll() is None:
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    kept = len(list(parts.glob("[0-9]*")))
    return kept, compare(corpus, out)[1]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--rows", type=int, default=4_000_000)
    parser.add_argument("--write", action="store_true")
    asked = parser.parse_args()
    source, corpus, out = (asked.work / name for name in ("rows", "corpus", "out"))
    if not source.is_dir():
        write_rows(asked.rows, source)
    if not corpus.is_dir():
        ingest(source, corpus, 2, ("--partitions", str(PARTITIONS)))
    lines = [
        "| where | wall, s | rows/s | rows/s and core | memory, MiB | octets |",
        "|---|--:|--:|--:|--:|---|",
    ]
    first: dict[str, str] = {}
    alone_s = 0.0
    for name, where, kills in (
        ("`--jobs 1`", ("--jobs", "1"), False),
        ("`--jobs 2`", ("--jobs", "2"), False),
        ("`--cluster local:2`", ("--cluster", "local:2"), False),
        ("`--jobs 2`, a worker killed", ("--jobs", "2"), True),
        ("`--cluster local:2`, a worker killed", ("--cluster", "local:2"), True),
    ):
        killer = Killer(out)
        run, found = compare(corpus, out, *where, meanwhile=killer if kills else lambda _: None)
        first = first or found
        alone_s = alone_s or run.wall_s
        record(f"compare, {name}", run.wall_s, "s", peer=("one process", alone_s), sizes={"rows": asked.rows})
        if kills and not killer.killed:
            raise SystemExit("no worker was killed: give it more rows")
        lines.append(
            f"| {name} | {run.wall_s:.0f} | {asked.rows / run.wall_s:,.0f} | "
            f"{asked.rows / run.processor_s:,.0f} | {run.resident_bytes / 2**20:,.0f} | "
            f"{'the same' if found == first else 'OTHERS'} |"
        )
        print(lines[-1], flush=True)
    kept, found = killed_and_resumed(corpus, out)
    lines.append(
        f"| `--jobs 2`, all killed, run again | | | | | {'the same' if found == first else 'OTHERS'}; "
        f"{kept} of {PARTITIONS} parts were kept |"
    )
    print(lines[-1])
    if asked.write:
        octets = sum(file.stat().st_size for file in (corpus / "rows").rglob("*") if file.is_file())
        head = f"{asked.rows:,} rows in {PARTITIONS} partitions, {octets / asked.rows:.0f} octets a row:"
        put({PAGE: {"jobs": [head, "", *lines]}}, check=False)


if __name__ == "__main__":
    main()
