"""How long commands are silent: each is run on a terminal of its own, with nothing compiled beforehand.

For each command, the times in which it wrote nothing to the terminal for longer than two seconds are listed,
with the last that it had shown. What is measured is this machine as it is: a loaded one shows more.

    python tools/signs_of_life.py out/signs
    python tools/signs_of_life.py out/signs --only demo network
"""

import argparse
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
SILENT_S = 2.0
WAIT_S = 0.1
CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")


@dataclass(frozen=True, slots=True)
class Silence:
    """A time in which nothing was written.

    Parameters
    ----------
    since_s, lasts_s
        When it began after the start, and how long it was [s].
    shown
        What had been written last.
    """

    since_s: float
    lasts_s: float
    shown: str


def watched(words: Sequence[str], folder: Path) -> tuple[int, float, list[Silence]]:
    """Run a command on a terminal: its exit code, its time, and when it was silent."""
    cache = folder / "cache"
    shutil.rmtree(cache, ignore_errors=True)
    ours, theirs = pty.openpty()
    known = {**os.environ, "TERM": "xterm", "MODELCAST_CACHE_DIR": str(cache)}
    found: list[Silence] = []
    begun_s = last_s = time.monotonic()
    shown = "(nothing yet)"
    running = subprocess.Popen(  # noqa: S603 - our own interpreter
        [sys.executable, "-m", "modelcast", *words],
        cwd=folder, env=known, stdin=theirs, stdout=subprocess.DEVNULL, stderr=theirs,
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
                now_s = time.monotonic()
                if now_s - last_s > SILENT_S:
                    found.append(Silence(last_s - begun_s, now_s - last_s, shown))
                last_s = now_s
                lines = CONTROL.sub("", data.decode("utf-8", "replace")).replace("\r", "\n").split("\n")
                shown = next((line.strip() for line in reversed(lines) if line.strip()), shown)
            if ended:
                break
    os.close(ours)
    return running.returncode, time.monotonic() - begun_s, found


def main() -> None:
    """Run what is asked for and list the silences."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="where the commands run; made anew")
    parser.add_argument("--only", nargs="+", choices=COMMANDS, default=list(COMMANDS))
    arguments = parser.parse_args()
    folder: Path = arguments.folder.resolve()
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "drives").mkdir(parents=True)
    for seed, name in enumerate("ab"):
        write_csv([generate_drive(seed=seed, duration_s=DRIVE_S).input], folder / "drives" / f"{name}.csv")
    for name in arguments.only:
        words = [*COMMANDS[name]]
        if "--out" not in words and words[0] not in WITHOUT_OUT:
            words += ["--out", f"out-{name}{FILES.get(name, '')}"]
        code, took_s, silences = watched(words, folder)
        print(f"{name}: {took_s:.1f} s, exit code {code}, silent {len(silences)} times", flush=True)
        for one in silences:
            print(f"    {one.lasts_s:5.1f} s after {one.since_s:5.1f} s: {one.shown[:90]}", flush=True)


if __name__ == "__main__":
    main()
