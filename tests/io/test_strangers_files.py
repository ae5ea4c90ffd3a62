"""Files as strangers bring them: a correct trip at once, or one error whose remedy gives it when copied.

All hold the same drive: 30 s at 10 Hz and 15 m/s, around a bend of 90 degrees in Bavaria. What is read of
each has to be that drive: a speed, heading or position in another unit that passes for the stated one fails.
"""

import gzip
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta

import numpy as np
import polars as pl
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin, enu_to_geodetic, wrap_angle_rad
from modelcast.io.trips import read_trips
from modelcast.trips.trajectory import Trajectory

COUNT, STEP_S, SPEED_MPS = 300, 0.1, 15.0
T = STEP_S * np.arange(COUNT)
HEADING_RAD = 0.3 + 0.5 * np.pi * np.clip((T - 10.0) / 10.0, 0.0, 1.0)
EAST, NORTH = (
    SPEED_MPS * STEP_S * np.concatenate([[0.0], np.cumsum(part)[:-1]])
    for part in (np.sin(HEADING_RAD), np.cos(HEADING_RAD))
)
LAT, LON, _ = enu_to_geodetic(np.stack([EAST, NORTH, 0.0 * T], axis=1), Origin(48.1, 11.5, 0.0)).T
TURN_RADPS = np.where((T >= 10.0) & (T < 20.0), 0.05 * np.pi, 0.0)
V, HEADING = np.full(COUNT, SPEED_MPS), np.degrees(HEADING_RAD)
BEGIN = datetime(2024, 3, 15, 23, 59, 50)  # noqa: DTZ001 - what a file without a zone says
UNIX_S = 1710547190.0
PLACE_M = 0.05
"""Seven decimals of a degree are 1 cm; a plane that touches elsewhere bends by less over 450 m."""

Cells = Sequence[str] | FloatArray


def numbers(column: FloatArray, form: str = ".9g") -> list[str]:
    return [format(cell, form) for cell in column]


def places(form: str = ".7f", **more: Cells) -> dict[str, Cells]:
    return {"time": T, "lat": numbers(LAT, form), "lon": numbers(LON, form), **more}


def plane(**more: Cells) -> dict[str, Cells]:
    return {"t": T, "x": EAST, "y": NORTH, **more}


def table(columns: Mapping[str, Cells], mark: str = ",", *, decimal: str = ".", end: str = "") -> str:
    """Return a table of text; `end` ends its rows."""
    cells = [
        [cell if isinstance(cell, str) else f"{cell:.9g}".replace(".", decimal) for cell in column]
        for column in columns.values()
    ]
    rows = [mark.join(row) + end for row in zip(*cells, strict=True)]
    return "\n".join([mark.join(columns), *rows]) + "\n"


def dates(form: str) -> list[str]:
    """Times of the drive as text; ``%f`` has three decimals."""
    return [(BEGIN + timedelta(seconds=round(t, 3))).strftime(form.replace("%f", "%f#")).replace("000#", "")
            for t in T]  # fmt: skip


@dataclass(frozen=True)
class Shape:
    """A file; what its error says where it is not read at once; what has to be there.

    `has` names the optional columns; `remedy` is the column map that the error, or the list of what is not
    used, has to show.
    """

    file: str | bytes
    error: str = ""
    has: str = ""
    name: str = "mine.csv"
    columns: Mapping[str, str] = field(default_factory=dict[str, str])
    said: Mapping[str, str] = field(default_factory=dict[str, str])
    counted: Mapping[str, int] = field(default_factory=dict[str, int])
    trips: int = 1


def minutes(degrees: FloatArray) -> list[str]:
    return [f"{100 * int(one) + 60 * (one % 1):.6f}" for one in degrees]


def with_gaps(column: FloatArray, word: str, step: int = 29) -> list[str]:
    """A column with a word in place of some cells, none of the first."""
    return [word if at and at % step == 0 else f"{cell:.9g}" for at, cell in enumerate(column)]


