"""The example of a policy: installed as a package, it decides in the station, in networks and nodes."""

import json

import polars as pl
import pytest

NETWORK = (
    "-m", "modelcast", "network", "--density", "30", "--length", "800", "--duration", "12", "--warm-up", "2",
    "--seeds", "1", "--jobs", "1", "--radio", "ideal",
)  # fmt: skip


@pytest.mark.slow
def test_a_network_run_sends_by_it_at_each_threshold_and_names_its_package(python_with, tmp_path):
    out = tmp_path / "out"
    asked = (
        "--policy",
        "forecast",
        "forecast:ahead_s=0,threshold_m=0.05",
        "mbc",
        "--threshold",
        "0.05",
        "0.2",
    )
    python_with(("forecast_policy",), *NETWORK, *asked, "--out", str(out), "--quiet")
    summary = json.loads((out / "summary.json").read_text())
    assert summary["inputs"]["policy forecast"] == "forecast-policy 1.0.0"
    rows = pl.read_parquet(out / "runs.parquet")
    sent = {
        (policy, threshold): rate
        for policy, threshold, rate in rows.select("policy", "threshold_m", "message_rate_hz").iter_rows()
    }
    assert sent["forecast", 0.05] > sent["forecast", 0.2]
    alone = [rate for (policy, _), rate in sent.items() if policy.startswith("forecast:")]
    assert len(alone) == 1, "its word sets the threshold"
    assert alone[0] < sent["forecast", 0.05], "who looks ahead sends earlier"


@pytest.mark.slow
def test_a_station_of_its_own_and_a_node_send_by_it(python_with, tmp_path):
    place = tmp_path / "node.toml"
    place.write_text('[sending]\npolicy = "forecast:longest_s=0.5"\n')
    script = """
import sys
import modelcast
from modelcast.cli.node import sender_of_config
from modelcast.node.config import read_config
sender = sender_of_config(read_config(sys.argv[1]))
station = modelcast.Station(sender)
sent = [len(station.sense(0.1 * k, (1.5 * k, 0.0), speed_mps=15.0, heading_rad=1.5707963)) for k in range(41)]
print(sender.policy, sum(sent), sent[5::5])
"""
    said = python_with(("forecast_policy",), "-c", script, str(place)).stdout
    assert "Forecast(threshold_m=0.2, ahead_s=0.2, longest_s=0.5) 9 [1, 1, 1, 1, 1, 1, 1, 1]" in said


@pytest.mark.slow
def test_an_evaluation_and_a_comparison_are_driven_by_it(python_with, tmp_path):
    """Errors are forecast to grow, so it sends more often than the error-driven policy."""
    script = """
import sys
from modelcast.io.write_trips import write_csv
import modelcast
write_csv([modelcast.generate_drive(seed=0, duration_s=90.0).truth], sys.argv[1])
"""
    drive = tmp_path / "drive.csv"
    python_with((), "-c", script, str(drive))
    shared = ("--threshold", "0.3", "--per", "0.2", "--seeds", "1", "--no-references", "--quiet")
    rates: dict[str, float] = {}
    word = "forecast:longest_s=10"
    for name, sender, more in (("own", "mbc", ()), ("forecast", word, ("--policy", word))):
        out = tmp_path / name
        python_with(
            ("forecast_policy",), "-m", "modelcast", "evaluate", str(drive), *shared, *more, "--out", str(out)
        )
        rows = json.loads((out / "summary.json").read_text())["rates"]
        rates[name] = next(row["total_rate_hz"] for row in rows if row["policy"] == sender)
    assert rates["forecast"] > rates["own"]
    run = json.loads((tmp_path / "forecast" / "run.json").read_text())
    assert run["versions"]["policy forecast:longest_s=10"] == "forecast-policy 1.0.0"
    settings = json.loads((tmp_path / "forecast" / "summary.json").read_text())["settings"]
    assert settings["policy"] == "Forecast(threshold_m=0.2, ahead_s=0.2, longest_s=10)"
    compared = ("compare", str(drive), "--bank", "cv", "default", "--policy", "forecast", *shared)
    out = tmp_path / "compared"
    protocol = ("--protocol", "recorded", "--out", str(out))
    python_with(("forecast_policy",), "-m", "modelcast", *compared, *protocol)
    run = json.loads((out / "run.json").read_text())
    assert run["versions"]["policy forecast"] == "forecast-policy 1.0.0"
