"""An evaluation of a corpus: that of its trips, whatever the partitions and the workers."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.corpora import evaluation
from modelcast.corpora.evaluation import EvaluateJob, gather_parts, reduce_evaluation
from modelcast.corpora.evaluation_tables import read_tables, write_tables_of
from modelcast.corpora.executors.base import AbstractExecutor
from modelcast.corpora.executors.here import HereExecutor
from modelcast.corpora.executors.processes import ProcessExecutor
from modelcast.corpora.ingestion import ingest
from modelcast.corpora.layout import Corpus
from modelcast.corpora.running import run_job
from modelcast.corpora.sources import find_sources
from modelcast.io.results import summary_document
from modelcast.io.write_trips import write_parquet
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.runtime.trip.context import ContextSettings
from modelcast.station.banks import PAPER_BANK, bank_from_text
from modelcast.study.evaluate import evaluate, evaluate_trip
from modelcast.study.recording import HeldRecords
from modelcast.study.result import EvaluationResult
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive

SETTINGS = EvaluationSettings(
    (0.3,), (0.0, 0.4), seeds=2, protocol="recorded", keep_samples="first", bank=PAPER_BANK
)
SHORT = "made/short"


def made_trips() -> list[Trajectory]:
    """Five drives at two rates by five vehicles, and a trip too short for a window."""
    drives = [
        replace(
            generate_drive(seed=seed, duration_s=90.0, rate_hz=5.0 if seed == 3 else 10.0).truth,
            trip_id=f"made/{seed}",
            vehicle=f"car {seed}",
        )
        for seed in range(5)
    ]
    return [*drives, build_trajectory(SHORT, np.arange(9) * 0.1, np.zeros((9, 2)), speed_mps=np.zeros(9))]


@pytest.fixture(scope="module")
def corpora(tmp_path_factory: pytest.TempPathFactory) -> Callable[[int], Corpus]:
    """The same trips in some partitions."""
    folder = tmp_path_factory.mktemp("corpora")
    write_parquet(made_trips(), folder / "made.parquet")
    found: dict[int, Corpus] = {}

    def make(partitions: int) -> Corpus:
        if partitions not in found:
            sources = find_sources([folder / "made.parquet"])
            found[partitions] = ingest(sources, folder / str(partitions), partitions=partitions).corpus
        return found[partitions]

    return make


@pytest.fixture(scope="module")
def alone(corpora: Callable[[int], Corpus]) -> EvaluationResult:
    """The evaluation of the same trips without a corpus."""
    corpus = corpora(1)
    return evaluate(corpus.trips(corpus.partitions[0]), SETTINGS)


def evaluated(
    corpus: Corpus, settings: EvaluationSettings, results: Path, executor: AbstractExecutor
) -> EvaluationResult:
    """What the parts of all partitions give together."""
    return reduce_evaluation(corpus, settings, run_job(corpus, EvaluateJob(settings), results, executor))


def drawn(result: EvaluationResult) -> list[Any]:
    """What figures draw, in a form that compares."""
    assert result.timeline is not None
    assert result.manoeuvre is not None
    curves = [(one.policy, one.packet_error_ratio, one.tracking_error_m.tolist()) for one in result.ecdfs]
    return [curves, result.timeline.tracking_error_m.tolist(), result.manoeuvre.truth_m.tolist()]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("partitions", "executor"), [(1, HereExecutor()), (2, ProcessExecutor(2)), (5, HereExecutor())]
)
def test_it_is_the_evaluation_of_the_trips_to_the_last_bit(
    corpora: Callable[[int], Corpus],
    alone: EvaluationResult,
    tmp_path: Path,
    partitions: int,
    executor: AbstractExecutor,
) -> None:
    corpus = corpora(partitions)
    assert len(corpus.partitions) > 1 or partitions == 1
    found = evaluated(corpus, SETTINGS, tmp_path / "work", executor)
    assert summary_document(found) == summary_document(alone)
    assert drawn(found) == drawn(alone)
    assert list(found.failures) == [SHORT]


def test_its_tables_are_one_data_set(
    corpora: Callable[[int], Corpus], alone: EvaluationResult, tmp_path: Path
) -> None:
    """Rows of all trips, messages and samples, whichever partition they are in."""
    evaluated(corpora(2), SETTINGS, tmp_path, HereExecutor())
    rates, events, samples = (
        pl.read_parquet(tmp_path / "parts" / "*" / f"{name}.parquet")
        for name in ("rates", "events", "samples")
    )
    pooled = rates.group_by("policy").agg(pl.col("updates").sum() / pl.col("duration_s").sum())
    wanted = {row.policy: row.update_rate_hz for row in alone.rates if row.trip == "all"}
    assert dict(pooled.iter_rows()) == pytest.approx(wanted)
    assert rates["message_bytes"].sum() == events["size_bytes"].sum()
    assert len(samples) == sum(one.errors["along_track_m"].size for one in alone.samples)


def test_of_many_trips_only_pooled_rows_are_in_the_result(
    corpora: Callable[[int], Corpus],
    alone: EvaluationResult,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(evaluation, "MOST_LISTED", 3)
    result = evaluated(corpora(2), SETTINGS, tmp_path, HereExecutor())
    for name in ("rates", "references", "tracking"):
        pooled = [repr(row) for row in getattr(alone, name) if row.trip == "all"]
        assert [repr(row) for row in getattr(result, name)] == pooled
    assert result.trips == alone.trips


def test_a_few_of_many_trips_are_listed(
    corpora: Callable[[int], Corpus], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What counts is how many trips there are results of, not how many the corpus has."""
    monkeypatch.setattr(evaluation, "MOST_LISTED", 2)
    job = EvaluateJob(replace(SETTINGS, packet_error_ratios=(), references=False), pattern="made/[12]")
    outcome = run_job(corpora(2), job, tmp_path, HereExecutor())
    gathered, each_trip = gather_parts(outcome)
    assert (each_trip, [trip.id for trip in gathered.trips]) == (True, ["made/1", "made/2"])
    (outcome.parts[0].folder / "trips.parquet").unlink()
    with pytest.raises(DataFormatError, match=r"trips\.parquet"):
        gather_parts(outcome)


