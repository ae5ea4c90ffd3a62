"""``modelcast evaluate`` on a corpus."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from modelcast.cli.app import run
from modelcast.cli.reading import PARTLY_FAILED
from modelcast.corpora.layout import open_corpus
from modelcast.io.write_trips import write_parquet
from modelcast.world.drive import generate_drive


@pytest.fixture(scope="module")
def corpus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Five generated drives in two partitions."""
    folder = tmp_path_factory.mktemp("command")
    drives = [
        replace(generate_drive(seed=seed, duration_s=90.0).truth, trip_id=f"drive/{name}", vehicle=name)
        for seed, name in enumerate(("red", "blue", "green", "white", "grey"))
    ]
    write_parquet(drives, folder / "drive.parquet")
    words = ["ingest", str(folder / "drive.parquet"), "--partitions", "2", "--jobs", "1", "--quiet"]
    assert run([*words, "--out", str(folder / "corpus")]) == 0
    assert len(open_corpus(folder / "corpus").partitions) == 2
    return folder / "corpus"


def evaluated(corpus: Path, out: Path, *more: str) -> int:
    return run(["evaluate", str(corpus), "--out", str(out), "--rates-only", "--quiet", "--jobs", "1", *more])


@pytest.fixture(scope="module")
def done(corpus: Path) -> Path:
    """Where the corpus was evaluated."""
    out = corpus.parent / "done"
    assert evaluated(corpus, out) == 0
    return out


def unfinished_folder(out: Path) -> Path:
    return out.with_name(f"{out.name}.unfinished")


@pytest.mark.slow
def test_a_corpus_gives_the_files_of_an_evaluation_and_its_parts(
    corpus: Path, done: Path, tmp_path: Path
) -> None:
    """And the same to the byte by its run.json."""
    one, other = done, tmp_path / "other"
    assert not unfinished_folder(one).exists()
    assert {path.name for path in one.iterdir()} == {
        "summary.json", "report.html", "run.json", "figures", "parts", "MANIFEST.txt",
    }  # fmt: skip
    assert list(json.loads((one / "run.json").read_text())["inputs"]) == [str(corpus / "corpus.json")]
    assert run(["evaluate", "--rerun", str(one / "run.json"), "--out", str(other), "--quiet"]) == 0
    for name in ("summary.json", "report.html", "run.json"):
        assert (one / name).read_bytes() == (other / name).read_bytes()


@pytest.mark.slow
def test_an_interrupted_run_goes_on(corpus: Path, done: Path, tmp_path: Path) -> None:
    """Parts that lie beside the output folder are not made again."""
    work = unfinished_folder(tmp_path / "out")
    work.mkdir()
    (work / "job.json").write_text('{"format": "modelcast job", "job": "evaluate"}\n')
    shutil.copytree(done / "parts", work / "parts")
    made = {path.relative_to(work): path.stat().st_ino for path in (work / "parts").rglob("*.parquet")}
    assert evaluated(corpus, tmp_path / "out") == 0
    assert {path: (tmp_path / "out" / path).stat().st_ino for path in made} == made


@pytest.mark.slow
def test_a_part_that_fails_is_named_and_the_rest_is_there(
    corpus: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    damaged = tmp_path / "damaged"
    shutil.copytree(corpus, damaged)
    rows = sorted((damaged / "rows").rglob("*.parquet"))
    rows[0].write_bytes(b"PAR1 no more")
    out = tmp_path / "out"
    assert evaluated(damaged, out) == PARTLY_FAILED
    assert "is left out" in capsys.readouterr().err
    summary = json.loads((out / "summary.json").read_text())
    assert len(summary["failures"]) == len(rows) - 1 == len(list((out / "parts").iterdir())) == 1
    kept = list((unfinished_folder(out) / "parts").iterdir())
    assert [path.name for path in kept] == [path.name for path in (out / "parts").iterdir()]


@pytest.mark.slow
def test_some_trips_of_a_corpus(corpus: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert evaluated(corpus, out, "--trip", "drive/*re*") == 0
    trips = json.loads((out / "summary.json").read_text())["trips"]
    assert [trip["id"] for trip in trips] == ["drive/green", "drive/grey", "drive/red"]


@pytest.mark.parametrize("option", [("--memory", "1GiB"), ("--cluster", "local:2"), ("--jobs", "2")])
def test_what_is_for_a_corpus_is_refused_for_files(
    corpus: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], option: tuple[str, str]
) -> None:
    path = str(corpus.parent / "drive.parquet")
    assert run(["evaluate", path, "--out", str(tmp_path / "out"), *option]) == 2
    assert "corpus" in capsys.readouterr().err


def test_a_run_of_which_nothing_is_done_leaves_nothing(corpus: Path, tmp_path: Path) -> None:
    """Another command may then have the same output folder."""
    damaged = tmp_path / "damaged"
    shutil.copytree(corpus, damaged)
    for path in (damaged / "rows").rglob("*.parquet"):
        path.write_bytes(b"PAR1 no more")
    assert evaluated(damaged, tmp_path / "out") != 0
    assert not unfinished_folder(tmp_path / "out").exists()
