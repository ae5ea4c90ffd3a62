"""The example of a policy: installed as a package, it decides in the station, in networks and nodes."""

import json

import polars as pl

NETWORK = (
    "-m", "modelcast", "network", "--density", "30", "--length", "800", "--duration", "12", "--warm-up", "2",
    "--seeds", "1", "--jobs", "1", "--radio", "ideal",
)  # fmt: skip


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
