"""`compare` over a corpus gives what it gives of all trips together, whatever the partitions and workers."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import modelcast
from modelcast.cli.app import USAGE, run
from modelcast.cli.reading import PARTLY_FAILED
from modelcast.cli.signals import INTERRUPTED
from modelcast.core.exceptions import ConfigError
from modelcast.corpora.comparison import ComparisonJob, pool_comparison, why_not_shared
from modelcast.corpora.executors.here import HereExecutor
from modelcast.corpora.ingestion import ingest
from modelcast.corpora.layout import Corpus
from modelcast.corpora.running import run_job
from modelcast.corpora.sources import find_sources
from modelcast.io.comparison import comparison_document
from modelcast.io.write_trips import write_parquet
from modelcast.station.banks import BASELINE_BANK, named_bank
from modelcast.study.compare.candidate import AbstractCandidate, FixedCandidate, TrainedCandidate
from modelcast.study.compare.free import with_free
from modelcast.study.compare.run import compare
from modelcast.study.compare.settings import CompareSettings
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import build_trajectory
from modelcast.world.drive import generate_drive

WORDS = (
    "--rates-only",
    "--route-by",
    "trip",
    "--threshold",
    "0.5",
    "--bank",
    "cv",
    "paper",
    "--resamples",
    "50",
    "--quiet",
)
SETTINGS = CompareSettings(EvaluationSettings((0.3, 0.5), ()), route_by="trip", resamples=50)
CANDIDATES = with_free(
    (FixedCandidate("cv", BASELINE_BANK), FixedCandidate("paper", named_bank("paper").bank)),
    SETTINGS.evaluation,
)
SHORT = "d/0"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Callable[[int], Corpus]:
    """Make a corpus of four drives, and of a trip too short to compare, in some partitions."""
    folder = tmp_path_factory.mktemp("drives")
    drives = [replace(generate_drive(seed, 90.0).input, trip_id=f"d/{seed}") for seed in (4, 1, 3, 2)]
    write_parquet([*drives, build_trajectory(SHORT, [0.0, 0.1], np.ones((2, 2)))], folder / "d.parquet")
    known: dict[int, Corpus] = {}

    def make(partitions: int) -> Corpus:
        if partitions not in known:
            out = folder.with_name(f"corpus-{partitions}")
            known[partitions] = ingest(find_sources([folder]), out, partitions=partitions).corpus
        return known[partitions]

    return make


def test_trips_of_one_name_are_refused(made: Callable[[int], Corpus], tmp_path: Path) -> None:
    job = ComparisonJob(CANDIDATES, SETTINGS, asked="")
    outcome = run_job(made(2), job, tmp_path / "results", HereExecutor())
    twice = replace(outcome, parts=(*outcome.parts, outcome.parts[0]))
    with pytest.raises(ConfigError, match=r"two trips of the corpus are called d/\d"):
        pool_comparison(twice, job, failures={}, skipped={})


@pytest.mark.parametrize("partitions", [1, 2, 5])
def test_it_is_the_comparison_of_all_trips_together(
    made: Callable[[int], Corpus], tmp_path: Path, partitions: int
) -> None:
    corpus = made(partitions)
    trips = [trip for one in corpus.partitions for trip in corpus.trips(one)]
    wanted = compare(sorted(trips, key=lambda trip: trip.trip_id), CANDIDATES, SETTINGS)
    job = ComparisonJob(CANDIDATES, SETTINGS, asked="")
    outcome = run_job(corpus, job, tmp_path / "results", HereExecutor())
    found = pool_comparison(outcome, job, failures={}, skipped={})
    assert comparison_document(found) == comparison_document(wanted)
    assert found.counts == wanted.counts
    assert found.failures == {SHORT: "its longest part has 2 samples, a window needs 13: record longer"}
    assert len(corpus.partitions) == 1 or partitions > 1


@pytest.mark.slow
def test_the_command_writes_the_same_octets_whatever_the_partitions(
    made: Callable[[int], Corpus], tmp_path: Path
) -> None:
    found: list[dict[str, bytes]] = []
    for name, partitions in (("one", 1), ("two", 5)):
        words = str(made(partitions).path), "--out", str(tmp_path / name), "--jobs", "1"
        assert run(["compare", *words, *WORDS]) == PARTLY_FAILED
        files = (tmp_path / name).iterdir()
        found.append({one.name: one.read_bytes() for one in files if one.name != "run.json"})
    assert found[0] == found[1]
    assert "messages.parquet" in found[0]
    assert sorted(one.name for one in tmp_path.iterdir()) == ["one", "two"]
    recorded = json.loads((tmp_path / "one" / "run.json").read_text())["inputs"]
    assert [Path(name).name for name in recorded] == ["corpus.json"]


def test_what_is_not_shared_says_so_in_one_line_and_is_done(
    made: Callable[[int], Corpus], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    corpus = str(made(2).path)
    words = [word for word in WORDS if word not in {"--route-by", "trip"}]
    assert run(["compare", corpus, "--out", str(tmp_path / "out"), *words]) == PARTLY_FAILED
    assert capsys.readouterr().err == (
        "modelcast: the trips of a corpus are taken together, in one process: routes are found among all "
        "pairs of trips: --route-by trip takes each as its own\n"
    )
    assert (tmp_path / "out" / "summary.json").exists()
    assert run(["compare", corpus, "--out", str(tmp_path / "o"), *words, "--jobs", "2"]) == USAGE
    assert "--jobs: this is not shared among workers: routes are found" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("candidates", "settings", "reason"),
    [
        (CANDIDATES, replace(SETTINGS, evaluation=EvaluationSettings((0.5,), (0.0,))), "--rates-only"),
        (CANDIDATES, replace(SETTINGS, route_by="file"), "--route-by trip"),
        ((TrainedCandidate("t", lambda _trips, shared: shared),), SETTINGS, "t learns from"),
    ],
)
def test_what_needs_all_trips_is_told(
    candidates: tuple[AbstractCandidate, ...], settings: CompareSettings, reason: str
) -> None:
    assert why_not_shared(CANDIDATES, SETTINGS) is None
    assert reason in (why_not_shared(candidates, settings) or "")


@pytest.mark.parametrize(
    ("option", "why"),
    [
        (("--cluster", "local:2"), "--cluster is for a corpus"),
        (("--memory", "2GB"), "--memory is for a corpus"),
        (("--cluster", "route"), "--resample-by route"),
    ],
)
def test_options_for_a_corpus_are_refused_of_files(
    made: Callable[[int], Corpus],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    option: tuple[str, str],
    why: str,
) -> None:
    file = made(1).path / "rows"
    words = str(file), "--out", str(tmp_path / "out"), *WORDS, *option
    assert run(["compare", *words]) == USAGE
    assert why in capsys.readouterr().err


INTERRUPTED_RUN = """
import signal, sys
from modelcast.cli import app, corpus_run
from modelcast.corpora.executors.here import HereExecutor

