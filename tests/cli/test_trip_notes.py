"""Notes of trips: what is printed of many is one document, however they were kept."""

import json
from pathlib import Path

import numpy as np
import pytest

from modelcast.cli import trip_notes
from modelcast.cli.app import run
from modelcast.report.inspection import trip_document
from modelcast.station.receiver.plausibility import trip_findings
from modelcast.trips.inspection import inspect
from modelcast.trips.manoeuvres.rank import count_manoeuvres
from modelcast.trips.trajectory import build_trajectory


def note(name: str):
    t_s = 0.1 * np.arange(60)
    trip = build_trajectory(
        name, t_s, np.stack([10.0 * t_s, 0.0 * t_s], axis=1),
        speed_mps=10.0 + 0.0 * t_s, heading_rad=np.full(60, np.pi / 2),
    )  # fmt: skip
    quality = inspect(trip)
    return quality, trip_findings(trip), count_manoeuvres(trip, quality)


@pytest.mark.parametrize("names", [["a/1"], ["a/1", "b/2", "c/3"]])
def test_the_document_is_what_one_encoder_would_write(
    names: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(trip_notes, "_IN_MEMORY_BYTES", 100)
    kept = [note(name) for name in names]
    with trip_notes.TripNotes() as notes:
        for one in kept:
            notes.add(*one)
        notes.say_json({"x.csv": "has [] in it"}, {"y": "no [] either"}, (0.2, 0.5))
    trips = [trip_document(*one, thresholds_m=(0.2, 0.5)) for one in kept]
    whole = {
        "failures": {"x.csv": "has [] in it"}, "skipped": {"y": "no [] either"},
        "thresholds_m": [0.2, 0.5], "trips": trips,
    }  # fmt: skip
    assert capsys.readouterr().out == json.dumps(whole, indent=2, sort_keys=True) + "\n"


def test_what_a_file_was_taken_for_stands_before_its_first_trip_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two vehicles in one file, and another file that is written otherwise; JSON says it of every trip."""
    rows = [f"{k / 10},{1.5 * k},0,{v},{54.0},7" for k in range(60) for v in "ab"]
    (tmp_path / "one.csv").write_text("\n".join(["Time,X,Y,vehicle,v_ego,rpm", *rows]) + "\n")
    other = [row.replace(",", ";") for row in rows if ",a," in row]
    (tmp_path / "two.csv").write_text("\n".join(["Time;X;Y;vehicle;v_ego;rpm", *other]) + "\n")
    paths = [str(tmp_path / "one.csv"), str(tmp_path / "two.csv")]
    assert run(["trips", *paths, "--quiet"]) == 0
    shown = capsys.readouterr().out
    assert shown.index("columns") < shown.index("duration")
    assert shown.count("t=Time, east=X, north=Y, vehicle=vehicle") == 2, "once a file, not once a trip"
    assert "v_ego, rpm (perhaps: --columns 'speed_kmh=v_ego')" in " ".join(shown.split())
    assert "Time in seconds; X and Y in metres" in " ".join(shown.split())
    assert run(["trips", *paths, "--json", "--quiet"]) == 0
    found = json.loads(capsys.readouterr().out)["trips"]
    assert [one["understood"]["notes"]["text"] for one in found] == ["commas", "commas", "semicolons"]
    assert found[0]["understood"]["suggested"] == {"speed_kmh": "v_ego"}
    assert found[0]["source"] == "csv"
