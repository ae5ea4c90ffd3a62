"""``modelcast cruise``: what it writes, from what, and what it refuses."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from modelcast.cli.app import run
from modelcast.io.write_trips import write_csv
from modelcast.trips.trajectory import build_trajectory

SHORT = {
    "--policy": ["bsm-10hz", "mbc"],
    "--threshold": ["0.1"],
    "--loss": ["0", "0.5"],
    "--vehicles": ["3"],
    "--seeds": ["2"],
    "--duration": ["11"],
}


def arguments(out: Path, **changes: str) -> list[str]:
    """Return the words of a short run, with options changed or added: each is a name and its values."""
    options = SHORT | {f"--{name.replace('_', '-')}": values.split(" ") for name, values in changes.items()}
    words = [word for name, values in options.items() for word in (name, *values) if word]
    return ["cruise", *words, "--out", str(out)]


@pytest.fixture
def trip_csv(tmp_path: Path) -> Path:
    """A car that speeds up from 20 m/s to 22 m/s."""
    t_s = np.arange(150) * 0.1
    speed = np.clip(20.0 + 0.5 * t_s, 20.0, 22.0)
    east = np.cumsum(speed) * 0.1
    path = tmp_path / "leader.csv"
    write_csv(
        [build_trajectory("leader/car", t_s, np.column_stack([east, 0.0 * east]), speed_mps=speed)], path
    )
    return path


@pytest.mark.slow
def test_cruise_writes_table_document_and_figure_and_repeats_itself(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([*arguments(tmp_path / "one", burst="1"), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert run(arguments(tmp_path / "two", burst="1")) == 0
    shown = capsys.readouterr().out
    assert "2 platoons of 3 by path, with a ranging sensor, behind sinusoid" in shown
    for name in ("summary.json", "runs.parquet", "table.md", "cruise.png"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    assert printed == json.loads((tmp_path / "one" / "summary.json").read_text())
    found = [(row["sender"], row["loss_ratio"], row["burst_s"]) for row in printed["rows"]]
    each = [(0.0, 0.0), (0.5, 1.0)]
    assert found == [("perfect", 0.0, 0.0), *((name, *loss) for name in ("bsm-10hz", "mbc") for loss in each)]
    table = pl.read_parquet(tmp_path / "one" / "runs.parquet")
    assert table["gap_min_m"].to_list() == [row["gap_min_m"] for row in printed["rows"]]
    assert table["threshold_m"].to_list() == [row["threshold_m"] for row in printed["rows"]]
    assert len((tmp_path / "one" / "table.md").read_text().splitlines()) == 2 + len(found)


@pytest.mark.slow
def test_cruise_follows_a_recorded_leader(tmp_path: Path, trip_csv: Path) -> None:
    words = arguments(tmp_path / "out", leader=str(trip_csv), law="ploeg", loss="0", policy="free")
    assert run([*words, "--no-ranging", "--quiet"]) == 0
    document = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert document["leader"] == "leader/car"
    assert (document["law"], document["ranging"]) == ("ploeg", False)
    assert document["options"]["leader"] == "leader.csv"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"leader": "circus"}, "--leader must be sinusoid, braking, steady, or a file"),
        ({"policy": "smoke"}, "or bsm-Nhz or free-Nhz"),
        ({"loss": "2"}, "must lie in 0..1"),
        ({"vehicles": "2"}, "3 vehicles or more"),
        ({"duration": "6"}, "disturbances begin at 5.0 s"),
        ({"leader": "braking", "deceleration": "0"}, "deceleration_mps2 must be positive"),
    ],
)
def test_what_cannot_be_driven_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], changes: dict[str, str], message: str
) -> None:
    assert run([*arguments(tmp_path / "out", **changes), "--quiet"]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_file_without_the_trip_is_refused(
    tmp_path: Path, trip_csv: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(arguments(tmp_path / "out", leader=str(trip_csv), trip="nobody*")) == 2
    assert "no usable trip matches 'nobody*'" in capsys.readouterr().err