inner = corpus_run.run_job

def run_job(corpus, job, results, executor, *, watch):
    def watched(tally):
        watch(tally)
        if tally.done == 1 and not tally.kept_rows:
            signal.raise_signal(signal.SIGINT)
    return inner(corpus, job, results, executor, watch=watched)

corpus_run.run_job = run_job
sys.exit(app.run(sys.argv[1:]))
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="a console's Ctrl-C is another thing there")
def test_an_interrupt_ends_with_130_and_one_line_and_the_next_run_goes_on(
    made: Callable[[int], Corpus], tmp_path: Path
) -> None:
    corpus = made(5)
    known = {**os.environ, "PYTHONPATH": str(Path(modelcast.__file__).parent.parent)}
    words = "compare", str(corpus.path), "--out", str(tmp_path / "out"), *WORDS
    found = subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", INTERRUPTED_RUN, *words, "--jobs", "2"],
        env=known,
        capture_output=True,
        text=True,
        check=False,
    )
    assert not (tmp_path / "out").exists()
    # Both workers may have written further parts before they were ended.
    done = len(list((tmp_path / "out.unfinished" / "parts").glob("*/done.json")))
    assert 1 <= done < 5
    kept = "1 partition is kept" if done == 1 else f"{done} partitions are kept"
    line = f"modelcast: interrupted; {kept}: the same command goes on from there\n"
    assert (found.returncode, found.stderr) == (INTERRUPTED, line)
    assert run([*words, "--jobs", "1"]) == PARTLY_FAILED
    assert (tmp_path / "out" / "summary.json").exists()
    assert not (tmp_path / "out.unfinished").exists()