def test_parts_of_the_same_settings_are_kept_and_others_made_anew(
    corpora: Callable[[int], Corpus], tmp_path: Path
) -> None:
    rates = replace(SETTINGS, packet_error_ratios=())
    kept = [
        run_job(corpora(2), EvaluateJob(settings), tmp_path, HereExecutor()).kept
        for settings in (rates, rates, replace(rates, thresholds_m=(0.4,)))
    ]
    assert kept == [0, len(corpora(2).partitions), 0]


def test_the_map_of_a_trip_asked_for(corpora: Callable[[int], Corpus], tmp_path: Path) -> None:
    asked = replace(SETTINGS, packet_error_ratios=(), map_at=("made/2", 40.0))
    result = evaluated(corpora(2), asked, tmp_path, HereExecutor())
    assert result.manoeuvre is not None
    assert (result.manoeuvre.trip, result.manoeuvre.start_s) == (
        "made/2",
        pytest.approx(39.5),
    )  # half a second before
    with pytest.raises(ConfigError, match="no trip named made/9"):
        evaluated(corpora(2), replace(asked, map_at=("made/9", 1.0)), tmp_path, HereExecutor())


def test_a_trip_that_fails_costs_itself_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    good, other = made_trips()[:2]

    def fail_of_one(trip: Trajectory, *rest: Any, **more: Any) -> Any:
        if trip.trip_id == other.trip_id:
            raise FloatingPointError("no good")
        return evaluate_trip(trip, *rest, **more)

    monkeypatch.setattr(evaluation, "evaluate_trip", fail_of_one)
    job = EvaluateJob(replace(SETTINGS, packet_error_ratios=()))
    job.run(iter([other, good]), tmp_path)
    assert [trip.id for trip in read_tables(tmp_path, each_trip=True).trips] == [good.trip_id]
    assert "no good" in (tmp_path / "failures.json").read_text()


def test_a_trip_that_runs_out_of_memory_is_tried_again(
    corpora: Callable[[int], Corpus], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(trip: Trajectory, *rest: Any, **more: Any) -> Any:
        if trip.trip_id == "made/1":
            raise MemoryError("too little")
        return evaluate_trip(trip, *rest, **more)

    job = EvaluateJob(replace(SETTINGS, packet_error_ratios=(), references=False))
    with monkeypatch.context() as patch:
        patch.setattr(evaluation, "evaluate_trip", fail)
        outcome = run_job(corpora(2), job, tmp_path, HereExecutor())
    assert list(outcome.failures.values()) == ["MemoryError: too little"]
    again = run_job(corpora(2), job, tmp_path, HereExecutor())
    assert (again.kept, dict(again.failures), sum(part.trips for part in again.parts)) == (1, {}, 6)


def test_what_a_part_holds_reads_back_as_it_was(tmp_path: Path) -> None:
    (trip,) = made_trips()[3:4]
    found = evaluate_trip(trip, SETTINGS, records=HeldRecords())
    write_tables_of(found, {trip.trip_id: found.sharpness}, tmp_path)
    read = read_tables(tmp_path, each_trip=True)
    for name in ("trips", "counts", "references", "tracking", "illustration"):
        assert repr(getattr(read, name)) == repr(getattr(found, name))
    assert list(read.pools) == list(found.pools)
    for key, pool in found.pools.items():
        assert repr(read.pools[key]) == repr(pool)
    (tmp_path / "pools.parquet").write_bytes(b"PAR1")
    with pytest.raises(DataFormatError, match=r"pools\.parquet"):
        read_tables(tmp_path, each_trip=True)


def test_every_setting_is_in_the_key() -> None:
    changed = (
        {"thresholds_m": (0.7,)},
        {"seed": 5},
        {"references": False},
        {"trained_on": frozenset({"a"})},
        {"bank": Bank((ConstantVelocity(),))},
    )
    jobs = [EvaluateJob(SETTINGS), *(EvaluateJob(replace(SETTINGS, **one)) for one in changed)]
    jobs += [EvaluateJob(SETTINGS, pattern="a/*"), EvaluateJob(SETTINGS, asked="more")]
    assert len({job.key for job in jobs}) == len(jobs)


def test_a_bank_that_reads_context_is_not_shared_out() -> None:
    bank = bank_from_text("free-context")
    with pytest.raises(ConfigError, match="reads context"):
        EvaluateJob(replace(SETTINGS, bank=bank, context=ContextSettings()))
