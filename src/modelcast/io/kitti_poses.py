"""KITTI odometry: the poses of a sequence, with the times of its pictures.

A recording is a file of poses, ``poses/00.txt`` of the benchmark or ``sequences/00/poses.txt`` of
SemanticKITTI. Its times are in ``../sequences/00/times.txt``, in ``times.txt`` beside it or in
``00_times.txt`` beside it: the first that is there. The trip is ``00/car``.

=============================  ===========================================================================
Column                         Use
=============================  ===========================================================================
poses 0-11                     the 3x4 matrix [R | t], row by row: from the left camera's axes now to its
                               axes at the first pose; x is to the right, y down, z forward [m]
poses 3, 7, 11 (t)             position: x is taken for east, z for north, -y for up
poses 2, 6, 10 (R's third)     where the camera looks: heading, clockwise from north
times 0                        time [s] from the first picture
=============================  ===========================================================================

The frame is local: its north is where the camera looked first, and its plane is that of the first picture. A
camera that is not level tilts it, which shortens ways by the cosine (0.06 % at 2 degrees). No place on Earth
and no date is known. Positions are the camera's, not those of the vehicle's middle. There is no speed.

Skipped and counted: "partial last line" of the poses. Another number of poses than of times, a rotation whose
axis has not the length 1, and times that do not increase are errors.

References
----------
KITTI visual odometry benchmark, readme.txt of its development kit (poses, times.txt); Geiger, Lenz, Stiller,
Urtasun: Vision meets robotics, IJRR 32 (2013), doi 10.1177/0278364913491297 (axes, 10 Hz).
"""

from collections.abc import Iterator
from os.path import normpath
from pathlib import Path
from typing import ClassVar

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.io.base import OnSkipped, Tally, ignore_skipped
from modelcast.io.holding import AbstractHoldingReader
from modelcast.io.packed import is_there, recording_stem
from modelcast.io.reading_limits import require_fitting
from modelcast.io.rows import Rows, make_trip
from modelcast.io.table_layout import is_number
from modelcast.io.text_blocks import number_column, read_blocks
from modelcast.io.text_head import file_head, first_lines
from modelcast.trips.trajectory import Trajectory

__all__ = ["KittiPosesReader"]

_WIDTH = 12
_AXIS, _PLACE = (2, 6, 10), (3, 7, 11)
_TOLERANCE = 0.01
"""How far the length of an axis may be from 1: poses are written with seven digits."""


class KittiPosesReader(AbstractHoldingReader):
    """Reads poses of KITTI's odometry benchmark; the module's docstring has the axes."""

    name: ClassVar[str] = "kitti-poses"
    streams: ClassVar[bool] = True

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether lines hold 12 numbers, and the first of them a rotation."""
        lines = [line.split() for line in first_lines(head) if line.strip()]
        if path.suffix != ".txt" or not lines or not all(len(line) == _WIDTH for line in lines):
            return False
        if not all(map(is_number, lines[0])):
            return False
        axis = np.array([float(lines[0][at]) for at in _AXIS])
        return bool(abs(float(np.linalg.norm(axis)) - 1.0) < _TOLERANCE)

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield the trip of one sequence, which is held whole."""
        trip_id = f"{_sequence(path)}/car"
        line, pose, partial = _numbers(path, _WIDTH, (*_AXIS, *_PLACE), trip_id, self.held_bytes)
        if not line.size and not partial:
            raise DataFormatError(path, "the file is empty", remedy="Check that it is complete.")
        times = _times_of(path)
        t_line, t_s, cut = _numbers(str(times), 1, (0,), trip_id, self.held_bytes)
        if cut or t_line.size != line.size + partial:
            raise DataFormatError(
                path,
                f"{line.size + partial} poses, but {t_line.size} times in {times}",
                remedy="Give the times of this sequence.",
            )
        _require_rotation(path, line, pose[:, :3])
        tally = Tally()
        tally.skip("partial last line", partial)
        axis, place = pose[:, :3], pose[:, 3:]
        rows = Rows(
            line,
            {
                "t_s": t_s[: line.size, 0],
                "east_m": place[:, 0],
                "north_m": place[:, 2],
                "up_m": -place[:, 1],
                "heading_rad": np.arctan2(axis[:, 0], axis[:, 2]),
            },
        )
        trip = make_trip(path, trip_id, rows, tally, count=len(rows) + partial, source=self.name)
        if trip is None:
            on_skipped(trip_id, tally.why_empty())
        else:
            yield trip


def _sequence(path: str) -> str:
    """Return what a sequence is called: by the file, or by the folder of a file called poses."""
    stem = recording_stem(path)
    return Path(path).resolve().parent.name if stem == "poses" else stem


def _times_of(path: str) -> Path:
    """Return the file of times that goes with the poses."""
    folder, stem = Path(path).parent, recording_stem(path)
    places = (
        Path(normpath(folder / "..")) / "sequences" / stem / "times.txt",
        folder / "times.txt",
        folder / f"{stem}_times.txt",
    )
    found = next((place for place in places if is_there(place)), None)
    if found is None:
        raise DataFormatError(
            path,
            f"no times with these poses: none of {', '.join(map(str, places))} is there",
            remedy="Put the sequence's times.txt beside it.",
        )
    return found


def _numbers(
    path: str, width: int, fields: tuple[int, ...], trip_id: str, held_bytes: int
) -> tuple[IntArray, FloatArray, int]:
    """Return line numbers, (R,), the wanted fields, (R, F), and whether a cut last line was passed over."""
    file_head(path)
    lines = [np.zeros(0, np.int64)]
    values = [np.zeros((0, len(fields)))]
    partial = count = 0
    for block in read_blocks(path, counts=[width], fields=fields, skip_lines=0, separator=" "):
        partial = partial or int(block.partial > 0)
        columns = [number_column(path, block, field, f"column {field + 1}") for field in fields]
        known = np.stack(columns, axis=1)
        if np.isnan(known).any():
            row = int(np.argmax(np.isnan(known).any(axis=1)))
            raise DataFormatError(
                path, "a number is missing", row=int(block.line[row]), remedy="Correct the line."
            )
        count += block.line.size
        require_fitting(path, trip_id, count, row_bytes=8 * (len(fields) + 1), held_bytes=held_bytes)
        lines.append(block.line)
        values.append(known)
    return np.concatenate(lines), np.concatenate(values), partial


def _require_rotation(path: str, line: IntArray, axis: FloatArray) -> None:
    length = np.linalg.norm(axis, axis=1)
    wrong = ~(np.abs(length - 1.0) < _TOLERANCE)
    if wrong.any():
        at = int(np.argmax(wrong))
        raise DataFormatError(
            path,
            f"the axis in columns 3, 7 and 11 has the length {length[at]:.6g}, not 1: no rotation",
            row=int(line[at]),
            remedy="A line is the 3x4 matrix of a pose, row by row.",
        )
