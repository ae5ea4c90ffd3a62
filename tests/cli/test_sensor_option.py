"""Claims about ``--sensor``, which evaluate, compare and network share."""

import json
from dataclasses import asdict
from pathlib import Path

import pytest

from modelcast.cli.app import USAGE, run
from modelcast.cli.evaluate_options import EvaluateOptions
from modelcast.cli.options import SensorOptions
from modelcast.cli.run_record import EvaluationRun, load_run, write_run
from modelcast.core.exceptions import ConfigError
from modelcast.io.write_trips import write_csv
from modelcast.trips.trajectory import Trajectory
from modelcast.world.drive import generate_drive
from modelcast.world.named_sensors import named_sensor

TRAFFIC = (
    "--density",
    "20",
    "--length",
    "300",
    "--duration",
    "1",
    "--warm-up",
    "0",
    "--seeds",
    "1",
    "--quiet",
)


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("drive") / "drive.csv"
    write_csv([generate_drive(seed=1, duration_s=90.0).truth], path)
    return str(path)


@pytest.mark.parametrize("command", ["evaluate", "compare", "network"])
def test_a_sensor_that_has_no_name_is_told_with_those_that_have(
    command: str, drive: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [command, *(TRAFFIC if command == "network" else (drive,)), "--sensor", "gps"]
    assert run([*words, "--out", str(tmp_path / "out")]) == USAGE
    assert "default, ideal, gnss, gnss-rtk, ins, phone" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["evaluate", "compare"])
def test_a_sensor_and_the_recorded_protocol_contradict_each_other(
    command: str, drive: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [command, drive, "--sensor", "gnss", "--protocol", "recorded", "--out", str(tmp_path / "out")]
    assert run(words) == USAGE
    assert "--protocol recorded the sender sees the log itself" in " ".join(capsys.readouterr().err.split())


def test_a_sensor_by_name_makes_sensor_of_auto_and_leaves_the_other_protocols() -> None:
    named, sizes = SensorOptions(sensor="default"), SensorOptions(latency=0.1)
    assert named.protocols(("auto", "recorded")) == ("sensor", "recorded")
    assert sizes.protocols(("auto", "recorded")) == ("auto", "recorded")


@pytest.mark.slow
def test_a_real_trip_is_truth_and_the_sender_sees_it_through_the_sensor(
    dynamic_trips: dict[str, Trajectory], tmp_path: Path
) -> None:
    """A clean log, which auto alone would give to the sender as it is; errors of the speed cost messages."""
    log = str(tmp_path / "log.csv")
    write_csv([next(iter(dynamic_trips.values()))], log)
    small = ("--threshold", "0.2", "--per", "0", "--seeds", "1", "--bank", "cv", "--no-references")
    sent: dict[str, int] = {}
    for name in ("ideal", "phone", None):
        out = tmp_path / str(name)
        named = () if name is None else ("--sensor", name)
        assert run(["evaluate", log, *small, *named, "--quiet", "--out", str(out)]) == 0
        summary = json.loads((out / "summary.json").read_text())
        trip = summary["trips"][0]
        assert trip["protocol"] == ("recorded" if name is None else "sensor")
        assert trip["conditioned"] is False
        sent[str(name)] = next(row["updates"] for row in summary["rates"] if row["policy"] == "mbc")
    assert sent["phone"] > 1.2 * sent["ideal"]


def test_an_evaluation_uses_the_sensor_and_can_be_repeated(drive: str, tmp_path: Path) -> None:
    small = ("--threshold", "0.3", "--per", "0", "--seeds", "1", "--bank", "cv", "--protocol", "sensor")
    out = tmp_path / "out"
    words = [drive, *small, "--sensor", "gnss", "--latency", "0", "--quiet", "--out", str(out)]
    assert run(["evaluate", *words]) == 0
    sensor = json.loads((out / "summary.json").read_text())["settings"]["sensor"]
    assert (sensor["slow_position_noise_m"], sensor["latency_s"]) == (0.5, 0.0)
    asked = json.loads((out / "run.json").read_text())["arguments"]["options"]
    assert EvaluateOptions.from_plain(asked).sensor == SensorOptions(sensor="gnss", latency=0.0)


def test_a_run_file_with_a_sensor_that_has_no_name_is_refused_by_field(drive: str, tmp_path: Path) -> None:
    asked = EvaluationRun(
        (Path(drive),), None, None, "*", EvaluateOptions(sensor=SensorOptions(sensor="gps"))
    )
    write_run(tmp_path, "evaluate", asked.arguments(), asked.inputs)
    with pytest.raises(ConfigError, match=r"\$\.arguments\.options\.sensor must be null or one of 'default'"):
        load_run(tmp_path / "run.json")


def test_options_from_before_sensors_had_names_mean_the_default_sensor() -> None:
    plain = {name: value for name, value in EvaluateOptions().as_plain().items() if name != "sensor"}
    found = EvaluateOptions.from_plain({**plain, "position_noise": 0.02})
    assert found.sensor == SensorOptions(position_noise=0.02)
    assert EvaluateOptions.from_plain(plain).settings().sensor == named_sensor("default")


@pytest.mark.slow
def test_a_fleet_uses_the_sensor(tmp_path: Path) -> None:
    tracked: list[str] = []
    for name in ("ideal", "phone"):
        out = tmp_path / name
        words = ["network", *TRAFFIC, "--policy", "mbc", "--radio", "abstract", "--jobs", "1"]
        assert run([*words, "--sensor", name, "--out", str(out)]) == 0
        sensor = json.loads((out / "summary.json").read_text())["options"]["sensor"]
        assert (sensor["sensor"], sensor["model"]) == (name, asdict(named_sensor(name)))
        tracked.append((out / "table.md").read_text())
    assert tracked[0] != tracked[1]
