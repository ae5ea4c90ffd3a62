"""Claims about ``modelcast capacity``: what it writes, takes up again, and refuses."""

import json
from pathlib import Path

import pytest

from modelcast.cli.app import run

SHORT = ("--duration", "2", "--warm-up", "1", "--length", "400", "--seeds", "1", "--jobs", "1")
SMALL = (
    *SHORT, "--policy", "bsm-10hz", "--limit", "0.3", "--lowest", "20", "--highest", "60", "--ratio", "1.8",
)  # fmt: skip


def test_a_search_writes_its_folder_and_is_taken_up(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert run(["capacity", *SMALL, "--out", str(out)]) == 0
    shown = capsys.readouterr().out
    assert "bsm-10hz" in shown
    names = {path.name for path in out.iterdir()}
    assert names >= {"summary.json", "capacity.parquet", "table.md", "capacity.png", "capacity.svg", "runs"}
    (found,) = json.loads((out / "summary.json").read_text())["found"]
    assert found["radio"] == "dsrc"
    assert found["probes"][0]["density_per_km"] == 20.0
    before = {path.name: path.stat().st_mtime_ns for path in (out / "runs").iterdir()}
    assert run(["capacity", *SMALL, "--json", "--out", str(out)]) == 0
    assert json.loads(capsys.readouterr().out)["found"] == [found]
    assert set(before) == {path.name for path in (out / "runs").iterdir()}


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--limit", "0"), "--limit"),
        (("--highest", "60", "--lowest", "100"), "--lowest and --highest"),
        (("--ratio", "1"), "--ratio"),
        (("--scenario", "platoon"), "--scenario must be highway or grid"),
        (("--policy", "loud"), "--policy"),
        (("--radio", "wifi"), "--radio"),
    ],
)
def test_bad_options_are_told(
    words: tuple[str, ...], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["capacity", *SHORT, *words, "--out", str(tmp_path / "out")]) == 2
    assert told in capsys.readouterr().err.replace("\n", " ")
    assert not (tmp_path / "out").exists()
