"""Claims about floating-car data."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io.fcd import most_vehicles, read_fcd

STEPS = 6


def table() -> list[tuple[float, str, float, float, float, float]]:
    """Rows of time, vehicle, east, north, heading [deg], speed; b is there from step 2 to 3 only."""
    rows = []
    for k in range(STEPS):
        rows.append((round(0.1 * k, 1), "a", 100.0 + k, 5.0, 90.0, 10.0))
        if k in {2, 3}:
            rows.append((round(0.1 * k, 1), "b", 0.0, 2.0 * k, 0.0, 20.0))
    return rows


def write_sumo_csv(path: Path) -> None:
    lines = ["timestep_time;vehicle_id;vehicle_x;vehicle_y;vehicle_angle;vehicle_speed"]
    path.write_text("\n".join(lines + [";".join(map(str, row)) for row in table()]) + "\n")


def write_sumo_parquet(path: Path) -> None:
    names = ["timestep_time", "vehicle_id", "vehicle_x", "vehicle_y", "vehicle_angle", "vehicle_speed"]
    columns = zip(*table(), strict=True)
    pq.write_table(pa.table(dict(zip(names, map(list, columns), strict=True))), path)


def write_sumo_xml(path: Path) -> None:
    lines = ["<fcd-export>"]
    for k in range(STEPS):
        lines.append(f'<timestep time="{0.1 * k:.2f}">')
        lines += [
            f'<vehicle id="{name}" x="{x}" y="{y}" angle="{angle}" speed="{speed}" type="t"/>'
            for t, name, x, y, angle, speed in table()
            if abs(t - 0.1 * k) < 1e-9
        ]
        lines.append("</timestep>")
    path.write_text("\n".join([*lines, "</fcd-export>"]))


@pytest.mark.parametrize("write", [write_sumo_csv, write_sumo_parquet, write_sumo_xml])
def test_the_three_formats_of_sumo_give_the_same_frames(
    write: Callable[[Path], None], tmp_path: Path
) -> None:
    path = tmp_path / "made"
    write(path)
    frames = list(read_fcd(path, vehicle_length_m=4.0))
    assert most_vehicles(path) == 2
    assert [frame.t_s for frame in frames] == pytest.approx([0.1 * k for k in range(STEPS)])
    assert [frame.active.sum() for frame in frames] == [1, 1, 2, 2, 1, 1]
    # half a length behind the bumper, against the heading
    np.testing.assert_allclose(frames[2].position_m, [[100.0, 5.0], [0.0, 2.0]], atol=1e-9)
    np.testing.assert_allclose(frames[2].heading_rad, [np.pi / 2, 0.0], atol=1e-9)
    np.testing.assert_allclose(frames[3].speed_mps, [10.0, 20.0])
    assert not frames[4].acceleration_mps2.any()
    assert frames[2].vehicle_id.tolist() == [0, 1]
    assert frames[4].vehicle_id.tolist() == [0, -1]


def test_a_plain_table_needs_a_time_a_vehicle_and_a_place_only(tmp_path: Path) -> None:
    path = tmp_path / "plain.csv"
    path.write_text("t,vehicle,x,y\n" + "".join(f"{k / 10},a,{k},0\n" for k in range(5)))
    frames = list(read_fcd(path))
    np.testing.assert_allclose([f.position_m[0, 0] for f in frames], range(5))
    np.testing.assert_allclose([f.speed_mps[0] for f in frames], 10.0)
    np.testing.assert_allclose([f.heading_rad[0] for f in frames], np.pi / 2)


def test_a_vehicle_that_comes_again_is_a_new_one(tmp_path: Path) -> None:
    path = tmp_path / "plain.csv"
    path.write_text("t,vehicle,x,y\n0,a,0,0\n0.1,b,0,0\n0.2,a,0,0\n")
    assert [frame.vehicle_id.tolist() for frame in read_fcd(path)] == [[0], [1], [2]]


@pytest.mark.parametrize(
    ("text", "row", "says"),
    [
        ("t,vehicle,x,y\n0,a,1,2\n0.1,a,east,2\n", 3, "'east'"),
        ("t,vehicle,x,y\n0,a,1,2\n0.1,a,nan,2\n", 3, "'nan'"),
        ("t,vehicle,x,y\n0,a,1,2\n0.1,a,,2\n", 3, "blank"),
        ("t,vehicle,x,y\n0,,1,2\n", 2, "vehicle is blank"),
        ("t,vehicle,x,y\n0.1,a,1,2\n0,a,1,2\n", 3, "runs back"),
        ("t,vehicle,x,y\n0,a,1,2\n0,a,1,2\n", 3, "twice"),
        ("t,vehicle,x,y\n0,a,1\n", 2, "fields"),
        ("t,vehicle,x,y,speed\n0,a,1,2,-3\n", 2, "negative"),
        ("t,x,y\n0,1,2\n", 1, "vehicle"),
        ("timestep_time;vehicle_id;vehicle_x;vehicle_y\n0;a;1;2\n", 2, "heading"),
        ('<fcd-export>\n<timestep time="0">\n<vehicle id="a" x="b" y="2"/>\n', 3, "'b'"),
        ('<fcd-export>\n<timestep time="0">\n<vehicle id="a" x="1" y="2"\n', 3, "well-formed"),
        ('<routes>\n<vehicle id="a"/></routes>', 2, "blank"),
        ("<routes></routes>", 1, "fcd-export"),
    ],
)
def test_what_is_wrong_is_named_with_file_row_and_value(
    text: str, row: int, says: str, tmp_path: Path
) -> None:
    path = tmp_path / "bad"
    path.write_text(text)
    with pytest.raises(DataFormatError, match=says) as caught:
        list(read_fcd(path, slots=4))
    assert caught.value.row == row
    assert caught.value.path == str(path)


def test_too_many_vehicles_for_the_slots_are_an_error_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "made.csv"
    write_sumo_csv(path)
    with pytest.raises(DataFormatError, match="slots"):
        list(read_fcd(path, slots=1))


@pytest.mark.parametrize("content", [b"", b"PAR1 and nothing more", None])
def test_an_empty_broken_or_missing_file_is_an_error(content: bytes | None, tmp_path: Path) -> None:
    path = tmp_path / "bad"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(DataFormatError):
        list(read_fcd(path))


@pytest.mark.parametrize("write", [write_sumo_csv, write_sumo_parquet, write_sumo_xml])
def test_damage_raises_nothing_but_format_errors(write: Callable[[Path], None], tmp_path: Path) -> None:
    path = tmp_path / "made"
    write(path)
    whole = path.read_bytes()
    rng = np.random.default_rng(1)
    refused = 0
    for _ in range(60):
        damaged = bytearray(whole)
        for at in rng.integers(0, len(whole), 3):
            damaged[at] = int(rng.integers(256))
        path.write_bytes(damaged[: int(rng.integers(len(whole) // 2, len(whole) + 1))])
        try:
            list(read_fcd(path))
        except DataFormatError:
            refused += 1
    assert refused > 10


def test_a_file_is_read_as_a_stream(tmp_path: Path) -> None:
    """A mistake far down the file shows only when the reader comes to it."""
    path = tmp_path / "long.csv"
    path.write_text("t,vehicle,x,y\n" + "".join(f"{k / 10},a,{k},0\n" for k in range(2000)) + "oops\n")
    frames = read_fcd(path, slots=1)
    assert [next(frames).t_s for _ in range(1000)][-1] == pytest.approx(99.9)
    with pytest.raises(DataFormatError, match="fields"):
        list(frames)
