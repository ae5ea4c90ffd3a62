"""Claims about ``modelcast network``."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from modelcast.cli.app import USAGE, run

DEFAULTS = {
    "--density": ["20"],
    "--length": ["300"],
    "--duration": ["2.5"],
    "--warm-up": ["1"],
    "--seeds": ["2"],
    "--policy": ["j2945", "j2945-mbc"],
    "--jobs": ["1"],
}


def words(out: Path, **changed: str) -> list[str]:
    """A small sweep with some options changed."""
    given = {name.replace("_", "-"): [value] for name, value in changed.items()}
    options = {**DEFAULTS, **{f"--{name}": value for name, value in given.items()}}
    flat = [word for name, values in options.items() for word in (name, *values)]
    return ["network", *flat, "--quiet", "--out", str(out)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("network") / "out"
    assert run(words(out)) == 0
    return out


def test_a_sweep_leaves_tables_and_a_report(folder: Path) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    assert [(row["policy"], row["run"]) for row in summary["runs"]] == [
        (policy, number) for policy in ("j2945", "j2945-mbc") for number in (0, 1)
    ]
    assert {row["seeds"] for row in summary["pooled"]} == {2}
    assert pq.read_table(folder / "distances.parquet").num_rows == 4 * 12
    assert pq.read_table(folder / "runs.parquet").num_rows == 4
    for name in ("report.html", "table.md", "load.png", "capacity.svg", "settling.png"):
        assert (folder / name).stat().st_size > 0


def test_runs_that_are_done_are_kept(folder: Path) -> None:
    runs = sorted((folder / "runs").iterdir())
    before = {path: path.stat().st_mtime_ns for path in runs}
    summary = (folder / "summary.json").read_bytes()
    assert run(words(folder)) == 0
    assert {path: path.stat().st_mtime_ns for path in sorted((folder / "runs").iterdir())} == before
    assert (folder / "summary.json").read_bytes() == summary


def test_other_options_need_another_folder(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(words(folder, length="400")) == USAGE
    assert "length_m" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("policy", "cow"),
        ("radio", "smoke"),
        ("scenario", "nowhere.csv"),
        ("warm_up", "9"),
        ("seeds", "0"),
        ("density", "100000"),
        ("certificates", "gold"),
    ],
)
def test_mistakes_are_told(option: str, value: str, tmp_path: Path) -> None:
    assert run(words(tmp_path / "out", **{option: value})) == USAGE


@pytest.mark.parametrize("changed", [{"scenario": "grid", "blocks": "2"}, {"radio": "abstract"}])
def test_other_scenarios_and_radios_run(changed: dict[str, str], tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run(words(out, seeds="1", policy="j2945", **changed)) == 0
    assert len(list((out / "runs").iterdir())) == 1
