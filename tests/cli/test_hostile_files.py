"""Claims about profiles and run files from strangers: refused by name, or they run; nothing else."""

import json
import os
import random
import runpy
import subprocess
import sys
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from modelcast.cli.app import run
from modelcast.cli.evaluate_options import EvaluateOptions
from modelcast.cli.option_rules import OPTIONS
from modelcast.cli.options import SensorOptions
from modelcast.cli.run_record import load_run
from modelcast.core.exceptions import ConfigError
from modelcast.io.profile import read_profile
from modelcast.io.trips import read_trips
from modelcast.io.write_trips import write_csv, write_parquet
from modelcast.models.profile import default_profile, profile_from_text
from modelcast.report.console import training_lines
from modelcast.station.banks import PAPER_BANK
from modelcast.study.evaluate import evaluate
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.fingerprint import fingerprint
from modelcast.world.drive import generate_drive

FUZZ = Path(__file__).parents[2] / "fuzz"
HOSTILE = runpy.run_path(str(FUZZ / "hostile.py"))
mutant: Callable[[Any, random.Random], bytes] = runpy.run_path(str(FUZZ / "mutating.py"))["mutant"]
check_profile, check_run = HOSTILE["check_profile"], HOSTILE["check_run"]
SMALL, SHIPPED = HOSTILE["profile_documents"]()


