"""Claims about SUMO's floating-car data: all forms give the same traffic; what is no traffic is counted."""

import gzip
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin, enu_to_geodetic
from modelcast.core.kinds import CYCLIST_M, PEDESTRIAN_M, Kind
from modelcast.io.fcd import read_fcd, survey_fcd
from modelcast.world.scenario.base import FleetFrame
from modelcast.world.scenario.resampling import resampled

Row = Mapping[str, Any]
"""A row: tag, time, id, x, y, angle, type, speed, pos, lane, edge; what a tag does not have is absent."""

PLACE = Origin(47.5, 11.0)


def traffic(steps: int = 40, dt_s: float = 0.1) -> list[Row]:
    """A car on a bend of 60 m, another that comes later on a straight road, a person and a container."""
    rows: list[Row] = []
    for k in range(steps):
        t_s = round(k * dt_s, 3)
        turned = 12.0 * t_s / 60.0
        rows.append(
            vehicle(
                t_s,
                "a",
                60.0 * np.sin(turned),
                60.0 * (np.cos(turned) - 1.0),
                90.0 + np.rad2deg(turned),
                12.0,
            )
        )
        if k >= 5:
            rows.append(vehicle(t_s, "b", -50.0, 20.0 + 15.0 * t_s, 0.0, 15.0))
        walker = {"x": -5.0, "y": 1.2 * t_s, "angle": 0.0, "speed": 1.2, "pos": 1.2 * t_s, "edge": "w"}
        rows.append({"tag": "person", "time": t_s, "id": "p", "type": "DEFAULT_PEDTYPE", **walker})
        box = {"x": -8.0, "y": 0.0, "angle": 0.0, "speed": 0.0, "pos": 0.0, "edge": "w"}
        rows.append({"tag": "container", "time": t_s, "id": "k", "type": "DEFAULT_CONTAINERTYPE", **box})
    return rows


def vehicle(t_s: float, name: str, x: float, y: float, angle: float, speed: float) -> Row:  # noqa: PLR0917
    """A row of a vehicle."""
    values = {"x": x, "y": y, "angle": angle, "type": "car", "speed": speed, "pos": 3.0, "lane": "e_0"}
    return {"tag": "vehicle", "time": t_s, "id": name, **values}


def geographic(rows: Sequence[Row], *, grid_deg: float = 0.0) -> list[Row]:
    """The rows with longitude and latitude for x and y, on a grid turned against true north."""
    enu = np.array([[row["x"], row["y"], 0.0] for row in rows])
    turn = np.deg2rad(grid_deg)
    east = enu[:, 0] * np.cos(turn) + enu[:, 1] * np.sin(turn)
    north = -enu[:, 0] * np.sin(turn) + enu[:, 1] * np.cos(turn)
    places = enu_to_geodetic(np.column_stack((east, north, enu[:, 2])), PLACE)
    return [
        {**row, "x": float(place[1]), "y": float(place[0])} for row, place in zip(rows, places, strict=True)
    ]


def only(rows: Sequence[Row], *names: str) -> list[Row]:
    """The rows with these attributes only, as --fcd-output.attributes leaves them."""
    return [{name: row[name] for name in ("tag", "time", "id", *names) if name in row} for row in rows]


def text(value: object) -> str:
    """A value as SUMO writes it, with more digits."""
    return f"{value:.8f}" if isinstance(value, float) else str(value)


def write_xml(path: Path, rows: Sequence[Row]) -> None:
    """SUMO's XML."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', "<fcd-export>"]
    for t_s in dict.fromkeys(row["time"] for row in rows):
        lines.append(f'    <timestep time="{t_s}">')
        for row in rows:
            if row["time"] == t_s and row["tag"]:
                shown = " ".join(f'{n}="{text(v)}"' for n, v in row.items() if n not in {"tag", "time"})
                lines.append(f"        <{row['tag']} {shown}/>")
        lines.append("    </timestep>")
    path.write_text("\n".join([*lines, "</fcd-export>"]) + "\n", encoding="utf-8")


def columns(rows: Sequence[Row], head: str = "") -> list[str]:
    """Names of the columns of a table, without the tag where it is not asked for."""
    known = ("id", "x", "y", "angle", "type", "speed", "pos", "lane", "edge")
    there = [name for name in known if any(name in row for row in rows)]
    return ["timestep_time" if head else "time", *(f"{head}{name}" for name in there)]


def write_csv(path: Path, rows: Sequence[Row], *, head: str = "vehicle_", mark: str = ";") -> None:
    """SUMO's CSV: persons and containers are rows as vehicles are."""
    names = columns(rows, head)
    plain = ["time", *(name.removeprefix(head) for name in names[1:])]
    lines = [mark.join(text(row.get(name, "")) for name in plain) for row in rows]
    path.write_text("\n".join([mark.join(names), *lines]) + "\n", encoding="utf-8")