SHAPES = {
    "semicolons and decimal commas": Shape(
        table(plane(speed=V), ";", decimal=","), has="speed", said={"text": "semicolons, decimal commas"}
    ),
    "tabs": Shape(table(plane(speed=V), "\t"), has="speed", said={"text": "tabs"}),
    "every field in quotes": Shape(
        "\n".join(",".join(f'"{cell}"' for cell in line.split(",")) for line in table(plane()).splitlines())
    ),
    "a separator at the end of every row": Shape(table(plane(speed=V), end=","), has="speed"),
    "a separator at the end of header and rows": Shape(table(plane(), end=",").replace("y\n", "y,\n", 1)),
    "a row of units": Shape(
        table({"Time": ["s", *numbers(T)], "X": ["m", *numbers(EAST)], "Y": ["m", *numbers(NORTH)],
               "Speed": ["km/h", *numbers(3.6 * V)], "Heading": ["deg", *numbers(HEADING)]}),
        has="speed heading", said={"text": "commas, units in line 2"},
    ),
    "a row of units under names that state theirs": Shape(
        table({"t_s": ["s", *numbers(T)], "x_m": ["m", *numbers(EAST)], "y_m": ["m", *numbers(NORTH)],
               "heading_deg": ["deg", *numbers(HEADING)], "speed_kmh": ["km/h", *numbers(3.6 * V)]}),
        has="speed heading",
    ),
    "a row of units under names that are mapped": Shape(
        table({"Zeit": ["s", *numbers(T)], "a": ["m", *numbers(EAST)], "b": ["m", *numbers(NORTH)]}),
        columns={"t": "Zeit", "east": "a", "north": "b"},
    ),
    "two rows of names": Shape("GPS,GPS,GPS,CAN\n" + table(places(speed=V)), has="speed"),
    "a logger's lines before the header": Shape(
        "Logger X100, serial 17\nExported 2024-03-15\n\n" + table(places()),
        said={"text": "commas, header in line 4"},
    ),
    "comments": Shape("# made by hand\n# x, y in metres\n" + table(plane())),
    "a byte order mark and CRLF": Shape(b"\xef\xbb\xbf" + table(plane()).replace("\n", "\r\n").encode()),
    "gzip": Shape(gzip.compress(table(plane()).encode()), name="mine.csv.gz"),
    "dates with the day first and dots": Shape(
        table(places(time=dates("%d.%m.%Y %H:%M:%S.%f"))), said={"time": "a date and time without a zone"}
    ),
    "dates with the year last": Shape(
        table(places(time=dates("%d/%m/%Y %H:%M:%S.%f"))), "Say what comes first: --columns t_dmy=time"
    ),
    "dates with AM and PM, the month first": Shape(
        table(places(time=dates("%m/%d/%Y %I:%M:%S.%f %p"))), columns={"t_mdy": "time"},
        said={"time": "a date and time without a zone, the month first"},
    ),
    "times of day over midnight": Shape(
        table(places(time=dates("%H:%M:%S.%f"))), said={"time": "a time of day without a date"}
    ),
    "date and time of day in two columns": Shape(
        table({"Date": dates("%Y-%m-%d"), **places(time=dates("%H:%M:%S.%f"))}), said={"not used": "Date"}
    ),
    "days of a spreadsheet": Shape(
        table(places(time=numbers(45366.4 + T / 86400, ".9f"))), "too little for seconds.*t_days=time"
    ),
    "Unix seconds": Shape(table(places(time=numbers(UNIX_S + T, ".3f")))),
    "Unix milliseconds": Shape(
        table(places(time=numbers(1000 * (UNIX_S + T), ".0f"))),
        said={"time": "Unix milliseconds, told by their size"},
    ),
    "Unix microseconds": Shape(table(places(time=numbers(1e6 * (UNIX_S + T), ".0f")))),
    "Unix nanoseconds": Shape(
        table(places(time=[f"{1710547190 + at // 10}{at % 10}00000000" for at in range(COUNT)]))
    ),
    "milliseconds from the start": Shape(table(places(time=1000 * T, speed=V)), "t_ms=time", has="speed"),
    "1e-7 degrees": Shape(
        table(places(lat=numbers(1e7 * LAT, ".0f"), lon=numbers(1e7 * LON, ".0f"))), "lat_e7=lat,lon_e7=lon"
    ),
    "1e-7 degrees by name": Shape(
        table({"time": T, "latitude_e7": numbers(1e7 * LAT, ".0f"),
               "longitude_e7": numbers(1e7 * LON, ".0f")})
    ),
    "radians": Shape(
        table(places(lat=numbers(np.radians(LAT), ".10f"), lon=numbers(np.radians(LON), ".10f"))),
        "lat_rad=lat,lon_rad=lon",
    ),
    "radians by name": Shape(
        table({"time": T, "lat [rad]": numbers(np.radians(LAT), ".10f"),
               "lon [rad]": numbers(np.radians(LON), ".10f")})
    ),
    "latitude and longitude swapped, with speeds": Shape(
        table({"time": T, "lat": numbers(LON, ".7f"), "lon": numbers(LAT, ".7f"), "speed": V}),
        "lat=lon,lon=lat", has="speed",
    ),
    "a map's X and Y that are longitude and latitude": Shape(
        table({"t": T, "X": numbers(LON, ".7f"), "Y": numbers(LAT, ".7f")}), "lon=X,lat=Y"
    ),
    "UTM": Shape(
        table({"t": T, "Easting": 691000 + EAST, "Northing": numbers(5336000 + NORTH, ".3f")}),
        said={"position": "a grid of a map (as UTM; its zone is not known), counted from (700000, 5300000); "
              "north is the grid's"},
    ),
    "positions in feet": Shape(
        table(plane(x=EAST / 0.3048, y=NORTH / 0.3048, speed=V)), "east_ft=x,north_ft=y", has="speed"
    ),
    "km/h that no name tells": Shape(table(places(speed=3.6 * V)), "speed_kmh=speed", has="speed"),
    "miles an hour that no name tells": Shape(
        table(places(speed=V / 0.44704)), "speed_mph=speed", has="speed"
    ),
    "knots by name": Shape(table(places(**{"SOG (kn)": V * 3600 / 1852})), has="speed"),
    "knots behind the name": Shape(table(places(speed_knots=V * 3600 / 1852)), has="speed"),
    "a heading counted from east": Shape(
        table(plane(heading_deg=90.0 - HEADING)), "yaw_deg=heading_deg", has="heading"
    ),
    "a heading in radians called degrees": Shape(
        table(plane(heading_deg=HEADING_RAD)), "heading_rad=heading_deg", has="heading"
    ),
    "a heading in degrees called radians": Shape(
        table(plane(heading_rad=HEADING)), "heading_deg=heading_rad", has="heading"
    ),
    "a heading in radians from east called radians": Shape(
        table(plane(heading_rad=0.5 * np.pi - HEADING_RAD)), "yaw_rad=heading_rad", has="heading"
    ),
    "a yaw rate to the left called one to the right": Shape(
        table(plane(yaw_rate_radps=-TURN_RADPS)), "yaw_rate_left_radps=yaw_rate_radps"
    ),
    "a yaw rate in degrees called radians": Shape(
        table(plane(yaw_rate_radps=np.degrees(TURN_RADPS))), "yaw_rate_degps=yaw_rate_radps"
    ),
    "a yaw rate as it is stated": Shape(table(plane(yaw_rate_degps=np.degrees(TURN_RADPS)))),
    "a heading without a unit": Shape(
        table(plane(heading=HEADING)), said={"not used": "heading (perhaps: --columns 'heading_deg=heading')"}
    ),
    "a yaw without a unit": Shape(
        table(plane(yaw=0.5 * np.pi - HEADING_RAD)),
        said={"not used": "yaw (perhaps: --columns 'yaw_rad=yaw')"},
    ),
    "a speed of another name": Shape(
        table(plane(v_ego=3.6 * V, foo=V)),
        said={"not used": "v_ego, foo (perhaps: --columns 'speed_kmh=v_ego')"},
    ),
    "NaN and NA": Shape(
        table(plane(speed=with_gaps(V, "NaN"), heading_deg=with_gaps(HEADING, "NA"))), has="speed heading"
    ),
    "-999 for what is not known": Shape(
        table(places(lat=with_gaps(LAT, "-999", 50), heading_deg=with_gaps(HEADING, "-999"))), has="heading",
        counted={"position not known (-999)": 5, "heading not known (-999)": 10},
    ),
    "a column that is blank": Shape(table(plane(speed=[""] * COUNT))),
    "the same row twice": Shape(
        table({name: np.repeat(column, 2) for name, column in plane().items()}),
        "time of mine/vehicle does not increase.*leave one row per time",
    ),
    "rows out of order": Shape(
        table({name: column[::-1] for name, column in plane().items()}), "does not increase.*Sort the file"
    ),
    "several vehicles in turn, named by a column that is not known": Shape(
        table({name: np.repeat(column, 2) for name, column in plane().items()}
              | {"stationID": ["a", "b"] * COUNT}),
        "vehicle=stationID", trips=2,
    ),
    "several vehicles one behind the other": Shape(
        table({name: np.tile(column, 2) for name, column in plane().items()}
              | {"car_id": ["a"] * COUNT + ["b"] * COUNT}),
        trips=2,
    ),
    "clocks that jitter": Shape(table(plane(t=T + 0.01 * np.sin(37.0 * T)))),
    "names of rostopic": Shape(
        table({"%time": numbers(1e9 * (UNIX_S + T), ".0f"), "field.latitude": numbers(LAT, ".7f"),
               "field.longitude": numbers(LON, ".7f")}),
        "t=%time,lat=field.latitude,lon=field.longitude",
    ),
    "German names": Shape(
        table({"Zeitstempel": dates("%Y-%m-%d %H:%M:%S.%f"), "Breitengrad": numbers(LAT, ".7f"),
               "Längengrad": numbers(LON, ".7f"), "Geschwindigkeit": 3.6 * V}, ";").encode("cp1252"),
        "t=Zeitstempel,lat=Breitengrad,lon=Längengrad,speed_kmh=Geschwindigkeit", has="speed",
    ),
}  # fmt: skip

