"""``modelcast ingest``: what it says, and how it ends."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from modelcast.cli.app import run
from modelcast.cli.octets import parse_octets
from modelcast.cli.reading import PARTLY_FAILED
from modelcast.core.exceptions import ConfigError
from modelcast.corpora.layout import open_corpus

Sources = Callable[[], Path]


def test_it_tells_what_was_made_skipped_and_failed(
    sources: Sources, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    code = run(["ingest", str(sources()), "--out", str(tmp_path / "c"), "--jobs", "2", "--partitions", "3"])
    told = capsys.readouterr()
    assert code == PARTLY_FAILED
    assert "data/broken.csv: row 301: 3 fields where the format has 27" in told.err.replace("\n", "")
    assert told.out.splitlines()[0].startswith("22 trips, ")
    assert f"in 3 partitions written to {tmp_path / 'c'}" in told.out
    assert "skipped: 18 no fix, 2 position unavailable" in told.out
    assert "no trip from data/notes.txt" in told.out
    assert len(open_corpus(tmp_path / "c").partitions) == 3


def test_json_has_the_same_counts(sources: Sources, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    files = [str(sources() / name) for name in ("may.csv", "lost.csv")]
    assert run(["ingest", *files, "--out", str(tmp_path / "c"), "--json", "--jobs", "1"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["trips"], document["rows"], document["samples"]) == (7, 243, 241)
    assert document["skipped_rows"] == {"no fix": 6, "position unavailable": 2}
    assert [one["trips"] for one in document["partitions"]] == [7]


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        ([], "name at least one trip file or folder"),
        (["data", "--partitions", "0"], "at least 1 partition"),
        (["data", "--memory", "much"], "--memory much: name an amount"),
        (["data", "--format", "tape"], "tape"),
        (["nothing.csv"], "no usable trip"),
    ],
)
def test_bad_usage_is_told_and_leaves_nothing(
    sources: Sources, tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], problem: str
):
    words = [str(sources()) if word == "data" else word for word in words]
    assert run(["ingest", *words, "--out", str(tmp_path / "c")]) == 2
    assert problem in capsys.readouterr().err.replace("\n", " ")
    assert not (tmp_path / "c" / "ingest.json").exists()


@pytest.mark.parametrize(
    ("text", "octets"),
    [("1", 1), ("2GB", 2 * 10**9), ("1.5 GiB", 3 * 2**29), ("500m", 5 * 10**8), ("4kib", 4096)],
)
def test_amounts_are_decimal_or_binary(text: str, octets: int):
    assert parse_octets(text, "--memory") == octets


@pytest.mark.parametrize("text", ["", "0", "GB", "-1GB", "1PB", "1 2"])
def test_what_is_no_amount_is_refused(text: str):
    with pytest.raises(ConfigError, match="--memory"):
        parse_octets(text, "--memory")
