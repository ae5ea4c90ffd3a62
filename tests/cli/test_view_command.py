"""Claims: ``modelcast view`` refuses what it cannot show, and asks for a token where others can look."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from modelcast.cli.app import USAGE, run
from modelcast.cli.signals import INTERRUPTED


def test_one_of_a_log_and_the_demo_is_needed(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert run(["view"]) == USAGE
    assert "give a log, or --demo" in capsys.readouterr().err
    assert run(["view", str(tmp_path), "--demo"]) == USAGE


def test_a_file_that_is_no_log_is_named(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("hello\n")
    assert run(["view", str(tmp_path / "notes.txt")]) == USAGE
    assert "notes.txt, row 1: no snapshot and no road" in capsys.readouterr().err
    assert run(["view", str(tmp_path / "none")]) == USAGE
    assert run(["view", "--demo", "--port", "70000"]) == USAGE
    assert "--port must be from 0 to 65535" in capsys.readouterr().err


@pytest.mark.parametrize(("host", "asks"), [("127.0.0.1", False), ("0.0.0.0", True)])  # noqa: S104 - the claim
def test_the_address_is_printed_with_a_token_where_others_can_look(
    tmp_path: Path, host: str, *, asks: bool
) -> None:
    log = tmp_path / "log"
    log.write_text(
        '{"kind":"snapshot","t_s":0.0,"schema":1,"host":null,"remotes":{"ahead_ms":[],"names":[],"id":[],'
        '"model":[],"east_cm":[],"north_cm":[],"major_cm":[],"minor_cm":[],"path_cm":[],"heading_mrad":[],'
        '"speed_cmps":[],"angle_mrad":[],"age_ms":[],"silent_ms":[],"messages":[],"loss_permille":[],'
        '"error_mm":[]},"warnings":[],"counters":{"sent_per_s":0,"received_per_s":0,"sent_bytes_per_s":0,'
        '"received_bytes_per_s":0,"loss_ratio":null,"channel_busy_ratio":null,"rejected":{}}}\n'
    )
    words = [sys.executable, "-u", "-m", "modelcast", "view", str(log), "--host", host, "--port", "0"]
    with subprocess.Popen(  # noqa: S603 - our own interpreter
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        address = running.stdout.readline().strip()
        running.send_signal(signal.SIGINT)
        assert running.wait(60) == INTERRUPTED
        assert running.stderr.read() == "modelcast: interrupted\n"
    assert address.startswith(f"http://{host}:")
    assert ("?token=" in address) is asks
    if asks:
        assert len(address.split("?token=")[1]) >= 32
