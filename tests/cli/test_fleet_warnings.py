"""Claims about warnings in ``modelcast network`` and ``modelcast mixed``."""

import json
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from modelcast.cli.app import USAGE, run

STREAMS = """--scenario braking --density 60 --length 600 --duration 25 --warm-up 3 --seeds 2 --jobs 1
    --application fcw --threshold 0.5 --bank paper"""
NETWORK = f"network {STREAMS} --policy bsm-10hz baseline --radio ideal dsrc"
MIXED = f"mixed {STREAMS} --policy baseline mbc --penetration 0 100 --receivers 0 50 100"


@pytest.fixture(scope="module")
def network(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("network") / "out"
    assert run([*NETWORK.split(), "--out", str(out), "--quiet"]) == 0
    return out


@pytest.fixture(scope="module")
def mixed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("mixed") / "out"
    assert run([*MIXED.split(), "--out", str(out), "--quiet"]) == 0
    return out


def pooled(folder: Path) -> list[dict[str, Any]]:
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))["warnings"]


@pytest.mark.slow
def test_all_policies_and_radios_meet_the_same_true_warnings(network: Path) -> None:
    rows = pq.read_table(network / "warned_events.parquet").to_pylist()
    by_case: dict[tuple[str, str], list[tuple[Any, ...]]] = {}
    for row in rows:
        key = (row["radio"], row["policy"])
        by_case.setdefault(key, []).append(tuple(row[name] for name in ("run", "host", "remote", "t_s")))
    assert len(by_case) == 4
    assert len({tuple(events) for events in by_case.values()}) == 1
    assert len(next(iter(by_case.values()))) >= 10


@pytest.mark.slow
def test_ten_messages_a_second_without_losses_miss_least(network: Path) -> None:
    found = {(row["radio"], row["policy"]): row for row in pooled(network)}
    floor = found["ideal", "bsm-10hz"]
    assert all(floor["missed_ratio"] <= row["missed_ratio"] for row in found.values())
    assert floor["missed_over"] == 1.0
    assert found["ideal", "baseline"]["missed_over"] == pytest.approx(
        found["ideal", "baseline"]["missed_ratio"] / floor["missed_ratio"]
    )


@pytest.mark.slow
def test_totals_hosts_and_events_are_the_same_counts(network: Path) -> None:
    totals = pq.read_table(network / "warnings.parquet").to_pylist()
    assert len(totals) == 2 * 2 * 2
    for total in totals:
        keys = ("radio", "policy", "run")
        for name, columns in (
            ("warned_hosts", ("negatives", "false", "false_warnings")),
            ("warned_events", ("positives", "missed")),
        ):
            own = [
                row
                for row in pq.read_table(network / f"{name}.parquet").to_pylist()
                if all(row[key] == total[key] for key in keys)
            ]
            for column in columns:
                assert sum(row[column] for row in own) == total[column]


@pytest.mark.slow
def test_the_report_shows_them_and_runs_are_taken_up_again(
    network: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = (network / "report.html").read_text(encoding="utf-8")
    assert "<h2>Warnings</h2>" in page
    assert 'src="warnings.svg"' in page
    assert (network / "warnings.svg").stat().st_size > 1000
    assert "| fcw | 60 | ideal | bsm-10hz |" in (network / "table.md").read_text(encoding="utf-8")
    before = (network / "summary.json").read_bytes()
    assert run([*NETWORK.split(), "--out", str(network)]) == 0
    shown = capsys.readouterr()
    assert "8 done before" in shown.err + shown.out
    assert "fcw, 60/km:" in shown.out
    assert (network / "summary.json").read_bytes() == before


@pytest.mark.slow
def test_every_reading_of_a_mixed_fleet_meets_the_same_warnings(mixed: Path) -> None:
    rows = [row for row in pooled(mixed) if row["sender"] == "all"]
    assert {(row["policy"], row["reading"]) for row in rows} == {
        (policy, reading)
        for policy in ("baseline+mbc@0", "baseline+mbc@100")
        for reading in ("legacy", "free", "model")
    }
    assert len({row["events"] for row in rows}) == 1
    found = {(row["policy"], row["reading"]): row for row in rows}
    # Who sends by constant velocity is read alike by those who know models and those who do not.
    alike = [found["baseline+mbc@0", reading]["missed_ratio"] for reading in ("legacy", "model")]
    assert alike[0] == alike[1]
    assert found["baseline+mbc@0", "legacy"]["missed_over"] == 1.0
    page = (mixed / "report.html").read_text(encoding="utf-8")
    for name in ("penetration", "warned_map"):
        assert f'src="{name}.svg"' in page
        assert (mixed / f"{name}.svg").stat().st_size > 1000


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--application cow", "Unknown application 'cow'"),
        ("--application eebl --algorithm knipling", "goes with --application fcw"),
        ("--algorithm knipling", "goes with --application fcw"),
        ("--application fcw --algorithm cow", "Unknown forward collision warning 'cow'"),
        ("--application fcw --against cam", "--against cam: no run has that policy; there are baseline"),
    ],
)
def test_what_does_not_go_together_is_told(
    words: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = f"network --policy baseline --seeds 1 --duration 2 --warm-up 1 {words}"
    assert run([*line.split(), "--out", str(tmp_path / "out")]) == USAGE
    assert said in " ".join(capsys.readouterr().err.split())
