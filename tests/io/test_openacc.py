"""OpenACC: cars by their place in Vehicle_order, one frame, missing cells, columns of the campaigns."""

from math import radians

import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.io.openacc import read_platoon
from modelcast.io.trips import read_trips


def row(at, second="10.0,90,50,16.8,46.9,230", time=None):
    return f"{5370 + at / 10 if time is None else time},10.0,{100 + at},50,16.8,46.9,229,{second},5.5"


def test_car_k_is_the_kth_name_and_cars_without_columns_are_reported(made):
    told = {}
    trips = list(read_trips(made.write("p.csv", made.openacc()), on_skipped=told.__setitem__))
    assert [trip.trip_id for trip in trips] == ["p/FIRST", "p/SECOND"]
    assert told == {"p/GHOST": "named in Vehicle_order but without columns"}


def test_cars_share_the_frame_of_the_first_valid_sample(made):
    first, second = read_trips(made.write("p.csv", made.openacc()))
    assert first.origin == second.origin == Origin(46.9, 16.8, 229.0)
    assert first.position_m[0].tolist() == [0, 0]
    assert second.position_m[1].tolist() == [-9, 0]
    assert second.up_m[0] == 1.0
    assert first.heading_rad is None


def test_blank_cells_leave_a_gap_and_are_counted(made):
    rows = [row(at, second=",,,,," if 3 <= at < 7 else "10.0,90,50,16.8,46.9,230") for at in range(12)]
    _, second = read_trips(made.write("p.csv", made.openacc(rows)))
    assert second.segments.tolist() == [0, 3, 8]
    assert dict(second.reading.skipped) == {"position missing": 4}


def test_missing_speed_is_held(made):
    rows = [row(at, second=f"{'' if at == 5 else at},90,50,16.8,46.9,230") for at in range(12)]
    _, second = read_trips(made.write("p.csv", made.openacc(rows)))
    assert second.speed_mps[5] == 4.0
    assert dict(second.reading.repaired) == {"speed missing, last value held": 1}


def test_car_with_blank_cells_only_is_reported(made):
    told = {}
    rows = [row(at, second=",,,,,") for at in range(4)]
    (only,) = read_trips(made.write("p.csv", made.openacc(rows)), on_skipped=told.__setitem__)
    assert only.trip_id == "p/FIRST"
    assert told["p/SECOND"] == "no usable row: 4 position missing"


def test_cut_last_line_counts_for_every_car(made):
    for trip in read_trips(made.write("p.csv", made.openacc()[:-40])):
        assert trip.reading.rows == 12
        assert dict(trip.reading.skipped) == {"partial last line": 1}


def test_time_running_backwards_is_an_error(made):
    rows = [row(0), row(2), row(1)]
    with pytest.raises(
        DataFormatError, match=r"row 9: time of p/FIRST does not increase: 5370\.1 after 5370\.2"
    ):
        list(read_trips(made.write("p.csv", made.openacc(rows))))


def test_column_without_a_name_is_an_error(made):
    with pytest.raises(DataFormatError, match=r"row 6: Speed3 has no name; Vehicle_order names 2 cars"):
        list(read_trips(made.write("p.csv", made.openacc(order="GHOST,FIRST,"))))


def test_two_cars_of_one_model_keep_different_names(made):
    trips = read_trips(made.write("p.csv", made.openacc(order="GHOST,FIRST,FIRST,")))
    assert [trip.trip_id for trip in trips] == ["p/FIRST-2", "p/FIRST-3"]


def test_a_platoon_keeps_the_clock_of_its_file(made):
    rows = [row(at, second=",,,,," if at < 4 else f"10.0,{90 + at},50,16.8,46.9,230") for at in range(12)]
    platoon = read_platoon(made.write("p.csv", made.openacc(rows)))
    assert platoon.slots == 2
    assert platoon.active[:, 0].all()
    assert platoon.active[:, 1].tolist() == [False] * 4 + [True] * 8
    assert (platoon.position_m[4:, 0, 0] - platoon.position_m[4:, 1, 0]).tolist() == pytest.approx([10.0] * 8)
    assert platoon.heading_rad[5, 0] == pytest.approx(1.5707963)


