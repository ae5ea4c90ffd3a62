"""What a result leaves on disk, and how output folders come and go."""

import json
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from made_rows import filled
from modelcast.core.exceptions import ConfigError
from modelcast.io import record_files
from modelcast.io.arrow import EVENTS_SCHEMA, SAMPLES_SCHEMA, columns_table
from modelcast.io.manifest import MANIFEST
from modelcast.io.output import atomic_folder
from modelcast.io.record_files import RecordFiles
from modelcast.io.results import summary_document, write_message_trace, write_results, write_summary
from modelcast.station.banks import PAPER_BANK
from modelcast.study.evaluate import evaluate
from modelcast.study.recording import joined_columns
from modelcast.study.result import (
    RATES,
    TRACKING,
    Coded,
    EvaluationResult,
    SampleBlock,
    TripRow,
)
from modelcast.study.settings import EvaluationSettings
from modelcast.world.drive import generate_drive

NAN = float("nan")


def made(row_type: type, **values: object) -> object:
    """A row whose other fields are 1.0, which is enough to be written."""
    return row_type(**{item.name: values.get(item.name, 1.0) for item in fields(row_type)})


@pytest.fixture(name="result")
def _result() -> EvaluationResult:
    errors = np.arange(20, dtype=np.float32).reshape(2, 2, 5)
    errors[0, 0, 0] = np.nan
    names = SAMPLES_SCHEMA.names[8:]
    block = SampleBlock(
        "a/1", "mbc", "hybrid", None, 0.2, (0.0, 0.4), np.arange(5.0), dict.fromkeys(names, errors)
    )
    return EvaluationResult(
        {"seed": 3, "thresholds_m": (0.2, 0.5), "input": Path("/data/secret/a.csv"), "count": np.int64(4)},
        trips=(
            made(TripRow, id="a/1", source="csv", grid_m=(0.0, 0.0), skipped={"späte": 2}, conditioning=None),
        ),
        rates=RATES.table(
            [
                filled(RATES, 1.0, trip="a/1", policy="mbc", threshold_m=0.1 + 0.2),
                filled(RATES, 1.0, trip="all", policy="baseline", bytes_per_s=float("inf")),
            ]
        ),
        tracking=TRACKING.table(
            [filled(TRACKING, 1.0, trip="all", policy="mbc", rate_basis=None, pte_p99_m=NAN)]
        ),
        ecdfs=(),
        timeline=None,
        manoeuvre=None,
        events={
            "trip": Coded(np.array([1, 0, 1, 0], dtype=np.int32), ("a/1", "b,2")),
            "policy": np.array(["mbc", "mbc", "mbc", "baseline"]),
            "bank": np.array(["hybrid"] * 3 + ["cv"], dtype=object),
            "threshold_m": np.array([0.2, 0.2, 0.5, 0.2]),
            "t_s": np.array([1.5, 0.0, 2.0, 0.0]),
            "kind": np.array(["update", "identification", "update", "update"]),
            "sub_model": np.array(["cv", "gp", None, "cv"], dtype=object),
            "airtime_s": np.array([1e-4, 5e-5, 1e-4, 8e-5]),
            "size_bytes": np.array([60, 12, 60, 39], dtype=np.int32),
        },
        samples=(block, replace(block, trip="b,2", rate_basis="total")),
        failures={"c/1": "too short"},
    )


def test_summary_has_the_rows_under_their_own_names(result: EvaluationResult, tmp_path: Path) -> None:
    document = json.loads(write_results(result, tmp_path)[0].read_text(encoding="utf-8"))
    assert document.keys() == {
        "schema",
        "modelcast",
        "settings",
        "trips",
        "rates",
        "references",
        "tracking",
        "failures",
        "skipped",
    }
    assert document["schema"] == 1
    assert document["rates"][0].keys() == set(RATES.names)
    assert document["tracking"][0].keys() == set(TRACKING.names)
    assert document["trips"][0].keys() == {item.name for item in fields(TripRow)}
    assert document == summary_document(result)


def test_summary_writes_floats_in_full_and_what_is_not_finite_as_null(
    result: EvaluationResult, tmp_path: Path
) -> None:
    text = write_results(result, tmp_path)[0].read_text(encoding="utf-8")
    assert "0.30000000000000004" in text
    assert "NaN" not in text
    assert "Infinity" not in text
    assert '"pte_p99_m": null' in text
    assert "späte" in text
    assert text.endswith("}\n")


