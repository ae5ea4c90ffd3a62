"""The example of a radio: installed as a package, it carries a fleet."""

import json

import polars as pl
import pytest

NETWORK = (
    "-m", "modelcast", "network", "--density", "30", "--length", "1000", "--duration", "6", "--warm-up", "2",
    "--seeds", "1", "--jobs", "1", "--policy", "bsm-10hz", "--quiet",
)  # fmt: skip


@pytest.mark.slow
def test_a_network_run_over_it_loses_by_distance_alone(python_with, tmp_path):
    out = tmp_path / "out"
    radio = "disc:sure_m=100,range_m=300"
    python_with(("disc_radio",), *NETWORK, "--radio", radio, "ideal", "--out", str(out))
    summary = json.loads((out / "summary.json").read_text())
    assert summary["inputs"][f"radio {radio}"] == "disc-radio 1.0.0"
    assert [row["radio"] for row in summary["runs"]] == [radio, "ideal"]
    rows = pl.read_parquet(out / "outcomes.parquet").filter(pl.col("radio") == radio)
    near, far = rows.filter(pl.col("low_m") < 100), rows.filter(pl.col("low_m") >= 100)
    assert near["pairs"].sum() > 1000
    assert near["received_ratio"].to_list() == [1.0, 1.0]
    share = (far["received_ratio"] * far["pairs"]).sum() / far["pairs"].sum()
    assert abs(share - 0.5) < 0.1, "the chance falls evenly from 1 to 0"


@pytest.mark.slow
def test_its_runs_are_taken_up_again_by_the_same_version_alone(python_with, tmp_path):
    call = (*NETWORK[:-1], "--radio", "disc", "--out", str(tmp_path / "out"))
    assert "done before" not in python_with(("disc_radio",), *call).stdout
    assert "1 run (1 done before)" in python_with(("disc_radio",), *call).stdout


def test_without_the_package_the_radio_is_unknown(python_with):
    ended = python_with((), *NETWORK, "--radio", "disc", fails=True)
    told = "--radio: Unknown radio 'disc' (is dsrc meant?). Known: dsrc, sidelink, nr, abstract, ideal."
    assert told in ended.stderr