def test_a_platoon_without_a_car_is_an_error(made):
    rows = [f"{5370 + at / 10},,,,,,,,,,,,," for at in range(4)]
    with pytest.raises(DataFormatError, match="no car"):
        read_platoon(made.write("p.csv", made.openacc(rows)))


FIELDS = "Speed{k},Lat{k},Lon{k},Alt{k},E{k},N{k},U{k},Driver{k}"


def campaign(fields, angle, *, step_deg=1e-5, count=40, extra=""):
    """Return a file of two cars that drive north, 20 m apart, in the columns of another campaign."""
    same = {"Speed": 11.12, "Lon": angle(20.0), "E": 0.0, "U": 7.0, "Driver": "ACC", "VE": 0.0, "VN": 11.12,
            "VU": 0.0, "Acc": 0.25, "IVS": 15.0, "Yaw": 1.0}  # fmt: skip

    def cell(name: str, at: int) -> str:
        k = int(name[-1])
        north_deg = at * step_deg + k * 1.8e-4
        moving = {"Lat": angle(10.0 + north_deg), "Alt": 300.0 + k, "N": 110_600.0 * north_deg}
        return str((same | moving)[name[:-1]])

    names = ",".join(fields.format(k=k) for k in (1, 2)).split(",") + ([extra] if extra else [])
    rows = [",".join([f"{at / 10}", *(cell(name, at) for name in names)]) for at in range(count)]
    head = [
        "Date,1,2,2020",
        "Vehicle_order,LEAD,TAIL",
        "Number_of_vehicles,2",
        "ACC,1",
        "Distance_setting,min",
    ]
    return "\n".join([*head, ",".join(["Time", *names]), *rows]) + "\n"


@pytest.mark.parametrize(
    "fields", [FIELDS, "Speed{k},VE{k},VN{k},VU{k},Lat{k},Lon{k},E{k},N{k}", "Speed{k},Lat{k},Lon{k}"]
)
@pytest.mark.parametrize("angle", [float, radians])
def test_degrees_and_radians_give_the_same_trip(made, fields, angle):
    first, second = read_trips(made.write("p.csv", campaign(fields, angle, extra="IVS1")))
    assert (first.trip_id, len(first), dict(first.reading.skipped)) == ("p/LEAD", 40, {})
    assert first.origin.latitude_deg == pytest.approx(10.00018)
    assert first.position_m[39] == pytest.approx([0.0, 43.1], abs=0.2)
    assert (second.position_m - first.position_m)[:, 1] == pytest.approx([19.9] * 40, abs=0.1)


def test_near_the_equator_the_motion_tells_degrees(made):
    text = campaign(FIELDS, lambda degrees: degrees - 9.5 if degrees < 15 else 1.0)
    first, _ = read_trips(made.write("p.csv", text))
    assert first.origin.latitude_deg == pytest.approx(0.50018)


def test_accelerations_are_read(made):
    first, _ = read_trips(made.write("p.csv", campaign("Speed{k},E{k},N{k},Acc{k}", float)))
    assert first.acceleration_mps2.tolist() == [0.25] * 40
    assert (first.origin, first.up_m) == (None, None)


def test_an_unknown_column_is_an_error_that_names_it(made):
    with pytest.raises(DataFormatError, match=r"row 6: column 'Yaw1' is not known. Known are Speed, E, N"):
        list(read_trips(made.write("p.csv", campaign(FIELDS, float, extra="Yaw1"))))


def test_a_file_without_positions_is_an_error(made):
    with pytest.raises(DataFormatError, match=r"row 6: no car has the columns E and N, or Lat and Lon"):
        list(read_trips(made.write("p.csv", campaign("Speed{k},Driver{k}", float))))


def test_latitudes_beyond_the_pole_are_an_error(made):
    with pytest.raises(DataFormatError, match=r"row 7: lat is 100\.0\d*, beyond 90"):
        list(
            read_trips(made.write("p.csv", campaign("Speed{k},Lat{k},Lon{k}", lambda degrees: 10 * degrees)))
        )
