"""The example of a reader: installed as a package, every command reads its files."""

import numpy as np
import pytest


def trace(steps: int = 60) -> str:
    """Two nodes that drive in bends, the second with a place told twice; and one that only stands."""
    lines: list[str] = []
    for node in range(2):
        t_s = 0.1 * np.arange(steps)
        places = np.column_stack([t_s, 12.0 * t_s, 40.0 * node + 3.0 * np.sin(t_s)])
        if node:
            places = np.repeat(places, [1] * (steps - 1) + [2], axis=0)
        lines.append(" ".join(f"{number:.4f}" for number in places.ravel()))
    return "\n".join([*lines, "0.0 5.0 5.0"]) + "\n"


def test_its_files_are_found_and_read(python_with, tmp_path):
    place = tmp_path / "walk.movements"
    place.write_text(trace())
    script = """
import sys
import modelcast
for trip in modelcast.read_trips(sys.argv[1]):
    print(trip.trip_id, len(trip), *trip.position_m[-1].round(2).tolist(), dict(trip.reading.skipped))
"""
    said = python_with(("bonnmotion_reader",), "-c", script, str(place)).stdout.splitlines()
    assert said == [
        "walk/1 60 70.8 -1.12 {}",
        "walk/2 60 70.8 38.88 {'time repeated': 1}",
    ]


def test_the_commands_read_it_and_tell_who_gave_no_trip(python_with, tmp_path):
    place, out = tmp_path / "walk.movements", tmp_path / "walk.csv"
    place.write_text(trace())
    python_with(("bonnmotion_reader",), "-m", "modelcast", "convert", str(place), "--out", str(out))
    assert out.read_text().count("walk/1") == 60
    told = python_with(("bonnmotion_reader",), "-m", "modelcast", "trips", str(place)).stdout
    assert "no trip from walk/3: no usable row" in told


@pytest.mark.slow
def test_what_is_wrong_is_told_with_its_line(python_with, tmp_path):
    for number, (line, told) in enumerate(
        [
            ("0 1 x", "could not convert"),
            ("0 1", "2 numbers"),
            ("1 0 0 0.5 1 1", "times fall"),
            ("0 1 inf", "finite"),
        ]
    ):
        place = tmp_path / f"{number}.movements"
        place.write_text("0 0 0 0.1 1 1 0.2 2 2\n" + line + "\n")
        ended = python_with(("bonnmotion_reader",), "-m", "modelcast", "trips", str(place), fails=True)
        assert f"{number}.movements, row 2" in ended.stderr
        assert told in ended.stderr
