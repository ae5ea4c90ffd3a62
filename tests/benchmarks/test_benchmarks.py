"""Claims about the benchmarks: each file is one or a part, what they measure is kept, the page shows it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "validation"))
sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
import machine as machines
from measured import VARIABLE, record
from page_blocks import blocks_in
from performance_page import PAGE, blocks
from quoted_results import QUOTED, quoted
from registry import BENCHMARKS, PARTS, STUDIES, Benchmark
from run_all import RESULTS, chosen, left_out, merged, read_results, table

sys.path.pop(0)
sys.path.pop(0)

ROOT = Path(__file__).parents[2]
KEPT = read_results(RESULTS)


def test_every_file_is_a_benchmark_or_said_to_be_something_else() -> None:
    files = sorted(file.stem for file in RESULTS.parent.glob("*.py"))
    assert files == sorted([*(one.name for one in BENCHMARKS), *PARTS, *STUDIES])


@pytest.mark.parametrize("benchmark", [one.name for one in BENCHMARKS])
def test_a_benchmark_keeps_what_it_measures(benchmark: str) -> None:
    text = (RESULTS.parent / f"{benchmark}.py").read_text(encoding="utf-8")
    assert "record(" in text or "from numpy_sub_model import show" in text


def test_every_result_is_of_a_benchmark_and_says_on_what_it_was_made() -> None:
    assert set(KEPT) <= {one.name for one in BENCHMARKS}
    for name, result in KEPT.items():
        assert result["records"], name
        assert {"cores", "processor", "memory_gib"} <= set(result["machine"])
        assert {"python", "numpy", "modelcast"} <= set(result["versions"])
        for one in result["records"]:
            assert one["value"] > 0, (name, one)
            assert ("peer" in one) is ("ratio" in one)


def test_the_page_has_what_the_results_give() -> None:
    wanted = {name: "\n".join(lines).strip().splitlines() for name, lines in blocks(KEPT).items()}
    assert blocks_in(PAGE.read_text(encoding="utf-8")) == wanted


def test_pages_that_quote_results_have_what_the_results_give() -> None:
    for page, own in quoted(KEPT).items():
        there = blocks_in(page.read_text(encoding="utf-8"))
        for name, lines in own.items():
            assert there[name] == "\n".join(lines).strip().splitlines(), (page.name, name)


def test_a_table_of_what_was_not_kept_names_the_command_that_keeps_it() -> None:
    found = quoted({})
    for page, own in QUOTED.items():
        for name, benchmarks in own.items():
            (line,) = found[ROOT / page][name]
            assert all(f"--only {one}" in line for one in benchmarks)


def test_no_result_names_the_host() -> None:
    told = json.dumps(machines.machine())
    assert set(json.loads(told)) == {"cores", "processor", "virtual", "architecture", "system", "memory_gib"}


def test_a_record_holds_four_digits_and_the_ratio_of_its_peer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "kept"))
    record("a fit", 2.00004, "µs", peer=("another", 5.0), sizes={"windows": 10})
    record("a tick", 3.0, "ms")
    first, second = map(json.loads, (tmp_path / "kept").read_text(encoding="utf-8").splitlines())
    assert first == {
        "what": "a fit", "value": 2.0, "unit": "µs", "sizes": {"windows": 10},
        "peer": "another", "peer_value": 5.0, "ratio": 2.5,
    }  # fmt: skip
    assert second == {"what": "a tick", "value": 3.0, "unit": "ms"}


def test_nothing_is_kept_where_nobody_asks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.chdir(tmp_path)
    record("a fit", 2.0, "µs")
    assert not list(tmp_path.iterdir())


def test_a_result_replaces_only_its_own_and_stands_in_the_order_of_the_list(tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    first, second = BENCHMARKS[0].name, BENCHMARKS[1].name
    for name, value in ((second, 1.0), (first, 2.0), (second, 3.0)):
        merged(path, name, {"records": [{"what": "a", "value": value, "unit": "s"}]})
    kept = read_results(path)
    assert [(name, one["records"][0]["value"]) for name, one in kept.items()] == [(first, 2.0), (second, 3.0)]
    assert [file.name for file in tmp_path.iterdir()] == ["results.json"]


def test_a_benchmark_without_what_it_needs_is_left_out_with_the_reason() -> None:
    needy = Benchmark("one", "", "", "seconds", needs=("SOME_DATA",))
    assert left_out(needy, {}) == "SOME_DATA is not set"
    assert not left_out(needy, {"SOME_DATA": "folder"})
    alone = Benchmark("two", "", "", "seconds", packages=("no_such_package",))
    assert left_out(alone, {}) == "no_such_package is not installed"
    either = Benchmark("three", "", "", "seconds", packages=("no_such_package", "numpy"))
    assert not left_out(either, {})


def test_hours_are_run_when_asked_for_and_quick_runs_take_what_is_quick() -> None:
    usual = {one.takes for one in chosen(only=(), quick=False, hours=False)}
    assert usual == {"seconds", "minutes"}
    assert len(chosen(only=(), quick=False, hours=True)) == len(BENCHMARKS)
    assert all(one.quick is not None for one in chosen(only=(), quick=True, hours=False))
    assert [one.name for one in chosen(only=["corpus"], quick=False, hours=False)] == ["corpus"]


def test_the_table_shows_sizes_and_peers() -> None:
    one = {"what": "a", "value": 2.0, "unit": "s", "sizes": {"trips": 3}, "peer": "b", "ratio": 4.0}
    assert table({"name": {"records": [one]}}) == ["name  a trips=3  2 s  4 times for b"]


def test_a_benchmark_that_was_asked_for_and_cannot_run_is_an_error() -> None:
    environment = {"PATH": "", "PYTHONPATH": str(ROOT / "src")}
    command = [sys.executable, str(RESULTS.parent / "run_all.py"), "--only", "rate_evaluation"]
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)  # noqa: S603 - ours
    assert ended.returncode == 1
    assert "rate_evaluation: left out: MODELCAST_DATA is not set" in ended.stdout


def made(*records: dict[str, object]) -> dict[str, dict[str, object]]:
    """Results of one benchmark on a machine of two cores with three processes waiting."""
    machine = {
        "cores": 2,
        "processor": "p",
        "virtual": True,
        "architecture": "a",
        "system": "s",
        "memory_gib": None,
    }
    one = {"date": "2026-11-30", "machine": machine, "versions": {"python": "3.11"}, "load_average": 3.0}
    return {"bsm_codec": {**one, "exit_code": 0, "records": list(records)}}


def test_growth_is_shown_from_three_sizes_on_as_the_largest_over_the_smallest() -> None:
    sizes = [
        {"what": "a", "value": cost, "unit": "µs", "sizes": {"trips": n}}
        for n, cost in ((4, 3), (1, 2), (2, 9))
    ]
    few = blocks(made(*sizes[:2]))
    assert len(few["growth"]) == 2
    assert few["alone"][2:] == [
        "| `bsm_codec`: a (4 trips) | 3 µs | 1.5 |",
        "| `bsm_codec`: a (1 trips) | 2 µs | 1.5 |",
    ]
    assert len(blocks(made(*sizes))["alone"]) == 2
    assert blocks(made(*sizes))["growth"][2:] == [
        "| `bsm_codec`: a | µs | trips 1: 2, 2: 9, 4: 3 | 1.5 | 1.5 |"
    ]


def test_other_programs_stand_apart_from_modelcast_itself() -> None:
    peers = ("tinygp, compiled", "plain NumPy")
    kept = [
        {"what": "a", "value": 2, "unit": "s", "peer": one, "peer_value": 9, "ratio": 4.5} for one in peers
    ]
    found = blocks(made(*kept))
    assert found["programs"][2:] == ["| `bsm_codec`: a | 2 s | tinygp, compiled | 9 s | 4.5 | 1.5 |"]
    assert found["parts"][2:] == ["| `bsm_codec`: a | 2 s | plain NumPy | 9 s | 4.5 | 1.5 |"]