def write_parquet(path: Path, rows: Sequence[Row], *, head: str = "vehicle_") -> None:
    """SUMO's Parquet, likewise."""
    names = columns(rows, head)
    plain = ["time", *(name.removeprefix(head) for name in names[1:])]
    pq.write_table(
        pa.table({name: [row.get(at) for row in rows] for name, at in zip(names, plain, strict=True)}),
        path,  # pyright: ignore[reportUnknownArgumentType] - no stubs
    )


def packed(write: Callable[[Path, Sequence[Row]], None]) -> Callable[[Path, Sequence[Row]], None]:
    """A writer of the same inside gzip."""

    def write_packed(path: Path, rows: Sequence[Row]) -> None:
        write(path, rows)
        path.write_bytes(gzip.compress(path.read_bytes()))

    return write_packed


FORMS: Mapping[str, Callable[[Path, Sequence[Row]], None]] = {
    "xml": write_xml,
    "csv": write_csv,
    "csv plain": lambda path, rows: write_csv(path, rows, head=""),
    "csv plain, commas": lambda path, rows: write_csv(path, rows, head="", mark=","),
    "csv full": lambda path, rows: write_csv(path, rows, head="timestep_vehicle_"),
    "parquet": write_parquet,
    "parquet plain": lambda path, rows: write_parquet(path, rows, head=""),
    "xml.gz": packed(write_xml),
    "csv.gz": packed(write_csv),
    "parquet.gz": packed(write_parquet),
}


OFF = -1073741824.0
CENTIMETRE = 0.01  # SUMO's own rounding
GRID_DEG = 1.5  # what a UTM grid is turned by at 47.5° north, 2° from its meridian


def taken(frames: Sequence[FleetFrame]) -> int:
    """Rows of vehicles that became part of a frame."""
    return sum(int(frame.active.sum()) for frame in frames)


def speeds_by_position(frames: Sequence[FleetFrame]) -> np.ndarray:
    """How fast vehicles came from frame to frame."""
    found: list[np.ndarray] = []
    for before, after in pairwise(frames):
        same = before.active & (before.vehicle_id == after.vehicle_id)
        moved = np.hypot(*(after.position_m - before.position_m)[same].T)
        found.append(moved / (after.t_s - before.t_s))
    return np.concatenate(found)


@pytest.fixture
def metric(tmp_path: Path) -> list[FleetFrame]:
    path = tmp_path / "metric.xml"
    write_xml(path, traffic())
    return list(read_fcd(path))


@pytest.mark.parametrize("form", FORMS)
def test_every_form_gives_the_same_frames_without_persons_and_containers(
    form: str, metric: list[FleetFrame], tmp_path: Path
) -> None:
    path = tmp_path / "traffic"
    FORMS[form](path, traffic())
    found = survey_fcd(path)
    frames = list(read_fcd(path, found=found))
    assert found.reading.skipped == {"person": 40, "container": 40}
    assert found.reading.rows == 155
    assert found.taken == taken(frames) == 75
    assert found.vehicles == found.most == 2
    for frame, same in zip(frames, metric, strict=True):
        np.testing.assert_allclose(frame.position_m, same.position_m, atol=1e-6)
        np.testing.assert_allclose(frame.speed_mps, same.speed_mps, atol=1e-6)
        assert frame.vehicle_id.tolist() == same.vehicle_id.tolist()


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("grid_deg", [0.0, GRID_DEG])
def test_longitude_and_latitude_are_laid_out_in_metres(
    form: str, grid_deg: float, metric: list[FleetFrame], tmp_path: Path
) -> None:
    """Speeds agree with the metric file to 1 %, and headings point where vehicles move, whatever the grid."""
    path = tmp_path / "traffic"
    FORMS[form](path, geographic(traffic(), grid_deg=grid_deg))
    found = survey_fcd(path)
    frames = list(read_fcd(path, found=found))
    assert found.origin is not None
    assert any("longitude and latitude" in note for note in found.notes)
    assert np.rad2deg(found.turn_rad) == pytest.approx(grid_deg, abs=0.1)
    np.testing.assert_allclose(speeds_by_position(frames), speeds_by_position(metric), rtol=0.01)
    for frame, same in zip(frames, metric, strict=True):
        np.testing.assert_allclose(frame.speed_mps, same.speed_mps, rtol=0.01)
    apart, should = (one[20].position_m[0] - one[20].position_m[1] for one in (frames, metric))
    assert np.hypot(*apart) == pytest.approx(np.hypot(*should), abs=CENTIMETRE)


