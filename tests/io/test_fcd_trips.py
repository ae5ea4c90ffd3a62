"""SUMO's floating-car data as trips: every form, middles, people, absences, bounded memory."""

import numpy as np
import pytest
from tests.io.test_fcd_sumo import FORMS, GRID_DEG, PLACE, geographic, only, traffic, write_csv, write_xml

from modelcast.core.exceptions import DataFormatError
from modelcast.core.kinds import CYCLIST_M
from modelcast.io.registry import detect_format, get_reader
from modelcast.io.trips import read_trips

STEPS, OTHERS = 40, "no usable row: 40 person, 40 container"
HALF_M = 2.25
"""Of the usual vehicle."""


def written(path, rows, form="xml"):
    FORMS[form](path, rows)
    return path


@pytest.mark.parametrize("form", FORMS)
def test_every_form_is_found_and_gives_the_same_trips(made, form):
    path = written(made.folder / "traffic", traffic(), form)
    assert detect_format(path) == "sumo-fcd"
    told = {}
    first, second = read_trips(path, on_skipped=told.__setitem__)
    assert [first.trip_id, second.trip_id] == ["traffic/a", "traffic/b"]
    if "plain" not in form:
        assert sum(int(word) for word in told["traffic/others"].split() if word.isdigit()) == 2 * STEPS
    expected, _ = read_trips(written(made.folder / "same.xml", traffic()))
    assert first.position_m == pytest.approx(expected.position_m, abs=1e-6)
    assert first.heading_rad == pytest.approx(expected.heading_rad, abs=1e-9)


def test_a_name_that_ends_in_gz_names_its_trips_without_it(made):
    path = written(made.folder / "run.xml.gz", traffic(), "xml.gz")
    assert [trip.trip_id for trip in read_trips(path)] == ["run/a", "run/b"]


def test_positions_are_middles_and_times_one_clock(made):
    first, second = read_trips(written(made.folder / "t.xml", traffic()))
    assert second.position_m[:, 1] == pytest.approx(20.0 + 15.0 * (second.t_s + 0.5) - HALF_M, abs=1e-6)
    assert second.position_m[:, 0] == pytest.approx(-50.0)
    on_bend = first.position_m - [0.0, -60.0]
    assert np.hypot(*on_bend.T) == pytest.approx(np.hypot(60.0, HALF_M)), "half a length along the heading"
    assert (first.clock_s, second.clock_s) == (0.0, pytest.approx(0.5))
    assert dict(first.reading.repaired) == {"length not known, usual one taken": STEPS}
    assert (first.origin, first.start_unix_s, first.acceleration_mps2) == (None, None, None)


def test_a_length_in_the_file_goes_before_the_usual_one(made):
    rows = [{**row, "length": 12.0} for row in traffic() if row["tag"] == "vehicle"]
    _, second = read_trips(written(made.folder / "t.xml", rows))
    assert second.position_m[0, 1] == pytest.approx(20.0 + 7.5 - 6.0, abs=1e-6)
    assert dict(second.reading.repaired) == {}


def test_longitude_and_latitude_are_laid_out_and_headings_turned(made):
    path = written(made.folder / "t.xml", geographic(traffic(), grid_deg=GRID_DEG))
    _, second = read_trips(path)
    assert second.origin.latitude_deg == pytest.approx(PLACE.latitude_deg, abs=0.01)
    assert second.heading_rad == pytest.approx(np.radians(GRID_DEG), abs=2e-3)
    step = np.diff(second.position_m, axis=0)
    assert np.hypot(*step.T) == pytest.approx(1.5, abs=1e-3)


def test_without_a_heading_front_bumpers_are_kept_and_counted(made):
    rows = only([row for row in traffic() if row["tag"] == "vehicle"], "x", "y", "speed", "lane")
    _, second = read_trips(written(made.folder / "t.xml", rows))
    assert second.position_m[0, 1] == pytest.approx(20.0 + 7.5, abs=1e-6)
    assert second.heading_rad is None
    assert dict(second.reading.repaired) == {"heading not known, front bumper kept": STEPS - 5}


def test_bicycles_are_told_apart_and_persons_reported(made):
    told = {}
    trips = list(read_trips(made.valid("sumo-fcd"), on_skipped=told.__setitem__))
    assert [trip.trip_id for trip in trips] == ["fcd/a", "fcd/bicycle-b"]
    assert trips[1].position_m[0, 0] == pytest.approx(-0.5 * CYCLIST_M[0])
    assert told == {"fcd/others": "no usable row: 12 person"}


def test_who_is_away_for_a_while_has_a_gap(made):
    rows = [row for row in traffic() if not (row["id"] == "a" and 1.0 < row["time"] < 2.0)]
    first, _ = read_trips(written(made.folder / "t.xml", rows))
    assert first.gaps_s == pytest.approx([1.0])


def test_vehicles_are_gathered_in_any_memory_alike(made):
    path = written(made.folder / "t.xml", traffic())
    expected = list(read_trips(path))
    found = sorted(
        get_reader("sumo-fcd").within(STEPS * 72 + 2000).read(str(path)), key=lambda one: one.trip_id
    )
    for one, other in zip(found, expected, strict=True):
        assert one.position_m.tobytes() == other.position_m.tobytes()
    with pytest.raises(DataFormatError, match="the trip t/a has over"):
        list(get_reader("sumo-fcd").within(500).read(str(path)))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda rows: [*rows, rows[0]], "occurs twice at 0.0 s"),
        (lambda rows: [{**row, "speed": 400.0} for row in rows], "as the speeds say"),
        (lambda rows: only(rows, "x", "speed", "angle"), "north (attribute y of SUMO) is blank"),
        (lambda _: [], "no vehicle in the file"),
    ],
)
def test_what_is_wrong_is_an_error_as_for_scenarios(made, change, message):
    with pytest.raises(DataFormatError) as caught:
        list(read_trips(written(made.folder / "t.xml", change(traffic()))))
    assert message in str(caught.value)


def test_tables_with_other_names_are_left_to_csv_and_parquet(made):
    rows = [row for row in traffic() if row["id"] == "b"]
    path = made.folder / "t.csv"
    write_csv(path, rows, head="", mark=",")
    path.write_text(
        path.read_text().replace("lane", "road").replace("angle", "heading_deg").replace("pos", "s")
    )
    assert detect_format(path) == "csv"


@pytest.mark.parametrize(
    ("inside", "message"), [("<x>" * 80, "deeper than 64"), ("<!--" + "x" * 9_000_000, "a tag")]
)
def test_hostile_xml_ends_in_an_error(made, inside, message):
    with pytest.raises(DataFormatError, match=message):
        list(read_trips(made.write("t.xml", f'<fcd-export><timestep time="0">{inside}'), "sumo-fcd"))


def test_entities_are_refused(made):
    path = made.folder / "t.xml"
    write_xml(path, traffic())
    path.write_text('<!DOCTYPE x [<!ENTITY a "b">]>' + path.read_text().partition("?>")[2])
    with pytest.raises(DataFormatError, match="declares the entity 'a'"):
        list(read_trips(path))
