"""Claims about ``modelcast capacity``: what it finds and writes, takes up again, and refuses."""

import json
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from modelcast.cli.app import run
from modelcast.cli.capacity_search import margin_of
from modelcast.cli.fleet_options import FleetOptions
from modelcast.cli.options import SensorOptions

SHORT = {
    "--duration": "2",
    "--warm-up": "1",
    "--length": "400",
    "--margin": "0",
    "--seeds": "1",
    "--jobs": "1",
    "--policy": "bsm-10hz",
    "--lowest": "20",
    "--highest": "40",
    "--ratio": "1.8",
}


def words(out: Path, **changes: str) -> list[str]:
    """The short call with some options changed, named with underscores; blanks part several words."""
    options = {**SHORT, **{f"--{name.replace('_', '-')}": value for name, value in changes.items()}}
    return [
        "capacity",
        *(word for name, value in options.items() for word in (name, *value.split())),
        "--out",
        str(out),
    ]


def found_in(out: Path) -> list[dict[str, Any]]:
    return json.loads((out / "summary.json").read_text())["found"]


def test_a_search_writes_its_folder_and_is_taken_up(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert run(words(out, limit="0.3", highest="60")) == 0
    shown = capsys.readouterr().out
    assert "bsm-10hz" in shown
    names = {path.name for path in out.iterdir()}
    assert names >= {"summary.json", "capacity.parquet", "table.md", "capacity.png", "capacity.svg", "runs"}
    (found,) = found_in(out)
    assert found["radio"] == "dsrc"
    assert (found["quantity"], found["limit"], found["threshold_m"]) == ("absolute", 0.3, None)
    assert found["probes"][0]["density_per_km"] == 20.0
    before = {path.name: path.stat().st_mtime_ns for path in (out / "runs").iterdir()}
    assert run([*words(out, limit="0.3", highest="60"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["found"] == [found]
    assert set(before) == {path.name for path in (out / "runs").iterdir()}


def test_a_constant_bias_fails_at_every_density_unless_places_are_relative_and_it_is_shared(
    tmp_path: Path,
) -> None:
    """Three metres an axis: of absolute places nobody holds 1 m, of relative ones those who share it do."""
    bias = {"sensor": "ideal", "slow_noise": "3", "limit": "1", "position": "absolute relative"}
    assert run(words(tmp_path / "own", **bias)) == 0
    assert run(words(tmp_path / "shared", **bias, shared_bias="1")) == 0
    assert run(words(tmp_path / "free", sensor="ideal", limit="1", position="relative")) == 0
    relative: dict[str, Any] = {}
    for name in ("own", "shared"):
        absolute, relative[name] = found_in(tmp_path / name)
        assert (absolute["holds_per_km"], absolute["fails_per_km"]) == (None, 20.0)
        assert relative[name]["quantity"] == "relative"
    (relative["free"],) = found_in(tmp_path / "free")
    assert {name: one["holds_per_km"] for name, one in relative.items()} == {
        "own": None,
        "shared": 40.0,
        "free": 40.0,
    }


def test_thresholds_and_seeds_are_told_apart(tmp_path: Path) -> None:
    out = tmp_path / "out"
    asked = {"policy": "baseline", "threshold": "0.05 1.5", "limit": "0.4", "seeds": "2", "keep_alive": "3"}
    assert run(words(out, **asked, duration="5", warm_up="2")) == 0
    fine, coarse = found_in(tmp_path / "out")
    assert (fine["threshold_m"], coarse["threshold_m"]) == (0.05, 1.5)
    assert coarse["fails_per_km"] is not None
    rows = pq.read_table(tmp_path / "out" / "capacity.parquet").to_pylist()
    assert len(rows) == len(fine["probes"]) + len(coarse["probes"])
    for row in rows:
        assert row["least"] <= row["value"] <= row["greatest"]
        assert 0 <= row["seeds_held"] <= row["seeds"] == 2
    assert "150 cm" in (tmp_path / "out" / "table.md").read_text()


@pytest.mark.slow
def test_misses_are_a_limit_too(tmp_path: Path) -> None:
    """On an ideal radio nine tenths of the warnings may be missed, and are not; errors are not asked for."""
    asked = {"scenario": "braking", "missed": "0.9", "radio": "ideal", "duration": "20", "length": "1000"}
    assert run(words(tmp_path / "out", **asked, lowest="39")) == 0
    (found,) = found_in(tmp_path / "out")
    assert (found["quantity"], found["holds_per_km"]) == ("missed", 40.0)
    assert all(probe["warnings"] > 0 for probe in found["probes"])
    assert "missed < 90 %" in (tmp_path / "out" / "table.md").read_text()


def test_a_margin_at_both_ends_of_the_road_is_left_out() -> None:
    def counted(margin_m: float) -> tuple[float, float] | None:
        plan = FleetOptions(length=2000.0).plan(
            SensorOptions(), banks=("default",), thresholds_m=(0.5,), margin_m=margin_m
        )
        return plan.settings.counted_m

    assert counted(margin_of("highway", 2000.0, None)) == (500.0, 1500.0)
    assert counted(margin_of("loaded", 2000.0, None)) == (500.0, 1500.0)
    assert counted(margin_of("highway", 2000.0, 0.0)) is None
    assert counted(margin_of("grid", 2000.0, None)) is None


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"limit": "0"}, "--limit"),
        ({"missed": "1"}, "--missed"),
        ({"position": "polar"}, "--position must be of absolute, relative, got polar"),
        ({"highest": "60", "lowest": "100"}, "--lowest and --highest"),
        ({"ratio": "1"}, "--ratio"),
        ({"scenario": "platoon"}, "--scenario must be highway, braking, cut-in, loaded, grid"),
        ({"margin": "200"}, "--margin 200 at both ends leaves nothing of --length 400"),
        ({"scenario": "grid", "margin": "5"}, "--margin goes with"),
        ({"policy": "loud"}, "--policy"),
        ({"radio": "wifi"}, "--radio"),
        ({"shared_bias": "1.5"}, "shared_slow_ratio"),
        ({"missed": "0.5", "radio": "ideal"}, "no true warning of fcw at 20 vehicles/km"),
    ],
)
def test_bad_options_are_told(
    changes: dict[str, str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(words(tmp_path / "out", **changes)) == 2
    assert told in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "out").exists()
