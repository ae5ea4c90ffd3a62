"""How long commands are silent: each is run on a terminal of its own, with nothing compiled beforehand.

For each command, the times in which it wrote nothing to the terminal for longer than two seconds are listed,
with the last that it had shown; with ``--log`` it writes into a pipe, where it says something every ten
seconds, and the limit is a little more than that. A table of the longest silences stands at the end, and the
program ends with 1 where one is over the limit. What is measured is this machine as it is: a loaded one shows
more. So the load is told, and the processor time that the command itself had in its longest silence: on an
idle machine that silence takes as long, or a few times less where the time is that of several threads.

    python tools/signs_of_life.py out/signs
    python tools/signs_of_life.py out/signs --only demo network
    python tools/signs_of_life.py out/signs --log
"""

import argparse
import math
import os
import pty
import re
import select
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from modelcast.io.write_trips import write_csv
from modelcast.world.drive import generate_drive

DRIVE_S = 120.0
ROAD = ("--duration", "4", "--warm-up", "2", "--seeds", "1")
COMMANDS: dict[str, tuple[str, ...]] = {
    "demo": ("demo", "--duration", "120"),
    "trips": ("trips", "drives"),
    "trips-rank": ("trips", "drives", "--rank"),
    "convert": ("convert", "drives"),
    "ingest": ("ingest", "drives", "--out", "corpus", "--jobs", "2"),
    "evaluate": ("evaluate", "drives/a.csv", "--seeds", "1"),
    "evaluate-corpus": ("evaluate", "corpus", "--seeds", "1", "--jobs", "2"),
    "compare": ("compare", "drives", "--seeds", "1", "--resamples", "50"),
    "coverage": ("coverage", "drives/a.csv"),
    "network": ("network", "--density", "25", "--policy", "mbc", "bsm-10hz", *ROAD),
    "network-alone": ("network", "--density", "25", "--policy", "mbc", *ROAD, "--jobs", "1"),
    "mixed": ("mixed", "--density", "25", "--penetration", "0", "100", *ROAD),
    "capacity": ("capacity", "--policy", "bsm-10hz", "--highest", "50", "--ratio", "2", *ROAD),
    "safety": ("safety", "--streams", "1"),
    "cruise": ("cruise", "--loss", "0", "0.4", "--seeds", "1", "--duration", "20"),
    "reproduce": ("reproduce", "paper", "drives/a.csv", "--threshold", "0.3", "--seeds", "1"),
    "train": ("train", "drives", "--bank", "free+cv", "--steps", "20", "--windows", "200"),
    "prepare": ("prepare",),
    "doctor": ("doctor",),
}  # fmt: skip
"""What is run: in the folder, one after another, each with an empty folder for compiled code."""

FILES = {"convert": ".parquet", "train": ".json"}
"""Kind of file of those that write one."""
WITHOUT_OUT = frozenset({"trips", "prepare", "doctor"})
ON_TERMINAL_S = 2.0
IN_LOG_S = 10.5
"""A line every ten seconds, and what it takes to wake up for it."""
WAIT_S = 0.1
CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")


@dataclass(frozen=True, slots=True)
class Silence:
    """A time in which nothing was written.

    Parameters
    ----------
    since_s, lasts_s
        When it began after the start, and how long it was [s].
    worked_s
        Processor time that the command's own process had meanwhile; not a number where that is not known [s].
    shown
        What had been written last.
    """

    since_s: float
    lasts_s: float
    worked_s: float
    shown: str


@dataclass(frozen=True, slots=True)
class Watched:
    """A command that has been run.

    Parameters
    ----------
    code, took_s
        Its exit code, and its time [s].
    silences
        All of its silences, however short.
    """

    code: int
    took_s: float
    silences: Sequence[Silence]

    @property
    def longest(self) -> Silence:
        """The longest of them."""
        return max(self.silences, key=lambda one: one.lasts_s)


