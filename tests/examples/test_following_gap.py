"""The example of a safety application: installed as a package, it warns in every command that warns."""

import json

import pytest

NETWORK = (
    "-m", "modelcast", "network", "--scenario", "braking", "--density", "20", "--length", "1000",
    "--duration", "8", "--warm-up", "2", "--seeds", "1", "--jobs", "1", "--radio", "ideal", "--policy", "cam",
)  # fmt: skip


def test_it_warns_exactly_where_the_gap_is_below_its_time(python_with):
    """Of N pairs in a row: 20 m/s, a least gap of 0.8 s and cars of 4.5 m, so 16 m between bumpers."""
    script = """
import numpy as np
from modelcast import Motions
from following_gap import FollowingGap
gap_m = np.array([15.9, 16.1, 23.9, 24.1, 10.0, 10.0, -10.0])
place = np.stack([np.array([0, 0, 0, 0, 1.9, 0, 0]), gap_m + 4.5], axis=1)
heading = np.array([0, 0, 0, 0, 0, np.pi, 0])
host = Motions.of(np.zeros((7, 2)), speed_mps=20.0, heading_rad=0.0)
print(*FollowingGap().assess(host, Motions.of(place, speed_mps=20.0, heading_rad=heading)).level)
turned = Motions.of(np.zeros((7, 2)), speed_mps=20.0, heading_rad=np.pi / 2)
place, heading = np.stack([place[:, 1], -place[:, 0]], axis=1), heading + np.pi / 2
print(*FollowingGap().assess(turned, Motions.of(place, speed_mps=20.0, heading_rad=heading)).level)
"""
    said = python_with(("following_gap",), "-c", script).stdout.splitlines()
    assert said == ["2 1 1 0 0 0 0"] * 2


@pytest.mark.slow
def test_a_network_run_counts_its_warnings_and_names_its_package(python_with, tmp_path):
    asked = ("--application", "following-gap:least_s=0.9", "fcw", "--out", str(tmp_path / "out"), "--quiet")
    python_with(("following_gap",), *NETWORK, *asked)
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["inputs"]["application following-gap:least_s=0.9"] == "following-gap 1.0.0"
    assert {row["application"] for row in summary["warnings"]} == {"following-gap:least_s=0.9", "fcw"}
    assert "following-gap" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.slow
def test_a_safety_evaluation_takes_it_and_names_its_package(python_with, tmp_path):
    asked = (
        "-m", "modelcast", "safety", "--streams", "1", "--application", "following-gap", "--bank", "cv",
        "default", "--per", "0.4", "--burst", "0", "--sensors", "default", "--basis", "threshold", "--seeds",
        "1", "--resamples", "50", "--jobs", "1", "--out", str(tmp_path / "out"), "--quiet",
    )  # fmt: skip
    python_with(("following_gap",), *asked)
    run = json.loads((tmp_path / "out" / "run.json").read_text())
    assert run["versions"]["application following-gap"] == "following-gap 1.0.0"


def test_a_setting_it_has_not_is_refused_by_name(python_with):
    ended = python_with(("following_gap",), *NETWORK, "--application", "following-gap:gap=1", fails=True)
    assert "'following-gap' of following-gap refuses its settings" in ended.stderr
    assert "'gap'" in ended.stderr


def test_a_node_warns_by_it(python_with, tmp_path):
    script = """
import sys
from modelcast.node.building import applications_of
from modelcast.node.config import read_config
print(applications_of(read_config(sys.argv[1])))
"""
    place = tmp_path / "node.toml"
    place.write_text('[applications]\nnames = ["fcw", "following-gap:caution_s=2.0"]\n')
    assert (
        "FollowingGap(least_s=0.8, caution_s=2.0"
        in python_with(("following_gap",), "-c", script, str(place)).stdout
    )
    ended = python_with((), "-c", script, str(place), fails=True)
    assert "row 2: [applications] names[1] must be one of 'fcw', 'eebl', 'ima', 'vru'" in ended.stderr
