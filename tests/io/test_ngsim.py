"""NGSIM: feet, three layouts, numbers that are given anew."""

import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io.trips import read_trips

FEET = 0.3048


def write(made, rows, *, header=True, name="t.csv"):
    return made.write(name, made.lines(rows, header=made.ngsim_header if header else None, end="\n"))


def test_feet_become_metres_and_milliseconds_unix_time(made):
    (trip,) = read_trips(made.valid("ngsim"))
    assert trip.trip_id == "trajectories/2-437"
    assert trip.position_m[1] == pytest.approx([16.4 * FEET, 39.4 * FEET])
    assert trip.speed_mps == pytest.approx(40.0 * FEET)
    assert trip.start_unix_s == pytest.approx(1118846980.2)
    assert trip.t_s[1] == 0.1
    assert trip.heading_rad is None


def test_the_three_layouts_give_the_same_trip(made):
    tables = {
        "plain": write(made, [made.ngsim_row(at) for at in range(5)]),
        "blanks": write(
            made, ["   " + made.ngsim_row(at, separator="   ") for at in range(5)], header=False, name="b.txt"
        ),
    }
    joined = made.ngsim_header.lower() + ",Location"
    rows = [made.ngsim_row(at) + ",us-101" for at in range(5)]
    tables["joined"] = made.write("j.csv", made.lines(rows, header=joined, end="\n"))
    trips = {name: next(iter(read_trips(path))) for name, path in tables.items()}
    assert [trip.source for trip in trips.values()] == ["ngsim"] * 3
    assert trips["joined"].trip_id == "j/us-101-2-437"
    for trip in trips.values():
        assert trip.position_m.tobytes() == trips["plain"].position_m.tobytes()
        assert trip.start_unix_s == trips["plain"].start_unix_s


def test_a_number_given_anew_in_another_period_is_another_vehicle(made):
    """By its Total_Frames where those differ, else by the time between."""
    later = 20 * 60_000
    rows = [made.ngsim_row(at) for at in range(5)]
    rows += [made.ngsim_row(at, start=later) for at in range(4)]
    rows += [made.ngsim_row(at, total=90) for at in range(3)]
    trips = {trip.trip_id: len(trip) for trip in read_trips(write(made, rows))}
    assert trips == {"t/2-437": 5, "t/2-437-2": 4, "t/2-90": 3}


def test_a_vehicle_unseen_for_a_minute_is_still_the_same(made):
    rows = [made.ngsim_row(at) for at in range(5)] + [made.ngsim_row(at, start=60_000) for at in range(5)]
    (trip,) = read_trips(write(made, rows))
    assert len(trip.segments) == 3


def test_rows_that_occur_twice_are_counted(made):
    rows = [made.ngsim_row(at) for at in (0, 1, 1, 2, 3, 3)]
    (trip,) = read_trips(write(made, rows))
    assert dict(trip.reading.skipped) == {"duplicate time": 2}


def test_other_numbers_without_a_header_are_not_taken_for_it(made):
    rows = [" ".join(["1"] * 18) for _ in range(5)]
    with pytest.raises(DataFormatError, match="no reader knows"):
        list(read_trips(write(made, rows, header=False, name="n.txt")))
    with pytest.raises(DataFormatError, match="neither the header nor a row of NGSIM"):
        list(read_trips(made.folder / "n.txt", "ngsim"))
