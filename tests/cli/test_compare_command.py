"""Claims about ``modelcast compare``: what it writes and prints, and what it refuses."""

import json
from dataclasses import replace
from pathlib import Path

import polars as pl
import pytest

from modelcast.cli.app import run
from modelcast.cli.compare_options import CompareOptions
from modelcast.cli.evaluate_options import EvaluateOptions
from modelcast.cli.options import SensorOptions
from modelcast.io.write_trips import write_csv
from modelcast.models.profile import default_profile
from modelcast.station.banks import member_names
from modelcast.world.drive import generate_drive

SMALL = ("--threshold", "0.3", "0.5", "--per", "0", "0.4", "--seeds", "2", "--resamples", "50")
BANKS = ("--bank", "cv", "ctra+cv", "--rules", "order/on-failure", "keep/final")


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Two generated drives, a file each."""
    folder = tmp_path_factory.mktemp("drives")
    paths = [folder / f"drive{seed}.csv" for seed in (1, 2)]
    for seed, path in enumerate(paths, start=1):
        write_csv([replace(generate_drive(seed, 90.0).truth, trip_id=f"{path.stem}/1")], path)
    return paths


@pytest.fixture(scope="module")
def done(drives: list[Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("done") / "out"
    words = [*map(str, drives), *BANKS, *SMALL, "--against", "ctra+cv keep/final", "--quiet"]
    assert run(["compare", *words, "--out", str(out)]) == 0
    return out


def test_a_comparison_leaves_table_figure_rows_and_arguments(done: Path) -> None:
    assert {item.name for item in done.iterdir()} == {
        "summary.json",
        "table.md",
        "report.html",
        "comparison.png",
        "comparison.svg",
        "comparison.pdf",
        "messages.parquet",
        "tracking.parquet",
        "run.json",
        "MANIFEST.txt",
    }
    asked = json.loads((done / "run.json").read_text())
    assert asked["command"] == "compare"
    assert asked["arguments"]["options"]["rules"] == ["order/on-failure", "keep/final"]
    assert asked["arguments"]["options"]["sensor"] is None
    assert len(asked["inputs"]) == 2


def test_every_bank_meets_every_rule_and_a_single_member_one(done: Path) -> None:
    summary = json.loads((done / "summary.json").read_text())
    assert [(row["name"], row["start"], row["identify"]) for row in summary["candidates"]] == [
        ("cv", "order", "on-failure"),
        ("ctra+cv order/on-failure", "order", "on-failure"),
        ("ctra+cv keep/final", "keep", "final"),
        ("free", "order", "never"),
    ]
    assert summary["settings"]["against"] == "ctra+cv keep/final"
    assert [row["name"] for row in summary["routes"]] == ["drive1/1", "drive2/1"]
    assert len(summary["ratios"]) == 4 * 2 * 2
    assert len(summary["tracking"]) == 4 * 2 * 2 * 2


def test_rows_a_trip_are_read_back(done: Path) -> None:
    messages = pl.read_parquet(done / "messages.parquet")
    assert messages.shape == (4 * 2 * 2 * 2, 13)
    assert messages.schema["updates"] == pl.Int64
    tracking = pl.read_parquet(done / "tracking.parquet")
    assert set(tracking["trip"]) == {"all", "drive1/1", "drive2/1"}
    assert tracking.filter(pl.col("trip") != "all")["p90_low"].null_count() == 4 * 2 * 2 * 2 * 2


@pytest.mark.slow
def test_rows_agree_with_the_evaluate_command(done: Path, drives: list[Path], tmp_path: Path) -> None:
    out = tmp_path / "alone"
    words = ["--bank", "ctra+cv", "--start", "keep", "--identify", "final", "--protocol", "sensor"]
    words += [*SMALL[:8], "--quiet", "--no-references"]
    assert run(["evaluate", str(drives[1]), *words, "--out", str(out)]) == 0
    rates = {
        (row["policy"], row["threshold_m"]): row
        for row in json.loads((out / "summary.json").read_text())["rates"]
        if row["trip"] == "drive2/1"
    }
    found = pl.read_parquet(done / "messages.parquet").filter(
        (pl.col("candidate") == "ctra+cv keep/final")
        & (pl.col("protocol") == "sensor")
        & (pl.col("trip") == "drive2/1")
    )
    assert found.height == 2
    for row in found.to_dicts():
        alone = rates["mbc", row["threshold_m"]]
        assert (row["updates"], row["identifications"]) == (alone["updates"], alone["identifications"])
        assert row["baseline_messages"] == rates["baseline", row["threshold_m"]]["updates"]


@pytest.mark.slow
def test_json_is_the_summary_and_tables_are_printed_otherwise(
    drives: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [
        str(drives[0]),
        "--bank",
        "ctra",
        *SMALL,
        "--protocol",
        "recorded",
        "--out",
        str(tmp_path / "out"),
    ]
    assert run(["compare", *words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads((tmp_path / "out" / "summary.json").read_text())
    assert run(["compare", *words]) == 0
    shown = capsys.readouterr().out
    assert "Same threshold, recorded, without loss" in shown
    assert "Found: At the same threshold, without loss, ctra sent" in shown
    assert "1 trip, 0.03 h, 1 route; 2 candidates" in shown


def test_the_free_receiver_can_be_left_out(drives: list[Path], tmp_path: Path) -> None:
    words = ["--bank", "ctra", *SMALL[:3], "--rates-only", "--no-references", "--no-free", "--quiet"]
    assert run(["compare", str(drives[0]), *words, "--out", str(tmp_path / "out")]) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert [row["name"] for row in summary["candidates"]] == ["ctra"]
    assert (summary["settings"]["free"], summary["settings"]["against"]) == (None, "ctra")


def test_by_default_every_member_and_both_named_banks_are_compared() -> None:
    singles = member_names(default_profile())
    assert [one.name for one in CompareOptions().candidates()] == [*singles, "regimes", "paper", "default"]


def test_a_bank_of_a_profile_trained_anew_is_named_behind_a_colon() -> None:
    options = CompareOptions(("trained", "trained:regimes", "regimes"))
    plain, regimes, shipped = options.candidates()
    assert (plain.name, regimes.name, shipped.name) == ("trained", "trained:regimes", "regimes")
    assert (plain.is_trained, regimes.is_trained, shipped.is_trained) == (True, True, False)


def test_every_bank_meets_every_trusted_horizon_that_changes_it() -> None:
    options = CompareOptions(("cv", "ctra"), trusted_horizon=(0.0, 2.0, 4.0))
    names = [one.name for one in options.candidates()]
    assert names == ["cv", "ctra", "ctra trusted 2 s", "ctra trusted 4 s"]
    (alone,) = CompareOptions(("ctra",), trusted_horizon=(2.0,)).candidates()
    assert alone.name == "ctra"
    assert alone.bank == options.candidates()[2].bank


def test_options_shared_with_evaluate_mean_the_same() -> None:
    sensor = SensorOptions(position_noise=0.05, heading_noise=1.0, latency=0.1)
    shared = CompareOptions(threshold=(0.3,), per=(0.1,), keep_alive=0.0, sensor=sensor).settings().evaluation
    alone = EvaluateOptions(threshold=(0.3,), per=(0.1,), keep_alive=0.0, seeds=3, sensor=sensor).settings()
    assert shared == alone


def test_evaluate_options_survive_being_written_down() -> None:
    options = EvaluateOptions(seed=4, sensor=SensorOptions(speed_noise=0.3))
    assert EvaluateOptions.from_plain(options.as_plain()) == options
    with pytest.raises(ValueError, match="unknown options colour"):
        EvaluateOptions.from_plain({"colour": 1})


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--bank", "ctra+nothing"), "no sub-model is named 'nothing'; there are cv, ca, ctrv, ctra"),
        (("--bank", "ctra", "ctra"), "two candidates are named ctra"),
        (
            ("--rules", "order"),
            "--rules: 'order' is not START/IDENTIFY; starts are order, keep, survivor, predicted, hindsight",
        ),
        (("--against", "ctrb"), "no candidate is named 'ctrb' (is ctrv or ctra meant?); there are cv, ca"),
        (("--protocol", "recorded", "recorded"), "protocols must be one or more, each once"),
        (("--threshold", "0"), "threshold_m must be positive"),
        (("--position-noise=-1",), "position_noise_m"),
        (("--resamples", "0"), "resamples must be >= 1"),
    ],
)
def test_mistakes_are_refused_before_anything_is_written(
    drives: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], said: str
) -> None:
    assert run(["compare", str(drives[0]), *words, "--out", str(tmp_path / "out")]) == 2
    shown = capsys.readouterr()
    assert said in " ".join(shown.err.split())
    assert shown.out == ""
    assert not (tmp_path / "out").exists()


def test_a_file_that_cannot_be_read_is_named_and_the_rest_is_complete(
    drives: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bad = tmp_path / "bad.csv"
    bad.write_text("t,east\n1,2\n")
    words = [str(drives[0]), str(bad), "--bank", "ctra", *SMALL, "--quiet", "--out", str(tmp_path / "out")]
    assert run(["compare", *words]) == 3
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert list(summary["failures"]) == ["bad.csv"]
    assert "bad.csv" in capsys.readouterr().err
    assert run(["compare", "--out", str(tmp_path / "none")]) == 2
