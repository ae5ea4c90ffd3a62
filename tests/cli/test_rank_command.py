"""Claims about ``modelcast trips --rank``."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from modelcast.cli.app import run
from modelcast.io.trips import read_trips
from modelcast.io.write_trips import write_csv
from modelcast.report.figures.course import plot_course
from modelcast.trips.manoeuvres.rank import count_manoeuvres
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.manoeuvre_drive import generate_known_drive


def straight(name: str) -> Trajectory:
    t_s = np.arange(0.0, 30.0, 0.1)
    return build_trajectory(name, t_s, np.stack([12.0 * t_s, 0.0 * t_s], axis=1))


@pytest.fixture(scope="module")
def corpus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A straight trip, a rich one and a shorter one, in this order."""
    path = tmp_path_factory.mktemp("corpus") / "corpus.csv"
    rich, poor = generate_known_drive(4, 400.0).truth, generate_known_drive(5, 60.0).truth
    write_csv([straight("made/plain"), rich, poor], path)
    return path


def test_the_richest_trip_comes_first(corpus: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trips", "--rank", str(corpus), "--json"]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    document = json.loads(shown.out)
    assert [trip["rank"] for trip in document["trips"]] == [1, 2, 3]
    assert [trip["trip"].partition("/")[2] for trip in document["trips"]] == ["4", "5", "plain"]
    assert (document["counted"], document["failures"], document["skipped"]) == (3, {}, {})
    totals = [trip["manoeuvres"] for trip in document["trips"]]
    assert totals == [len(trip["found"]) for trip in document["trips"]]
    assert totals == sorted(totals, reverse=True)
    assert totals[2] == 0


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_the_whole_order_is_written_whatever_is_shown(
    suffix: str, corpus: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / f"order{suffix}"
    assert run(["trips", "--rank", str(corpus), "--top", "1", "--out", str(out), "--quiet"]) == 0
    text = capsys.readouterr().out
    assert "known/4" in text
    assert "known/5" not in text
    assert "1 of 3 trips shown; 0 skipped, 0 failed" in text
    table = pl.read_csv(out) if suffix == ".csv" else pl.read_parquet(out)
    assert table["rank"].to_list() == [1, 2, 3]
    kinds = ["lane_changes", "turns", "u_turns", "roundabouts", "stops", "hard_brakes"]
    assert table.select(kinds).sum_horizontal().to_list() == table["manoeuvres"].to_list()
    for row, trip in zip(table.iter_rows(named=True), sorted(read_trips(corpus), key=_rank), strict=True):
        assert row["manoeuvres"] == count_manoeuvres(trip).total


def _rank(trip: Trajectory) -> tuple[int, ...]:
    return (-count_manoeuvres(trip).total,)


def test_the_courses_of_the_trips_shown_are_drawn_the_same_each_time(corpus: Path, tmp_path: Path) -> None:
    folders = [tmp_path / name for name in ("one", "two")]
    for folder in folders:
        asked = ["trips", "--rank", str(corpus), "--top", "2", "--figures", str(folder), "--quiet"]
        assert run(asked) == 0
    names = {path.name for path in folders[0].iterdir()} - {"MANIFEST.txt"}
    assert names == {f"course_00{at}.{suffix}" for at in (1, 2) for suffix in ("png", "svg", "pdf")}
    for name in names:
        assert (folders[0] / name).read_bytes() == (folders[1] / name).read_bytes()


def test_a_course_shows_every_kind_that_was_found() -> None:
    trip = generate_known_drive(4, 400.0).truth
    counts = count_manoeuvres(trip)
    figure = plot_course(trip, counts)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    for kind, count in counts.by_kind.items():
        assert any(kind.value.lower() in text.lower() for text in labels) == (count > 0)
        assert not count or any(text.endswith(f"({count})") for text in labels)
    with pytest.raises(ValueError, match="plain"):
        plot_course(straight("made/plain"), counts)


def test_a_file_that_cannot_be_read_costs_itself_alone(
    corpus: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bad = tmp_path / "bad.csv"
    bad.write_text("nothing,known\n1,2\n", encoding="utf-8")
    assert run(["trips", "--rank", str(bad), str(corpus)]) == 3
    shown = capsys.readouterr()
    assert "3 trips; 0 skipped, 1 failed" in shown.out
    assert "bad.csv" in shown.err


@pytest.mark.parametrize(
    ("asked", "problem"),
    [
        (["--rank", "--out", "order.txt"], "end it in"),
        (["--rank", "--top", "0"], "at least 1"),
        (["--top", "3"], "belong to --rank"),
        (["--figures", "somewhere"], "belong to --rank"),
    ],
)
def test_what_cannot_be_done_is_refused_before_the_work(
    asked: list[str], problem: str, corpus: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["trips", str(corpus), *asked]) == 2
    assert problem in capsys.readouterr().err


def test_the_table_fits_eighty_columns(
    corpus: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    assert run(["trips", "--rank", str(corpus)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    heading = next(line for line in lines if "total" in line)
    assert heading.split() == [
        "trip",
        "total",
        "lane",
        "turn",
        "U-turn",
        "round",
        "stop",
        "brake",
        "/km",
        "min",
        "km",
    ]