REFUSED = {
    "degrees and minutes": (
        "mine.csv", table(places(lat=minutes(LAT), lon=minutes(LON))), r"int\(lat / 100\) \+ \(lat mod 100\)"
    ),
    "degrees with their sign behind": (
        "mine.csv", table(places(lat=[f"{one:.6f}N" for one in LAT])), "as a decimal number, as 48.1173"
    ),
    "degrees, minutes and seconds": (
        "mine.csv", table(places(lat=["48°07'02.1\""] * COUNT)), "as a decimal number, as 48.1173"
    ),
    "Earth-centred positions": (
        "mine.csv",
        table({"t": T, "x": 4_182_000 + EAST, "y": 851_000 + NORTH, "z": 4_725_000 + 0 * T}),
        "counts from the middle of the Earth",
    ),
    "KML": ("mine.kml", '<?xml version="1.0"?><kml xmlns="http://www.opengis.net/kml/2.2"></kml>', "as GPX"),
    "GeoJSON": ("mine.geojson", '{"type": "FeatureCollection", "features": []}', "a row a point"),
    "TCX": ("mine.tcx", '<?xml version="1.0"?><TrainingCenterDatabase></TrainingCenterDatabase>', "as GPX"),
    "a workbook": ("mine.xlsx", b"PK\x03\x04" + bytes(200), "as CSV"),
    "a bag of ROS 1": ("mine.bag", b"#ROSBAG V2.0\n" + bytes(200), "rosbags-convert"),
    "MATLAB": ("mine.mat", b"MATLAB 5.0 MAT-file, Platform: GLNXA64" + bytes(200), "writetable"),
    "HDF5": ("mine.h5", b"\x89HDF\r\n\x1a\n" + bytes(200), "pandas"),
    "a measurement of MDF": ("mine.mf4", b"MDF     4.10    " + bytes(200), "asammdf"),
    "FIT": ("mine.fit", b"\x0e\x10\xd9\x07\x00\x10\x00\x00.FIT" + bytes(200), "as GPX"),
}  # fmt: skip