def test_columns_named_longitude_and_latitude_need_no_guess(tmp_path: Path) -> None:
    path = tmp_path / "named.csv"
    rows = geographic([vehicle(0.1 * k, "a", 0.0, 1.0 * k, 0.0, 10.0) for k in range(20)])
    lines = [f"{row['time']},{row['id']},{row['x']:.9f},{row['y']:.9f}" for row in rows]
    path.write_text("\n".join(["t,vehicle,lon,lat", *lines]) + "\n", encoding="utf-8")
    frames = list(read_fcd(path))
    np.testing.assert_allclose(speeds_by_position(frames), 10.0, rtol=0.01)


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"speed": 15.0 * 3.6}, "positions do not move as the speeds say"),
        ({"speed": 0.0}, "positions do not move as the speeds say"),
        ({"angle": 90.0}, "headings point"),
        ({"x": 1e-4}, "positions do not move as the speeds say"),
    ],
)
def test_columns_that_contradict_each_other_are_refused(
    changed: dict[str, float], says: str, tmp_path: Path
) -> None:
    """Speeds in km/h or all zero, headings from east, positions in another unit."""
    path = tmp_path / "wrong.csv"
    rows: list[Row] = []
    for k in range(40):
        row: dict[str, Any] = {**vehicle(0.1 * k, "a", 1000.0, 1.5 * k, 0.0, 15.0), **changed}
        if "x" in changed:
            row.update(x=0.01, y=1.5e-9 * k)
        rows.append(row)
    write_csv(path, rows)
    with pytest.raises(DataFormatError, match=says):
        survey_fcd(path)


def test_degrees_without_speeds_cannot_be_told_and_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "geo.xml"
    write_xml(path, only(geographic(traffic()), "x", "y"))
    with pytest.raises(DataFormatError, match=r"do not move as the speeds say.*attribute speed"):
        survey_fcd(path)


def test_a_fleet_that_stands_within_half_a_unit_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "geo.xml"
    rows = [
        vehicle(0.1 * k, name, at, 47.5, 0.0, 0.0)
        for k in range(9)
        for name, at in (("a", 11.0), ("b", 11.001))
    ]
    write_xml(path, rows)
    with pytest.raises(DataFormatError, match="longitude and latitude"):
        survey_fcd(path)


@pytest.mark.parametrize("form", ["xml", "csv", "parquet"])
@pytest.mark.parametrize("column", ["x", "y", "speed", "angle", "pos"])
def test_a_vehicle_off_the_road_is_skipped_and_counted(form: str, column: str, tmp_path: Path) -> None:
    path = tmp_path / "off"
    rows = [{**row, column: OFF} if row["id"] == "b" and row["time"] > 3.0 else row for row in traffic()]
    FORMS[form](path, rows)
    found = survey_fcd(path)
    assert found.reading.skipped == {"person": 40, "container": 40, "vehicle off the road": 9}
    assert taken(list(read_fcd(path, found=found))) == found.taken == 66


def test_persons_with_types_of_their_own_are_known_by_their_edge(tmp_path: Path) -> None:
    path = tmp_path / "own.csv"
    write_csv(path, [{**row, "type": "own"} for row in traffic()])
    assert survey_fcd(path).reading.skipped == {"person or container": 80}


