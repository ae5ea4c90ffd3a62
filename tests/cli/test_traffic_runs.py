"""Claims about the traffic runs: they are those of ``modelcast network``, and are taken up by either."""

from pathlib import Path

import pytest

from modelcast.cli.app import run
from modelcast.cli.traffic_runs import TrafficResult, run_traffic
from modelcast.study.network.densities import TrafficPlan

SMALL = TrafficPlan(
    densities_per_km=(30.0,),
    radios=("dsrc", "sidelink"),
    thresholds_m=(0.05, 0.2),
    seeds=2,
    duration_s=4.0,
    warm_up_s=1.0,
    length_m=400.0,
)
SAME = """network --density 30 --radio dsrc sidelink --policy baseline mbc --bank paper --threshold 0.05 0.2
    --keep-alive 2 --approach 0 --duration 4 --warm-up 1 --length 400 --jobs 1 --quiet"""


@pytest.fixture(scope="module")
def traffic(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, TrafficResult, list[tuple[int, int]]]:
    out, steps = tmp_path_factory.mktemp("traffic") / "out", list[tuple[int, int]]()
    found = run_traffic(out, SMALL, jobs=1, progress=lambda done, whole: steps.append((done, whole)))
    return out, found, steps


Traffic = tuple[Path, TrafficResult, list[tuple[int, int]]]


@pytest.mark.slow
def test_every_run_of_the_plan_is_made_and_told(traffic: Traffic) -> None:
    _, found, steps = traffic
    assert len(found.network.runs) == SMALL.runs == 16
    assert steps == [(done, 16) for done in range(17)]


@pytest.mark.slow
def test_the_hybrid_identifies_and_the_baseline_cannot(traffic: Traffic) -> None:
    for row in traffic[1].rows:
        if row.figure == "identification_rate_hz":
            assert row.baseline == 0.0
            assert row.hybrid >= 0.0
    assert any(row.hybrid > 0.0 for row in traffic[1].rows if row.figure == "identification_rate_hz")


@pytest.mark.slow
def test_pairs_meet_the_same_traffic(traffic: Traffic) -> None:
    by_seed: dict[tuple[str, int], set[float]] = {}
    for row in traffic[1].network.runs:
        by_seed.setdefault((row.radio, row.run), set()).add(row.vehicles)
    assert all(len(vehicles) == 1 for vehicles in by_seed.values())


@pytest.mark.slow
def test_verdicts_and_figures_are_written(traffic: Traffic) -> None:
    names = {path.name for path in traffic[0].iterdir()}
    assert {"traffic.md", "traffic.html", "traffic.parquet", "runs", "summary.json", "report.html"} <= names
    assert {f"traffic_{name}.png" for name in ("load", "reception", "range", "density")} <= names


@pytest.mark.slow
def test_the_command_takes_the_runs_up_and_the_plan_those_of_the_command(
    traffic: Traffic, tmp_path: Path
) -> None:
    out, found, _ = traffic
    before = {path: path.stat().st_mtime_ns for path in (out / "runs").iterdir()}
    text = (out / "traffic.md").read_bytes()
    assert run([*SAME.split(), "--seeds", "2", "--out", str(out)]) == 0
    assert {path: path.stat().st_mtime_ns for path in (out / "runs").iterdir()} == before
    assert (out / "traffic.md").read_bytes() == text

    other, steps = tmp_path / "out", list[int]()
    assert run([*SAME.split(), "--seeds", "1", "--out", str(other)]) == 0
    told: list[str] = []
    again = run_traffic(other, SMALL, jobs=1, progress=lambda done, _: steps.append(done), say=told.append)
    assert steps == list(range(8, 17))
    assert [line.split(":")[0] for line in told[1:]] == ["16 runs (8 done before)"]
    assert told[0] == "the whole plan takes about 1 min, 1 at a time"
    assert again.rows == found.rows


class ToldError(Exception):
    """What was said first."""


@pytest.mark.parametrize(
    ("seeds", "jobs", "words"),
    [(30, 1, "11 h, 1 at a time"), (3, 1, "1 h, 1 at a time"), (1, 2, "11 min, 2 at a time")],
)
def test_how_long_a_plan_takes_is_told_in_whole_hours_or_minutes(
    tmp_path: Path, seeds: int, jobs: int, words: str
) -> None:
    def say(line: str) -> None:
        raise ToldError(line)

    with pytest.raises(ToldError, match=f"about {words}$"):
        run_traffic(tmp_path, TrafficPlan(seeds=seeds), jobs=jobs, progress=lambda *_: None, say=say)


@pytest.mark.slow
def test_a_sweep_without_the_baseline_compares_nothing(tmp_path: Path) -> None:
    line = (
        "network --density 30 --policy mbc --duration 3 --warm-up 1 --length 400 --jobs 1 --seeds 1 --quiet"
    )
    assert run([*line.split(), "--out", str(tmp_path / "out")]) == 0
    assert not list((tmp_path / "out").glob("traffic*"))
