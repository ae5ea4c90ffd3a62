"""A policy that another package brings, and what is told where it asks for what no station can do."""

import json
import warnings
from collections.abc import Callable
from pathlib import Path

import polars as pl
import pytest

import modelcast
from modelcast.cli.app import run
from modelcast.cli.evaluate_options import EvaluateOptions
from modelcast.study.rules import RIVALS

POLICY = """from dataclasses import dataclass

import numpy as np

from modelcast import AbstractTransmitPolicy, Decisions, MessageKind


@dataclass(frozen=True, slots=True)
class Wild(AbstractTransmitPolicy[None]):
    longest_silence_s: float = 1.0

    def init(self, vehicles, sub_models):
        return None

    def decide(self, state, inputs, rng):
        kind = np.full(inputs.t_s.shape, MessageKind.IDENTIFICATION)
        return Decisions.at_once(kind, np.full(kind.shape, -1), inputs.t_s), None
"""


@pytest.mark.filterwarnings("ignore:--policy wild has no threshold_m")
@pytest.mark.parametrize(
    "command",
    ["evaluate {trip} --per 0 --no-references", "network --density 5 --duration 2 --warm-up 1 --radio ideal"],
)
def test_policy_that_asks_for_the_impossible_ends_a_command_in_one_line(
    command: str, other_package: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other_package("wild", {"modelcast.policies": {"wild": "wild_policy:Wild"}}, {"wild_policy": POLICY})
    trip = tmp_path / "drive.csv"
    modelcast.write_csv([modelcast.generate_drive(seed=1, duration_s=90.0).truth], trip)
    words = command.format(trip=trip).split()
    assert run([*words, "--policy", "wild", "--seeds", "1", "--out", str(tmp_path / "out")]) != 0
    told = " ".join(capsys.readouterr().err.split())
    assert "modelcast: Wild: kind must be nothing, an update or a keep-alive, got 2" in told
    assert "Traceback" not in told


QUIET = POLICY.replace("IDENTIFICATION", "KEEP_ALIVE").replace("Wild", "Steady")
AT_THRESHOLD = QUIET.replace("Steady", "Held").replace(
    "    longest_silence_s", "    threshold_m: float = 0.2\n    longest_silence_s"
)


@pytest.mark.parametrize(
    ("word", "module", "told"),
    [
        ("steady", QUIET, "--policy steady has no threshold_m: it sends the same at every --threshold"),
        ("held", AT_THRESHOLD, ""),
    ],
)
def test_threshold_that_a_policy_does_not_take_is_told(
    word: str, module: str, told: str, other_package: Callable[..., Path]
) -> None:
    kind = word.capitalize()
    other_package(word, {"modelcast.policies": {word: f"{word}_policy:{kind}"}}, {f"{word}_policy": module})
    with warnings.catch_warnings(record=True) as met:
        warnings.simplefilter("always")
        settings = EvaluateOptions(policy=word, threshold=(0.2, 0.5)).settings()
    assert type(settings.decides).__name__ == kind
    assert [str(one.message).startswith(told) for one in met] == [True] * bool(told)


EVERY = """

@dataclass(frozen=True, slots=True)
class Every(Wild):
    every_s: float = 0.5

    def decide(self, state, inputs, rng):
        kind = np.where(inputs.silence_s >= self.every_s - 1e-9, MessageKind.UPDATE, MessageKind.NOTHING)
        return Decisions.at_once(kind, np.full(kind.shape, -1), inputs.t_s), None
"""
WORD = "every:every_s=0.5"


@pytest.fixture
def drive(other_package: Callable[..., Path], tmp_path: Path) -> Path:
    points = {"modelcast.policies": {"every": "every_policy:Every"}}
    other_package("every", points, {"every_policy": POLICY + EVERY})
    trip = tmp_path / "drive.csv"
    modelcast.write_csv([modelcast.generate_drive(seed=1, duration_s=90.0).truth], trip)
    return trip


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:--policy every")
def test_rows_console_report_and_trace_name_the_policy_that_decides(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    out, trace = tmp_path / "out", tmp_path / "trace.csv"
    words = [
        "evaluate",
        str(drive),
        "--per",
        "0",
        "0.4",
        "--threshold",
        "0.5",
        "--no-references",
        "--seeds",
        "1",
    ]
    assert run([*words, "--policy", WORD, "--out", str(out), "--trace", str(trace)]) == 0
    told = capsys.readouterr().out
    summary = json.loads((out / "summary.json").read_text())
    assert {row["policy"] for row in summary["rates"]} == {WORD, "baseline", "free"}
    assert {row["policy"] for row in summary["tracking"]} == {WORD, *RIVALS}
    assert set(pl.read_parquet(out / "events.parquet")["policy"].unique()) == {WORD, "baseline", "free"}
    rate_hz = {row["policy"]: row["total_rate_hz"] for row in summary["rates"] if row["trip"] == "all"}
    assert rate_hz[WORD] == pytest.approx(2.0, abs=0.05)
    html = (out / "report.html").read_text()
    assert f"{WORD} / baseline" in html
    assert f"at {WORD}" in html
    assert f"rate as {WORD}" in told
    for text in (told, html):
        assert f"{WORD}: a vehicle sends a small model of its motion" in text
        assert "MBC" not in text.replace("Which of MBC", "")
    assert f"{rate_hz[WORD]:.3g}" in told
    assert len(trace.read_text().splitlines()) > 100


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:--policy every")
def test_a_comparison_says_who_decides_for_its_candidates(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    words = ["compare", str(drive), "--per", "0", "--threshold", "0.5", "--no-references", "--seeds", "1"]
    assert run([*words, "--bank", "cv", "ctra", "--policy", WORD, "--out", str(out)]) == 0
    assert f"{WORD} decides when the candidates send" in " ".join(capsys.readouterr().out.split())
    assert "every_s=0.5 decides when the candidates send" in (out / "table.md").read_text()
    assert json.loads((out / "summary.json").read_text())["settings"]["decided_by"] == WORD
