"""Notes of trips: what is printed of many is one document, however they were kept."""

import json

import numpy as np
import pytest

from modelcast.cli import trip_notes
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