def right(trip: Trajectory, shape: Shape) -> None:
    """Check that a trip is the drive, with the optional columns that it has to have and no others."""
    assert len(trip) == COUNT
    assert trip.duration_s == pytest.approx(COUNT * STEP_S, abs=0.11)
    at = np.clip(np.searchsorted(T, trip.t_s + 0.5 * STEP_S) - 1, 0, COUNT - 1)
    moved_m = trip.position_m - trip.position_m[0]
    off_m = np.hypot(moved_m[:, 0] - EAST[at], moved_m[:, 1] - NORTH[at])
    assert np.median(off_m) < PLACE_M
    assert off_m.max() < (PLACE_M if np.allclose(trip.t_s, T[at], atol=1e-3) else 0.4)
    assert (trip.speed_mps is not None, trip.heading_rad is not None) == (
        "speed" in shape.has, "heading" in shape.has,
    )  # fmt: skip
    if trip.speed_mps is not None:
        assert trip.speed_mps == pytest.approx(SPEED_MPS, rel=1e-6)
    if trip.yaw_rate_radps is not None:
        assert trip.yaw_rate_radps == pytest.approx(TURN_RADPS, rel=1e-6)
    if trip.heading_rad is not None:
        off_rad = np.abs(wrap_angle_rad(trip.heading_rad - HEADING_RAD[at]))
        assert off_rad.max() < 0.02, "a value that is not known is that of a sample before"


