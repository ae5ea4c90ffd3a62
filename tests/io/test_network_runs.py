"""Claims about finished runs of a network evaluation on disk."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from made_rows import filled
from modelcast.core.exceptions import ConfigError
from modelcast.io.network_runs import NetworkRunFiles, RunKey, case_name, read_case, run_path, write_case
from modelcast.io.run_store import run_store
from modelcast.study.network.rows import RUNS, CaseResult, NetworkCase

CASE = NetworkCase(25.0, "dsrc", "j2945", "none", 0)
KEY = RunKey("1.0", {"0 traffic.xml": "ab"})
OPTIONS = {"seed": 0}
FILES = NetworkRunFiles(OPTIONS, KEY)


def result(case: NetworkCase = CASE) -> CaseResult:
    return CaseResult(filled(RUNS, 0.5, **case.values()), (), outcomes=(), seconds=())


def made(folder: Path) -> Path:
    folder.mkdir()
    return folder


def test_a_run_comes_back_as_it_was_written(tmp_path: Path) -> None:
    write_case(result(), CASE, OPTIONS, KEY, tmp_path)
    assert read_case(CASE, OPTIONS, KEY, tmp_path) == result()


@pytest.mark.parametrize("bank", ["good:table=a/b", "good:table=../b+cv", "good:table=/b"])
def test_a_setting_with_a_slash_stays_in_the_folder(bank: str, tmp_path: Path) -> None:
    case = replace(CASE, bank=bank)
    path = write_case(result(case), case, OPTIONS, KEY, tmp_path)
    assert path.parent == tmp_path
    assert list(tmp_path.iterdir()) == [path]
    assert read_case(case, OPTIONS, KEY, tmp_path) == result(case)
    assert Path(case_name(case)).name == case_name(case)


@pytest.mark.parametrize(
    "bank", ["none", "paper", "default", "cv+ctra", "gp-anchored", "my_bank-2.json", "mixed@0.5"]
)
def test_plain_banks_stand_in_names_as_they_are(bank: str) -> None:
    assert case_name(replace(CASE, bank=bank)) == f"dsrc_j2945_{bank}_25_0"


@pytest.mark.parametrize("key", [RunKey("1.1", KEY.inputs), RunKey("1.0", {"0 traffic.xml": "ac"})])
def test_a_run_of_another_version_or_input_is_not_taken_up(key: RunKey, tmp_path: Path) -> None:
    write_case(result(), CASE, OPTIONS, KEY, tmp_path)
    assert read_case(CASE, OPTIONS, key, tmp_path) is None


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("vehicles", "many"),
        ("vehicles", -1),
        ("vehicles", 1e300),
        ("vehicles", True),
        ("busy_ratio", 2.0),
        ("policy", "cam"),
        ("bank", "paper"),
        ("run", 1.5),
        ("unknown", 1),
    ],
)
def test_a_damaged_field_is_named(field: str, value: object, tmp_path: Path) -> None:
    path = write_case(result(), CASE, OPTIONS, KEY, tmp_path)
    document = json.loads(path.read_text(encoding="utf-8"))
    document["run"][0][field] = value
    path.write_text(json.dumps(document), encoding="utf-8")
    named = "a mapping of" if field == "unknown" else f"run.0..{field}"
    with pytest.raises(ConfigError, match=rf"{path.name} is not a run.*{named}"):
        read_case(CASE, OPTIONS, KEY, tmp_path)


@pytest.mark.parametrize("text", ["", "[" * 100_000, "{}", "[1]", '{"run": NaN}', "9" * 5000])
def test_what_is_no_run_is_refused(text: str, tmp_path: Path) -> None:
    run_path(CASE, KEY, tmp_path).write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match="is not a run"):
        read_case(CASE, OPTIONS, KEY, tmp_path)


def test_an_interrupted_call_is_taken_up_and_a_finished_one_leaves_nothing(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt), run_store(out, FILES, command="network") as store:  # noqa: PT012
        store.keep(CASE, result())
        raise KeyboardInterrupt
    with run_store(out, FILES, command="network") as store:
        assert store.find(CASE) == result()
    assert not list(tmp_path.iterdir())


def test_two_calls_at_a_time_are_one_too_many(tmp_path: Path) -> None:
    with (
        run_store(tmp_path / "out", FILES, command="network"),
        pytest.raises(ConfigError, match="another modelcast network"),
        run_store(tmp_path / "out", FILES, command="network"),
    ):
        pass


def test_a_run_depends_on_the_file_of_its_own_bank_alone(tmp_path: Path) -> None:
    """One without a model is taken up whatever banks are asked for."""
    mine = replace(CASE, policy="mbc", bank="mine.json")
    asked, changed = (replace(KEY, banks={"mine.json": found}) for found in ("ab", "ac"))
    for case in (CASE, mine):
        write_case(result(case), case, OPTIONS, asked, tmp_path)
    for key in (KEY, changed):
        assert read_case(CASE, OPTIONS, key, tmp_path) == result()
        assert read_case(mine, OPTIONS, key, tmp_path) is None
    assert read_case(mine, OPTIONS, replace(asked, banks={**asked.banks, "b.json": "0"}), tmp_path) == result(
        mine
    )


def test_a_run_depends_on_what_other_packages_bring_to_its_own_bank_alone() -> None:
    key = replace(KEY, sub_models={"chord+cv": {"sub-model chord": "chord 1.0"}, "cv": {}})
    mine = replace(CASE, policy="mbc", bank="chord+cv")
    assert key.of(mine).all_inputs == {**KEY.inputs, "sub-model chord": "chord 1.0"}
    assert key.of(CASE).all_inputs == key.of(replace(mine, bank="cv")).all_inputs == KEY.inputs
    assert key.all_inputs == key.of(mine).all_inputs


def test_why_runs_are_not_taken_up_is_told_by_input(tmp_path: Path) -> None:
    """The nearest of the older runs counts, and what is no run says nothing."""
    old = replace(KEY, foreign={"radio dsrc": "radios 1.0"}, inputs={"0 traffic.xml": "a" * 64})
    new = replace(old, foreign={"radio dsrc": "radios 2.0"})
    more = replace(new, version="1.1", inputs={"0 traffic.xml": "b" * 64})
    cases = [replace(CASE, run=number) for number in range(3)]
    with run_store(tmp_path / "out", NetworkRunFiles(OPTIONS, old), command="network") as store:
        store.publish({case: result(case) for case in cases[:2]}, made(tmp_path / "out"))
        run_path(cases[0], KEY, store.done).write_text("{}")
    told = {}
    for key in (old, new, more):
        with run_store(tmp_path / "out", NetworkRunFiles(OPTIONS, key), command="network") as store:
            told[key.short] = store.outdated(cases)
    changed = "radio dsrc was radios 1.0, is radios 2.0"
    assert list(told.values()) == [
        [],
        [f"2 runs are not taken up again: {changed}"],
        [f"2 runs are not taken up again: modelcast was 1.0, is 1.1; 0 traffic.xml has changed; {changed}"],
    ]


def test_what_a_hostile_run_says_of_its_inputs_is_not_shown_raw(tmp_path: Path) -> None:
    path = write_case(result(), CASE, OPTIONS, KEY, made(made(tmp_path / "out") / "runs"))
    document = json.loads(path.read_text(encoding="utf-8"))
    key = replace(KEY, version="1.1")
    for inputs, told in (({"0 traffic.xml": "\x1b[31m"}, []), ({"0 traffic.xml": 1}, []), ([], [])):
        path.write_text(json.dumps({**document, "inputs": inputs}), encoding="utf-8")
        with run_store(tmp_path / "out", NetworkRunFiles(OPTIONS, key), command="network") as store:
            assert store.outdated([CASE]) == told
