"""OdeBsmJson: both forms of the core data, the time of a message, objects in any arrangement."""

import json

import numpy as np
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io.json_records import MOST_CHARACTERS
from modelcast.io.trips import read_trips

COUNT = 12


def trips_of(made, records, name="m.json"):
    return list(read_trips(made.write(name, made.ode(records)), "ode-bsm"))


def coded(made, at, wrap=lambda core: {"coreData": core}, **metadata: object):
    record = made.ode_record(at, **metadata)
    record["payload"]["data"] = wrap(made.ode_codes(at))
    return record


def test_values_are_si_and_times_unix(made):
    (trip,) = read_trips(made.valid("ode-bsm"))
    assert trip.trip_id == "messages/24EF0000"
    assert trip.start_unix_s == pytest.approx(1502395734.3)
    assert trip.speed_mps.tolist() == [10.0] * COUNT
    assert trip.acceleration_mps2 == pytest.approx(-0.15)
    assert trip.yaw_rate_radps == pytest.approx(np.radians(1.5))
    assert np.hypot(*np.diff(trip.position_m, axis=0).T) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    "wrap",
    [
        lambda core: {"coreData": core},
        lambda core: {"messageId": 20, "value": {"BasicSafetyMessage": {"coreData": core}}},
        lambda core: {
            "MessageFrame": {"messageId": "20", "value": {"BasicSafetyMessage": {"coreData": core}}}
        },
    ],
)
def test_codes_of_the_standard_are_read_wherever_they_stand(made, wrap):
    (trip,) = trips_of(made, [coded(made, at, wrap) for at in range(COUNT)])
    assert trip.speed_mps == pytest.approx(10.0)
    assert trip.acceleration_mps2 == pytest.approx(-0.15)
    assert trip.yaw_rate_radps == pytest.approx(np.radians(1.5))
    assert trip.heading_rad is None, "28800 is unavailable"
    assert trip.origin.latitude_deg == 40.0
    assert trip.origin.altitude_m == pytest.approx(-15.2)


def test_times_go_on_over_the_minute(made):
    (trip,) = trips_of(made, [made.ode_record(at) for at in range(80)])
    assert np.diff(trip.t_s) == pytest.approx(0.1)


def test_the_time_of_reception_stands_in_for_that_of_the_record(made):
    stamps = {"recordGeneratedAt": "", "odeReceivedAt": "2017-08-10T20:08:57.462Z"}
    (trip,) = trips_of(made, [made.ode_record(at, **stamps) for at in range(COUNT)])
    assert trip.start_unix_s == pytest.approx(1502395734.3)


def test_a_zone_by_name_gives_no_absolute_time(made):
    records = [coded(made, at, recordGeneratedAt="2017-12-05 14:18:54.400 [ET]") for at in range(COUNT)]
    (trip,) = trips_of(made, records)
    assert trip.start_unix_s is None
    assert trip.clock_s is not None
    with pytest.raises(
        DataFormatError, match=r"row 13: the time of the message is .* unlike the first of the file"
    ):
        trips_of(made, [*records, made.ode_record(COUNT)])


def test_messages_without_a_time_or_place_are_counted(made):
    records = [made.ode_record(at) for at in range(COUNT)]
    records[3] = made.ode_record(3, core={"secMark": 65535})
    records[4] = made.ode_record(4, core={"secMark": None})
    records[5] = made.ode_record(
        5, core={"position": {"latitude": None, "longitude": None, "elevation": None}}
    )
    records[6] = made.ode_record(6, core={"position": {"latitude": 90.0000001, "longitude": 180.0000001}})
    (trip,) = trips_of(made, [*records, made.ode_record(11)])
    assert dict(trip.reading.skipped) == {"time missing": 2, "position unavailable": 2, "duplicate time": 1}


def test_values_that_the_standard_calls_unavailable_are_missing_in_either_form(made):
    """2001 stands for itself in some programs' acceleration in m/s², and 450 is no heading."""
    wrong = {"speed": 163.82, "heading": 450.123, "accelSet": {"accelLong": 2001, "accelYaw": None}}
    records = [made.ode_record(at, core=wrong if at == 8 else {}) for at in range(20)]
    (trip,) = trips_of(made, records)
    told = {
        f"{word} missing, last value held": 1 for word in ("speed", "heading", "acceleration", "yaw rate")
    }
    assert dict(trip.reading.repaired) == told


