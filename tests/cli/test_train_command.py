"""Claims about ``modelcast train`` and the banks that come from its profiles."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from modelcast.cli.app import run
from modelcast.cli.banks import bank_in_use
from modelcast.core.exceptions import ConfigError
from modelcast.io.profile import read_profile
from modelcast.io.write_trips import write_csv
from modelcast.models.profile import default_profile
from modelcast.world.drive import generate_drive

QUICK = ("--steps", "12", "--hidden", "8", "8", "--windows", "100")
NAMED = ("--bank", "learned+ctra", "--coefficients", "2")


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("drives")
    for seed in (1, 2):
        write_csv([replace(generate_drive(seed, 90.0).truth, trip_id=f"d{seed}/1")], folder / f"d{seed}.csv")
    return folder


@pytest.fixture(scope="module")
def profile(drives: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("profile") / "mine.json"
    assert run(["train", str(drives), *QUICK, "--out", str(out), "--quiet"]) == 0
    return out


@pytest.fixture(scope="module")
def extended(drives: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A profile whose messages carry coefficients, so that a sub-model may be named later."""
    out = tmp_path_factory.mktemp("profiles") / "extended.json"
    assert run(["train", str(drives), *QUICK, *NAMED, "--out", str(out), "--quiet"]) == 0
    return out


@pytest.mark.slow
def test_the_same_trips_and_options_give_the_same_bytes_and_the_record_is_shown(
    drives: Path, profile: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    again = tmp_path / "again.json"
    assert run(["train", str(drives), *QUICK, "--out", str(again)]) == 0
    assert again.read_bytes() == profile.read_bytes()
    shown = capsys.readouterr().out
    assert "Messages over the baseline's" in shown
    assert read_profile(profile).identity in shown.replace("\n", "")


@pytest.mark.slow
def test_an_evaluation_takes_bank_and_rules_from_the_file(
    drives: Path, profile: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    words = ["--bank", str(profile), "--threshold", "0.3", "--per", "0", "--seeds", "1", "--quiet"]
    assert run(["evaluate", str(drives / "d1.csv"), *words, "--out", str(out)]) == 0
    settings = json.loads((out / "summary.json").read_text())["settings"]
    read = read_profile(profile)
    assert settings["bank"] == read.bank.name
    assert (settings["start"], settings["identify"]) == (read.start, read.identify)
    asked = json.loads((out / "run.json").read_text())
    assert str(profile) in asked["inputs"]


@pytest.mark.slow
def test_it_prints_the_record(drives: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "p.json"
    assert run(["train", str(drives), *QUICK, "--out", str(out), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["sha256"] == read_profile(out).identity
    assert printed["figures"]["counted_on"] == "training trips"


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ([], "name at least one trip"),
        (["{drives}", "--out", "{drives}/none/p.json"], "its folder does not exist"),
        (["{drives}", "--trip", "nothing", "--out", "{drives}/p.json"], "no usable trip"),
        (["{drives}", *QUICK, "--bank", "learned+gp", "--out", "{drives}/p.json"], "named gp;"),
        (["{drives}", "--steps", "0", "--out", "{drives}/p.json"], "steps"),
        (["{drives}", "--windows", "0", "--out", "{drives}/p.json"], "at least 1, got 0"),
        (["{drives}", *QUICK, "--also", "gp", "--out", "{drives}/p.json"], "names families, free, learned"),
        (["{drives}", *QUICK, "--add", "free", "--out", "{drives}/p.json"], "itself trained with free"),
    ],
)
def test_mistakes_are_named(
    words: list[str], named: str, drives: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["train", *(word.format(drives=drives) for word in words)]) == 2
    assert named in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("cost", ["messages", "bytes", "airtime"])
def test_trained_rules_run_with_what_the_profile_holds(
    cost: str, drives: Path, extended: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    words = ["--bank", str(extended), "--threshold", "0.3", "--per", "0", "--seeds", "1", "--quiet"]
    rules = ["--start", "predicted", "--identify", "cheapest", "--cost", cost]
    assert run(["evaluate", str(drives / "d1.csv"), *words, *rules, "--out", str(out)]) == 0
    settings = json.loads((out / "summary.json").read_text())["settings"]
    assert settings["selector"]["members"] == [member.name for member in read_profile(extended).bank.members]
    update, identification = (settings["costs"][name] for name in ("update_cost", "identification_cost"))
    assert (update == identification) == (cost == "messages")


def test_trained_rules_are_refused_where_nothing_was_trained(
    drives: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["compare", str(drives), "--bank", "paper", "--rules", "predicted/never"]
    assert run([*words, "--out", str(tmp_path / "out")]) == 2
    assert "has nothing trained for it" in capsys.readouterr().err


def test_a_file_that_is_no_profile_is_named(tmp_path: Path) -> None:
    path = tmp_path / "wrong.json"
    with pytest.raises(ConfigError, match=r"wrong\.json cannot be read"):
        bank_in_use(str(path), profile=default_profile())
    path.write_text("{}")
    with pytest.raises(ConfigError, match=r"wrong\.json is no profile"):
        bank_in_use(str(path), profile=default_profile())


def test_a_profiles_bank_takes_no_window_of_the_users() -> None:
    with pytest.raises(ConfigError, match="leave out --window"):
        bank_in_use("default", profile=default_profile(), window=12)
