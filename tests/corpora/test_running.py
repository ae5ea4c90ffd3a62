"""A job over a corpus: every trip once, whatever the partitions, the workers and the interruptions."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from length_job import LengthJob, lengths
from modelcast.core.exceptions import ConfigError
from modelcast.corpora.executors.base import AbstractExecutor
from modelcast.corpora.executors.here import HereExecutor
from modelcast.corpora.executors.processes import ProcessExecutor
from modelcast.corpora.ingestion import ingest
from modelcast.corpora.job import read_failures
from modelcast.corpora.layout import Corpus
from modelcast.corpora.parts import DONE_FILE
from modelcast.corpora.running import Tally, claimed_results, run_job
from modelcast.corpora.sources import find_sources

FIRST = "april/10100-1"


@pytest.fixture
def made(sources: Callable[[], Path], tmp_path: Path) -> Callable[[int], Corpus]:
    """Make a corpus of the good sources in some partitions."""

    def make(partitions: int) -> Corpus:
        files = sorted(file for file in sources().iterdir() if file.stem in {"april", "may", "odd"})
        folder = tmp_path / f"corpus-{partitions}"
        return ingest(find_sources(files), folder, partitions=partitions).corpus

    return make


@pytest.fixture
def job(tmp_path: Path) -> LengthJob:
    """The job, and the folder in which its runs are noted."""
    (tmp_path / "runs").mkdir()
    return LengthJob(tmp_path / "runs")


def runs(job: LengthJob) -> int:
    """How many partitions have been worked on."""
    return len(list(job.runs.iterdir()))


def contents(folder: Path) -> dict[str, bytes]:
    """Every file of a results folder."""
    return {str(one.relative_to(folder)): one.read_bytes() for one in folder.rglob("*") if one.is_file()}


@pytest.mark.parametrize("partitions", [1, 2, 5])
def test_what_is_found_does_not_depend_on_partitions(
    made: Callable[[int], Corpus], job: LengthJob, tmp_path: Path, partitions: int
) -> None:
    corpus = made(partitions)
    wanted = {trip.trip_id: len(trip) for one in corpus.partitions for trip in corpus.trips(one)}
    outcome = run_job(corpus, job, tmp_path / "results", HereExecutor())
    assert lengths(outcome) == dict(sorted(wanted.items()))
    assert len(wanted) == 21
    assert (outcome.failures, outcome.kept) == ({}, 0)
    assert sum(part.trips for part in outcome.parts) == 21
    assert sum(part.rows for part in outcome.parts) == sum(wanted.values())


@pytest.mark.parametrize("clusters", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_every_executor_writes_the_same_octets(
    made: Callable[[int], Corpus], job: LengthJob, tmp_path: Path, *, clusters: bool
) -> None:
    corpus = made(5)
    executors: list[AbstractExecutor] = [HereExecutor(), ProcessExecutor(1), ProcessExecutor(2)]
    if clusters:
        pytest.importorskip("distributed")
        from modelcast.corpora.executors.cluster import ClusterExecutor  # noqa: PLC0415 - of an extra

        executors += [ClusterExecutor("local:1"), ClusterExecutor("local:2")]
    for at, executor in enumerate(executors):
        run_job(corpus, job, tmp_path / f"results-{at}", executor)
    first, *others = [contents(tmp_path / f"results-{at}") for at in range(len(executors))]
    assert all(other == first for other in others)
    assert runs(job) == len(corpus.partitions) * len(executors)


def test_what_is_done_is_not_done_again(
    made: Callable[[int], Corpus], job: LengthJob, tmp_path: Path
) -> None:
    corpus = made(5)
    before = run_job(corpus, job, tmp_path / "results", HereExecutor())
    shutil.rmtree(before.parts[1].folder)
    tallies: list[Tally] = []
    after = run_job(corpus, job, tmp_path / "results", HereExecutor(), watch=tallies.append)
    count, rows = len(corpus.partitions), sum(part.rows for part in before.parts)
    assert (runs(job), after.kept, after.parts) == (count + 1, count - 1, before.parts)
    kept = rows - before.parts[1].rows
    assert tallies == [Tally(count - 1, count, kept, rows, kept), Tally(count, count, rows, rows, kept)]


def test_a_part_of_other_settings_or_another_partition_is_done_anew(
    made: Callable[[int], Corpus], job: LengthJob, tmp_path: Path
) -> None:
    corpus = made(2)
    run_job(corpus, job, tmp_path / "results", HereExecutor())
    run_job(corpus, replace(job, version="2"), tmp_path / "results", HereExecutor())
    assert runs(job) == 4
    mark = tmp_path / "results" / "parts" / corpus.partitions[0].name / DONE_FILE
    mark.write_text(mark.read_text().replace(corpus.partitions[0].digest, "0" * 64))
    run_job(corpus, replace(job, version="2"), tmp_path / "results", HereExecutor())
    assert runs(job) == 5
    outcome = run_job(made(1), replace(job, version="2"), tmp_path / "results", HereExecutor())
    assert [one.name for one in (tmp_path / "results" / "parts").iterdir()] == [outcome.parts[0].partition]


@pytest.mark.parametrize("damage", ["", "{", '{"format": "modelcast part"}', "[]"])
def test_a_damaged_part_is_done_anew(
    made: Callable[[int], Corpus], job: LengthJob, tmp_path: Path, damage: str
) -> None:
    corpus = made(1)
    before = run_job(corpus, job, tmp_path / "results", HereExecutor())
    (before.parts[0].folder / DONE_FILE).write_text(damage)
    assert run_job(corpus, job, tmp_path / "results", HereExecutor()) == before
    assert runs(job) == 2


def test_a_trip_that_fails_stops_nothing(
    made: Callable[[int], Corpus], job: LengthJob, tmp_path: Path
) -> None:
    outcome = run_job(made(2), replace(job, fails=FIRST), tmp_path / "results", HereExecutor())
    failed = {trip: why for part in outcome.parts for trip, why in read_failures(part.folder).items()}
    assert failed == {FIRST: "ValueError: too long"}
    assert len(lengths(outcome)) == 20
    assert FIRST not in lengths(outcome)
    assert sum(part.trips for part in outcome.parts) == 21


def test_a_partition_that_fails_is_named_and_tried_anew(
    made: Callable[[int], Corpus], job: LengthJob, tmp_path: Path
) -> None:
    corpus = made(5)
    home = next(
        one.name for one in corpus.partitions if FIRST in [trip.trip_id for trip in corpus.trips(one)]
    )
    broken = run_job(corpus, replace(job, breaks=FIRST), tmp_path / "results", HereExecutor())
    assert broken.failures == {home: f"ValueError: {FIRST} breaks its partition"}
    assert len(broken.parts) == len(corpus.partitions) - 1
    assert not (tmp_path / "results" / "parts" / home).exists()
    whole = run_job(corpus, job, tmp_path / "results", HereExecutor())
    assert (whole.failures, whole.kept) == ({}, len(broken.parts))
    assert len(whole.parts) == len(corpus.partitions)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["processes", pytest.param("cluster", marks=pytest.mark.slow)])
def test_a_worker_that_is_killed_in_a_partition_costs_nothing(
    made: Callable[[int], Corpus], job: LengthJob, tmp_path: Path, kind: str
) -> None:
    executor: AbstractExecutor = ProcessExecutor(2)
    if kind == "cluster":
        pytest.importorskip("distributed")
        from modelcast.corpora.executors.cluster import ClusterExecutor  # noqa: PLC0415 - of an extra

        executor = ClusterExecutor("local:2")
    corpus = made(5)
    outcome = run_job(corpus, replace(job, dies=FIRST), tmp_path / "results", executor)
    assert (job.runs / "died").exists()
    assert outcome.failures == {}
    assert len(lengths(outcome)) == 21
    run_job(corpus, job, tmp_path / "other", HereExecutor())
    assert contents(tmp_path / "results") == contents(tmp_path / "other")
    assert not list((tmp_path / "results" / "parts").glob(".*"))


def test_a_second_run_into_the_same_results_is_refused(
    made: Callable[[int], Corpus], job: LengthJob, tmp_path: Path
) -> None:
    results = tmp_path / "results"
    corpus = made(1)
    with claimed_results(results, "lengths"):
        with ProcessExecutor(1).start() as crew:
            ((_, answer),) = crew.as_done(_claimed, [results])
        run_job(corpus, job, results, HereExecutor())  # the holder itself goes on
    assert (
        answer
        == f"another modelcast lengths is writing to {results}: wait for it, or name another output folder"
    )
    with ProcessExecutor(1).start() as crew:
        assert dict(crew.as_done(_claimed, [results])) == {results: "claimed"}


def _claimed(results: Path) -> str:
    """What another process is told that wants the folder."""
    try:
        with claimed_results(results, "lengths"):
            return "claimed"
    except ConfigError as error:
        return str(error)


@pytest.mark.parametrize("name", ["notes.txt", "job.json"])
def test_a_folder_with_other_files_is_left_alone(
    made: Callable[[int], Corpus], job: LengthJob, tmp_path: Path, name: str
) -> None:
    results = tmp_path / "results"
    results.mkdir()
    (results / name).write_text("{}")
    with pytest.raises(ConfigError, match="no folder of unfinished work of modelcast lengths"):
        run_job(made(1), job, results, HereExecutor())
    assert contents(results) == {name: b"{}"}