@pytest.mark.parametrize("name", SHAPES)
def test_a_file_is_read_right_or_its_error_says_how(made, name: str) -> None:
    shape = SHAPES[name]
    path = made.write(shape.name, shape.file)
    columns = dict(shape.columns)
    if shape.error:
        with pytest.raises(DataFormatError) as caught:
            list(read_trips(path, columns=columns or None))
        assert re.search(shape.error, str(caught.value))
        shown = re.search(r"--columns (?:with )?(?:'([^']+)'|([^ ]+?))[.]?(?: |$)", str(caught.value))
        if shown is None:
            assert "--columns" not in shape.error
            return
        columns = dict(one.split("=") for one in (shown[1] or shown[2]).split(","))
    trips = list(read_trips(path, columns=columns or None))
    assert len(trips) == shape.trips
    for trip in trips:
        right(trip, shape)
    taken = trips[0].reading.understood
    assert taken is not None
    assert taken.lines() | dict(shape.said) == taken.lines()
    counted = {**trips[0].reading.skipped, **trips[0].reading.repaired}
    assert counted | dict(shape.counted) == counted


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_table_or_cannot_be_told_is_refused_with_what_to_do(made, name: str) -> None:
    file, content, remedy = REFUSED[name]
    with pytest.raises(DataFormatError, match=remedy):
        list(read_trips(made.write(file, content)))


@pytest.mark.parametrize(
    ("name", "factor", "remedy"),
    [("acceleration_mps2", 1 / 9.80665, "acceleration_g="), ("acceleration_g", 1, "acceleration=")],
)
def test_an_acceleration_in_another_unit_is_refused_with_its_map(made, name, factor, remedy) -> None:
    """Brakes with 4 m/s² and speeds up again, three times."""
    acceleration = 4.0 * np.sign(np.sin(2.0 * np.pi * T / 10.0))
    east = STEP_S * np.cumsum(20.0 + STEP_S * np.cumsum(acceleration))
    path = made.write("t.csv", table({"t": T, "x": east, "y": 0.0 * T, name: factor * acceleration}))
    with pytest.raises(DataFormatError, match=f"--columns {remedy}{name}"):
        list(read_trips(path))
    (trip,) = read_trips(path, columns={remedy.strip("="): name})
    assert trip.acceleration_mps2 == pytest.approx(acceleration, rel=1e-6)