def test_a_table_that_cannot_tell_persons_says_so(tmp_path: Path) -> None:
    path = tmp_path / "few.csv"
    write_csv(path, only(traffic(), "x", "y", "speed", "angle"))
    found = survey_fcd(path)
    assert found.vehicles == 4
    assert any("taken for vehicles" in note for note in found.notes)


def test_columns_for_persons_as_xml2csv_writes_them(tmp_path: Path) -> None:
    path = tmp_path / "both.csv"
    lines = ["timestep_time;person_id;person_x;vehicle_angle;vehicle_id;vehicle_speed;vehicle_x;vehicle_y"]
    for k in range(10):
        lines += [f"{0.1 * k:.1f};;;90;a;10;{100 + k};5", f"{0.1 * k:.1f};p;3;;;;;"]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    found = survey_fcd(path)
    assert (found.taken, dict(found.reading.skipped)) == (10, {"person": 10})


@pytest.mark.parametrize("form", ["xml", "csv", "parquet"])
def test_speed_and_angle_that_are_not_written_come_from_motion(
    form: str, metric: list[FleetFrame], tmp_path: Path
) -> None:
    path = tmp_path / "few"
    FORMS[form](path, only([row for row in traffic() if row["tag"] == "vehicle"], "x", "y", "lane"))
    found = survey_fcd(path)
    frames = list(read_fcd(path, found=found))
    assert found.taken == taken(frames) == 75
    assert {note.partition(" rows ")[2] for note in found.notes} >= {
        "without a speed: taken from motion",
        "without a heading (angle): taken from motion",
    }
    for frame, same in zip(frames[2:-2], metric[2:-2], strict=True):
        np.testing.assert_allclose(frame.speed_mps, same.speed_mps, rtol=0.01)
        np.testing.assert_allclose(frame.position_m, same.position_m, atol=0.05)


def test_who_has_no_angle_and_stands_is_left_out_until_it_moves(tmp_path: Path) -> None:
    path = tmp_path / "few.xml"
    rows = [vehicle(0.1 * k, "a", 5.0 + 1.5 * max(0, k - 20), 0.0, 90.0, 0.0) for k in range(40)]
    write_xml(path, only(rows, "x", "y", "lane"))
    found = survey_fcd(path)
    frames = list(read_fcd(path, found=found))
    assert sum(found.reading.skipped.values()) == 20
    assert found.taken == taken(frames) == 20


@pytest.mark.parametrize("name", ["x", "y"])
@pytest.mark.parametrize("form", ["xml", "csv", "parquet"])
def test_a_position_that_is_not_written_is_refused_by_the_name_of_its_attribute(
    form: str, name: str, tmp_path: Path
) -> None:
    path = tmp_path / "few"
    FORMS[form](path, only(traffic(), "speed", "angle", "lane", "y" if name == "x" else "x"))
    with pytest.raises(DataFormatError, match=f"attribute {name} of SUMO"):
        survey_fcd(path)


def test_hours_minutes_and_seconds_are_a_time(tmp_path: Path) -> None:
    path = tmp_path / "clock.csv"
    rows = [vehicle(0.0, "a", 10.0 * k, 0.0, 90.0, 10.0) for k in range(3)]
    times = ("00:59:59.00", "01:00:00.00", "0:01:00:01.00")
    write_csv(path, [{**row, "time": time} for row, time in zip(rows, times, strict=True)])
    assert [frame.t_s for frame in read_fcd(path)] == [0.0, 1.0, 2.0]
    write_csv(path, [{**rows[0], "time": "00:61:00"}])
    with pytest.raises(DataFormatError, match="h:m:s"):
        survey_fcd(path)


@pytest.mark.parametrize("form", ["xml", "csv"])
def test_who_is_away_for_a_time_step_comes_back_as_another(form: str, tmp_path: Path) -> None:
    """Also where nobody is there at all, in a time step that the file shows empty, or leaves out."""
    path = tmp_path / "away"
    rows = [vehicle(0.5 * k, "a", 5.0 * k, 0.0, 90.0, 10.0) for k in range(12) if k not in {5, 8, 9}]
    empty = {"tag": "", "time": 2.5, "id": "", "x": "", "y": ""}
    FORMS[form](path, sorted([*rows, empty], key=lambda row: row["time"]))
    found = survey_fcd(path)
    frames = list(read_fcd(path, found=found))
    assert [int(frame.vehicle_id.max()) for frame in frames] == [0] * 5 + [-1] + [1] * 2 + [-1] + [2] * 2
    assert found.reading.skipped == {"time step without vehicles": 1}
    assert any("1 gaps in time" in note for note in found.notes)


