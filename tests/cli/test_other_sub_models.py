"""Sub-models that other packages bring: who they are is told in results, and keeps finished runs apart."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import modelcast
from modelcast.cli.app import run
from modelcast.cli.banks import bank_in_use, profile_in_use
from modelcast.core.open_group import registered
from modelcast.io.profile import write_profile
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.profile import Profile
from modelcast.models.sub_models import registered_model, sub_model_origins
from modelcast.models.trusted import Trusted

MODULE = """from dataclasses import dataclass
from tests.models.numpy_models import Coasting

@dataclass(frozen=True, slots=True)
class Rolling(Coasting):
    name = "rolling"
"""
NETWORK = "network --density 10 --length 400 --duration 3 --warm-up 1 --radio ideal --policy mbc --seeds 1"
ROLLING = {"sub-model rolling": "wheels 1.2"}


@pytest.fixture
def wheels(other_package: Callable[..., Path]) -> Path:
    return other_package(
        "wheels", {"modelcast.sub_models": {"rolling": "wheels_models:Rolling"}}, {"wheels_models": MODULE}
    )


@pytest.fixture
def profile(wheels: Path, tmp_path: Path) -> Path:
    """A profile whose bank has the other package's sub-model, with a trusted horizon."""
    assert wheels.is_dir()
    bank = Bank((Trusted(registered_model("rolling"), 2.0), ConstantVelocity()), "rolled")
    path = tmp_path / "rolled.json"
    write_profile(Profile(bank), path)
    return path


def raised(wheels: Path) -> None:
    """Give the package another version."""
    old = wheels / "wheels-1.2.dist-info"
    (old / "METADATA").write_text("Metadata-Version: 2.1\nName: wheels\nVersion: 1.3\n")
    old.rename(wheels / "wheels-1.3.dist-info")
    registered.cache_clear()


def versions(folder: Path) -> dict[str, Any]:
    found = json.loads((folder / "run.json").read_text())["versions"]
    return {name: one for name, one in found.items() if name.startswith("sub-model")}


@pytest.fixture
def trip(tmp_path: Path) -> Path:
    path = tmp_path / "drive.csv"
    modelcast.write_csv([modelcast.generate_drive(seed=1, duration_s=90.0).truth], path)
    return path


def test_a_wrapped_sub_model_is_told_and_no_other_package_is_loaded(
    profile: Path, other_package: Callable[..., Path]
) -> None:
    other_package("wreck", {"modelcast.sub_models": {"sunk": "no_such_module:Sunk"}})
    assert sub_model_origins(profile_in_use(profile).bank.members) == ROLLING
    assert sub_model_origins(bank_in_use("paper", profile=profile_in_use(None)).bank.members) == {}


@pytest.mark.slow
@pytest.mark.parametrize("bank", ["rolling+cv", "rolled.json", "default"])
@pytest.mark.parametrize("command", ["evaluate --no-references", "compare --no-references"])
def test_results_over_recorded_trips_name_the_package(
    command: str, bank: str, profile: Path, trip: Path, tmp_path: Path
) -> None:
    name, *more = command.split()
    banks = [str(profile) if bank == "rolled.json" else bank]
    words = [name, str(trip), *more, "--per", "0", "--seeds", "1", "--threshold", "0.5", "--bank", *banks]
    words += ["--profile", str(profile)] if bank == "default" else []
    assert run([*words, "--quiet", "--out", str(tmp_path / "out")]) == 0
    assert versions(tmp_path / "out") == ROLLING


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:The sub-model rolling of a profile")
@pytest.mark.parametrize("how", ["bank", "profile", "people"])
def test_a_run_with_another_version_of_the_package_is_not_taken_up_and_says_why(
    how: str, profile: Path, wheels: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = {
        "bank": ["--bank", "rolling+cv"],
        "profile": ["--bank", "default", "--profile", str(profile)],
        "people": [
            "--scenario",
            "crossing",
            "--pedestrians",
            "2",
            "--bank",
            "cv",
            "--people-bank",
            "rolling+cv",
        ],
    }[how]
    line = [*NETWORK.split(), *words, "--jobs", "1", "--out", str(tmp_path / "out")]
    assert run(line) == 0
    assert run(line) == 0
    assert "1 run (1 done before)" in capsys.readouterr().out
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert ROLLING.items() <= summary["inputs"].items()
    raised(wheels)
    assert run(line) == 0
    told = capsys.readouterr().out
    assert "done before" not in told
    assert "1 run is not taken up again: sub-model rolling was wheels 1.2, is wheels 1.3\n" in told
