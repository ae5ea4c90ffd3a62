"""Claims about the example sub-model in plain NumPy: installed, it works wherever a sub-model does."""

import json
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from modelcast.cli.app import USAGE, run
from modelcast.core.exceptions import ConfigError
from modelcast.io.profile import read_profile
from modelcast.io.write_trips import write_csv
from modelcast.world.drive import generate_drive

Run = Callable[..., subprocess.CompletedProcess[str]]
QUICK = ("--threshold", "0.3", "--per", "0", "--seeds", "1", "--quiet")
SMALL = ["--steps", "12", "--hidden", "8", "8", "--windows", "100", "--quiet"]


@pytest.fixture(scope="module", name="drive")
def _drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("drive") / "d1.csv"
    write_csv([replace(generate_drive(1, 90.0).truth, trip_id="d1/1")], path)
    return path


@pytest.fixture(scope="module", name="profile")
def _profile(drive: Path, python_with: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What ``train --bank chord+free`` writes."""
    pytest.importorskip("optax", reason="training needs the extra train")
    out = tmp_path_factory.mktemp("profile") / "chord.json"
    words = ["train", str(drive), "--bank", "chord+free", *SMALL, "--out", str(out)]
    python_with(("chord",), "-m", "modelcast", *words)
    return out


def test_it_is_known_by_its_name_alone_and_fits_as_it_says(python_with: Run) -> None:
    program = """
import modelcast, numpy as np
from modelcast.station.banks import bank_from_text, member_names
from modelcast_chord import Chord

bank = bank_from_text("chord+cv")
assert bank.members == (Chord(), modelcast.ConstantVelocity())
assert "chord" in member_names(modelcast.default_profile())
samples = np.zeros((1, 5, 7))
samples[0, :, 0] = [0.0, 1.0, 2.0, 3.0, 6.0]
model = bank.members[0]
found = model.fit(modelcast.Windows(samples, dt_s=0.5))
assert found.tolist() == [[3.0, 0.0]]
assert model.predict(found, np.array([0.5, 2.0]), dt_s=0.5).tolist() == [[[1.5, 0.0], [6.0, 0.0]]]
assert model.row_dependence(0.5) == ()
"""
    python_with(("chord",), "-c", program)


@pytest.mark.slow
def test_a_node_on_the_air_sends_and_holds_what_the_evaluation_does(python_with: Run) -> None:
    """Its predicted path goes through encoded messages to another node, which tracks as the evaluation."""
    program = """
from modelcast.node.agreement import node_agreement
from modelcast.station.banks import named_bank
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.study.evaluate import make_case
from modelcast.study.settings import EvaluationSettings
from modelcast.world.drive import generate_drive

case = make_case(generate_drive(4, 90.0).truth, EvaluationSettings())
found = node_agreement(case, named_bank("chord+cv").bank, ErrorDriven(0.2, "order", "on-failure"))
assert found.agrees and found.messages > 10, found
"""
    python_with(("chord",), "-c", program)


@pytest.mark.slow
def test_compiled_or_not_it_sends_the_same(python_with: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    program = """
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import bank_from_text
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.world.drive import generate_drive

drive = generate_drive(seed=3, duration_s=90.0).input
bank = bank_from_text("chord+cv").carried()
walk = TripRuntime(drive, bank, velocity_estimator_for(drive), quantised=True).run(ErrorDriven(0.3))
print(walk.kind.tolist(), walk.in_use.tolist())
"""
    compiled = python_with(("chord",), "-c", program).stdout
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    assert python_with(("chord",), "-c", program).stdout == compiled != ""


@pytest.mark.slow
def test_evaluate_and_compare_take_it(drive: Path, python_with: Run, tmp_path: Path) -> None:
    words = ["evaluate", str(drive), "--bank", "chord+cv", *QUICK, "--out", str(tmp_path / "one")]
    python_with(("chord",), "-m", "modelcast", *words)
    summary = json.loads((tmp_path / "one" / "summary.json").read_text())
    assert summary["settings"]["bank"] == "chord+cv"
    words = ["compare", str(drive), "--bank", "chord", "cv", *QUICK, "--out", str(tmp_path / "two")]
    python_with(("chord",), "-m", "modelcast", *words)
    assert "chord" in (tmp_path / "two" / "summary.json").read_text()


def test_another_process_fits_it_as_this_one_does(python_with: Run) -> None:
    program = """
from operator import methodcaller
import numpy as np
from modelcast.corpora.executors.processes import ProcessExecutor
from modelcast.models.base import Windows
from modelcast.station.banks import bank_from_text

chord, _ = bank_from_text("chord+cv").members
fit = methodcaller("fit", Windows(np.random.default_rng(0).normal(size=(3, chord.window, 7)), dt_s=0.1))
with ProcessExecutor(1).start() as crew:
    ((_, found),) = crew.as_done(fit, [chord])
print(np.array_equal(found, fit(chord)) and found.shape == (3, len(chord.parameter_names)))
"""
    assert python_with(("chord",), "-c", program).stdout == "True\n"


@pytest.mark.slow
def test_network_takes_it_in_other_processes(python_with: Run, tmp_path: Path) -> None:
    line = "network --density 20 --length 300 --warm-up 1 --duration 3 --seeds 2 --jobs 2 --threshold 0.1"
    more = "--radio dsrc --policy mbc --bank chord+cv --quiet --out"
    python_with(("chord",), "-m", "modelcast", *line.split(), *more.split(), str(tmp_path / "out"))
    rows = json.loads((tmp_path / "out" / "summary.json").read_text())["runs"]
    assert [row["bank"] for row in rows] == ["chord+cv"] * 2
    assert all(row["update_rate_hz"] > 0.0 for row in rows)


@pytest.mark.slow
def test_a_profile_names_its_package_and_version_and_is_used_as_any(
    drive: Path, profile: Path, python_with: Run, tmp_path: Path
) -> None:
    member = json.loads(profile.read_text())["members"][0]
    assert member == {
        "is": "registered",
        "name": "chord",
        "package": "modelcast-chord",
        "version": "0.1.0",
        "fields": {"samples": 5},
    }
    words = ["evaluate", str(drive), "--bank", str(profile), *QUICK, "--out", str(tmp_path / "out")]
    python_with(("chord",), "-m", "modelcast", *words)
    node = tmp_path / "node.toml"
    node.write_text(f'[sending]\nprofile = "{profile}"\nbank = "default"\n', encoding="utf-8")
    python_with(("chord",), "-m", "modelcast", "node", str(node), "--check")


@pytest.mark.slow
def test_messages_with_its_path_are_encoded_and_decoded(profile: Path, python_with: Run) -> None:
    program = f"""
import modelcast
from modelcast.messages.mbc_codec import UpdateCodec
from modelcast.messages.mbc_profile import WireProfile
from modelcast.messages.mbc_update import UpdateMessage

core = modelcast.BsmCore.from_values({{"message_count": 7, "temporary_id": 1, "yaw_rate_radps": 0.0}})
codec = UpdateCodec(WireProfile.of_profile(modelcast.read_profile({str(profile)!r})))
print(codec.encode(UpdateMessage(core, 0, carries_all=False, codes=((0, 3, -2, 1, 0, 4, 5, -6),))).hex())
"""
    digits = python_with(("chord",), "-c", program).stdout.strip()
    words = ["-m", "modelcast", "decode", digits, "--json", "--profile", str(profile)]
    shown = python_with(("chord",), *words).stdout.strip()
    assert "chord" in shown
    words = ["-m", "modelcast", "encode", shown, "--profile", str(profile)]
    assert python_with(("chord",), *words).stdout.strip() == digits


@pytest.mark.slow
def test_a_profile_without_the_package_is_refused_with_its_name(
    profile: Path, drive: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(ConfigError, match=r"\$\.members\[0\]: the sub-model 'chord' is of the package"):
        read_profile(profile)
    assert run(["evaluate", str(drive), "--bank", str(profile), "--quiet"]) == USAGE
    told = capsys.readouterr().err
    assert "'modelcast-chord', version '0.1.0', and no installed package registers it" in told


@pytest.mark.slow
def test_a_profile_of_another_version_or_package_is_told(
    profile: Path, python_with: Run, tmp_path: Path
) -> None:
    changed: dict[str, str] = {}
    for key, value in (("version", "9.9"), ("package", "other"), ("fields", {"samples": 1})):
        document = json.loads(profile.read_text())
        document["members"][0][key] = value
        changed[key] = str(tmp_path / f"{key}.json")
        Path(changed[key]).write_text(json.dumps(document), encoding="utf-8")
    program = f"""
import modelcast, pytest
with pytest.warns(UserWarning, match="of a profile is of modelcast-chord 9.9; modelcast-chord 0.1.0 is inst"):
    found = modelcast.read_profile({changed["version"]!r})
assert found == modelcast.read_profile({str(profile)!r})
with pytest.raises(modelcast.ModelcastError, match=r"members.0..package must be modelcast-chord, which regi"):
    modelcast.read_profile({changed["package"]!r})
with pytest.raises(modelcast.ModelcastError, match="refuses its settings: samples must be at least 2, got 1"):
    modelcast.read_profile({changed["fields"]!r})
"""
    python_with(("chord",), "-c", program)


def test_the_readme_runs(python_with: Run) -> None:
    text = (Path(__file__).parents[2] / "examples" / "chord" / "README.md").read_text()
    program = text.partition("```python\n")[2].partition("```")[0]
    assert "baseline" in python_with(("chord",), "-c", program).stdout


@pytest.mark.slow
def test_two_live_nodes_show_one_another_by_it(python_with: Run, tmp_path: Path) -> None:
    """Their sockets are real, their time is not: each shows the other by the sub-model and on its path."""
    trip = tmp_path / "drive.csv"
    write_csv([generate_drive(3, 90.0).truth], trip)
    program = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parents[2])!r})
import asyncio, io, socket
from pathlib import Path
import numpy as np
from modelcast.cli.node import sender_of_config
from modelcast.node.config import Air, Gnss, NodeConfig, Sending
from modelcast.node.journal import Journal
from modelcast.node.live import LiveNode
from modelcast.node.showing import Showing
from tests.node.test_live import VirtualClock, for_a_while, free_port
from tests.node.virtual_time import run_in_virtual_time

config = NodeConfig(
    air=Air(group="239.255.16.79", port=free_port(socket.SOCK_DGRAM)),
    gnss=Gnss(source="trip:" + {str(trip)!r}),
    sending=Sending(bank="chord+cv"),
)
one, other = (
    LiveNode(config, sender_of_config(config), Journal(io.StringIO(), lambda: 0.0), clock=VirtualClock())
    for _ in range(2)
)
run_in_virtual_time(for_a_while(one, other, seconds=10.0))
for own, its in ((one, other), (other, one)):
    shown = Showing(own.node).snapshot(own.state).remotes
    assert shown.vehicle.tolist() == [its.node.station.temporary_id]
    assert shown.names[shown.model[0]] == "chord", shown.names
    path_m = np.vstack([shown.position_m, shown.path_m[0]])
    assert np.isfinite(path_m).all()
    # It goes on along a line, at the mean velocity.
    steps_m = np.diff(shown.path_m[0], axis=0)
    assert np.abs(steps_m - steps_m[0]).max() < 0.3, steps_m
    (off_m,) = abs(shown.position_m - its.state.motion.position_m).max(axis=1)
    assert off_m < 1.0
    assert own.node.counts["receipt: accepted"] > 3
"""
    python_with(("chord",), "-c", program)