@settings(derandomize=True, max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(seed=st.integers(0, 2**32))
def test_a_mutated_profile_is_refused_by_name_or_is_one(
    seed: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "mutant-profile.json"
    path.write_bytes(mutant(SMALL, random.Random(seed)))  # noqa: S311
    check_profile(path, runs=False)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:--threshold")  # a mutated one may look like centimetres
@settings(derandomize=True, max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(seed=st.integers(0, 2**32))
def test_a_mutated_run_file_is_refused_by_name_or_is_one(
    seed: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.getbasetemp()
    path = folder / "mutant-run.json"
    path.write_bytes(mutant(HOSTILE["run_document"](folder), random.Random(seed)))  # noqa: S311
    check_run(path, folder / "out", runs=False)


@pytest.mark.slow
def test_mutants_run_in_a_process_of_their_own_without_a_fault(tmp_path: Path) -> None:
    """A segmentation fault ends that process, not this one, and counts."""
    command = [
        sys.executable,
        "-W",
        "ignore",
        str(FUZZ / "profiles.py"),
        "--mutants",
        "60",
        "--runs-every",
        "3",
    ]
    done = subprocess.run(  # noqa: S603 - our own script
        [*command, "--seconds", "400", "--keep", str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 faults" in done.stdout


def changed(path: list[Any], value: Any) -> dict[str, Any]:
    document = json.loads(json.dumps(SHIPPED))
    holder = document
    for key in path[:-1]:
        holder = holder[key]
    holder[path[-1]] = value
    return document


@pytest.mark.parametrize(
    ("path", "value", "named"),
    [
        (
            ["shelf", 2, "velocities"],
            1_000_000,
            "$.shelf[2].velocities must be true or false, got 1000000",
        ),
        (["shelf", 2, "velocities"], 2, "$.shelf[2].velocities must be true or false, got 2"),
        (["shelf", 1, "lags"], 10**9, "$.shelf[1].lags must be a whole number from 10 to 100"),
        (["shelf", 1, "lags"], 15, "$.shelf[1].networks[0] must be a network with "),
        (["shelf", 1, "time_scale_s"], True, "$.shelf[1].time_scale_s must be a number"),
        (["shelf", 2, "samples"], 10.0, "$.shelf[2].samples must be a whole number"),
        (["shelf", 2, "label"], 7, "$.shelf[2].label must be a text"),
        (["members", 2, "model", "jerk_spread_mps3"], "inf", "$.members[2].model.jerk_spread_mps3 must be"),
        (["members", 2, "mass_kg"], 1, "$.members[2]: Trusted has no field 'mass_kg'"),
        (["members", 0, "estimates", 0, "reports"], 16, "$.members[0].estimates[0].reports must be a whole"),
        (["members", 1, "turn_s"], -1.0, "$.members[1].turn_s must be a number from 0"),
        (["selector", "margin"], None, "$.selector.margin must be a number"),
        (["calibrations", "cv", "factors", 3, 1], "2", "$.calibrations.cv.factors[3][1] must be a number"),
        (["costs", "residual_life_s", 0], [], "$.costs.residual_life_s"),
        (["start"], "fastest", "$.start must be one of"),
        (["schema"], 2, "made by a newer modelcast"),
        (["schema"], 0, "$.schema must be a whole number from 1"),
        (["record", "seed"], 1e300, "$.record.seed must be a number of at most"),
    ],
)
def test_a_wrong_field_is_named_by_file_path_value_and_what_was_expected(
    path: list[Any], value: Any, named: str, tmp_path: Path
) -> None:
    file = tmp_path / "wrong.json"
    file.write_text(json.dumps(changed(path, value)))
    with pytest.raises(ConfigError) as refusal:
        read_profile(file)
    assert named in str(refusal.value)
    assert str(file) in str(refusal.value)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("[" * 100_000, "deep"),
        ('{"schema":NaN}', "finite"),
        ('{"schema":1,"schema":1}', "stand once"),
        ('{"schema":' + "9" * 5000 + "}", "no JSON"),
        (" " * (1 << 24) + " ", "octets"),
        ("[" + "0," * 1_000_001 + "0]", "values"),
        ('{"a\\u001b[2J":1}', "control characters"),
    ],
)
def test_a_text_beyond_measure_is_refused_before_it_is_parsed(text: str, named: str, tmp_path: Path) -> None:
    file = tmp_path / "wrong.json"
    file.write_text(text)
    with pytest.raises(ConfigError, match=named):
        read_profile(file)


def test_only_ordinary_files_are_opened(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.json"
    os.mkfifo(pipe)
    for path, named in ((pipe, "a pipe"), (tmp_path, "a folder"), (Path("/dev/zero"), "a device")):
        for read in (read_profile, load_run):
            with pytest.raises(ConfigError, match=named):
                read(path)


@pytest.mark.parametrize(
    ("paths", "inputs", "named"),
    [
        (["/dev/zero"], {}, "is new since"),
        (["/dev/zero"], {"/dev/zero": 0}, "a device, not a file"),
        (["/usr"], {}, "is new since"),
        (["x" * 1000], {}, "is new since"),
        ([".."], {}, "is new since"),
        (["gone.csv"], {"gone.csv": 3}, "is missing"),
        (["{giant}"], {"{giant}": 5}, "had 5 octets, now"),
        (["{giant}"], {"{giant}": 10_000_000_000, "/etc/hostname": 3}, "do not name it"),
        ([1], {}, "$.arguments.paths[0] must be a text"),
        ([], {}, "$.arguments.paths must be a list of 1"),
    ],
)
def test_a_foreign_run_file_opens_nothing_that_it_did_not_record(
    paths: list[Any], inputs: dict[str, int], named: str, tmp_path: Path
) -> None:
    giant = tmp_path / "giant.csv"
    with giant.open("wb") as file:
        file.truncate(10_000_000_000)  # sparse: it takes no room, and hashing it would take a minute
    document = HOSTILE["run_document"](tmp_path)
    document["arguments"]["paths"] = [
        path.format(giant=giant) if isinstance(path, str) else path for path in paths
    ]
    document["inputs"] = {
        name.format(giant=giant): {"bytes": size, "sha256": "0" * 64} for name, size in inputs.items()
    }
    place = tmp_path / "foreign.json"
    place.write_text(json.dumps(document))
    with pytest.raises(ConfigError) as refusal:
        load_run(place)
    assert named in str(refusal.value)


@pytest.mark.parametrize(("schema", "named"), [(1, "made by an older"), (3, "made by a newer")])
def test_another_schema_of_a_run_file_is_refused_by_name(schema: int, named: str, tmp_path: Path) -> None:
    place = tmp_path / "other.json"
    place.write_text(json.dumps({**HOSTILE["run_document"](tmp_path), "schema": schema}))
    with pytest.raises(ConfigError, match=named):
        load_run(place)


def test_every_option_has_a_rule() -> None:
    names = {item.name for kind in (EvaluateOptions, SensorOptions) for item in fields(kind)}
    assert {*OPTIONS.needed, *OPTIONS.others} == names


def test_training_fails_before_it_begins_where_its_file_cannot_be_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    trip = tmp_path / "drive.csv"
    write_csv([generate_drive(seed=1, duration_s=90.0).truth], trip)
    missing = str(tmp_path / "no" / "p.json")
    for out, named in (
        (str(tmp_path), "is a folder"),
        (missing, "does not exist"),
        (str(trip), "which is never replaced"),
    ):
        assert run(["train", str(trip), "--out", out, "--quiet"]) == 2
        assert named in capsys.readouterr().err
    assert [item.name for item in tmp_path.iterdir()] == ["drive.csv"]


def test_a_trip_is_known_again_by_its_samples_whatever_its_name_and_format(tmp_path: Path) -> None:
    drive = generate_drive(seed=2, duration_s=90.0).truth
    write_csv([drive], tmp_path / "renamed.csv")
    write_parquet([replace(drive, trip_id="other")], tmp_path / "other.parquet")
    read = list(read_trips([tmp_path / "renamed.csv", tmp_path / "other.parquet"]))
    assert {fingerprint(trip) for trip in (*read, drive)} == {fingerprint(drive)}
    assert fingerprint(generate_drive(seed=3, duration_s=90.0).truth) != fingerprint(drive)


def test_a_run_on_a_training_trip_says_so() -> None:
    drive = generate_drive(seed=2, duration_s=90.0).truth
    asked = EvaluationSettings((0.5,), (), references=False, bank=PAPER_BANK)
    assert not training_lines(evaluate([drive], asked))
    told = training_lines(evaluate([drive], replace(asked, trained_on=frozenset({fingerprint(drive)}))))
    assert "1 of these 1 trips" in told[0]


def test_the_shipped_profile_names_its_50_trips_and_kept_its_identity() -> None:
    profile = default_profile()
    assert len(set(profile.training_trips)) == len(profile.record["trips"]) == 50
    assert profile_from_text(replace(profile, training_trips=()).text).identity == profile.identity


@pytest.mark.parametrize(
    ("bank", "said"),
    [("learned+gp-nothing", "no sub-model is named gp-nothing"), ("cv+" * 8 + "cv", "at most 6")],
)
def test_a_bank_that_no_profile_can_hold_is_refused_before_training(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], bank: str, said: str
) -> None:
    """The trips are not even read: they do not exist."""
    assert run(["train", str(tmp_path / "no.csv"), "--out", str(tmp_path / "p.json"), "--bank", bank]) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "p.json").exists()