def test_who_jumps_is_another_vehicle_from_there_on(tmp_path: Path) -> None:
    path = tmp_path / "jump.xml"
    write_xml(path, [vehicle(0.1 * k, "a", 1.0 * k + 100.0 * (k >= 30), 0.0, 90.0, 10.0) for k in range(40)])
    found = survey_fcd(path)
    frames = list(read_fcd(path, found=found))
    assert [int(frame.vehicle_id[0]) for frame in frames] == [0] * 30 + [1] * 10
    assert any("1 jumps" in note for note in found.notes)


def test_vehicles_at_times_of_their_own_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "own.csv"
    rows = [
        vehicle(1.0 * k + 0.5 * car, f"c{car}", 10.0 * k, 9.0 * car, 90.0, 10.0)
        for k in range(20)
        for car in (0, 1)
    ]
    write_csv(path, rows)
    with pytest.raises(DataFormatError, match="times of its own"):
        survey_fcd(path)


@pytest.mark.parametrize(
    ("content", "says"),
    [(b"BZh91AY", "bzip2"), (b"\x28\xb5\x2f\xfd..", "zstd"), (b"\x1f\x8b\x08\x00broken", "unpacked")],
)
def test_other_or_broken_compression_is_named(content: bytes, says: str, tmp_path: Path) -> None:
    path = tmp_path / "packed"
    path.write_bytes(content)
    with pytest.raises(DataFormatError, match=says):
        survey_fcd(path)


def test_a_packed_file_cut_short_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "cut"
    FORMS["xml.gz"](path, traffic())
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(DataFormatError, match="unpacked"):
        survey_fcd(path)


def test_a_file_of_persons_alone_says_what_it_holds(tmp_path: Path) -> None:
    path = tmp_path / "walk.xml"
    write_xml(path, [row for row in traffic() if row["tag"] == "person"])
    with pytest.raises(DataFormatError, match=r"no vehicle in the file \(40 person\)"):
        survey_fcd(path)


@pytest.fixture(scope="module")
def wholes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("fcd")
    found: dict[str, bytes] = {}
    for form in ("xml", "csv", "parquet", "csv plain"):
        rows = geographic(traffic(12)) if form == "csv plain" else traffic(12)
        FORMS[form](folder / "one", rows)
        found[form] = (folder / "one").read_bytes()
    return found


def test_an_encoding_that_nobody_knows_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "odd.xml"
    path.write_text('<?xml version="1.0" encoding="U0F-8"?><fcd-export/>', encoding="utf-8")
    with pytest.raises(DataFormatError, match="U0F-8"):
        survey_fcd(path)


@pytest.mark.slow
@given(data=st.data())
@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@pytest.mark.parametrize("form", ["xml", "csv", "parquet", "csv plain"])
def test_of_a_mutated_file_every_row_is_taken_or_counted(
    form: str, wholes: dict[str, bytes], tmp_path: Path, data: st.DataObject
) -> None:
    """Or the file is refused, by nothing but a format error."""
    path = tmp_path / "mutated"
    whole = wholes[form]
    content = bytearray(whole)
    for at, value in data.draw(
        st.lists(
            st.tuples(st.integers(0, len(whole) - 1), st.sampled_from(b'0123456789-.;,\n" e<>/aNv\0\xff')),
            max_size=4,
        )
    ):
        content[at] = value
    cut = data.draw(st.one_of(st.just(len(whole)), st.integers(0, len(whole))))
    lines = bytes(content[:cut]).split(b"\n")
    if form != "parquet" and len(lines) > 3 and data.draw(st.booleans()):
        first = data.draw(st.integers(1, len(lines) - 2))
        lines[first : first + data.draw(st.integers(0, 3))] = data.draw(
            st.sampled_from([[], lines[first : first + 2] * 2])
        )
    path.write_bytes(b"\n".join(lines))
    try:
        found = survey_fcd(path)
        frames = list(read_fcd(path, found=found))
    except DataFormatError:
        return
    assert found.reading.rows == taken(frames) + sum(found.reading.skipped.values())
    assert found.taken == taken(frames)


