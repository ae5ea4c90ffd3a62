"""Claims about ``modelcast reproduce paper``: what it writes and prints, and what it refuses."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import pytest

from modelcast.cli.app import run
from modelcast.io.write_trips import write_csv
from modelcast.study.paper.choices import CHOICES, ENDS, one_at_a_time
from modelcast.world.drive import generate_drive

SMALL = ("--threshold", "0.3", "0.5", "--per", "0", "0.4", "--seeds", "2", "--resamples", "50")


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
    words = ["reproduce", "paper", *map(str, drives), *SMALL, "--jobs", "1", "--quiet"]
    assert run([*words, "--out", str(out)]) == 0
    return out


@pytest.mark.slow
def test_a_reproduction_leaves_a_report_claims_and_figures(done: Path) -> None:
    assert {item.name for item in done.iterdir()} == {
        "summary.json",
        "claims.csv",
        "claims.md",
        "report.html",
        "figures",
        "run.json",
        "MANIFEST.txt",
    }
    asked = json.loads((done / "run.json").read_text())
    assert asked["command"] == "reproduce"
    assert asked["arguments"]["study"] == "paper"
    assert asked["arguments"]["options"]["seeds"] == 2
    assert len(asked["inputs"]) == 2


@pytest.mark.slow
def test_the_summary_holds_every_reading_and_the_choices_it_comes_from(done: Path) -> None:
    summary = json.loads((done / "summary.json").read_text())
    labels = [one.label for one in one_at_a_time()]
    assert [one["label"] for one in summary["readings"]] == [*labels, *ENDS]
    assert [one["field"] for one in summary["choices"]] == [choice.field for choice in CHOICES]
    assert {row["trip"] for row in summary["evaluation"]["tracking"]} == {"all"}
    plain = summary["readings"][0]
    assert [row["threshold_m"] for row in plain["messages"]] == [0.3, 0.5]
    assert {(row["rate_basis"], row["schedule"]) for row in plain["tracking"]} == {
        ("update", "periodic"),
        ("update", "matched"),
        ("total", "periodic"),
        ("total", "matched"),
    }


@pytest.mark.slow
def test_claims_are_a_table_for_programs_too(done: Path) -> None:
    summary = json.loads((done / "summary.json").read_text())
    with (done / "claims.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {(row["claim"], row["reading"]): row["verdict"] for row in rows} == {
        (claim["name"], reading): verdict
        for claim in summary["claims"]
        for reading, verdict in claim["verdicts"].items()
    }


@pytest.mark.slow
def test_processes_and_repetition_change_no_byte(drives: list[Path], done: Path, tmp_path: Path) -> None:
    again = tmp_path / "again"
    words = ["reproduce", "paper", *map(str, drives), *SMALL, "--jobs", "2", "--quiet"]
    assert run([*words, "--out", str(again)]) == 0
    for path in sorted(done.rglob("*")):
        if path.is_file():
            assert (again / path.relative_to(done)).read_bytes() == path.read_bytes(), path.name


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["paper"], "at least one trip"),
        (["paper", "TRIP", "--per", "0", "0.5"], "must hold 0.4"),
        (["paper", "TRIP", "--jobs", "-1"], "--jobs"),
        (["paper", "TRIP", "--threshold", "-1"], "threshold"),
        (["thesis", "TRIP"], "thesis"),
        (["paper", "TRIP", "--traffic", "--traffic-out", "OUT"], "a folder of their own"),
        (["paper", "TRIP", "--traffic", "--traffic-out", "OUT/runs"], "a folder of their own"),
        (["paper", "TRIP", "--traffic", "--traffic-out", "FOREIGN"], "files that modelcast did not write"),
        (["paper", "TRIP", "--traffic-density", "0"], "--traffic-density"),
        (["paper", "TRIP", "--traffic-seeds", "0"], "--traffic-seeds"),
        (["paper", "TRIP", "--trip", "nothing*"], "no usable trip"),
    ],
)
def test_mistakes_are_named(
    words: list[str],
    named: str,
    drives: list[Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    foreign = tmp_path / "foreign"
    foreign.mkdir()
    (foreign / "thesis.txt").write_text("mine")
    places = {
        "TRIP": drives[0],
        "OUT": tmp_path / "out",
        "FOREIGN": foreign,
        "OUT/runs": tmp_path / "out/runs",
    }
    asked = [str(places.get(word, word)) for word in words]
    assert run(["reproduce", *asked, "--out", str(tmp_path / "out")]) == 2
    assert named in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_the_richest_trip_is_picked_the_others_are_named_and_a_terminal_shows_claims_and_readings(
    drives: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    words = ["reproduce", "paper", *map(str, drives), "--threshold", "0.5", "--per", "0.4", "--seeds", "1"]
    assert run([*words, "--pick", "--jobs", "1", "--out", str(out)]) == 0
    shown = capsys.readouterr().out
    assert "fewer messages" in shown
    assert "rate basis: all messages" in shown
    assert str(out / "report.html") in shown.replace("\n", "")
    summary = json.loads((out / "summary.json").read_text())
    ranked = [sum(one["counts"].values()) for one in summary["manoeuvres"]]
    assert ranked == sorted(ranked, reverse=True)
    assert len(ranked) == 2
    first = summary["manoeuvres"][0]["trip"]
    assert [row["id"] for row in summary["evaluation"]["trips"]] == [first]
    assert f"picked {first}: {ranked[0]} manoeuvres, the most of 2 trips" in (out / "report.html").read_text()


@pytest.mark.slow
def test_traffic_is_run_beside_the_report_and_taken_up_again(drives: list[Path], tmp_path: Path) -> None:
    words = ["reproduce", "paper", str(drives[0]), "--threshold", "0.5", "--per", "0.4", "--seeds", "1"]
    words += ["--jobs", "1", "--quiet", "--traffic", "--traffic-density", "2", "--out", str(tmp_path / "out")]
    assert run([*words, "--traffic-seeds", "1"]) == 0
    runs = {path.name: path.read_bytes() for path in (tmp_path / "out-traffic" / "runs").iterdir()}
    assert run([*words, "--traffic-seeds", "2"]) == 0
    again = {path.name: path.read_bytes() for path in (tmp_path / "out-traffic" / "runs").iterdir()}
    assert len(again) == 2 * len(runs)
    assert {name: again[name] for name in runs} == runs
    claims = {
        row["name"]: row for row in json.loads((tmp_path / "out" / "summary.json").read_text())["claims"]
    }
    assert claims["any radio"]["verdicts"]["plain"] == "holds"
    assert claims["a channel less busy"]["verdicts"]["plain"] != "not run"
    assert "traffic_load" in {path.stem for path in (tmp_path / "out" / "figures").iterdir()}
