"""Claims about ``modelcast network``."""

import json
import pickle
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from modelcast.cli.app import USAGE, run
from modelcast.cli.network_case import propagation_of
from modelcast.cli.network_plan import NetworkPlan
from modelcast.cli.network_traffic import traffic
from modelcast.cli.options import SensorOptions
from modelcast.core.exceptions import (
    CodecError,
    ConfigError,
    DataFormatError,
    MissingExtraError,
    ModelcastError,
)
from modelcast.io.sumo_roads import junction_input
from modelcast.study.network.rows import NetworkCase

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
    for name in ("report.html", "table.md", "load.png", "delivery.svg", "settling.png"):
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
        ("relaxed_error", "-1"),
        ("trips", "somewhere.csv"),
    ],
)
def test_mistakes_are_told(option: str, value: str, tmp_path: Path) -> None:
    assert run(words(tmp_path / "out", **{option: value})) == USAGE


@pytest.mark.slow
@pytest.mark.parametrize(
    "changed",
    [
        {"scenario": "grid", "blocks": "2"},
        {"scenario": "crossing", "blocks": "2"},
        {"scenario": "braking"},
        {"scenario": "cut-in"},
        {"scenario": "loaded"},
        {"radio": "abstract"},
    ],
)
def test_other_scenarios_and_radios_run(changed: dict[str, str], tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run(words(out, seeds="1", policy="j2945", **changed)) == 0
    assert len(list((out / "runs").iterdir())) == 1


@pytest.mark.parametrize("scenario", ["grid", "crossing"])
def test_in_a_town_buildings_stand_between_the_streets(scenario: str) -> None:
    """Who drives in one street sees each other, around a corner nobody does; along a road all do."""
    plan = NetworkPlan(
        scenario, duration_s=1.0, warm_up_s=0.0, length_m=400.0, lanes=0, blocks=3, seed=0,
        certificates="gap", banks=("default",), profile=None, start=None, identify=None, cost="bytes",
        threads=1, thresholds_m=(0.2,), keep_alive_s=1.0, believe=None, budget=4.0 / 3.0, approach_m=20.0,
        relaxed_error_m=None, legacy_threshold_m=0.0, sensor=SensorOptions(),
    )  # fmt: skip
    with traffic(plan, NetworkCase(20.0, "dsrc", "j2945", "", 0)) as frames:
        place = next(iter(frames)).position_m
    a, b = np.triu_indices(len(place), 1)
    sees = propagation_of(plan).line_of_sight(place[a], place[b])
    street = np.abs(place - 200.0 * np.round(place / 200.0)) <= 15.0
    number = np.round(place / 200.0)
    together = (street[a] & street[b] & (number[a] == number[b])).any(axis=1)
    inside = (~street[a]).any(axis=1) & (~street[b]).any(axis=1)  # not in the middle of a junction
    assert inside.sum() > 50
    assert (sees == together)[inside].all()
    assert 0.05 < sees[inside].mean() < 0.6
    assert propagation_of(replace(plan, scenario="braking")).line_of_sight(place[a], place[b]).all()


def test_streams_that_do_not_fit_are_told_with_what_to_change(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(words(tmp_path / "out", scenario="braking", density="600", lanes="2")) == USAGE
    told = capsys.readouterr().err
    assert "lower density_per_km, now 600.0" in told
    assert "raise lanes, now 2" in told


FCD = {"csv", "parquet", "xml"}
HAS_SUMO = find_spec("libsumo") is not None


def write_fcd(folder: Path, kind: str) -> Path:
    """Three cars abreast, 5 s at 2 Hz: the last comes late, and the loop gets 10 Hz of it."""
    rows = [
        (0.5 * step, f"car{car}", 7.5 * step, 100.0 * car, 15.0)
        for step in range(11)
        for car in range(3)
        if car < 2 or step > 4
    ]
    path = folder / f"traffic.{kind}"
    names = ("time", "id", "x", "y", "speed")
    if kind == "csv":
        lines = [",".join(names), *(",".join(str(value) for value in row) for row in rows)]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    elif kind == "parquet":
        columns = dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))
        pq.write_table(pa.table(columns), path)
    else:
        steps = ""
        for t_s in sorted({row[0] for row in rows}):
            cars = "".join(
                f'<vehicle id="{name}" x="{x}" y="{y}" angle="90" speed="{speed}"/>'
                for t, name, x, y, speed in rows
                if t == t_s
            )
            steps += f'<timestep time="{t_s}">{cars}</timestep>'
        path.write_text(f"<fcd-export>{steps}</fcd-export>", encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("kind", sorted(FCD))
def test_floating_car_data_of_every_format_run(kind: str, tmp_path: Path) -> None:
    path = write_fcd(tmp_path, kind)
    out = tmp_path / "out"
    assert run(words(out, scenario=str(path), seeds="1", policy="j2945", duration="9")) == 0
    (row,) = json.loads((out / "summary.json").read_text())["runs"]
    assert row["density_per_km"] is None
    assert 2.0 < row["vehicles"] < 3.0
    assert 9.0 < row["message_rate_hz"] < 11.0


def test_a_file_that_is_no_traffic_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "notes.csv"
    path.write_text("a,b\n1,2\n", encoding="utf-8")
    assert run(words(tmp_path / "out", scenario=str(path))) == USAGE
    assert "notes.csv" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("scenario", "trips", "told"),
    [
        ("platoon", None, "--trips"),
        ("trips", None, "--trips"),
        ("platoon", "missing.csv", "missing.csv: does not exist"),
        ("highway", "missing.csv", "--trips goes with"),
    ],
)
def test_trips_and_scenario_go_together(
    scenario: str, trips: str | None, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    changed = {"scenario": scenario} if trips is None else {"scenario": scenario, "trips": trips}
    assert run(words(tmp_path / "out", **changed)) == USAGE
    assert told in capsys.readouterr().err


@pytest.mark.skipif(HAS_SUMO, reason="the extra sumo is installed")
def test_without_sumo_the_extra_is_named_before_anything_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(words(tmp_path / "out", scenario="sumo-highway")) == USAGE
    assert " install eclipse-sumo libsumo" in capsys.readouterr().err


@pytest.mark.skipif(not HAS_SUMO, reason="the extra sumo is not installed")
@pytest.mark.parametrize("scenario", ["sumo-highway", "sumo-grid", "sumo-junction"])
def test_traffic_by_sumo_runs(scenario: str, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run(words(out, scenario=scenario, blocks="2", length="600", seeds="1", policy="j2945")) == 0
    (row,) = json.loads((out / "summary.json").read_text())["runs"]
    assert row["vehicles"] > 1.0


def test_recorded_platoons_run_a_file_a_seed(tmp_path: Path, data_folder: Path) -> None:
    folder = data_folder / "openacc_zalazone"
    names = ("short_setting__handling_part14.csv", "short_setting__dynamic_part12.csv")
    files = [str(folder / name) for name in names]
    out = tmp_path / "out"
    line = words(out, scenario="platoon", policy="j2945-mbc-relaxed", duration="6")
    assert run([*line, "--trips", *files]) == 0
    rows = json.loads((out / "summary.json").read_text())["runs"]
    assert len(rows) == 2
    assert rows[0]["vehicles"] != rows[1]["vehicles"]
    assert all(5.0 <= row["vehicles"] <= 11.0 and 0.5 < row["message_rate_hz"] < 8.0 for row in rows)


def test_trips_that_the_profile_was_trained_on_are_told(
    tmp_path: Path, data_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In the terminal, the table, the page and the summary."""
    file = str(data_folder / "openacc_zalazone" / "short_setting__handling_part14.csv")
    out = tmp_path / "out"
    line = words(out, scenario="platoon", policy="bsm-10hz", seeds="1", duration="6")
    assert run([word for word in line if word != "--quiet"] + ["--trips", file]) == 0
    assert json.loads((out / "summary.json").read_text())["training_trips"]
    for text in (capsys.readouterr().out, (out / "table.md").read_text(), (out / "report.html").read_text()):
        assert "the profile in use was trained on" in text


def test_real_trips_are_laid_on_a_road_at_a_density(tmp_path: Path, data_folder: Path) -> None:
    file = str(data_folder / "openacc_zalazone" / "short_setting__handling_part14.csv")
    out = tmp_path / "out"
    assert run(words(out, scenario="trips", trips=file, policy="j2945", seeds="1", density="40")) == 0
    (row,) = json.loads((out / "summary.json").read_text())["runs"]
    assert row["density_per_km"] == 40.0
    assert row["vehicles"] == 12.0


@pytest.mark.parametrize(
    "error",
    [
        CodecError("no", 7),
        ConfigError("no"),
        DataFormatError("a.csv", "no", row=3, remedy="Yes."),
        MissingExtraError("Traffic", "sumo"),
    ],
)
def test_an_error_of_a_worker_process_arrives_as_it_was_raised(error: ModelcastError) -> None:
    back = pickle.loads(pickle.dumps(error))  # noqa: S301 - our own
    assert type(back) is type(error)
    assert str(back) == str(error)
    assert vars(back) == vars(error)


@pytest.mark.slow
def test_a_changed_file_gives_a_new_run_and_what_was_skipped_is_shown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = write_fcd(tmp_path, "csv"), tmp_path / "out"
    line = words(out, scenario=str(path), seeds="1", policy="j2945", duration="3")
    line.remove("--quiet")
    assert run(line) == 0
    assert "traffic.csv: 28 rows = 28 taken" in capsys.readouterr().out
    first = json.loads((out / "summary.json").read_text())
    assert first["traffic"]["rows"] == first["traffic"]["taken"] == 28
    text = path.read_text(encoding="utf-8")
    path.write_text(
        "".join(row for row in text.splitlines(keepends=True) if "car1" not in row), encoding="utf-8"
    )
    assert run(line) == 0
    second = json.loads((out / "summary.json").read_text())
    assert second["runs"][0]["vehicles"] < first["runs"][0]["vehicles"]
    assert second["inputs"] != first["inputs"]
    assert (out / "MANIFEST.txt").is_file()
    assert {item.name for item in tmp_path.iterdir()} == {"traffic.csv", "out"}


@pytest.mark.parametrize(
    ("scenario", "people", "told"),
    [("highway", "5", "go with --scenario grid or crossing"), ("grid", "-5", "at least 0")],
)
def test_people_go_with_the_grids_of_ours(
    scenario: str, people: str, told: str, capsys: pytest.CaptureFixture[str]
):
    assert run(["network", "--scenario", scenario, "--pedestrians", people, "--quiet"]) == USAGE
    assert told in " ".join(capsys.readouterr().err.split())


@pytest.mark.slow
def test_traces_are_a_folder_a_run_and_agree_with_its_rows(tmp_path: Path) -> None:
    out, traces = tmp_path / "out", tmp_path / "traces"
    assert run(words(out)) == 0  # done before: run again for the trace
    assert run([*words(out), "--trace", str(traces), "--trace-format", "parquet", "csv"]) == 0
    rows = json.loads((out / "summary.json").read_text())["runs"]
    names = {
        f"dsrc_{policy}_20_{number}" for policy in ("j2945_none", "j2945-mbc_default") for number in (0, 1)
    }
    assert {path.name for path in traces.iterdir()} == names
    bank = {"j2945": "none", "j2945-mbc": "default"}
    for row in rows:
        folder = traces / f"dsrc_{row['policy']}_{bank[row['policy']]}_20_{row['run']}"
        positions = pq.read_table(folder / "positions.parquet")
        sent = pq.read_table(folder / "transmissions.parquet")
        vehicle_s = 0.1 * (positions["t_s"].to_numpy() > 0.95).sum()
        assert (sent["t_s"].to_numpy() >= 1.0).sum() / vehicle_s == pytest.approx(
            row["message_rate_hz"], rel=0.02
        )
        assert (folder / "receptions.csv").is_file()


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--trace-format", "csv"], "--trace FOLDER"),
        (["--trace", "t", "--trace-format", "pcap"], "--trace-format must be of parquet"),
        (["--trace", "OUT/t"], "lies in --out"),
    ],
)
def test_traces_that_cannot_be_written_are_told_before_anything_runs(
    options: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = [word.replace("OUT", str(tmp_path / "out")) for word in options]
    assert run([*words(tmp_path / "out"), *given]) == USAGE
    assert told in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(not HAS_SUMO, reason="the extra sumo is not installed")
def test_a_configuration_of_sumo_runs_with_its_people(tmp_path: Path) -> None:
    network = junction_input(tmp_path / "town").network
    (tmp_path / "town" / "own.rou.xml").write_text(
        '<routes><vType id="two" vClass="bicycle"/><route id="across" edges="inE outW"/>'
        '<flow id="c" route="across" begin="0" end="60" period="3"/>'
        '<vehicle id="b" type="two" route="across" depart="0"/>'
        '<person id="p" depart="0"><walk edges="inS outN"/></person></routes>',
        encoding="utf-8",
    )
    path = tmp_path / "town" / "a.sumocfg"
    path.write_text(
        f'<configuration><input><net-file value="{network.name}"/><route-files value="own.rou.xml"/></input>'
        "</configuration>",
        encoding="utf-8",
    )
    given = [*words(tmp_path / "out", scenario=str(path), policy="mbc", lead_in="10"), "--persons"]
    assert run(given) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (summary["traffic"]["pedestrians"], summary["traffic"]["cyclists"]) == (1, 1)
    assert {"eclipse-sumo", "0 a.sumocfg"} <= set(summary["inputs"])
    assert sum("road.net.xml" in name or "own.rou.xml" in name for name in summary["inputs"]) == 2
    assert {row["run"] for row in summary["people"]} == {0, 1}


def test_a_lead_in_goes_with_a_configuration_of_sumo(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(words(tmp_path / "out", lead_in="10")) == USAGE
    assert "--lead-in goes with a .sumocfg" in capsys.readouterr().err