NOISE = np.random.default_rng(7).normal(0.0, 1.0, (2, 600))
LONG = STEP_S * np.arange(600)
VALID = {
    "a height beside Gauss-Krueger coordinates as far away as the middle of the Earth": {
        "t": T, "x": 3_500_000 + EAST, "y": 5_320_000 + NORTH, "z": 500 + 0 * T, "speed": V,
    },
    "a vehicle that reverses to the south-east": {
        "t": T, "x": 0.15 * np.arange(COUNT), "y": -0.15 * np.arange(COUNT), "heading_deg": 315 + 0 * T,
    },
    "a heading of 0 as long as it is too slow for one": {
        "t": T, "x": 0.08 * np.arange(COUNT), "y": 0 * T, "heading_deg": np.where(T < 29.9, 0.0, 90.0),
    },
    "a speedometer that shows 10 % too much on a straight way to the north-north-east": {
        "t": T, "lat": 48.1 + 1.21e-5 * np.arange(COUNT), "lon": 11.5 + 8.92e-6 * np.arange(COUNT),
        "speed": 1.1 * V,
    },
    "a car that stands while its platform drifts": {
        "t": T, "x": 12 + 1e-5 * np.arange(COUNT), "y": -7 + 5e-6 * np.arange(COUNT), "speed": 0 * T,
    },
    "metres by name of what hardly moves": {
        "t": T, "east_m": 12 + 1e-5 * np.arange(COUNT), "north_m": -7 + 5e-6 * np.arange(COUNT),
    },
}  # fmt: skip


@pytest.mark.parametrize("name", VALID)
def test_what_is_right_is_read_though_it_looks_like_another_unit(made, name: str) -> None:
    columns = {key: numbers(column, ".10g") for key, column in VALID[name].items()}
    assert len(list(read_trips(made.write("mine.csv", table(columns))))) == 1


def test_white_noise_is_not_taken_for_feet(made) -> None:
    """Noise that makes the way from row to row 3.28 times as long as the speeds say."""
    goal_m = 3.0 * LONG[-1] / 0.3048
    ways_m = {size: np.hypot(*np.diff([3.0 * LONG + size * NOISE[0], size * NOISE[1]])).sum()
              for size in np.linspace(0.4, 0.7, 61)}  # fmt: skip
    size = min(ways_m, key=lambda one: abs(ways_m[one] - goal_m))
    assert ways_m[size] == pytest.approx(goal_m, rel=0.02)
    columns = {"t": LONG, "x": 3.0 * LONG + size * NOISE[0], "y": size * NOISE[1], "speed": 0 * LONG + 3.0}
    (trip,) = read_trips(made.write("mine.csv", table(columns)))
    assert len(trip) == LONG.size


@pytest.mark.parametrize(
    ("shape", "columns"),
    [
        ("positions in feet", {"east_m": "x", "north_m": "y"}),
        ("a heading counted from east", {"heading_deg": "heading_deg"}),
        ("latitude and longitude swapped, with speeds", {"latitude_deg": "lat", "longitude_deg": "lon"}),
    ],
)
def test_a_map_that_states_the_unit_is_not_doubted(made, shape: str, columns: dict[str, str]) -> None:
    path = made.write("mine.csv", SHAPES[shape].file)
    assert len(list(read_trips(path, columns=columns))) == 1


@pytest.mark.parametrize(("against", "refused"), [(1, False), (2, True), (3, True)])
@pytest.mark.parametrize("first", [True, False])
def test_half_of_the_vehicles_decide_of_what_a_column_holds(
    made, against: int, refused: bool, first: bool
) -> None:
    """Four vehicles on the same way, of which some count their headings from east."""
    turned = [at < against if first else at >= 4 - against for at in range(4)]
    headings = [90.0 - HEADING if other else HEADING for other in turned]
    columns = {name: np.tile(column, 4) for name, column in plane().items()}
    columns |= {"vehicle": np.repeat(np.arange(4.0), COUNT), "heading_deg": np.concatenate(headings)}
    path = made.write("mine.csv", table(columns))
    if refused:
        with pytest.raises(DataFormatError, match="yaw_deg=heading_deg"):
            list(read_trips(path))
    else:
        assert [trip.trip_id for trip in read_trips(path)] == [f"mine/{at}" for at in range(4)]


@pytest.mark.parametrize("word", ["NA", "NaN", "null", "-", ""])
def test_rows_whose_time_is_missing_are_skipped_and_counted(made, word: str) -> None:
    (trip,) = read_trips(made.write("mine.csv", table(plane(t=with_gaps(T, word)))))
    assert dict(trip.reading.skipped) == {"time blank": 10}


