"""Claims about ``--legacy-threshold``: the same option of three commands, off where nobody names it."""

import json
from pathlib import Path
from typing import Any

import pytest

from modelcast.cli.app import USAGE, run
from modelcast.io.write_trips import write_csv
from modelcast.world.drive import generate_drive

NETWORK = "network --density 30 --length 400 --duration 6 --warm-up 1 --seeds 1 --jobs 1 --policy mbc"
EVALUATE = "evaluate TRIP --threshold 0.3 --per 0 --seeds 1"


def summary(line: str, folder: Path, *options: str) -> dict[str, Any]:
    assert run([*line.split(), "--quiet", "--out", str(folder), *options]) == 0
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


@pytest.mark.slow
def test_a_network_pays_for_legacy_receivers_with_messages(tmp_path: Path) -> None:
    rates: list[float] = []
    for number, options in enumerate(((), ("--legacy-threshold", "0"), ("--legacy-threshold", "0.05"))):
        found = summary(NETWORK, tmp_path / str(number), "--keep-alive", "5", "--approach", "0", *options)
        rates.append(found["runs"][0]["message_rate_hz"])
        assert found["options"]["legacy_threshold_m"] == (0.05 if "0.05" in options else 0.0)
    assert rates[0] == rates[1] < 0.8 * rates[2]


@pytest.mark.slow
def test_an_evaluation_says_and_minds_the_threshold(tmp_path: Path) -> None:
    trip = tmp_path / "drive.csv"
    write_csv([generate_drive(seed=2, duration_s=90.0).input], trip)
    line = EVALUATE.replace("TRIP", str(trip))
    plain, minding = (
        summary(line, tmp_path / name, *more)
        for name, more in (("plain", ()), ("minding", ("--legacy-threshold", "0.3")))
    )
    assert plain["settings"]["legacy_threshold_m"] is None
    assert minding["settings"]["legacy_threshold_m"] == 0.3
    sent = [
        next(row["total_rate_hz"] for row in found["rates"] if row["policy"] == "mbc")
        for found in (plain, minding)
    ]
    assert sent[0] < sent[1]


def test_a_negative_threshold_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = [*NETWORK.split(), "--out", str(tmp_path / "out"), "--legacy-threshold", "-1"]
    assert run(given) == USAGE
    assert "legacy_threshold_m must be positive, got -1" in capsys.readouterr().err
