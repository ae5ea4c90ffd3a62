"""Claims about several banks in ``modelcast network``: what is run, what is refused, what is written."""

import io
import json
from collections.abc import Sequence
from contextlib import redirect_stderr
from dataclasses import replace
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from modelcast.cli.app import USAGE, run
from modelcast.cli.network_cases import Varied, network_cases, told
from modelcast.cli.network_plan import NetworkPlan
from modelcast.cli.network_senders import sender_rows
from modelcast.cli.options import SensorOptions
from modelcast.cli.people_plan import PeoplePlan
from modelcast.io.network_runs import run_path
from modelcast.io.profile import write_profile
from modelcast.models.profile import default_profile
from modelcast.station.policy.rules import IdentifyRule, StartRule
from modelcast.study.network.rows import NetworkCase

SENDERS = [("j2945", "none"), ("mbc", "default"), ("mbc", "paper")]


def words(out: Path, banks: Sequence[str], policies: str, more: str = "--duration 6 --seeds 2") -> list[str]:
    """A small sweep over two radios."""
    line = f"network --density 30 --length 400 --warm-up 2 --jobs 1 --threshold 0.05 {more}"
    return [
        *line.split(),
        *f"--radio dsrc sidelink --policy {policies} --bank".split(),
        *banks,
        "--out",
        str(out),
    ]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("network") / "out"
    assert run([*words(out, ["paper", "default", "paper"], "j2945 mbc"), "--quiet"]) == 0
    return out


@pytest.fixture(scope="module")
def summary(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "summary.json").read_text())


@pytest.mark.slow
def test_a_policy_without_a_model_runs_once_and_the_others_once_a_bank(
    folder: Path, summary: dict[str, Any]
) -> None:
    asked = [
        (radio, *sender, seed) for radio in ("dsrc", "sidelink") for sender in SENDERS for seed in (0, 1)
    ]
    rows = summary["runs"]
    assert [(row["radio"], row["policy"], row["bank"], row["run"]) for row in rows] == asked
    files = list((folder / "runs").iterdir())
    assert len(files) == len(asked)
    for file in files:
        (row,) = json.loads(file.read_text())["run"]
        threshold = "_0.05m" if row["policy"] == "mbc" else ""
        assert row["threshold_m"] == (0.05 if threshold else None)
        sender = f"{row['policy']}_{row['bank']}{threshold}"
        assert file.name.startswith(f"{row['radio']}_{sender}_30_{row['run']}-")
        assert row in rows


@pytest.mark.slow
def test_the_bank_is_a_column_of_every_table(folder: Path, summary: dict[str, Any]) -> None:
    for name in ("runs", "distances", "outcomes", "seconds"):
        table = pq.read_table(folder / f"{name}.parquet", columns=["policy", "bank"])
        assert sorted({(row["policy"], row["bank"]) for row in table.to_pylist()}) == SENDERS
    pooled = {(row["policy"], row["bank"], row["seeds"]) for row in summary["pooled"]}
    assert sorted(pooled) == [(*sender, 2) for sender in SENDERS]


@pytest.mark.slow
def test_each_bank_follows_its_own_rules_on_both_radios(summary: dict[str, Any]) -> None:
    """The paper's bank identifies on 802.11p and mode 4; the shipped one and timers never do."""
    profile = default_profile()
    rules = {row["bank"]: (row["policy"], row["start"], row["identify"]) for row in summary["senders"]}
    assert rules["paper"] == ("mbc", "order", "on-failure")
    assert rules["default"] == ("mbc", profile.start, profile.identify)
    for row in summary["runs"]:
        identified = row["identification_rate_hz"]
        assert (identified > 0.0) == (row["bank"] == "paper")
        assert row["update_rate_hz"] + identified == pytest.approx(row["message_rate_hz"])


@pytest.mark.slow
def test_banks_meet_the_same_traffic_and_messages_of_their_own(summary: dict[str, Any]) -> None:
    by_case = {(row["radio"], row["bank"], row["run"]): row for row in summary["runs"]}
    for radio, seed in (("dsrc", 0), ("sidelink", 1)):
        paper, shipped = by_case[radio, "paper", seed], by_case[radio, "default", seed]
        assert paper["vehicles"] == shipped["vehicles"]
        assert paper["message_rate_hz"] != shipped["message_rate_hz"]