def test_summary_keeps_no_folder(result: EvaluationResult) -> None:
    assert summary_document(result)["settings"]["input"] == "a.csv"


def test_summary_refuses_what_json_cannot_hold(result: EvaluationResult) -> None:
    with pytest.raises(TypeError, match="object"):
        summary_document(replace(result, settings={"odd": object()}))


def test_the_same_result_gives_the_same_bytes(result: EvaluationResult, tmp_path: Path) -> None:
    folders = [tmp_path / "a", tmp_path / "b"]
    for folder in folders:
        folder.mkdir()
    first, second = ([path.read_bytes() for path in write_results(result, folder)] for folder in folders)
    assert first == second


def test_parquet_text_is_plain_strings(result: EvaluationResult, tmp_path: Path) -> None:
    _, events, samples = write_results(result, tmp_path)
    table = pq.read_table(events)
    assert {table.schema.field(name).type for name in ("trip", "policy", "bank", "sub_model")} == {
        pa.string()
    }
    assert table["trip"].to_pylist() == ["b,2", "a/1", "b,2", "a/1"]
    assert table["sub_model"].to_pylist() == ["cv", "gp", None, "cv"]
    assert table.schema.field("size_bytes").type == pa.int32()
    assert pq.read_schema(samples).field("rate_basis").type == pa.string()


def test_samples_are_one_row_an_instant(result: EvaluationResult, tmp_path: Path) -> None:
    table = pq.read_table(write_results(result, tmp_path)[2])
    assert table.column_names == SAMPLES_SCHEMA.names
    assert table.num_rows == 40
    assert table["t_s"].to_pylist()[:6] == [0.0, 1.0, 2.0, 3.0, 4.0, 0.0]
    assert table["packet_error_ratio"].to_pylist()[9:11] == [0.0, 0.4]
    assert table["seed"].to_pylist()[4:6] == [0, 1]
    assert table["tracking_error_m"].to_pylist()[:2] == [None, 1.0]
    assert table["rate_basis"].to_pylist()[19:21] == [None, "total"]


