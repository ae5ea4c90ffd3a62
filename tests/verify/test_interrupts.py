"""Ctrl-C in every command, at its own signs of life: 130, one line, nobody left behind, nothing half done.

A command presses the key itself: it counts its calls of functions from the moment at which a sign of life
begins, and sends the signal at one of them, or where the sign ends before. So no case depends on who is
faster.
"""

import os
import select
import signal
import subprocess
import sys
import zlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

import pytest

import modelcast
from modelcast.cli.app import run
from modelcast.io.write_trips import write_csv
from modelcast.world.drive import generate_drive

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="process groups as Linux has them"),
]

PROGRAM = """
import os, signal, sys

from modelcast.__main__ import main
from modelcast.cli.board import Stage, board

sign, after, number = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
del sys.argv[1:4]
calls, pressed = 0, False
begin, turn, hear, finish = board._begin, Stage.begin, board.hear, board._finish

def press():
    global pressed
    sys.setprofile(None)
    if not pressed:
        pressed = True
        os.write(2, b"pressed ")
        if number == signal.SIGINT:
            os.killpg(0, number)  # a terminal sends it to all
        else:
            os.kill(os.getpid(), number)

def count(frame, event, _):
    global calls
    calls += event in ("call", "c_call")
    if calls > after:
        press()

def met(label):
    if sign in label and not pressed:
        sys.setprofile(count)

def begun(stage, **more):
    begin(stage, **more)
    met(stage.label)

def turned(stage, label, now_s):
    turn(stage, label, now_s)
    met(label)

def heard(one):
    if not one.label and sign == "compiling":
        press()
    hear(one)
    if one.label:
        met("compiling")

def finished(stage):
    if sign in stage.label:
        press()
    finish(stage)

board._begin, Stage.begin, board.hear, board._finish = begun, turned, heard, finished
if not sign:
    met("")
main()
"""

ROAD = ("--duration", "4", "--warm-up", "2", "--seeds", "2")
COLD = "compiling"
REPORT = "writing the report"
LATEST = 1500
"""Calls of functions that are waited for at most."""

ENDS_S = 600.0

OTHER_PATHS = [path for path in os.environ.get("PYTHONPATH", "").split(os.pathsep) if path]

HAS_CLUSTER = find_spec("distributed") is not None
HAS_JAX = find_spec("jax") is not None
HAS_SUMO = find_spec("libsumo") is not None

CASES: dict[str, tuple[str, tuple[str, ...]]] = {
    "demo": ("demo --duration 90", ("working", COLD, "evaluating", REPORT)),
    "demo's trips": ("demo --trips trips", ("generating",)),
    "doctor": ("doctor", ("looking",)),
    "trips": ("trips drives", ("working", "files")),
    "trips, ranked": ("trips drives --rank", ("files",)),
    "road": ("road build drives --out out.parquet", ("files",)),
    "convert": ("convert drives --out out.parquet", ("working", "files")),
    "ingest": ("ingest drives --out out --jobs 2", ("working", "reading")),
    "evaluate": ("evaluate drives/a.csv --out out --seeds 1", ("files", REPORT)),
    "evaluate a corpus": ("evaluate corpus --out out --seeds 1 --jobs 2", ("partitions",)),
    "compare": ("compare drives --out out --seeds 1 --resamples 20", (COLD, "trips", REPORT)),
    "coverage": ("coverage drives --out out", ("trips",)),
    "network": ("network --density 25 --out out --jobs 2", (COLD, "runs", REPORT)),
    "network alone": ("network --density 25 --out out --jobs 1", (COLD, "runs")),
    "mixed": ("mixed --density 25 --out out --jobs 2", ("runs",)),
    "capacity": ("capacity --policy bsm-10hz --highest 50 --ratio 2 --out out", ("runs",)),
    "safety": ("safety --streams 2 --out out", ("roads", "recordings")),
    "cruise": ("cruise --out out --seeds 2 --duration 20", ("runs",)),
    "reproduce": ("reproduce paper drives --out out --seeds 1", ("parts",)),
    "prepare": ("prepare", (COLD, "rehearsing")),
}
"""What is run, and the words of its rows at which the key is pressed."""

