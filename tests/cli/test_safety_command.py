"""Claims about ``modelcast safety``: what it writes and prints, takes up again, and refuses."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from modelcast.cli import safety_sweep
from modelcast.cli.app import USAGE, run
from modelcast.io.write_trips import write_csv
from modelcast.trips.trajectory import build_trajectory

SMALL = (
    "--sensors", "default", "--burst", "0", "0.5", "--per", "0", "0.4", "--seeds", "2", "--resamples", "50",
    "--threshold", "0.2", "--bank", "cv", "free", "--jobs", "1",
)  # fmt: skip


@pytest.fixture(scope="module")
def platoon(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file with three cars that brake one after another."""
    path = tmp_path_factory.mktemp("platoon") / "platoon.csv"
    t_s = np.arange(450) * 0.1
    lines = ["vehicle,t_s,east_m,north_m,speed_mps,heading_rad"]
    for place in range(3):
        own_s = t_s - 1.2 * place
        braking = np.clip(own_s - 25.0, 0.0, 2.0)
        east = 14.0 * own_s - 2.5 * braking**2 - 10.0 * np.maximum(own_s - 27.0, 0.0)
        speed = np.gradient(east, t_s)
        rows = zip((t_s + 100.0).tolist(), east.tolist(), speed.tolist(), strict=True)
        lines += [f"{place},{t:.1f},{x:.4f},0.0,{v:.4f},{np.pi / 2}" for t, x, v in rows]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(scope="module")
