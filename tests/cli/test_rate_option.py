"""--rate: trips as read so many times a second, wherever a command reads trips."""

import gzip
import json
from pathlib import Path

import pytest

from modelcast.cli.app import run
from modelcast.cli.evaluate_options import EvaluateOptions
from modelcast.cli.reading import TripSource
from modelcast.cli.run_record import EvaluationRun, load_run, write_run
from modelcast.io.trips import read_trips


@pytest.fixture
def drives(tmp_path: Path) -> Path:
    """One trip at 10 Hz and one at 1 Hz, packed."""
    rows = [f"{0.1 * at:.1f},{at},0,fast" for at in range(101)]
    rows += [f"{at}.0,{10 * at},0,slow" for at in range(11)]
    path = tmp_path / "drives.csv.gz"
    path.write_bytes(gzip.compress(("t,x,y,vehicle\n" + "\n".join(rows) + "\n").encode()))
    return path


def test_convert_writes_what_was_read_at_the_rate_and_tells_of_slower_trips(
    drives: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out.parquet"
    assert run(["convert", str(drives), "--rate", "4", "--out", str(out)]) == 0
    (trip,) = read_trips(out)
    assert (trip.trip_id, trip.dt_s, len(trip)) == ("drives/fast", 0.25, 41)
    assert trip.position_m[:5, 0].tolist() == [0.0, 2.0, 5.0, 7.0, 10.0]
    assert "drives/slow: recorded at 1 Hz, slower than the rate of 4 Hz" in capsys.readouterr().out


def test_trips_tells_what_was_taken(drives: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trips", str(drives), "--rate", "2", "--json"]) == 0
    (trip,) = json.loads(capsys.readouterr().out)["trips"]
    assert trip["repaired"]["taken at 2 Hz"] == trip["samples"] == 21


@pytest.mark.parametrize("rate", ["0", "-1", "nan", "inf"])
def test_a_rate_that_is_none_is_refused(drives: Path, rate: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trips", str(drives), "--rate", rate]) == 2
    assert "--rate must be above 0 and at most 1,000,000 Hz" in capsys.readouterr().err


def test_a_run_record_keeps_the_rate_and_older_ones_have_none(drives: Path, tmp_path: Path) -> None:
    for rate_hz in (5.0, None):
        asked = EvaluationRun((drives,), None, None, "*", EvaluateOptions(), rate_hz)
        write_run(tmp_path, "evaluate", asked.arguments(), asked.inputs)
        record = tmp_path / "run.json"
        assert load_run(record) == asked
    document = json.loads(record.read_text())
    del document["arguments"]["rate"]
    record.write_text(json.dumps(document))
    assert load_run(record) == asked


def test_a_source_without_a_rate_gives_trips_as_recorded(drives: Path) -> None:
    assert [len(trip) for trip in TripSource([drives])] == [101, 11]
