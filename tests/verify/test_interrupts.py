"""Ctrl-C in every command, at its own signs of life: 130, one line, nobody left behind, nothing half done."""

import os
import re
import select
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest

import modelcast
from modelcast.io.write_trips import write_csv
from modelcast.world.drive import generate_drive

pytestmark = [
    pytest.mark.interrupts,
    pytest.mark.skipif(sys.platform != "linux", reason="terminals and process groups as Linux has them"),
]

CONTROL = re.compile(rb"\x1b\[[0-9;?]*[A-Za-z]")
ROAD = ("--duration", "6", "--warm-up", "2", "--seeds", "2")
COLD = "compiling"
ENDS_S = 60.0

CASES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "demo": (("demo", "--duration", "90"), ("working", COLD, "evaluating", "writing the report")),
    "trips": (("trips", "drives"), ("working", "files")),
    "convert": (("convert", "drives", "--out", "out.parquet"), ("working", "files")),
    "ingest": (("ingest", "drives", "--out", "out", "--jobs", "2"), ("working", "reading")),
    "evaluate": (("evaluate", "drives", "--out", "out"), ("working", COLD, "files", "writing the report")),
    "compare": (("compare", "drives", "--out", "out", "--seeds", "1"), (COLD, "files", "writing the report")),
    "coverage": (("coverage", "drives", "--out", "out"), (COLD, "files")),
    "network": (("network", "--density", "25", "--out", "out", *ROAD, "--jobs", "2"), (COLD, "runs")),
    "network alone": (("network", "--density", "25", "--out", "out", *ROAD, "--jobs", "1"), (COLD, "runs")),
    "mixed": (("mixed", "--density", "25", "--out", "out", *ROAD, "--jobs", "2"), (COLD, "runs")),
    "capacity": (("capacity", "--highest", "60", "--out", "out", *ROAD), (COLD, "runs")),
    "safety": (("safety", "--streams", "2", "--out", "out"), ("roads", COLD, "recordings")),
    "cruise": (("cruise", "--out", "out", "--seeds", "2"), (COLD, "runs")),
    "reproduce": (("reproduce", "paper", "drives", "--out", "out"), (COLD, "parts")),
    "train": (("train", "drives", "--out", "out.json"), ("files", COLD)),
    "prepare": (("prepare",), ("working", COLD, "rehearsing")),
}  # fmt: skip
"""What is run, and the words of its rows at which the key is pressed."""


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("interrupts") / "drives"
    folder.mkdir()
    for seed, name in enumerate("ab"):
        write_csv([generate_drive(seed=seed, duration_s=120.0).input], folder / f"{name}.csv")
    return folder


@pytest.fixture(name="started")
def _started(tmp_path: Path, drives: Path) -> Iterator[Callable[..., tuple[subprocess.Popen[bytes], int]]]:
    """Start a command on a terminal of its own, in a process group of its own, beside the drives."""
    (tmp_path / "drives").symlink_to(drives)
    running: list[tuple[subprocess.Popen[bytes], int]] = []

    def start(words: tuple[str, ...], *, cold: bool) -> tuple[subprocess.Popen[bytes], int]:
        ours, theirs = os.openpty()
        known = {
            **os.environ,
            "PYTHONPATH": str(Path(modelcast.__file__).parent.parent),
            "MODELCAST_PROGRESS": "bars",
            "TERM": "xterm",
        }
        if cold:
            known["MODELCAST_CACHE_DIR"] = str(tmp_path / "cache")
        process = subprocess.Popen(  # noqa: S603 - our own interpreter
            [sys.executable, "-m", "modelcast", *words],
            cwd=tmp_path, env=known, stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True,
        )  # fmt: skip
        os.close(theirs)
        running.append((process, ours))
        return process, ours

    yield start
    for process, ours in running:
        if process.poll() is None:
            process.kill()
        process.wait()
        os.close(ours)


def read_until(ours: int, word: bytes) -> bytes:
    """What a terminal got until a word is in it, or until its other end is closed."""
    got = b""
    while word not in CONTROL.sub(b"", got) or not word:
        try:
            data = os.read(ours, 65536)
        except OSError:
            break
        if not data:
            break
        got += data
    return CONTROL.sub(b"", got)


def lines_of(got: bytes) -> list[str]:
    text = got.decode("utf-8", "replace").replace("\r", "\n")
    return [line.strip() for line in text.split("\n") if line.strip()]


def left_behind(group: int) -> list[int]:
    """Those of a process group that do not end within a minute; one that has ended unheard of is none."""
    found: list[int] = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # where it has ended meanwhile
            state, _, own = stat.read_text().rpartition(")")[2].split()[:3]
            if int(own) == group and state != "Z":
                ends = os.pidfd_open(int(stat.parent.name))
                if not select.select([ends], [], [], ENDS_S)[0]:
                    found.append(int(stat.parent.name))
                os.close(ends)
    return found


@pytest.mark.parametrize(
    ("name", "sign"), [(name, sign) for name, (_, signs) in CASES.items() for sign in signs]
)
@pytest.mark.parametrize("key", [signal.SIGINT, signal.SIGTERM])
def test_a_key_at_any_sign_of_life_ends_a_command_in_order(
    name: str,
    sign: str,
    key: signal.Signals,
    started: Callable[..., tuple[subprocess.Popen[bytes], int]],
    tmp_path: Path,
) -> None:
    if key == signal.SIGTERM and sign != CASES[name][1][-1]:
        pytest.skip("one moment is enough of the second")
    process, ours = started(CASES[name][0], cold=sign == COLD)
    assert sign.encode() in read_until(ours, sign.encode())
    if key == signal.SIGINT:
        os.killpg(process.pid, key)  # a terminal sends it to all
    else:
        process.send_signal(key)
    rest = lines_of(read_until(ours, b""))
    assert process.wait(ENDS_S) == 128 + key, rest[-30:]
    told = [line for line in rest if "modelcast: " in line]
    word = "interrupted" if key == signal.SIGINT else "ended by SIGTERM"
    assert len(told) == 1, rest
    assert told[0].partition("modelcast: ")[2].startswith(word)
    assert not [line for line in rest if "Traceback" in line or "Error" in line], rest
    assert left_behind(process.pid) == []
    left = [path.name for path in tmp_path.rglob("*") if ".partial" in path.name]
    assert left == []
    assert not (tmp_path / "out" / "report.html").exists()


def test_a_second_key_ends_everything_at_once(
    started: Callable[..., tuple[subprocess.Popen[bytes], int]],
) -> None:
    """Whoever is in a hurry presses again: the code is the same, and nobody is left."""
    process, ours = started(CASES["network"][0], cold=True)
    assert COLD.encode() in read_until(ours, COLD.encode())
    while process.poll() is None:
        os.killpg(process.pid, signal.SIGINT)
        try:
            process.wait(0.5)
        except subprocess.TimeoutExpired:
            continue
    # Where the interpreter is about to leave, the system ends it: a shell says 130 of that too.
    assert process.returncode in {128 + signal.SIGINT, -signal.SIGINT}
    assert "Traceback" not in "\n".join(lines_of(read_until(ours, b"")))
    assert left_behind(process.pid) == []


def test_workers_end_with_a_command_that_is_killed(
    started: Callable[..., tuple[subprocess.Popen[bytes], int]],
) -> None:
    process, ours = started(CASES["network"][0], cold=True)
    assert COLD.encode() in read_until(ours, COLD.encode())
    process.kill()
    assert process.wait(ENDS_S) == -signal.SIGKILL
    # The terminal closes when its last user has gone.
    read_until(ours, b"")
    assert left_behind(process.pid) == []