def test_other_messages_are_told_and_counted(made):
    other = made.ode_record(0)
    other["payload"] = {"dataType": "us.dot.its.jpo.ode.model.OdeTravelerInformationMessage", "data": {}}
    path = made.write("m.json", made.ode([other, *[made.ode_record(at) for at in range(COUNT)], other]))
    told = {}
    (trip,) = read_trips(path, on_skipped=told.__setitem__)
    assert len(trip) == COUNT
    assert told == {"m": "no usable row: 2 of another kind (OdeTravelerInformationMessage)"}


def test_kinds_of_other_messages_are_told_up_to_a_number(made):
    others = [made.ode_record(0) for _ in range(30)]
    for at, other in enumerate(others):
        other["payload"] = {"dataType": f"kind{at}", "data": {}}
    told = {}
    path = made.write("m.json", made.ode([*others, *[made.ode_record(at) for at in range(COUNT)]]))
    assert len(list(read_trips(path, on_skipped=told.__setitem__))) == 1
    assert told["m"].count("kind") == 16 + told["m"].count("another kind")
    assert told["m"].endswith("14 of another kind (unnamed)")


def test_the_arrangement_of_the_objects_changes_nothing(made):
    records = [made.ode_record(at) for at in range(COUNT)]
    texts = {
        "lines": made.ode(records).decode(),
        "array": json.dumps(records),
        "array of lines": "[\n" + ",\n".join(map(json.dumps, records)) + "\n]\n",
        "broken": "\ufeff" + "\n".join(json.dumps(record, indent=2) for record in records),
        "joined": "".join(map(json.dumps, records)),
    }
    trips = {
        name: next(iter(read_trips(made.write("m.json", text), "ode-bsm"))) for name, text in texts.items()
    }
    for trip in trips.values():
        assert trip.position_m.tobytes() == trips["lines"].position_m.tobytes()
        assert trip.reading.rows == COUNT


def test_objects_over_the_end_of_a_part_are_read_whole(made, monkeypatch):
    whole = trips_of(made, [made.ode_record(at) for at in range(COUNT)])
    for size in (50, 333, 1000):
        monkeypatch.setattr("modelcast.io.json_records.PART_CHARACTERS", size)
        (again,) = read_trips(made.folder / "m.json", "ode-bsm")
        assert again.position_m.tobytes() == whole[0].position_m.tobytes()


def test_a_cut_last_object_is_counted(made):
    path = made.valid("ode-bsm")
    path.write_bytes(path.read_bytes()[:-30])
    (trip,) = read_trips(path)
    assert (len(trip), dict(trip.reading.skipped)) == (COUNT - 1, {"partial last line": 1})


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('{"metadata": {}, "payload": NaN}', "row 1: is no JSON, or not complete: NaN is no JSON"),
        ("[" * 50 + "3", "row 1: is no JSON object: '3'"),
        ('{"a": ' * 100_000, "row 1: is no JSON, or not complete"),
        ('{"a": "' + "x" * (2 * MOST_CHARACTERS) + "\n", "row 1: is no JSON, or not complete"),
        ('{"payload": {}}', "row 1: has no metadata"),
        (
            '{"metadata": {}, "payload": {"dataType": "J2735Bsm"}}',
            "row 1: a basic safety message has no coreData",
        ),
        ('{"metadata": {}, "payload": {"data": {"coreData": {"id": 7}}}}', "row 1: id is 7, not a name"),
        ('{"metadata": {}, "payload": {"dataType": "J2735Spat"}}', "holds no basic safety message"),
    ],
)
def test_what_is_no_message_is_refused(made, text, told):
    with pytest.raises(DataFormatError, match=told):
        list(read_trips(made.write("m.json", text), "ode-bsm"))


@pytest.mark.parametrize(
    ("core", "told"),
    [
        ({"speed": "fast"}, "row 3: speed is 'fast', not a finite number"),
        ({"speed": True}, "row 3: speed is True, not a finite number"),
        ({"speed": 1e300}, r"row 3: speed is 1e.300, not a finite number"),
        ({"position": 5}, "row 3: latitude should stand in an object, not in 5"),
        ({"id": "a\nb"}, "row 3: id is 'a"),
    ],
)
def test_a_wrong_value_is_told_with_its_object(made, core, told):
    with pytest.raises(DataFormatError, match=told):
        trips_of(made, [made.ode_record(0), made.ode_record(1), made.ode_record(2, core=core)])


def test_codes_have_to_be_whole_numbers(made):
    record = coded(made, 0)
    record["payload"]["data"]["coreData"]["speed"] = 10.5
    with pytest.raises(
        DataFormatError, match=r"row 1: speed_mps is 10.5, no whole number of the standard's steps"
    ):
        trips_of(made, [record])
