"""Claims about ``modelcast node``."""

import gc
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from modelcast.cli.app import run
from modelcast.io.write_trips import write_csv
from modelcast.world.drive import generate_drive


@pytest.fixture(scope="module")
def trip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("trip") / "drive.csv"
    write_csv([generate_drive(3, 90.0).truth], path)
    return path


def test_a_configuration_is_checked_and_nothing_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "node.toml"
    path.write_text("[vehicle]\nlength_m = 12.0\n", encoding="utf-8")
    assert run(["node", str(path), "--check"]) == 0
    assert "all is as it should be" in capsys.readouterr().out
    path.write_text("[vehicle]\nlength_m = 120.0\n", encoding="utf-8")
    assert run(["node", str(path), "--check"]) != 0
    assert "row 2: [vehicle] length_m must be a number" in " ".join(capsys.readouterr().err.split())
    path.write_text('[sending]\nbank = "cow"\n', encoding="utf-8")
    assert run(["node", str(path), "--check"]) != 0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("--duration -1", "--duration must not be negative"),
        ("--gnss cow:moo --duration 1", "is no source of fixes"),
        ("--gnss trip:nowhere.csv --duration 1", "nowhere.csv"),
    ],
)
def test_mistakes_are_told(words: str, told: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["node", *words.split(), "--quiet"]) != 0
    assert told in " ".join(capsys.readouterr().err.split())


def test_it_ends_by_a_signal_with_what_it_did(trip: Path, tmp_path: Path) -> None:
    path = tmp_path / "node.toml"
    path.write_text('[air]\ngroup = "239.255.16.79"\nport = 16791\n', encoding="utf-8")
    words = [sys.executable, "-m", "modelcast", "node", str(path), "--gnss", f"trip:{trip}"]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as process:  # noqa: S603 - our own words
        assert process.stderr is not None
        for line in process.stderr:
            if '"event": "motion"' in line:
                process.send_signal(signal.SIGTERM)
                break
        rest = process.stderr.read()
        assert process.wait(60.0) == 0
    assert '"event": "stop"' in rest


def test_what_it_starts_with_is_not_looked_through_for_garbage(trip: Path, tmp_path: Path) -> None:
    """Neither while it runs, when steps would be late, nor at its end."""
    path = tmp_path / "node.toml"
    path.write_text('[air]\ngroup = "239.255.16.79"\nport = 16795\n', encoding="utf-8")
    gc.unfreeze()
    try:
        assert run(["node", str(path), "--gnss", f"trip:{trip}", "--duration", "0.2", "--quiet"]) == 0
        assert gc.get_freeze_count() > 10_000
    finally:
        gc.unfreeze()


@pytest.mark.slow
def test_four_nodes_run_on_this_machine_and_say_what_one_believes(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["demo-live", "--headless", "--duration", "4", "--udp-port", "16793", "--loss", "0"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) >= 2
    assert "second" in lines[-1]
    assert "m off" in lines[-1]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("--duration 0", "--duration must be above 0"),
        ("--loss 1.5", "--loss must be from 0 to 1"),
        ("--policy cow", "--policy: Unknown policy 'cow'. Known: bsm-10hz"),
        ("--port 70000", "must be from 0 to 65535"),
    ],
)
def test_what_four_nodes_cannot_do_is_told(words: str, told: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["demo-live", "--headless", *words.split()]) != 0
    assert told in " ".join(capsys.readouterr().err.split())