def test_rows_are_the_same_in_row_groups_of_any_size(
    result: EvaluationResult, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = [pq.read_table(path) for path in write_results(result, tmp_path)[1:]]
    monkeypatch.setattr(record_files, "GROUP_ROWS", 3)
    paths = write_results(result, tmp_path)[1:]
    assert [pq.read_table(path) for path in paths] == whole
    for path in paths:
        file = pq.ParquetFile(path)
        groups = [file.metadata.row_group(at).num_rows for at in range(file.num_row_groups)]
        assert set(groups[:-1]) == {3}


def test_rows_that_come_trip_by_trip_give_the_bytes_of_a_result_that_kept_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And no more than a row group waits in memory, whatever has come before."""
    monkeypatch.setattr(record_files, "GROUP_ROWS", 1000)
    settings = EvaluationSettings((0.3,), (0.0, 0.4), seeds=1, bank=PAPER_BANK)
    trips = [generate_drive(seed=seed, duration_s=90.0).truth for seed in (1, 2)]
    kept = write_results(evaluate(trips, settings), tmp_path / "kept")
    folder = tmp_path / "streamed"
    folder.mkdir()
    waiting: list[int] = []

    def look(_done: int, _known: int) -> None:
        waiting.append(records.held_rows)

    with RecordFiles(folder) as records:
        result = evaluate(trips, settings, records=records, progress=look)
    write_summary(result, folder)
    assert not result.samples
    assert max(waiting) < 2 * 1000
    for path in kept:
        assert path.read_bytes() == (folder / path.name).read_bytes()
    write_message_trace(folder, tmp_path / "streamed.csv")
    write_message_trace(evaluate(trips, settings), tmp_path / "kept.csv")
    assert (tmp_path / "streamed.csv").read_bytes() == (tmp_path / "kept.csv").read_bytes()


def test_results_without_samples_and_events_keep_their_columns(
    result: EvaluationResult, tmp_path: Path
) -> None:
    empty = replace(result, samples=(), events=joined_columns([]))
    _, events, samples = write_results(empty, tmp_path)
    assert pq.read_table(samples).column_names == SAMPLES_SCHEMA.names
    assert pq.read_table(events).column_names == EVENTS_SCHEMA.names
    assert pq.read_table(events).num_rows == 0


@pytest.mark.parametrize("kind", ["U", "object", "string"])
def test_text_arrays_of_every_kind_give_the_same_column(kind: str) -> None:
    values = ["x", "x", "y", "x", ""]
    dtype = {"U": None, "object": object, "string": np.dtypes.StringDType()}[kind]
    assert columns_table({"c": np.array(values, dtype=dtype)})["c"].to_pylist() == values


def test_message_trace_is_ordered_by_time(result: EvaluationResult, tmp_path: Path) -> None:
    path = tmp_path / "messages.csv"
    write_message_trace(result, path)
    assert path.read_text(encoding="utf-8").splitlines() == [
        "t_s,vehicle,size_bytes,kind",
        "0.0,a/1,12,identification",
        '1.5,"b,2",60,update',
    ]


def test_message_trace_of_another_threshold_and_policy(result: EvaluationResult, tmp_path: Path) -> None:
    path = tmp_path / "messages.parquet"
    write_message_trace(result, path, threshold_m=0.5)
    assert pq.read_table(path)["t_s"].to_pylist() == [2.0]
    write_message_trace(result, path, policy="baseline")
    assert pq.read_table(path)["size_bytes"].to_pylist() == [39]


def test_message_trace_refuses_what_it_cannot_write(result: EvaluationResult, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"threshold 0\.7"):
        write_message_trace(result, tmp_path / "m.csv", threshold_m=0.7)
    with pytest.raises(ConfigError, match="no message of policy 'none'"):
        write_message_trace(result, tmp_path / "m.csv", policy="none")
    with pytest.raises(ConfigError, match=r"or \.parquet"):
        write_message_trace(result, tmp_path / "m.txt")


def test_a_folder_appears_whole_and_replaces_an_earlier_one(tmp_path: Path) -> None:
    target = tmp_path / "deep" / "out"
    for name in ("old", "new"):
        with atomic_folder(target) as folder:
            (folder / "sub").mkdir()
            (folder / "sub" / name).write_text(name, encoding="utf-8")
            assert not (target / "sub" / name).exists()
    assert (target / MANIFEST).read_text(encoding="utf-8") == "sub/new\n"
    assert [path.name for path in (target / "sub").iterdir()] == ["new"]
    assert [path.name for path in target.parent.iterdir()] == ["out"]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_an_error_leaves_the_old_output(tmp_path: Path, error: type[BaseException]) -> None:
    target = tmp_path / "out"
    with atomic_folder(target) as folder:
        (folder / "a").touch()
    with pytest.raises(error), atomic_folder(target) as folder:  # noqa: PT012
        (folder / "b").touch()
        raise error
    assert sorted(path.name for path in target.iterdir()) == [MANIFEST, "a"]
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_an_empty_folder_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    with atomic_folder(tmp_path / "out") as folder:
        (folder / "a").touch()
    assert (tmp_path / "out" / "a").exists()


def test_foreign_files_are_refused_before_any_work(tmp_path: Path) -> None:
    target = tmp_path / "out"
    with atomic_folder(target) as folder:
        (folder / "a").touch()
    (target / "notes.txt").touch()
    with pytest.raises(ConfigError, match=r"did not write \(notes.txt\)"), atomic_folder(target):
        pytest.fail("the block must not run")
    assert (target / "notes.txt").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_a_foreign_file_that_appears_meanwhile_is_kept(tmp_path: Path) -> None:
    target = tmp_path / "out"
    with pytest.raises(ConfigError, match="late"), atomic_folder(target):  # noqa: PT012
        target.mkdir()
        (target / "late").touch()
    assert [path.name for path in target.iterdir()] == ["late"]


def test_a_file_and_the_working_folder_are_no_output_folders(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match="is a file"), atomic_folder(tmp_path / "file"):
        pass
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    with pytest.raises(ConfigError, match="working folder"), atomic_folder("."):
        pass


def test_a_link_keeps_pointing_at_the_folder(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real", target_is_directory=True)
    with atomic_folder(tmp_path / "link") as folder:
        (folder / "a").touch()
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real" / "a").exists()