PEOPLE = """<fcd-export>
{steps}
</fcd-export>
"""
STEP = """  <timestep time="{t:.1f}">
    <vehicle id="0" x="{x:.3f}" y="0" angle="90" type="car" speed="10" pos="1" lane="e_0"/>
    <vehicle id="b" x="0" y="{y:.3f}" angle="0" type="my_bicycle" speed="4" pos="1" lane="f_0"/>
    <vehicle id="m" x="20" y="{y:.3f}" angle="0" type="motorbike" speed="4" pos="1" lane="f_0"/>
    <person id="0" x="5" y="{z:.3f}" angle="180" speed="1.2" pos="2" edge="w" type="DEFAULT_PEDTYPE"/>
    <person id="2" x="{x:.3f}" y="0" angle="90" speed="10" pos="1" edge="e" type="p" vehicle="0"/>
    <container id="k" x="9" y="9" angle="0" speed="0" pos="1" edge="e"/>
  </timestep>"""


def people_file(path: Path, steps: int = 30) -> Path:
    shown = [STEP.format(t=0.1 * k, x=1.0 * k, y=0.4 * k, z=-0.12 * k) for k in range(steps)]
    path.write_text(PEOPLE.format(steps="\n".join(shown)), encoding="utf-8")
    return path


def test_persons_are_pedestrians_where_they_are_asked_for(tmp_path: Path) -> None:
    """A person may have a vehicle's name; who rides in one is that vehicle; bicycles say so by their type."""
    path = people_file(tmp_path / "fcd.xml")
    found = survey_fcd(path, people=True)
    assert dict(found.reading.skipped) == {"person in a vehicle": 30, "container": 30}
    assert (found.taken, found.vehicles, found.pedestrians, found.cyclists) == (120, 4, 1, 1)
    assert "people among them, by kind: 1 pedestrian, 1 cyclist" in found.notes
    last = list(read_fcd(path, people=True))[-1]
    assert last.kind is not None
    assert last.width_m is not None
    assert sorted(last.kind.tolist()) == [Kind.VEHICLE, Kind.VEHICLE, Kind.PEDESTRIAN, Kind.CYCLIST]
    walker, rider = (int(np.flatnonzero(last.kind == kind)[0]) for kind in (Kind.PEDESTRIAN, Kind.CYCLIST))
    assert last.position_m[walker] == pytest.approx([5.0, -0.12 * 29], abs=1e-6), "not moved back"
    assert abs(last.heading_rad[walker]) == pytest.approx(np.pi)
    assert last.position_m[rider] == pytest.approx([0.0, 0.4 * 29 - 0.95], abs=1e-6), "half a bicycle back"
    assert (last.length_m[walker], last.width_m[walker]) == PEDESTRIAN_M
    assert (last.length_m[rider], last.width_m[rider]) == CYCLIST_M


def test_persons_that_nobody_asked_for_are_counted(tmp_path: Path) -> None:
    found = survey_fcd(people_file(tmp_path / "fcd.xml"))
    assert dict(found.reading.skipped) == {"person": 60, "container": 30}
    assert (found.vehicles, found.pedestrians, found.cyclists) == (3, 0, 1)


def test_every_form_gives_the_same_persons(tmp_path: Path) -> None:
    rows = traffic()
    write_xml(tmp_path / "fcd.xml", rows)
    write_csv(tmp_path / "fcd.csv", rows)
    frames = [list(read_fcd(tmp_path / name, people=True)) for name in ("fcd.xml", "fcd.csv")]
    for one, other in zip(*frames, strict=True):
        assert one.kind is not None
        assert other.kind is not None
        np.testing.assert_array_equal(one.kind, other.kind)
        np.testing.assert_allclose(one.position_m, other.position_m, atol=1e-6)
    assert (frames[0][-1].kind == Kind.PEDESTRIAN).sum() == 1


def test_resampled_frames_keep_kinds(tmp_path: Path) -> None:
    frames = list(resampled(read_fcd(people_file(tmp_path / "fcd.xml"), people=True), 0.05))
    assert all(frame.kind is not None and (frame.kind == Kind.PEDESTRIAN).sum() == 1 for frame in frames)