def test_unix_seconds_that_are_called_days_are_told(made) -> None:
    path = made.write("mine.csv", table(places(time=numbers(UNIX_S + T, ".3f"))))
    with pytest.raises(DataFormatError, match=r"over 3,000 years.*: t_s=time"):
        list(read_trips(path, columns={"t_days": "time"}))


@pytest.mark.parametrize("rate_hz", [1, 4, 25, 100])
def test_any_rate_is_read(made, rate_hz: int) -> None:
    t = np.arange(30 * rate_hz) / rate_hz
    (trip,) = read_trips(
        made.write("t.csv", table({"t": t, "x": 15.0 * t, "y": 0.0 * t, "speed": 0.0 * t + 15.0}))
    )
    assert trip.dt_s == pytest.approx(1.0 / rate_hz)
    assert not trip.resampled


def test_a_vehicle_that_stands_is_read(made) -> None:
    (trip,) = read_trips(made.write("t.csv", table(places(lat=0 * T + 48.1, lon=0 * T + 11.5, speed=0 * T))))
    assert np.ptp(trip.position_m) == 0.0


@pytest.mark.parametrize(
    ("name", "subject", "said"),
    [
        ("openacc", "position", "E and N in metres; Lat and Lon in degrees, told by their size or motion"),
        ("sumo-fcd", "position", "x and y are metres, told by how vehicles move; front bumpers"),
        ("cv-pilot", "values", "in the standard's units, told by how they are written"),
        ("ode-bsm", "values", "told by how they are written"),
    ],
)
def test_other_readers_that_have_to_find_something_out_say_it(
    made, name: str, subject: str, said: str
) -> None:
    taken = next(iter(read_trips(made.valid(name), name))).reading.understood
    assert taken is not None
    assert said in taken.lines()[subject]


@pytest.mark.parametrize("stamped", [False, True])
def test_data_frames_and_parquet_say_it_too(made, stamped: bool) -> None:
    """Whatever types their columns have, those that are not read among them."""
    stamps = pl.Series("time", (1e6 * (UNIX_S + T)).round().astype(np.int64)).cast(pl.Datetime("us"))
    frame = pl.DataFrame({
        "time": stamps if stamped else pl.Series(T), "lat": LAT, "lon": LON, "v_ego": 3.6 * V,
        "car_id": pl.Series(["a"] * COUNT, dtype=pl.Categorical), "list": [[1.0]] * COUNT,
    })  # fmt: skip
    frame.write_parquet(made.folder / "mine.parquet")
    for source in (frame, made.folder / "mine.parquet"):
        (trip,) = read_trips(source)
        right(trip, Shape(""))
        taken = trip.reading.understood
        assert taken is not None
        assert taken.unused_text == "v_ego, list (perhaps: --columns 'speed_kmh=v_ego')"


@pytest.mark.parametrize(("unit", "count"), [("ns", 1_700_000_000_123_456_789), ("us", 2**60)])
def test_time_stamps_that_python_has_none_of_do_not_matter(made, unit, count: int) -> None:
    """Digits below the microsecond, and the year 38503; octets are no text."""
    until = pl.Series("until", [count] * COUNT).cast(pl.Datetime(unit))
    frame = pl.DataFrame({"t_s": T, "x": EAST, "y": NORTH, "until": until, "picture": [b"\xff"] * COUNT})
    frame.write_parquet(made.folder / "mine.parquet")
    for source in (frame, made.folder / "mine.parquet"):
        (trip,) = read_trips(source)
        right(trip, Shape(""))


def test_a_table_of_one_row_or_of_odd_columns_has_nothing_suggested(made) -> None:
    (trip,) = read_trips(made.write("t.csv", "t,x,y,id,note,a=b\n0,0,0,7,x,z\n"), columns={"t": "t"})
    taken = trip.reading.understood
    assert taken is not None
    assert (taken.unused, dict(taken.suggested)) == (("id", "note", "a=b"), {})
