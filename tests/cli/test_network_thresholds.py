"""Claims about several thresholds in ``modelcast network``: who runs with each, what is written."""

import json
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from modelcast.cli.app import USAGE, run

SENDERS = [("baseline", "none"), ("mbc", "paper")]


def words(out: Path, thresholds: str, more: str = "") -> list[str]:
    line = f"""network --density 30 --length 400 --duration 4 --warm-up 1 --seeds 1 --jobs 1 --bank paper
        --keep-alive 2 --approach 0
        --policy j2945 baseline mbc --threshold {thresholds} {more}"""
    return [*line.split(), "--out", str(out)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("thresholds") / "out"
    assert run([*words(out, "0.4 0.05 0.4"), "--quiet"]) == 0
    return out


@pytest.fixture(scope="module")
def summary(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "summary.json").read_text())


@pytest.mark.slow
def test_error_driven_senders_run_once_a_threshold_and_timers_once(summary: dict[str, Any]) -> None:
    asked = [("baseline", 0.05), ("baseline", 0.4), ("j2945", None), ("mbc", 0.05), ("mbc", 0.4)]
    assert [(row["policy"], row["threshold_m"]) for row in summary["runs"]] == asked


@pytest.mark.slow
def test_a_threshold_that_is_wider_calls_for_fewer_messages_of_the_same_traffic(
    summary: dict[str, Any],
) -> None:
    by_case = {(row["policy"], row["threshold_m"]): row for row in summary["runs"]}
    for policy in ("baseline", "mbc"):
        narrow, wide = by_case[policy, 0.05], by_case[policy, 0.4]
        assert narrow["vehicles"] == wide["vehicles"]
        assert narrow["message_rate_hz"] > 1.2 * wide["message_rate_hz"]


@pytest.mark.slow
def test_the_threshold_is_a_column_of_every_table(folder: Path, summary: dict[str, Any]) -> None:
    for name in ("runs", "distances", "outcomes", "seconds"):
        rows = pq.read_table(folder / f"{name}.parquet", columns=["policy", "threshold_m"]).to_pylist()
        by_policy = {
            policy: {row["threshold_m"] for row in rows if row["policy"] == policy} for policy, _ in SENDERS
        }
        assert by_policy == {"baseline": {0.05, 0.4}, "mbc": {0.05, 0.4}}
    assert {row["threshold_m"] for row in summary["pooled"]} == {0.05, 0.4, None}
    assert "threshold_m" not in summary["options"]
    table = (folder / "table.md").read_text(encoding="utf-8")
    assert "| radio | policy | threshold | seeds |" in table
    assert "| mbc | 5 cm | 1 |" in table
    assert "| j2945 | - | 1 |" in table


@pytest.mark.slow
def test_a_threshold_is_added_to_what_is_done(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = {path: path.stat().st_mtime_ns for path in (folder / "runs").iterdir()}
    assert run(words(folder, "0.4 0.2")) == 0
    senders = "3 senders (j2945; baseline; mbc with paper)"
    told = f"5 runs (3 done before): 1 density, 1 radio, 1 seed, 2 thresholds, {senders}"
    text = capsys.readouterr().out
    assert text.startswith(f"{told}\n")
    assert "mbc, 40 cm" in text
    after = {path: path.stat().st_mtime_ns for path in (folder / "runs").iterdir()}
    assert len(after) == 7
    assert before.items() <= after.items()


@pytest.mark.slow
@pytest.mark.parametrize(("start", "runs"), [("recent", 4), ("hindsight", 5), ("predicted", 5)])
def test_timers_run_once_a_threshold_where_their_start_rule_judges_by_it(
    start: str, runs: int, tmp_path: Path
) -> None:
    policies = ["--policy", "j2945", "j2945-mbc", "baseline", "--start", start, "--bank", "default", "--json"]
    line = words(tmp_path / "out", "0.05 0.4", "--quiet")
    place = line.index("--policy")
    del line[place : place + 4], line[line.index("--bank") : line.index("--bank") + 2]
    assert run([*line, *policies]) == 0
    rows = json.loads((tmp_path / "out" / "summary.json").read_text())["runs"]
    assert len(rows) == runs


@pytest.mark.parametrize("thresholds", ["0", "-0.1", "nan", "inf", "0.2 0"])
def test_a_threshold_that_is_none_is_told(
    thresholds: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(words(tmp_path / "out", thresholds)) == USAGE
    assert "--threshold" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
