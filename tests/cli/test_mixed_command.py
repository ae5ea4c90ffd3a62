"""Claims about ``modelcast mixed``: who is tracked by whom, the penetration map, what is refused."""

import json
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from modelcast.cli.app import USAGE, run

FLEET = """mixed --density 40 --length 500 --duration 8 --warm-up 2 --seeds 2 --jobs 1 --bank paper
    --threshold 0.1"""
POLICIES, SENDERS, RECEIVERS = "--policy baseline mbc", "--penetration 0 50 100", "--receivers 0 100"
LINE = f"{FLEET} {POLICIES} {SENDERS} {RECEIVERS}"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("mixed") / "out"
    assert run([*LINE.split(), "--out", str(out), "--quiet"]) == 0
    return out


def rows(folder: Path, name: str) -> list[dict[str, Any]]:
    return pq.read_table(folder / f"{name}.parquet").to_pylist()


@pytest.mark.slow
def test_every_pairing_of_every_run_has_a_row(folder: Path) -> None:
    found = rows(folder, "pairings")
    keys = [(row["senders_ratio"], row["run"], row["sender"], row["reading"]) for row in found]
    assert len(keys) == len(set(keys)) == 3 * 2 * 2 * 3
    for row in found:
        there = row["senders_ratio"] < 1.0 if row["sender"] == "baseline" else row["senders_ratio"] > 0.0
        assert (row["pairs"] > 0) == there
        if there:
            assert 0.0 < row["pte_p50_m"] <= row["pte_p90_m"] <= row["pte_p99_m"]
            assert row["message_rate_hz"] > 0.0


@pytest.mark.slow
def test_groups_are_parts_of_the_run(folder: Path) -> None:
    """At 50 % each sends for half of the vehicles; a run's rate is the mean of its groups' rates."""
    runs = {(row["policy"], row["run"]): row for row in rows(folder, "runs")}
    for one in (row for row in rows(folder, "pairings") if row["senders_ratio"] == 0.5):
        own = [
            row["message_rate_hz"]
            for row in rows(folder, "pairings")
            if (row["senders_ratio"], row["run"], row["reading"]) == (0.5, one["run"], one["reading"])
        ]
        whole = runs["baseline+mbc@50", one["run"]]["message_rate_hz"]
        assert min(own) <= whole <= max(own)


@pytest.mark.slow
def test_the_corners_of_the_map_are_pairings(folder: Path) -> None:
    pairings = {
        (row["senders_ratio"], row["run"], row["sender"], row["reading"]): row
        for row in rows(folder, "pairings")
    }
    found = {
        (row["senders_ratio"], row["receivers_ratio"], row["run"]): row for row in rows(folder, "penetration")
    }
    assert len(found) == 3 * 2 * 2
    for senders, sender in ((0.0, "baseline"), (1.0, "mbc")):
        for receivers, reading in ((0.0, "legacy"), (1.0, "model")):
            for number in (0, 1):
                for name in ("pte_p50_m", "pte_p90_m", "pte_p99_m"):
                    corner = pairings[senders, number, sender, reading][name]
                    assert found[senders, receivers, number][name] == pytest.approx(corner, rel=1e-3)


@pytest.mark.slow
def test_tables_figure_and_runs_are_written_and_taken_up_again(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert (folder / "penetration.svg").stat().st_size > 1000
    table = (folder / "pairings.md").read_text(encoding="utf-8")
    assert "| 40 | dsrc | 50 % | mbc | legacy |" in table
    assert len(list((folder / "runs").iterdir())) == 6
    capsys.readouterr()
    assert run([*LINE.split(), "--out", str(folder)]) == 0
    shown = capsys.readouterr()
    assert "6 runs (6 done before)" in shown.out + shown.err
    assert "mbc, legacy" in shown.out
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert summary["options"]["receivers_ratios"] == [0.0, 1.0]


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ("--policy mbc", "--policy must name two policies or more, each once, got mbc"),
        ("--policy mbc mbc", "--policy must name two policies or more"),
        ("--policy mbc nobody", "--policy: Unknown policy 'nobody'"),
        (f"{POLICIES} --penetration 120", "--penetration must be shares from 0 to 100 %, got 120"),
        (f"{POLICIES} --receivers -1", "--receivers must be shares from 0 to 100 %, got -1"),
    ],
)
def test_what_is_no_mixed_fleet_is_refused(
    options: str, text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([*FLEET.split(), *options.split(), "--out", str(tmp_path / "out")]) == USAGE
    assert text in " ".join(capsys.readouterr().err.split())
