"""Ctrl-C while compiled code runs: 130 and one line."""

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

import modelcast
from modelcast.io.write_trips import write_csv
from modelcast.world.drive import generate_drive

PROGRAM = """
import os, signal, sys, threading
from modelcast.cli import app
from modelcast.station.sender import speaking_kernels

inner, calls = speaking_kernels.speak_through, [0]

def walk(*arguments):
    # A signal that arrives while the kernel runs is seen when it returns: this one waits for nothing.
    calls[0] += 1
    if calls[0] == 3:
        signal.raise_signal(signal.SIGINT)
    return inner(*arguments)

speaking_kernels.speak_through = walk
sys.exit(app.run(sys.argv[1:]))
"""


@pytest.mark.skipif(os.name == "nt", reason="a console's Ctrl-C is another thing there")
def test_an_interrupt_in_an_evaluation_ends_with_130_and_one_line(tmp_path: Path) -> None:
    write_csv([generate_drive(seed=1, duration_s=90.0).input], tmp_path / "drive.csv")
    known = {**os.environ, "PYTHONPATH": str(Path(modelcast.__file__).parent.parent)}
    words = "evaluate", str(tmp_path / "drive.csv"), "--out", str(tmp_path / "out")
    found = subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", PROGRAM, *words], env=known, capture_output=True, text=True, check=False
    )
    line = f"modelcast: interrupted; --out {tmp_path / 'out'} is not written\n"
    assert (found.returncode, found.stderr) == (130, line)
    assert not (tmp_path / "out").exists()
    assert not [one for one in tmp_path.iterdir() if one.name != "drive.csv"]


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="a console's Ctrl-C is another thing there")
def test_a_signal_that_comes_while_a_kernel_runs_is_seen_when_it_returns(tmp_path: Path) -> None:
    """A timer interrupts the main thread in the middle of a long kernel of many calls by address."""
    program = """
import signal
import numpy as np
from modelcast.models.base import Windows
from modelcast.models.gp import GaussianProcess

model = GaussianProcess()
rng = np.random.default_rng(0)
windows = Windows(rng.normal(size=(200_000, 10, 7)), dt_s=0.1)
model.fit(Windows(windows.samples[:1], dt_s=0.1))
signal.setitimer(signal.ITIMER_REAL, 0.05)
signal.signal(signal.SIGALRM, signal.default_int_handler)
try:
    while True:
        model.fit(windows)
except KeyboardInterrupt:
    print("interrupted")
"""
    known = {**os.environ, "PYTHONPATH": str(Path(modelcast.__file__).parent.parent)}
    found = subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", program], env=known, capture_output=True, text=True, check=False, cwd=tmp_path
    )
    assert (found.stdout, found.stderr) == ("interrupted\n", "")


SWALLOWED = """
import signal, sys
from modelcast.cli import app, signals
from modelcast.station.sender import speaking_kernels

def walk(*arguments):
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt as error:
        error.add_note("2 runs are kept")
        raise OSError("a library says something else")

signals.install()
speaking_kernels.speak_through = walk
sys.exit(app.run(sys.argv[1:]))
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="a console's Ctrl-C is another thing there")
def test_an_interrupt_that_a_library_makes_an_error_of_still_says_what_is_kept(tmp_path: Path) -> None:
    write_csv([generate_drive(seed=1, duration_s=90.0).input], tmp_path / "drive.csv")
    known = {**os.environ, "PYTHONPATH": str(Path(modelcast.__file__).parent.parent)}
    words = "evaluate", str(tmp_path / "drive.csv"), "--out", str(tmp_path / "out")
    found = subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", SWALLOWED, *words], env=known, capture_output=True, text=True, check=False
    )
    assert (found.returncode, found.stderr) == (130, "modelcast: interrupted; 2 runs are kept\n")


BROKEN = """
import signal, sys
from modelcast.cli import app, signals
from modelcast.station.sender import speaking_kernels