def done(platoon: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("done") / "out"
    assert run(["safety", str(platoon), *SMALL, "--quiet", "--out", str(out)]) == 0
    return out


def test_the_folder_holds_tables_figures_and_what_repeats_it(done: Path) -> None:
    names = {path.name for path in done.iterdir()}
    assert names >= {
        "summary.json", "pooled.parquet", "events.parquet", "table.md", "report.html", "run.json", "runs",
        "accuracy.png", "accuracy.svg", "delays.png", "film.png",
    }  # fmt: skip
    summary = json.loads((done / "summary.json").read_text())
    assert summary["pairs"] == 2
    assert summary["events"] >= 2
    assert len(summary["pooled"]) == 2 * 2 * 3 * 2
    assert "true warnings in 2 pairs" in (done / "table.md").read_text()
    assert "anecdotes" in (done / "table.md").read_text()


def test_tables_agree_with_each_other(done: Path) -> None:
    pooled = pl.read_parquet(done / "pooled.parquet")
    events = pl.read_parquet(done / "events.parquet")
    assert set(events["run"].unique()) == {0, 1}
    own = (pl.col("candidate") == "cv") & (pl.col("basis") == "airtime")
    own &= (pl.col("packet_error_ratio") == 0.4) & (pl.col("mean_burst_s") == 0.5)
    rows = events.filter(own)
    share = float(rows["missed"].to_numpy().sum()) / float(rows["instants"].to_numpy().sum())
    assert pooled.filter(own)["missed_ratio"].item() == pytest.approx(share)


@pytest.mark.slow
def test_a_second_call_takes_up_what_is_done(
    done: Path, platoon: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*_: object) -> None:
        raise AssertionError("scored again")

    before = (done / "summary.json").read_bytes()
    monkeypatch.setattr(safety_sweep, "_score", refuse)
    assert run(["safety", str(platoon), *SMALL, "--json", "--out", str(done)]) == 0
    assert (done / "summary.json").read_bytes() == before
    assert json.loads(capsys.readouterr().out)["pairs"] == 2


@pytest.mark.slow
def test_the_terminal_shows_the_headline_first(
    done: Path, platoon: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["safety", str(platoon), *SMALL, "--out", str(done)]) == 0
    out = capsys.readouterr().out
    assert out.index("true warnings") < out.index("free misses")
    assert "report:" in out


def heard(path: Path, lost: np.ndarray) -> Path:
    """A BsmP1 log of what vehicle 7 heard of vehicle 5, that lost these messages of it."""
    rest = "0,42.0,-83.5,200,10,0,0,20.01,0,0,9,3276.7,95"
    lines = [
        f"7,70,5,{291864241884364 + 100_000 * at},-9018,{at % 128},{rest}"
        for at in np.flatnonzero(~np.pad(lost, 1)).tolist()
    ]
    path.write_text("\n".join(lines) + "\n")
    return path


REPLAYED = (
    "--sensors", "default", "--seeds", "2", "--resamples", "50", "--threshold", "0.2", "--bank", "cv", "free",
    "--jobs", "1",
)  # fmt: skip


@pytest.mark.slow
def test_recorded_losses_stand_alone_or_beside_drawn_ones(
    platoon: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Three of ten lost in bursts of 0.6 s; and a log without a loss: it scores as a ratio of 0 does."""
    bursts = heard(tmp_path / "bursts.csv", np.arange(400) % 20 < 6)
    none = heard(tmp_path / "none.csv", np.zeros(200, dtype=np.bool_))
    out = tmp_path / "out"
    asked = ["safety", str(platoon), *REPLAYED, "--losses", str(bursts), str(none), "--out", str(out)]
    assert run(asked) == 0
    told = capsys.readouterr().out
    first = "recorded losses: bursts.csv: 1 link, 402 messages, 29.9 % lost in bursts of 0.6 s on average"
    assert told.index(first) < told.index("recorded losses: none.csv: 1 link, 202") < told.index("true warn")
    assert "default, recorded: bursts.csv, mean burst 0.6 s, 29.85 % lost" in told
    assert first in (out / "report.html").read_text(encoding="utf-8")
    alone = pl.read_parquet(out / "pooled.parquet")
    assert alone["loss_log"].unique(maintain_order=True).to_list() == ["bursts.csv", "none.csv"]
    assert alone["packet_error_ratio"].unique().sort().to_list() == [0.0, pytest.approx(120 / 402)]
    inputs = json.loads((out / "run.json").read_text())["inputs"]
    assert len(inputs) == 3

    assert run([*asked, "--per", "0", "0.4", "--burst", "0", "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert [text.split(":")[0] for text in summary["settings"]["losses"]] == ["bursts.csv", "none.csv"]
    rows = summary["pooled"]
    kinds = list(dict.fromkeys((row["loss_log"], row["packet_error_ratio"]) for row in rows))
    assert kinds == [("", 0.0), ("", 0.4), ("bursts.csv", 120 / 402), ("none.csv", 0.0)]
    same = [
        [{**row, "loss_log": ""} for row in rows if (row["loss_log"], row["packet_error_ratio"]) == kind]
        for kind in (("", 0.0), ("none.csv", 0.0))
    ]
    assert same[0] == same[1]
    assert [row["mean_burst_s"] for row in rows if row["loss_log"] == "bursts.csv"] == [
        pytest.approx(0.6)
    ] * 6

    # A log of the same name with other losses is scored anew, and alone.
    before = {path.name for path in (out / "runs").iterdir()}
    heard(bursts, np.arange(400) % 20 < 7)
    assert run([*asked, "--per", "0", "0.4", "--burst", "0", "--quiet"]) == 0
    (new,) = {path.name for path in (out / "runs").iterdir()} - before
    assert "bursts.csv" in new


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--application", "acc"), "fcw, eebl, ima"),
        (("--application", "ima"), "take fcw or eebl"),
        (("--application", "eebl", "--algorithm", "nhtsa"), "--algorithm goes with"),
        (("--algorithm", "guess"), "camp-linear"),
        (("--bank", "cv", "nobody"), "nobody"),
        (("--budget", "imm"), "--budget imm"),
        (("--against", "imm"), "--against imm"),
        (("--sensors", "radar"), "radar"),
        (("--per", "1.5"), "0..1"),
        (("--losses", "nowhere.csv"), "nowhere.csv"),
        (("--streams", "2"), "one of the two"),
    ],
)
def test_bad_options_are_told(
    words: tuple[str, ...], told: str, platoon: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["safety", str(platoon), "--jobs", "1", "--quiet", "--out", str(tmp_path / "out"), *words]
    assert run(asked) == 2
    assert told in capsys.readouterr().err.replace("\n", " ")
    assert not (tmp_path / "out").exists()


def test_a_log_s_name_breaks_no_table(platoon: Path, tmp_path: Path) -> None:
    log = heard(tmp_path / "a|b.csv", np.zeros(200, dtype=np.bool_))
    out = tmp_path / "out"
    assert run(["safety", str(platoon), *REPLAYED, "--losses", str(log), "--quiet", "--out", str(out)]) == 0
    rows = [line for line in (out / "table.md").read_text().splitlines() if line.startswith("|")]
    assert any("a\\|b.csv" in row for row in rows)
    assert len({row.replace("\\|", "").count("|") for row in rows}) == 1


def test_a_log_that_tells_no_losses_is_told(
    platoon: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["safety", str(platoon), "--losses", str(platoon), "--out", str(tmp_path / "out")]
    assert run(asked) == 2
    assert "BsmP1 of Safety Pilot" in capsys.readouterr().err.replace("\n", " ")
    assert not (tmp_path / "out").exists()


def test_no_platoon_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["safety", "--out", str(tmp_path / "out")]) == 2
    assert "--streams" in capsys.readouterr().err
    path = tmp_path / "alone.csv"
    t_s = np.arange(300) * 0.1
    write_csv([build_trajectory("alone/1", t_s, np.column_stack((10 * t_s, 0 * t_s)))], path)
    assert run(["safety", str(path), "--jobs", "1", "--out", str(tmp_path / "out")]) == 2
    assert "nobody ahead" in capsys.readouterr().err


@pytest.mark.slow
def test_figures_of_other_folders_are_shown_beside(platoon: Path, tmp_path: Path) -> None:
    fleets = tmp_path / "fleets"
    line = """network --scenario braking --density 60 --length 400 --duration 4 --warm-up 1 --seeds 1
        --policy baseline --application fcw --jobs 1 --quiet"""
    assert run([*line.split(), "--out", str(fleets)]) == 0
    out = tmp_path / "out"
    assert run(["safety", str(platoon), *SMALL, "--quiet", "--out", str(out), "--beside", str(fleets)]) == 0
    for end in (".svg", ".png"):
        shown = out / f"beside_1_warnings{end}"
        assert shown.read_bytes() == (fleets / f"warnings{end}").read_bytes()
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "<h2>fleets</h2>" in page
    assert 'src="beside_1_warnings.svg"' in page


def test_a_folder_with_nothing_to_show_is_refused(
    platoon: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "empty").mkdir()
    line = [
        "safety",
        str(platoon),
        *SMALL,
        "--out",
        str(tmp_path / "out"),
        "--beside",
        str(tmp_path / "empty"),
    ]
    assert run(line) == USAGE
    assert "none of warnings.svg" in " ".join(capsys.readouterr().err.split())


POLICIES = """from dataclasses import dataclass

import numpy as np

from modelcast import AbstractTransmitPolicy, Decisions, MessageKind


@dataclass(frozen=True, slots=True)
class Clock(AbstractTransmitPolicy[None]):
    every_s: float = 0.5

    @property
    def longest_silence_s(self):
        return self.every_s

    def init(self, vehicles, sub_models):
        return None

    def decide(self, state, inputs, rng):
        due = (inputs.silence_s >= self.every_s - 1e-9) | ~(inputs.error_in_use_m < self._limit_m)
        kind = np.where(due, MessageKind.UPDATE, MessageKind.NOTHING)
        return Decisions.at_once(kind, np.full(kind.shape, -1), inputs.t_s), None

    @property
    def _limit_m(self):
        return np.inf


@dataclass(frozen=True, slots=True)
class Limited(Clock):
    threshold_m: float = 0.2

    @property
    def _limit_m(self):
        return self.threshold_m
"""


@pytest.fixture
def slow(other_package: Callable[..., Path]) -> None:
    points = {"clock": "slow_policies:Clock", "limited": "slow_policies:Limited"}
    other_package("slow", {"modelcast.policies": points}, {"slow_policies": POLICIES})


def rates(folder: Path, basis: str) -> dict[str, float]:
    """Messages a second of each sender without loss."""
    pooled = pl.read_parquet(folder / "pooled.parquet").filter(
        (pl.col("basis") == basis) & (pl.col("packet_error_ratio") == 0.0) & pl.col("mean_burst_s").is_null()
    )
    return dict(zip(pooled["candidate"], pooled["message_rate_hz"], strict=True))


def safe(platoon: Path, out: Path, *words: str) -> int:
    return run(["safety", str(platoon), *SMALL, *words, "--out", str(out)])


@pytest.mark.slow
@pytest.mark.usefixtures("slow")
@pytest.mark.filterwarnings("ignore:--policy clock")
def test_another_packages_policy_decides_for_all_but_the_baseline(
    platoon: Path, done: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert safe(platoon, out, "--policy", "clock:every_s=0.2") == 0
    assert (
        "clock:every_s=0.2 decides when the senders send, but for the baseline cv" in capsys.readouterr().out
    )
    without, own = rates(done, "threshold"), rates(out, "threshold")
    assert own["cv"] == without["cv"]
    assert own["free"] == pytest.approx(5.0, abs=0.1)
    assert rates(out, "messages")["cv"] == pytest.approx(own["free"], rel=0.05)
    assert json.loads((out / "summary.json").read_text())["settings"]["policy"] == "clock:every_s=0.2"
    run_json = json.loads((out / "run.json").read_text())
    assert run_json["versions"]["policy clock:every_s=0.2"] == "slow 1.2"
    assert run_json["arguments"]["options"]["policy"] == "clock:every_s=0.2"
    assert "clock:every_s=0.2 decides" in (out / "report.html").read_text()


@pytest.mark.slow
@pytest.mark.usefixtures("slow")
@pytest.mark.filterwarnings("ignore:--policy clock")
def test_a_policy_is_matched_by_its_threshold_and_one_without_is_refused(
    platoon: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ("--bank", "cv", "ctra", "free", "--basis", "messages", "--policy")
    assert safe(platoon, tmp_path / "limited", *asked, "limited:every_s=5") == 0
    found = rates(tmp_path / "limited", "messages")
    assert found["ctra"] == pytest.approx(found["free"], rel=0.1)
    capsys.readouterr()
    assert safe(platoon, tmp_path / "clock", *asked, "clock") != 0
    told = " ".join(capsys.readouterr().err.split())
    assert "Clock(every_s=0.5) has no threshold_m, so it cannot be made to cost as much as another" in told
