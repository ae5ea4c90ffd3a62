"""Claims about the command line: exit codes, what is written and printed, and that a run can be repeated."""

import csv
import json
import os
import subprocess
import sys
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from modelcast.cli.app import run
from modelcast.io.trips import read_trips
from modelcast.io.write_trips import write_csv
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive

SMALL = ("--threshold", "0.3", "--per", "0", "0.4", "--seeds", "2", "--quiet")


@pytest.fixture(scope="module", autouse=True)
def letters_of_pdfs() -> None:
    """Leave them as users get them: another process writes the same bytes."""


@pytest.fixture(scope="session")
def short_drive() -> Trajectory:
    """The first 40 s of a generated drive, with speed and heading."""
    truth = generate_drive(seed=5, duration_s=90.0).truth
    columns = {
        name: column[:400] for name, column in truth.columns().items() if name not in ("t_s", "position_m")
    }
    return build_trajectory("drive/1", truth.t_s[:400], truth.position_m[:400], **columns)


@pytest.fixture(scope="session")
def drive_csv(tmp_path_factory: pytest.TempPathFactory, short_drive: Trajectory) -> Path:
    path = tmp_path_factory.mktemp("trips") / "drive.csv"
    write_csv([short_drive], path)
    return path


@pytest.fixture(scope="session")
def done(tmp_path_factory: pytest.TempPathFactory, drive_csv: Path) -> Path:
    """The output folder of one small run, with its message trace beside it."""
    folder = tmp_path_factory.mktemp("done")
    trace = folder / "trace.csv"
    assert run(["evaluate", str(drive_csv), "--out", str(folder / "out"), *SMALL, "--trace", str(trace)]) == 0
    return folder / "out"


def names(folder: Path) -> set[str]:
    return {item.name for item in folder.iterdir()}


def same_bytes(one: Path, other: Path) -> bool:
    return all(
        (one / name).read_bytes() == (other / name).read_bytes()
        for name in ("summary.json", "events.parquet", "samples.parquet")
    )


def test_a_run_leaves_summary_tables_report_and_arguments(done: Path) -> None:
    expected = {"summary.json", "events.parquet", "samples.parquet", "report.html", "run.json", "figures"}
    assert expected <= names(done)
    assert not [name for name in names(done.parent) if name.startswith(".")]


def test_the_summary_has_the_keys_that_are_promised(done: Path) -> None:
    summary = json.loads((done / "summary.json").read_text())
    assert summary["schema"] == 1
    assert [trip["id"] for trip in summary["trips"]] == ["drive/1"]
    assert {"id", "source", "duration_s", "vehicles", "conditioned"} <= set(summary["trips"][0])
    rate_keys = {"trip", "policy", "bank", "threshold_m"}
    rate_keys |= {"update_rate_hz", "identification_rate_hz", "total_rate_hz"}
    assert rate_keys <= set(summary["rates"][0])
    tracking_keys = {"trip", "policy", "threshold_m", "packet_error_ratio", "bank", "rate_basis", "seeds"}
    tracking_keys |= {f"pte_{name}_m" for name in ("mean", "p50", "p90", "p90_low", "p90_high", "p95", "p99")}
    assert tracking_keys <= set(summary["tracking"][0])
    assert {row["policy"] for row in summary["rates"]} == {"mbc", "baseline", "free"}
    policies = {"mbc", "baseline", "baseline-periodic", "baseline-matched", "free", "free-matched"}
    assert {row["policy"] for row in summary["tracking"]} == policies
    assert {row["rate_basis"] for row in summary["tracking"]} == {"update", "total", None}
    assert {row["trip"] for row in summary["tracking"]} == {"all", "drive/1"}


def test_the_summary_names_no_absolute_path(done: Path, drive_csv: Path) -> None:
    text = (done / "summary.json").read_text()
    assert str(drive_csv.parent) not in text
    assert str(done) not in text
    assert '"/' not in text


def test_keys_are_sorted(done: Path) -> None:
    def is_sorted(value: object) -> bool:
        if isinstance(value, dict):
            return list(value) == sorted(value) and all(is_sorted(item) for item in value.values())
        return not isinstance(value, list) or all(is_sorted(item) for item in value)

    assert is_sorted(json.loads((done / "summary.json").read_text()))


@pytest.mark.slow
def test_another_process_writes_the_same_bytes(done: Path, drive_csv: Path, tmp_path: Path) -> None:
    """A real process, with other hash seeds, another working folder and another output folder."""
    command = [sys.executable, "-W", "error", "-m", "modelcast", "evaluate", str(drive_csv), *SMALL]
    environment = {**os.environ, "PYTHONHASHSEED": "7"}
    ended = subprocess.run(  # noqa: S603 - our own command
        [*command, "--out", "again"], cwd=tmp_path, env=environment, capture_output=True, check=False
    )
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, b"", b"")
    assert same_bytes(done, tmp_path / "again")