def walk(*arguments):
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        pass
    raise RuntimeError("half of it is missing")

signals.install()
speaking_kernels.speak_through = walk
sys.exit(app.run(sys.argv[1:]))
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="a console's Ctrl-C is another thing there")
def test_an_interrupt_that_breaks_a_library_is_still_one_line(tmp_path: Path) -> None:
    write_csv([generate_drive(seed=1, duration_s=90.0).input], tmp_path / "drive.csv")
    known = {**os.environ, "PYTHONPATH": str(Path(modelcast.__file__).parent.parent)}
    words = "evaluate", str(tmp_path / "drive.csv"), "--out", str(tmp_path / "out")
    found = subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", BROKEN, *words], env=known, capture_output=True, text=True, check=False
    )
    assert (found.returncode, found.stderr) == (130, "modelcast: interrupted\n")


CLOSING = """
import asyncio, os, signal, sys, threading
from modelcast.cli import signals
from modelcast.cli.stopping import stopped_by_signals

async def close():
    with stopped_by_signals(0.0) as stop:
        os.kill(os.getpid(), int(sys.argv[1]))
        await stop.wait()
        print("closing", flush=True)
        threading.Event().wait()  # what never ends, and holds the loop up

signals.install()
asyncio.run(close())
"""


@pytest.mark.skipif(os.name == "nt", reason="nodes and servers do not run there")
@pytest.mark.parametrize("first", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("second", [signal.SIGINT, signal.SIGTERM])
def test_a_second_signal_ends_at_once_what_does_not_end_by_the_first(
    first: signal.Signals, second: signal.Signals
) -> None:
    known = {**os.environ, "PYTHONPATH": str(Path(modelcast.__file__).parent.parent)}
    with subprocess.Popen(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", CLOSING, str(int(first))],
        env=known, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as closing:  # fmt: skip
        assert closing.stdout is not None
        assert closing.stderr is not None
        assert closing.stdout.readline() == "closing\n"
        while closing.poll() is None:
            # What comes at once after the first is the same key press, delivered twice.
            closing.send_signal(second)
            with suppress(subprocess.TimeoutExpired):
                closing.wait(0.1)
        said = "modelcast: interrupted again, ended at once\n"
        assert (closing.returncode, closing.stderr.read()) == (128 + second, said)


TWICE = """
import asyncio, os, signal
from modelcast.cli.stopping import stopped_by_signals

async def close():
    loop = asyncio.get_running_loop()
    forget = loop.remove_signal_handler

    def forget_and_hear(number):
        found = forget(number)
        os.kill(os.getpid(), signal.SIGTERM)
        return found

    loop.remove_signal_handler = forget_and_hear
    with stopped_by_signals(0.0):
        pass

signal.signal(signal.SIGTERM, lambda number, frame: print("heard"))
asyncio.run(close())
"""


@pytest.mark.skipif(os.name == "nt", reason="nodes and servers do not run there")
def test_a_signal_while_the_loop_gives_the_signals_back_is_heard() -> None:
    found = subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", TWICE],
        env={**os.environ, "PYTHONPATH": str(Path(modelcast.__file__).parent.parent)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (found.returncode, found.stdout, found.stderr) == (0, "heard\n", "")


@pytest.mark.skipif(os.name == "nt", reason="a console's Ctrl-C is another thing there")
@pytest.mark.parametrize(
    ("before", "line"),
    [
        ("", "interrupted when all was done"),
        ("signals.take(signal.SIGINT)", "interrupted again, ended at once"),
    ],
)
def test_an_interrupt_when_all_is_done_says_whether_it_is_the_first(before: str, line: str) -> None:
    program = f"import signal\nfrom modelcast.cli import signals\n{before}\nsignals.finish()\n"
    found = subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", f"{program}signal.raise_signal(signal.SIGINT)"],
        env={**os.environ, "PYTHONPATH": str(Path(modelcast.__file__).parent.parent)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (found.returncode, found.stderr) == (130, f"modelcast: {line}\n")