if HAS_CLUSTER:
    CASES["ingest on a cluster"] = ("ingest drives --out out --cluster local:2", ("reading",))
    CASES["evaluate on a cluster"] = (
        "evaluate corpus --out out --seeds 1 --cluster local:2", ("partitions",),
    )  # fmt: skip
if HAS_JAX:
    CASES["train"] = ("train drives --out out.json --steps 20 --windows 200", ("files", "selector"))
if HAS_SUMO:
    CASES["SUMO"] = (
        "network --scenario sumo-highway --density 25 --out out --jobs 2",
        ("runs",),
    )

TERMINATED = {"demo": REPORT, "ingest": "reading", "network": "runs", "evaluate on a cluster": "partitions"}
"""Where SIGTERM comes: what differs is how a command was started, not what it is at."""


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with drives, and a corpus of them."""
    folder = tmp_path_factory.mktemp("interrupts")
    (folder / "drives").mkdir()
    for seed, name in enumerate("ab"):
        write_csv([generate_drive(seed=seed, duration_s=90.0).input], folder / "drives" / f"{name}.csv")
    assert run(["ingest", str(folder / "drives"), "--out", str(folder / "corpus"), "--quiet"]) == 0
    return folder


Started = Callable[..., "subprocess.Popen[bytes]"]


@pytest.fixture(name="started")
def _started(tmp_path: Path, drives: Path) -> Iterator[Started]:
    """Start a command in a session of its own, beside the drives."""
    for name in ("drives", "corpus"):
        (tmp_path / name).symlink_to(drives / name)
    running: list[subprocess.Popen[bytes]] = []

    def start(*words: str, cold: bool) -> "subprocess.Popen[bytes]":
        known = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(Path(modelcast.__file__).parent.parent), *OTHER_PATHS]),
            "MODELCAST_PROGRESS": "bars",
            "TERM": "xterm",
        }
        if cold:
            known["MODELCAST_CACHE_DIR"] = str(tmp_path / "cache")
        process = subprocess.Popen(  # noqa: S603 - our own interpreter
            [sys.executable, *words], cwd=tmp_path, env=known, start_new_session=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        running.append(process)
        return process

    yield start
    for process in running:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


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
                if not select.select([ends], [], [], 60.0)[0]:
                    found.append(int(stat.parent.name))
                os.close(ends)
    return found


def read_until(sign: bytes, process: "subprocess.Popen[bytes]") -> None:
    """Wait until a command has said something."""
    both = [stream for stream in (process.stdout, process.stderr) if stream is not None]
    got = b""
    while sign not in got:
        ready, _, _ = select.select(both, [], [], ENDS_S)
        assert ready, got
        for stream in ready:
            data = os.read(stream.fileno(), 65536)
            assert data, got
            got += data


def require_order(process: "subprocess.Popen[bytes]", key: signal.Signals, place: Path) -> None:
    """The command ends by the key with its code and one line, and leaves nobody and nothing behind."""
    out, err = process.communicate(timeout=ENDS_S)
    said = lines_of(out + b"\n" + err)
    assert process.returncode == 128 + key, said[-30:]
    told = [line.partition("modelcast: ")[2] for line in said if "modelcast: " in line]
    assert len(told) == 1, said
    assert told[0].startswith("interrupted" if key == signal.SIGINT else "ended by SIGTERM")
    assert not [line for line in said if "Traceback" in line or "Error" in line or "ignored" in line], said
    assert left_behind(process.pid) == []
    assert [path.name for path in place.rglob("*") if ".partial" in path.name] == []
    assert not (place / "out" / "report.html").exists()


PRESSES = [
    *((name, sign, signal.SIGINT) for name, (_, signs) in CASES.items() for sign in signs),
    *((name, sign, signal.SIGTERM) for name, sign in TERMINATED.items() if name in CASES),
]


@pytest.mark.parametrize(("name", "sign", "key"), PRESSES)
def test_a_key_at_any_sign_of_life_ends_a_command_in_order(
    name: str, sign: str, key: signal.Signals, started: Started, tmp_path: Path
) -> None:
    line = CASES[name][0]
    words = [*line.split(), *(ROAD if line.split()[0] in {"network", "mixed", "capacity"} else ())]
    after = zlib.crc32(f"{name}, {sign}, {key}".encode()) % LATEST
    process = started("-c", PROGRAM, sign, str(after), str(int(key)), *words, cold=sign == COLD)
    require_order(process, key, tmp_path)


@pytest.mark.parametrize("after", [100, 3_000, 30_000, 100_000, 200_000])
def test_a_key_while_a_command_is_still_loaded_ends_it_in_order(
    after: int, started: Started, tmp_path: Path
) -> None:
    process = started("-c", PROGRAM, "", str(after), str(int(signal.SIGINT)), "demo", cold=False)
    require_order(process, signal.SIGINT, tmp_path)


SERVICES = {
    "node, compiling": ("node --gnss trip:drives/a.csv", b'"event": "compiling"', True),
    "node": ("node --gnss trip:drives/a.csv", b'"event": "plane"', False),
    "node with a page": ("node --gnss trip:drives/a.csv --dashboard --port 0", b'"event": "plane"', False),
    "serve": ("serve --socket socket", b"listening", False),
    "demo-live": ("demo-live --headless", b"third: ", False),
    "view": ("view --demo --port 0", b"http://", False),
}
"""What runs on until it is told to stop; what it says then; whether nothing is compiled."""


@pytest.mark.parametrize("key", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("name", SERVICES)
def test_what_runs_on_ends_by_a_key_and_a_service_well_by_sigterm(
    name: str, key: signal.Signals, started: Started, tmp_path: Path
) -> None:
    line, sign, cold = SERVICES[name]
    process = started("-u", "-m", "modelcast", *line.split(), cold=cold)
    read_until(sign, process)
    process.send_signal(key)
    if key == signal.SIGTERM and name in {"node", "node with a page", "serve", "demo-live"}:
        _, err = process.communicate(timeout=ENDS_S)
        assert process.returncode == 0, err
        assert b"modelcast: " not in err
        assert b"Traceback" not in err
        assert left_behind(process.pid) == []
    else:
        require_order(process, key, tmp_path)


def test_a_second_key_ends_everything_at_once(started: Started) -> None:
    """Whoever is in a hurry presses again: the code is the same, and nobody is left."""
    words = [*CASES["network"][0].split(), *ROAD]
    process = started("-c", PROGRAM, COLD, "100", str(int(signal.SIGINT)), *words, cold=True)
    read_until(b"pressed", process)
    while process.poll() is None:
        # What comes at once after the first is the same key press, delivered twice.
        with suppress(subprocess.TimeoutExpired):
            process.wait(0.5)
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=ENDS_S)
    # Where the interpreter is about to leave, the system ends it: a shell says 130 of that too.
    assert process.returncode in {128 + signal.SIGINT, -signal.SIGINT}
    assert b"Traceback" not in out + err
    assert left_behind(process.pid) == []


def test_workers_end_with_a_command_that_is_killed(started: Started) -> None:
    words = [*CASES["network"][0].split(), *ROAD]
    process = started("-c", PROGRAM, "runs", "700", str(int(signal.SIGKILL)), *words, cold=True)
    # The pipes close when their last user has gone.
    process.communicate(timeout=ENDS_S)
    assert process.returncode == -signal.SIGKILL
    assert left_behind(process.pid) == []
