"""What evaluate, compare and simulate_network return: frames, figures, files, and a line about themselves."""

import json
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import polars as pl
import pytest
from matplotlib.figure import Figure

import modelcast
from modelcast.cli.app import run
from modelcast.core.exceptions import ConfigError
from modelcast.interface.result import AbstractFrames
from modelcast.io.comparison import write_comparison
from modelcast.io.results import write_results
from modelcast.study.evaluate import evaluate as evaluate_trips
from modelcast.study.network.rows import CASE_KEYS
from modelcast.study.result import EvaluationResult

SMALL = modelcast.EvaluationSettings((0.3, 0.5), (0.0, 0.4), seeds=2)
RUNS = modelcast.FleetRuns(3.0, settings=modelcast.NetworkSettings(warm_up_s=1.0))


@pytest.fixture(name="evaluation", scope="module")
def _evaluation() -> Any:
    return modelcast.evaluate(modelcast.generate_drive(2, 90.0).truth, SMALL)


@pytest.fixture(name="comparison", scope="module")
def _comparison() -> Any:
    asked = modelcast.CompareSettings(SMALL, ("recorded",), resamples=50)
    candidates = [
        modelcast.FixedCandidate("cv", modelcast.bank_from_text("cv")),
        modelcast.FixedCandidate("paper", modelcast.PAPER_BANK),
    ]
    return modelcast.compare(modelcast.generate_drive(2, 90.0).truth, candidates, asked)


@pytest.fixture(name="network", scope="module")
def _network() -> Any:
    return modelcast.simulate_network(modelcast.Highway(500.0, 40.0), ("bsm-10hz", "j2945-mbc"), runs=RUNS)


@pytest.fixture(name="found", params=["evaluation", "comparison", "network"])
def _found(request: pytest.FixtureRequest) -> AbstractFrames:
    return request.getfixturevalue(request.param)


def frames(found: AbstractFrames) -> dict[str, pl.DataFrame]:
    names = [name for name, value in vars(type(found)).items() if isinstance(value, property)]
    values = {name: getattr(found, name) for name in names}
    return {name: value for name, value in values.items() if isinstance(value, pl.DataFrame)}


def test_a_frame_has_a_row_a_row_and_the_fields_of_the_rows(found: Any) -> None:
    for name, frame in frames(found).items():
        rows = getattr(found.result, name, None)
        if name in {"events", "samples", "headline"}:
            continue
        assert rows is not None, name
        assert frame.height == len(rows), name


def test_numbers_of_a_frame_are_those_of_the_rows(evaluation: Any, comparison: Any, network: Any) -> None:
    rows = evaluation.result.rates
    assert evaluation.rates["total_rate_hz"].to_list() == [row.total_rate_hz for row in rows]
    assert comparison.ratios.rows() == [row.values for row in comparison.result.ratios]
    assert network.runs["busy_ratio"].to_list() == [row.busy_ratio for row in network.result.runs]
    assert network.headline.columns[-5:] == [
        "message_rate_hz", "bytes_per_s", "busy_ratio", "held_ratio", "pte_p90_m",
    ]  # fmt: skip


def test_every_figure_is_a_figure(found: Any) -> None:
    names = [name for name in dir(found.plot) if not name.startswith("_") and name != "result"]
    assert names
    for name in names:
        assert isinstance(getattr(found.plot, name)(), Figure), name


def test_it_shows_itself_in_a_line_and_in_a_notebook_as_a_table(found: Any) -> None:
    assert "\n" not in repr(found)
    assert len(repr(found)) < 100
    assert repr(found).startswith(type(found).__name__)
    assert "<table" in found._repr_html_()


def test_what_is_written_is_what_the_commands_write(evaluation: Any, comparison: Any, tmp_path: Path) -> None:
    for found, write in ((evaluation, write_results), (comparison, write_comparison)):
        name = type(found).__name__
        written = found.write(tmp_path / name / "deep" / "down")
        (tmp_path / f"{name}-plain").mkdir()
        expected = write(found.result, tmp_path / f"{name}-plain")
        assert [path.read_bytes() for path in written] == [path.read_bytes() for path in expected]