@pytest.mark.slow
def test_a_bank_is_added_to_what_is_done(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = {path: path.stat().st_mtime_ns for path in (folder / "runs").iterdir()}
    assert run(words(folder, ["paper", "cv"], "j2945 mbc")) == 0
    text = capsys.readouterr().out
    assert text.startswith(
        "12 runs (8 done before): 1 density, 2 radios, 2 seeds, 3 senders (j2945; mbc with paper, cv)\n"
    )
    after = {path: path.stat().st_mtime_ns for path in (folder / "runs").iterdir()}
    assert len(after) == 16
    assert before.items() <= after.items()


def plan(*banks: str, start: StartRule | None = None, identify: IdentifyRule | None = None) -> NetworkPlan:
    return NetworkPlan(
        "highway",
        duration_s=6.0,
        warm_up_s=2.0,
        length_m=400.0,
        lanes=0,
        blocks=5,
        seed=0,
        certificates="gap",
        banks=banks,
        profile=None,
        start=start,
        identify=identify,
        cost="bytes",
        threads=1,
        thresholds_m=(0.2,),
        keep_alive_s=2.0,
        believe=None,
        budget=4.0 / 3.0,
        legacy_threshold_m=0.0,
        approach_m=20.0,
        relaxed_error_m=None,
        sensor=SensorOptions(),
    )


def of_people(bank: str) -> NetworkPlan:
    """A plan whose people take a bank."""
    people = PeoplePlan(policy="mbc", bank=bank)
    return replace(plan("cv"), people=people)


def test_only_runs_of_a_changed_bank_are_made_anew(tmp_path: Path) -> None:
    file = tmp_path / "mine.json"
    write_profile(default_profile(), file)
    asked = plan("paper", str(file))
    cases = [NetworkCase(30.0, "dsrc", "mbc", bank, 0) for bank in ("none", "paper", "mine.json")]
    before, alone = asked.key(), plan("paper").key()
    file.write_text(file.read_text() + "\n")
    after = asked.key()
    kept = [run_path(case, before, tmp_path) == run_path(case, after, tmp_path) for case in cases]
    assert kept == [True, True, False]
    assert [run_path(case, alone, tmp_path) for case in cases[:2]] == [
        run_path(case, after, tmp_path) for case in cases[:2]
    ]
    assert set(after.all_inputs) - set(alone.all_inputs) == {"bank mine.json"}
    assert asked.as_plain() == plan("cv").as_plain()


def test_runs_with_people_are_made_anew_where_the_file_of_their_bank_has_changed(tmp_path: Path) -> None:
    file = tmp_path / "walkers.json"
    write_profile(default_profile(), file)
    asked, case = of_people(str(file)), NetworkCase(30.0, "dsrc", "mbc", "cv", 0)
    before = run_path(case, asked.key(), tmp_path)
    file.write_text(file.read_text() + "\n")
    assert run_path(case, asked.key(), tmp_path) != before


def test_banks_of_people_with_one_last_part_are_two_and_a_file_goes_by_its_name() -> None:
    words = ("good:table=a/b", "good:gain=2,table=c/b")
    assert [of_people(word).as_plain()["people"]["bank"] for word in words] == list(words)
    assert of_people("here/mine.json").as_plain() == of_people("there/mine.json").as_plain()


def test_rules_of_the_user_stand_over_those_of_the_bank_and_timers_never_identify() -> None:
    policies = ("j2945", "j2945-mbc", "mbc")
    own = sender_rows(plan("regimes"), policies)
    assert [(row.policy, row.start, row.identify) for row in own] == [
        ("j2945-mbc", "recent", "never"),
        ("mbc", "hindsight", "never"),
    ]
    asked = sender_rows(plan("paper", start="keep", identify="best"), policies)
    assert [(row.policy, row.start, row.identify) for row in asked] == [
        ("j2945-mbc", "keep", "never"),
        ("mbc", "keep", "best"),
    ]
    assert {row.sub_models for row in asked} == {"cv+gp-anchored"}


def test_what_was_trained_goes_with_the_rule_that_asks_for_it() -> None:
    (row,) = sender_rows(plan("default", start="predicted", identify="never"), ["mbc"])
    assert (row.start, row.identify) == ("predicted", "never")


@pytest.mark.parametrize(
    ("banks", "policies", "rule", "problem"),
    [
        ("cow", "mbc", "", "no sub-model is named 'cow'"),
        ("nowhere.json", "mbc", "", "nowhere.json"),
        ("a/x.json b/x.json", "mbc", "", "a/x.json and b/x.json have the same name"),
        ("paper", "mbc", "--identify cheapest", "--policy mbc --bank paper: identify 'cheapest'"),
        (
            "default",
            "mbc",
            "--identify best",
            "--policy mbc --bank default: identify must be never with free",
        ),
        ("default paper", "mbc", "--start predicted", "--policy mbc --bank paper: start 'predicted'"),
        ("paper ca+ctra", "mbc", "--start guarded", "--bank ca+ctra: start 'guarded' needs cv"),
        ("paper", "mbc j2945-mbc", "--start survivor", "--policy j2945-mbc --bank paper: start must"),
        ("paper", "j2945-mbc", "--start predicted", "--policy j2945-mbc --bank paper: start 'predicted'"),
        ("paper", "j2945 j2945-mbc", "--identify best", "--identify best goes with --policy mbc"),
    ],
)
def test_what_does_not_go_together_is_told_before_anything_runs(
    banks: str, policies: str, rule: str, problem: str, tmp_path: Path
) -> None:
    errors = io.StringIO()
    with redirect_stderr(errors):
        assert run(words(tmp_path / "out", banks.split(), policies, rule)) == USAGE
    (line,) = errors.getvalue().splitlines()
    assert problem in line
    assert not list(tmp_path.iterdir())


def test_the_study_of_the_page_comes_to_the_runs_it_says() -> None:
    policies = ("j2945", "j2945-mbc", "mbc", "mbc")
    cases = network_cases(plan("paper", "default"), Varied((100.0, 400.0), ("dsrc", "sidelink"), policies, 3))
    assert len(set(cases)) == len(cases) == 60
    text = told(cases, 0)
    assert text.startswith(
        "60 runs: 2 densities, 2 radios, 3 seeds, 5 senders (j2945; j2945-mbc with paper, "
    )
    page = " ".join((Path(__file__).parents[2] / "docs" / "network.md").read_text(encoding="utf-8").split())
    assert "here 60 runs, of 2 densities, 2 radios, 3 seeds and 5 senders" in page