@pytest.mark.slow
def test_another_seed_draws_other_losses_and_keeps_the_rates(
    done: Path, drive_csv: Path, tmp_path: Path
) -> None:
    assert run(["evaluate", str(drive_csv), *SMALL, "--seed", "1", "--out", str(tmp_path / "out")]) == 0
    first, other = (json.loads((one / "summary.json").read_text()) for one in (done, tmp_path / "out"))
    assert first["rates"] == other["rates"]
    assert first["tracking"] != other["tracking"]


@pytest.mark.slow
def test_a_run_can_be_repeated_from_its_run_json(done: Path, tmp_path: Path) -> None:
    out = tmp_path / "again"
    assert run(["evaluate", "--rerun", str(done / "run.json"), "--out", str(out), "--quiet"]) == 0
    assert same_bytes(done, out)
    assert (out / "run.json").read_bytes() == (done / "run.json").read_bytes()


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """What is said on stderr by a command that ends with exit code 2 and prints nothing else."""
    assert run(list(arguments)) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert "Traceback" not in shown.err
    return " ".join(shown.err.split())


def test_a_repeated_run_refuses_inputs_that_changed(
    done: Path, drive_csv: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document = json.loads((done / "run.json").read_text())
    document["inputs"][str(drive_csv)]["sha256"] = "0" * 64
    changed = tmp_path / "run.json"
    changed.write_text(json.dumps(document))
    out = str(tmp_path / "out")
    assert "has changed" in refused(capsys, "evaluate", "--rerun", str(changed), "--out", out)
    document["inputs"][str(drive_csv)]["bytes"] += 1
    changed.write_text(json.dumps(document))
    assert "octets, now" in refused(capsys, "evaluate", "--rerun", str(changed), "--out", out)
    document["inputs"] = {}
    changed.write_text(json.dumps(document))
    assert "is new" in refused(capsys, "evaluate", "--rerun", str(changed), "--out", out)
    document["arguments"]["paths"] = [str(tmp_path / "gone.csv")]
    document["inputs"] = {str(tmp_path / "gone.csv"): {"bytes": 1, "sha256": "0" * 64}}
    changed.write_text(json.dumps(document))
    assert "is missing" in refused(capsys, "evaluate", "--rerun", str(changed), "--out", out)


@pytest.mark.parametrize(
    "option", [("--threshold", "0.4"), ("--seed", "3"), ("--format", "csv"), ("--trip", "a*")]
)
def test_a_repeated_run_takes_no_other_options(
    option: tuple[str, str], done: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """They would be ignored in silence."""
    arguments = ("evaluate", "--rerun", str(done / "run.json"), *option, "--out", str(tmp_path / "out"))
    assert "--rerun" in refused(capsys, *arguments)


@pytest.mark.parametrize("content", ["", "{}", "[]", '{"schema": 99}', "null"])
def test_what_is_no_run_json_is_refused(
    content: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "run.json"
    path.write_text(content)
    out = str(tmp_path / "out")
    assert "run.json" in refused(capsys, "evaluate", "--rerun", str(path), "--out", out)


@pytest.mark.slow
def test_json_is_the_summary_and_nothing_else(
    done: Path, drive_csv: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = [one for one in SMALL if one != "--quiet"]
    assert run(["evaluate", str(drive_csv), *arguments, "--json", "--out", str(tmp_path / "out")]) == 0
    shown = capsys.readouterr()
    assert json.loads(shown.out) == json.loads((done / "summary.json").read_text())
    assert shown.err == ""


@pytest.mark.slow
def test_the_tables_are_printed_otherwise(
    drive_csv: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--threshold", "0.3", "--per", "0", "--seeds", "1"]
    assert run(["evaluate", str(drive_csv), *arguments, "--out", str(tmp_path / "out")]) == 0
    shown = capsys.readouterr().out
    assert "30 cm" in shown
    assert "report.html" in shown


def test_the_message_trace_lists_every_message_of_mbc(done: Path) -> None:
    with (done.parent / "trace.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["t_s", "vehicle", "size_bytes", "kind"]
    summary = json.loads((done / "summary.json").read_text())
    (rate,) = (row for row in summary["rates"] if (row["trip"], row["policy"]) == ("all", "mbc"))
    assert len(rows) == rate["updates"] + rate["identifications"]
    events = pl.read_parquet(done / "events.parquet").filter(pl.col("policy").cast(pl.String) == "mbc")
    assert [float(row["t_s"]) for row in rows] == events["t_s"].to_list()


@pytest.mark.parametrize("trace", ["trace.txt", "no/folder/trace.csv", "out/trace.csv"])
def test_a_trace_that_cannot_be_written_is_refused_and_leaves_nothing(
    trace: str, drive_csv: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ("evaluate", str(drive_csv), *SMALL, "--out", str(tmp_path / "out"))
    assert "trace" in refused(capsys, *arguments, "--trace", str(tmp_path / trace))
    assert names(tmp_path) == set()


@pytest.mark.slow
def test_one_bad_file_leaves_the_others_complete(
    done: Path, drive_csv: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bad = tmp_path / "bad.csv"
    bad.write_text("t_s,east_m,north_m\n0.0,1.0,2.0\n0.1,oops,2.0\n0.2,1.0,2.0\n")
    out = tmp_path / "out"
    assert run(["evaluate", str(drive_csv), str(bad), *SMALL, "--out", str(out)]) == 3
    assert "bad.csv" in capsys.readouterr().err
    summary = json.loads((out / "summary.json").read_text())
    assert list(summary["failures"]) == ["bad.csv"]
    assert "oops" in summary["failures"]["bad.csv"]
    assert str(tmp_path) not in (out / "summary.json").read_text()
    assert summary["rates"] == json.loads((done / "summary.json").read_text())["rates"]


@pytest.mark.slow
def test_two_bad_files_of_one_name_are_both_named(drive_csv: Path, tmp_path: Path) -> None:
    paths = [tmp_path / folder / "bad.csv" for folder in ("a", "b")]
    for path in paths:
        path.parent.mkdir()
        path.write_text("t_s,east_m,north_m\n0.0,oops,2.0\n")
    out = tmp_path / "out"
    assert run(["evaluate", str(drive_csv), *map(str, paths), *SMALL, "--out", str(out)]) == 3
    assert len(json.loads((out / "summary.json").read_text())["failures"]) == 2


@pytest.fixture(name="bad_trips")
def _bad_trips(tmp_path: Path) -> Path:
    """A folder with an empty file and a trip shorter than a window."""
    folder = tmp_path / "bad"
    folder.mkdir()
    (folder / "empty.csv").write_text("")
    t = np.arange(9) * 0.1
    write_csv([build_trajectory("short/1", t, np.stack([t, t], axis=1))], folder / "short.csv")
    return folder


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ((), "trip file"),
        (("{bad}/none.csv",), "none.csv"),
        (("{bad}/empty.csv",), "empty.csv"),
        (("{bad}/short.csv",), "9 samples"),
        (("{drive}", "--no-such-option"), "no-such-option"),
        (("{drive}", "--bank", "cv+lstm"), "lstm"),
        (("{drive}", "--bank", "cv+cv"), "distinct"),
        (("{drive}", "--bank", ""), "--bank"),
        (("{drive}", "--threshold", "-0.3"), "threshold"),
        (("{drive}", "--threshold", "big"), "threshold"),
        (("{drive}", "--threshold", "0.3", "0.3"), "threshold"),
        (("{drive}", "--per", "40"), "0..1"),
        (("{drive}", "--seeds", "0"), "seeds"),
        (("{drive}", "--window", "2"), "window"),
        (("{drive}", "--window", "600"), "window"),
        (("{drive}", "--noise-floor", "-1"), "noise"),
        (("{drive}", "--bank", "ctra", "--trusted-horizon", "0.1"), "horizon_s must be a number from 0.2"),
        (("{drive}", "--delay", "-1"), "delay"),
        (("{drive}", "--position-noise", "nan"), "noise"),
        (("{drive}", "--start", "last"), "start"),
        (("{drive}", "--protocol", "real"), "protocol"),
        (("{drive}", "--format", "avi"), "avi"),
        (("{drive}", "--columns", "t"), "--columns"),
        (("{drive}", "--trip", "nothing*"), "usable trip"),
        (("{drive}", "--map", "drive/1"), "--map"),
        (("{drive}", "--map", "other/1@10"), "other/1"),
        (("{drive}", "--rerun", "run.json"), "--rerun"),
        (("{drive}", "--out", "{drive}"), "is a file"),
        (("{drive}", "--out", "{drive}/out"), "drive.csv"),
    ],
)
def test_bad_usage_ends_with_two_names_the_culprit_and_leaves_nothing(
    arguments: tuple[str, ...],
    named: str,
    drive_csv: Path,
    bad_trips: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    tmp_path = bad_trips.parent
    given = [one.format(drive=drive_csv, bad=bad_trips) for one in arguments]
    out = [] if "--out" in given else ["--out", str(tmp_path / "out")]
    assert named in refused(capsys, "evaluate", *given, "--quiet", *out)
    assert names(tmp_path) == {"bad"}
    assert names(drive_csv.parent) == {"drive.csv"}


@pytest.mark.parametrize("command", ["evaluat", "--no-such-option"])
def test_an_unknown_command_is_bad_usage(command: str) -> None:
    assert run([command]) == 2


@pytest.mark.slow
def test_an_earlier_output_is_replaced_whole(drive_csv: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    quick = ["evaluate", str(drive_csv), "--threshold", "0.3", "--per", "0", "--seeds", "1", "--quiet"]
    assert run([*quick, "--out", str(out)]) == 0
    first = (out / "summary.json").read_bytes()
    assert run([*quick, "--bank", "cv+gp-intercept", "--out", str(out)]) == 0
    assert (out / "summary.json").read_bytes() != first
    assert names(tmp_path) == {"out"}


@pytest.mark.slow
def test_a_failed_run_leaves_the_earlier_output(
    drive_csv: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    quick = ["evaluate", str(drive_csv), "--threshold", "0.3", "--per", "0", "--seeds", "1", "--quiet"]
    assert run([*quick, "--out", str(out)]) == 0
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    refused(capsys, *quick, "--map", "other/1@3", "--out", str(out))
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before
    assert names(tmp_path) == {"out"}


def test_a_folder_with_a_users_file_is_not_replaced(
    drive_csv: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    assert "notes.txt" in refused(capsys, "evaluate", str(drive_csv), *SMALL, "--out", str(tmp_path))
    assert names(tmp_path) == {"notes.txt"}


def test_trips_shows_a_table_or_json(drive_csv: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trips", str(drive_csv)]) == 0
    assert "drive/1" in capsys.readouterr().out
    assert run(["trips", str(drive_csv), "--json"]) == 0
    shown = capsys.readouterr()
    assert json.loads(shown.out)
    assert "drive/1" in shown.out
    assert shown.err == ""


def test_trips_counts_implausible_samples_by_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A car at 20 m/s whose speed column says 5 m/s."""
    path = tmp_path / "stuck.csv"
    rows = [f"{i / 10},{2.0 * i},0,5,1.5707963" for i in range(60)]
    path.write_text("\n".join(["t_s,east_m,north_m,speed_mps,heading_rad", *rows]), encoding="utf-8")
    assert run(["trips", str(path), "--json"]) == 0
    (trip,) = json.loads(capsys.readouterr().out)["trips"]
    assert trip["implausible"] == {"speed against displacement": 17, "stuck speed": 40}
    assert run(["trips", str(path)]) == 0
    assert "40 (stuck speed)" in capsys.readouterr().out


def test_trips_goes_on_after_a_bad_file(
    drive_csv: Path, bad_trips: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["trips", str(bad_trips / "empty.csv"), str(drive_csv), "--json"]) == 3
    shown = capsys.readouterr()
    assert "drive/1" in json.dumps(json.loads(shown.out))
    assert "empty.csv" in shown.err


@pytest.mark.parametrize("command", ["trips", "convert"])
def test_no_trip_is_bad_usage(command: str, bad_trips: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = ("--out", str(bad_trips / "out.csv")) if command == "convert" else ()
    assert "trip file" in refused(capsys, command, *out)
    assert "no usable trip" in refused(capsys, command, str(bad_trips / "empty.csv"), *out)
    assert names(bad_trips) == {"empty.csv", "short.csv"}


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_what_convert_writes_is_read_back_the_same(suffix: str, drive_csv: Path, tmp_path: Path) -> None:
    out = tmp_path / f"trips{suffix}"
    assert run(["convert", str(drive_csv), "--out", str(out), "--quiet"]) == 0
    (given,), (read,) = (list(read_trips(path)) for path in (drive_csv, out))
    assert read.trip_id == given.trip_id
    for name, column in given.columns().items():
        assert np.array_equal(read.columns()[name], column), name
    assert names(tmp_path) == {out.name}


def test_convert_names_what_gave_no_trip(
    drive_csv: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "given"
    folder.mkdir()
    (folder / "drive.csv").write_bytes(drive_csv.read_bytes())
    for number in range(7):
        (folder / f"n{number}.md").write_text("no trip")
    ask = ["convert", str(folder), "--out", str(tmp_path / "all.csv")]
    assert run(ask) == 0
    shown = capsys.readouterr().out.replace("\n", " ")
    assert shown.count("no trip from given/n") == 5
    assert "nor from 2 more (modelcast trips names all)" in shown
    assert run([*ask, "--quiet"]) == 0
    assert capsys.readouterr().out == ""
    (folder / "drive.csv").unlink()
    told = refused(capsys, *ask)
    assert "no trip from given/n0.md" in told
    assert "no usable trip: nothing was written" in told


@pytest.mark.parametrize("out", ["trips.txt", "no/folder/trips.csv"])
def test_convert_refuses_what_it_cannot_write(
    out: str, drive_csv: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "--out" in refused(capsys, "convert", str(drive_csv), "--out", str(tmp_path / out))
    assert names(tmp_path) == set()


def test_the_demo_needs_no_data(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["demo", "--duration", "90", "--out", str(tmp_path / "demo")]) == 0
    assert "MBC" in capsys.readouterr().out
    assert {"summary.json", "report.html"} <= names(tmp_path / "demo")
    summary = json.loads((tmp_path / "demo" / "summary.json").read_text())
    assert summary["trips"][0]["source"] == "generated"
    drive = generate_drive(seed=0, duration_s=90.0)
    assert summary["settings"]["protocol"] == "sensor"
    assert summary["settings"]["sensor"] == asdict(drive.sensor)
    assert drive.sensor != EvaluationSettings().sensor


def test_a_demo_too_short_is_bad_usage(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "90" in refused(capsys, "demo", "--duration", "5", "--out", str(tmp_path / "demo"))
    assert names(tmp_path) == set()


@pytest.mark.parametrize("command", ["demo", "evaluate", "trips", "convert"])
def test_help_names_every_option_with_its_unit(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([command, "--help"]) == 0
    shown = capsys.readouterr().out
    assert "--out" in shown or command == "trips"
    if command == "evaluate":
        for option in (
            "--threshold",
            "--per",
            "--seeds",
            "--bank",
            "--keep-alive",
            "--map",
            "--trace",
            "--json",
        ):
            assert option in shown
        assert "[m]" in shown
        assert "[s]" in shown


def test_help_and_version_of_the_whole(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--help"]) == 0
    shown = capsys.readouterr().out
    for command in ("demo", "evaluate", "trips", "convert"):
        assert command in shown
    assert run(["--version"]) == 0
    assert capsys.readouterr().out.strip()


def test_help_imports_none_of_the_heavy_libraries() -> None:
    script = (
        "import sys\nfrom modelcast.cli.app import run\nassert run(['--help']) == 0\n"
        "heavy = {'numba', 'polars', 'matplotlib', 'scipy', 'pyarrow'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", script], check=True, capture_output=True)  # noqa: S603 - our own script


@pytest.mark.slow
def test_coverage_writes_document_and_figure_and_repeats_itself(
    tmp_path: Path, short_drive: Trajectory, capsys: pytest.CaptureFixture[str]
) -> None:
    other = tmp_path / "other.csv"
    write_csv([replace(short_drive.moved(1.0, (50.0, 0.0)), trip_id="other/1")], other)
    first = tmp_path / "first.csv"
    write_csv([short_drive], first)
    arguments = ["coverage", str(first), str(other), "--bank", "cv+ctra", "--threshold", "0.3"]
    arguments += ["--start", "hindsight"]
    assert run([*arguments, "--out", str(tmp_path / "one"), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert run([*arguments, "--out", str(tmp_path / "two")]) == 0
    assert "mapped" in capsys.readouterr().out
    for name in ("coverage.json", "coverage.png", "times.png"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    assert printed == json.loads((tmp_path / "one" / "coverage.json").read_text())
    assert set(printed["calibrations"]) == {"drive", "other"}
    assert {row["sub_model"] for row in printed["coverage"]} == {"cv", "ctra", "cv+ctra"}
    assert {row["threshold_m"] for row in printed["times"]} == {0.3}


@pytest.mark.slow
def test_coverage_learns_from_other_files_where_these_are_named(tmp_path: Path, drive_csv: Path) -> None:
    out = tmp_path / "out"
    arguments = ["coverage", str(drive_csv), "--train", str(drive_csv), "--bank", "ctrv"]
    assert run([*arguments, "--out", str(out), "--quiet"]) == 0
    document = json.loads((out / "coverage.json").read_text())
    assert set(document["calibrations"]) == {"drive"}


def test_coverage_of_one_file_alone_is_refused(
    tmp_path: Path, drive_csv: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["coverage", str(drive_csv), "--out", str(tmp_path / "out"), "--quiet"]) == 2
    assert "cannot be split" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