def processor_s(pid: int, before_s: float) -> float:
    """Processor time of a process so far; that of before where it has ended, as far as Linux tells it [s]."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace").rpartition(")")[2]
    except OSError:
        return before_s if sys.platform == "linux" else math.nan
    user, system = fields.split()[11:13]
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


def watched(words: Sequence[str], folder: Path, *, log: bool) -> Watched:
    """Run a command on a terminal, or into a log."""
    cache = folder / "cache"
    shutil.rmtree(cache, ignore_errors=True)
    ours, theirs = os.pipe() if log else pty.openpty()
    known = {**os.environ, "TERM": "xterm", "MODELCAST_CACHE_DIR": str(cache)}
    found: list[Silence] = []
    begun_s = last_s = time.monotonic()
    worked_s = 0.0
    shown = "(nothing yet)"
    running = subprocess.Popen(  # noqa: S603 - our own interpreter
        [sys.executable, "-m", "modelcast", *words],
        cwd=folder, env=known, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=theirs,
    )  # fmt: skip
    os.close(theirs)
    with running:
        while True:
            ready, _, _ = select.select([ours], [], [], WAIT_S)
            data = b""
            if ready:
                with suppress(OSError):  # the other end is closed
                    data = os.read(ours, 65536)
            ended = running.poll() is not None and not data
            if data or ended:
                now_s, had_s = time.monotonic(), worked_s
                worked_s = processor_s(running.pid, had_s)
                found.append(Silence(last_s - begun_s, now_s - last_s, worked_s - had_s, shown))
                last_s = now_s
                lines = CONTROL.sub("", data.decode("utf-8", "replace")).replace("\r", "\n").split("\n")
                shown = next((line.strip() for line in reversed(lines) if line.strip()), shown)
            if ended:
                break
    os.close(ours)
    return Watched(running.returncode, time.monotonic() - begun_s, found)


def main() -> int:
    """Run what is asked for and list the silences; 1 where one is over the limit, or a command failed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="where the commands run; made anew")
    parser.add_argument("--only", nargs="+", choices=COMMANDS, default=list(COMMANDS))
    parser.add_argument("--log", action="store_true", help="into a pipe instead of onto a terminal")
    arguments = parser.parse_args()
    folder: Path = arguments.folder.resolve()
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "drives").mkdir(parents=True)
    for seed, name in enumerate("ab"):
        write_csv([generate_drive(seed=seed, duration_s=DRIVE_S).input], folder / "drives" / f"{name}.csv")
    limit_s, bad = IN_LOG_S if arguments.log else ON_TERMINAL_S, 0
    rows = [
        "| command | took [s] | longest silence [s] | of processor [s] | after [s] | load | last shown |",
        "|---|---|---|---|---|---|---|",
    ]
    for name in arguments.only:
        words = [*COMMANDS[name]]
        if "--out" not in words and words[0] not in WITHOUT_OUT:
            words += ["--out", f"out-{name}{FILES.get(name, '')}"]
        seen = watched(words, folder, log=arguments.log)
        over = [one for one in seen.silences if one.lasts_s > limit_s]
        bad += bool(over or seen.code)
        print(f"{name}: {seen.took_s:.1f} s, exit code {seen.code}, silent {len(over)} times", flush=True)
        for one in over:
            time_of = f"{one.lasts_s:5.1f} s ({one.worked_s:.1f} s of processor) after {one.since_s:5.1f} s"
            print(f"    {time_of}: {one.shown[:90]}", flush=True)
        most, load = seen.longest, os.getloadavg()[0]
        cells = (
            name,
            f"{seen.took_s:.1f}",
            f"{most.lasts_s:.1f}",
            f"{most.worked_s:.1f}",
            f"{most.since_s:.1f}",
            f"{load:.1f}",
        )
        rows.append(f"| {' | '.join((*cells, most.shown[:60].replace('|', '/')))} |")
    print("\n".join(["", *rows]))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