@pytest.mark.slow
def test_a_report_is_written_into_a_folder_that_is_made(found: Any, tmp_path: Path) -> None:
    paths = found.report(tmp_path / "a" / "b")
    assert paths
    assert all(path.is_file() for path in paths)
    assert (tmp_path / "a" / "b") in paths[0].parents


@pytest.mark.slow
def test_functions_of_rows_take_the_result_too(evaluation: Any, tmp_path: Path) -> None:
    assert isinstance(evaluation.result, EvaluationResult)
    for name in ("rates", "references", "tracking"):
        function: Callable[[Any], pl.DataFrame] = getattr(modelcast, f"{name}_frame")
        assert function(evaluation).equals(function(evaluation.result))
    one = modelcast.write_results(evaluation, tmp_path / "one")
    other = modelcast.write_results(evaluation.result, tmp_path / "other")
    assert [path.read_bytes() for path in one] == [path.read_bytes() for path in other]
    assert modelcast.write_report(evaluation, tmp_path / "report")[0].name == "report.html"


def test_a_file_in_the_way_is_named_with_a_remedy(found: Any, tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("")
    for write in (found.write, found.report):
        for folder in (tmp_path / "taken", tmp_path / "taken" / "below"):
            with pytest.raises(ConfigError, match=r"taken.* cannot be written into: .*name another folder"):
                write(folder)


@pytest.mark.slow
def test_what_the_operating_system_refuses_is_named(evaluation: Any, tmp_path: Path) -> None:
    (tmp_path / "summary.json").mkdir()
    (tmp_path / "report.html").mkdir()
    for write in (evaluation.write, evaluation.report):
        with pytest.raises(ConfigError, match="cannot be written into: Is a directory: name another folder"):
            write(tmp_path)


@pytest.mark.parametrize("write", [modelcast.write_csv, modelcast.write_parquet, modelcast.write_profile])
def test_files_are_refused_by_name_where_they_cannot_be_written(write: Any, tmp_path: Path) -> None:
    profile = write is modelcast.write_profile
    what = modelcast.default_profile() if profile else [modelcast.generate_drive(2, 90.0).truth]
    with pytest.raises(ConfigError, match=r"missing/file: its folder does not exist: make it"):
        write(what, tmp_path / "missing" / "file")
    with pytest.raises(ConfigError, match="is a folder, not a file"):
        write(what, tmp_path)


def test_evaluate_is_the_evaluation_of_the_study(evaluation: Any) -> None:
    plain = evaluate_trips([modelcast.generate_drive(2, 90.0).truth], SMALL)
    assert plain.rates == evaluation.result.rates
    assert plain.tracking == evaluation.result.tracking


@pytest.mark.slow
def test_a_network_is_that_of_the_command(network: Any, tmp_path: Path) -> None:
    """Same road, senders, seeds: the rows agree to the bit; only the bank is named by what it holds."""
    asked = "network --density 40 --length 500 --duration 3 --warm-up 1 --seeds 1 --lanes 3 --quiet --jobs 1"
    assert run([*asked.split(), "--policy", "bsm-10hz", "j2945-mbc", "--out", str(tmp_path / "out")]) == 0
    rows = json.loads((tmp_path / "out" / "summary.json").read_text())["runs"]
    assert len(rows) == network.runs.height == 2
    for theirs, ours in zip(rows, network.runs.to_dicts(), strict=True):
        assert theirs.keys() == ours.keys()
        for name in ours.keys() - set(CASE_KEYS):
            known = ours[name] is not None and ours[name] == ours[name]
            assert theirs[name] == (ours[name] if known else None), name


@pytest.mark.slow
def test_runs_of_several_processes_are_those_of_one(network: Any, tmp_path: Path) -> None:
    """To the byte of every table, and in the same order; what is handed over survives it."""
    told: list[tuple[int, int]] = []
    given = (modelcast.Highway(500.0, 40.0), ("bsm-10hz", "j2945-mbc"), "dsrc", RUNS)
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        shared = modelcast.simulate_network(*given, each=pool.map, progress=lambda *at: told.append(at))
    assert told == [(1, 2), (2, 2)]
    ours, theirs = (
        {path.name: path for path in one.write(tmp_path / name)}
        for one, name in ((network, "one"), (shared, "several"))
    )
    assert ours.keys() == theirs.keys()
    assert "runs.parquet" in ours
    for name, path in ours.items():
        assert path.read_bytes() == theirs[name].read_bytes(), name


def test_runs_that_could_not_be_told_apart_are_refused() -> None:
    road = modelcast.Highway(500.0, 40.0)
    with pytest.raises(ConfigError, match="could not be told apart"):
        modelcast.simulate_network([road, road], "bsm-10hz", runs=RUNS)
    with pytest.raises(ConfigError, match="at least one scenario"):
        modelcast.simulate_network([], "bsm-10hz", runs=RUNS)


@pytest.mark.parametrize(
    ("radios", "names"),
    [
        ("ideal", ["ideal"]),
        (["dsrc", "ideal"], ["dsrc", "ideal"]),
        (modelcast.Dsrc(), ["dsrc"]),
        ({"one": modelcast.Dsrc(), "other": modelcast.Dsrc()}, ["one", "other"]),
    ],
)
def test_radios_are_named_given_or_both(radios: Any, names: list[str]) -> None:
    runs = modelcast.FleetRuns(1.0, settings=modelcast.NetworkSettings(warm_up_s=0.5))
    found = modelcast.simulate_network(modelcast.Highway(500.0, 20.0), "bsm-10hz", radios, runs)
    assert found.runs["radio"].to_list() == names


@pytest.mark.parametrize(("changes", "message"), [({"seeds": 0}, "seeds"), ({"duration_s": 1.0}, "warm-up")])
def test_runs_are_checked(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        modelcast.FleetRuns(**{"duration_s": 30.0, **changes})


@pytest.mark.slow
def test_warnings_are_those_of_the_command(tmp_path: Path, data_folder: Path) -> None:
    path = data_folder / "openacc_zalazone" / "short_setting__dynamic_part12.csv"
    asked = f"safety {path} --bank cv paper --per 0 0.4 --seeds 1 --burst 0 --sensors default --resamples 20"
    assert run([*asked.split(), "--quiet", "--jobs", "1", "--out", str(tmp_path / "out")]) == 0
    rows = json.loads((tmp_path / "out" / "summary.json").read_text())["pooled"]
    evaluation = modelcast.EvaluationSettings(
        (0.5,), (0.0, 0.4), seeds=1, keep_alive_s=2.0, protocol="sensor", references=False
    )
    candidates = [
        modelcast.FixedCandidate("cv", modelcast.bank_from_text("cv")),
        modelcast.FixedCandidate("paper", modelcast.PAPER_BANK),
    ]
    settings = modelcast.SafetySettings(evaluation, resamples=20)
    found = modelcast.evaluate_warnings(path, candidates, settings)
    for theirs, ours in zip(rows, found.pooled.to_dicts(), strict=True):
        for name in ("candidate", "basis", "packet_error_ratio", "threshold_m", "message_rate_hz"):
            assert theirs[name] == ours[name]
    assert "<table" in found._repr_html_()
    assert found.report(tmp_path / "report")[1].name == "report.html"
    for name in ("accuracy", "delays"):
        assert isinstance(getattr(found.plot, name)(), Figure)


@pytest.mark.parametrize(
    ("names", "changes", "message"),
    [
        (("a", "a"), {}, "each once"),
        ((), {}, "at least one"),
        (("a",), {"against": "b"}, "no candidate is named 'b'"),
    ],
)
def test_candidates_of_warnings_are_told_apart(
    names: tuple[str, ...], changes: dict[str, Any], message: str
) -> None:
    evaluation = modelcast.EvaluationSettings((0.5,), (0.0,), protocol="sensor", references=False)
    candidates = [modelcast.FixedCandidate(name, modelcast.PAPER_BANK) for name in names]
    with pytest.raises(ConfigError, match=message):
        modelcast.evaluate_warnings([], candidates, modelcast.SafetySettings(evaluation, **changes))
