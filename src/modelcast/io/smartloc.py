"""smartLoc drives in libRSF's text format: a ground-truth file and the sensor file beside it, 5 Hz.

Given either ``<name>_GT.txt`` or ``<name>_Input.txt``, the other is read too where it is there. The trip
is ``<name>_GT/car``.

==============  ===========================  ==========================================================
Line            Fields                       Use
==============  ===========================  ==========================================================
point3          t x y z, covariance (9)      time [s], position, Earth-centred [m]
odom3           t vx vy vz wx wy wz,         vx is the speed [m/s]; wz the yaw rate [rad/s], which is
                covariance (6)               anticlockwise and so turned round (against the positions'
                                             course its slope is -1.001)
anything else   a word and numbers           skipped, "other measurement" (pseudoranges), of both files
==============  ===========================  ==========================================================

Times are seconds from the start of the drive, not absolute. Steps of 0.3 s occur among those of 0.2 s, so
trips are resampled. Speed and yaw rate are those of the same instant; where odometry lacks an instant, its
last value before it is held. Without an input file a trip has positions only.

Skipped and counted: "partial last line" (also a cut last number), "no first value yet"; "duplicate time".
Repaired and counted: "odometry missing, last value held". Time running backwards is an error.
"""

from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import ecef_to_enu
from modelcast.io.base import AbstractTripReader, OnSkipped, Tally, ignore_skipped
from modelcast.io.packed import is_there
from modelcast.io.reading_limits import HELD_BYTES, require_fitting
from modelcast.io.rows import LARGEST, Rows, make_trip
from modelcast.io.text_head import first_lines
from modelcast.trips.trajectory import Trajectory

__all__ = ["SmartLocReader"]

_TRUTH, _INPUT = "_GT.txt", "_Input.txt"
_WORDS = {"point3": 4, "odom3": 7}
"""Numbers needed on a line of each kind."""
_MOST_NUMBERS = 13
"""Numbers on a line of either kind with its covariance; more are two lines in one."""
_EARTH_RADIUS_M = (6.3e6, 6.5e6)
"""Bounds of the distance of a road from the Earth's centre."""


@dataclass(frozen=True, slots=True)
class _Measurements:
    """One file: its points with their line numbers, its odometry, counts of other and of cut lines."""

    line: IntArray
    point: FloatArray
    odometry: FloatArray
    other: int
    cut: int


class SmartLocReader(AbstractTripReader):
    """Reads smartLoc drives; the module's docstring has the lines and the repairs."""

    name: ClassVar[str] = "smartloc"

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether the first lines are measurements with a libRSF word and numbers."""
        del path
        lines = [line.split() for line in first_lines(head) if line.strip()]
        return bool(lines) and all(
            words[0] in {*_WORDS, "pseudorange3"} and len(words) > 4 for words in lines[:3]
        )

    def stands_for(self, path: Path) -> Path:
        """Return the ground-truth file, where there is one beside this file."""
        truth = path.with_name(path.name.removesuffix(_INPUT) + _TRUTH)
        return truth if path.name.endswith(_INPUT) and is_there(truth) else path

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield the drive's one trip."""
        truth = self.stands_for(Path(path))
        truth_path = str(truth) if truth != Path(path) else path
        files = [_measurements(truth_path)]
        sensors = truth.with_name(truth.name.removesuffix(_TRUTH) + _INPUT)
        if truth.name.endswith(_TRUTH) and sensors.exists():
            files.append(_measurements(str(sensors)))
        point_line, point = files[0].line, files[0].point
        odometry = files[-1].odometry
        if not point.size:
            raise DataFormatError(
                path,
                "no point3 line",
                remedy=f"Positions are in the file that ends with {_TRUTH}; put it beside this one.",
            )
        radius = np.linalg.norm(point[:, 1:4], axis=1)
        wrong = (radius < _EARTH_RADIUS_M[0]) | (radius > _EARTH_RADIUS_M[1])
        if wrong.any():
            at = int(np.argmax(wrong))
            raise DataFormatError(
                truth_path,
                f"the position is {radius[at]:.0f} m from the Earth's centre",
                row=int(point_line[at]),
                remedy="Positions are Earth-centred, in metres.",
            )
        tally = Tally()
        cut, other = sum(file.cut for file in files), sum(file.other for file in files)
        tally.skip("partial last line", cut)
        tally.skip("other measurement", other)
        trip_id = f"{truth.stem}/car"
        enu, origin = ecef_to_enu(point[:, 1:4])
        columns = {"t_s": point[:, 0], "east_m": enu[:, 0], "north_m": enu[:, 1], "up_m": enu[:, 2]}
        if odometry.size:
            columns |= _odometry_at(point[:, 0], odometry, tally)
        rows = Rows(point_line, columns)
        again = np.concatenate([[False], np.diff(point[:, 0]) == 0])
        rows = rows.without(again, "duplicate time", tally)
        trip = make_trip(
            truth_path, trip_id, rows, tally,
            count=len(point_line) + cut + other, source=self.name, origin=origin,
        )  # fmt: skip
        if trip is None:
            on_skipped(trip_id, tally.why_empty())
        else:
            yield trip


def _odometry_at(t_s: FloatArray, odometry: FloatArray, tally: Tally) -> dict[str, FloatArray]:
    """Return speed and yaw rate at these times: of the same instant, else the last before it."""
    odometry = odometry[np.argsort(odometry[:, 0], kind="stable")]
    last = np.searchsorted(odometry[:, 0], t_s, side="right") - 1
    none = last < 0
    found = odometry[np.maximum(last, 0)]
    tally.repair("odometry missing, last value held", int((~none & (found[:, 0] != t_s)).sum()))
    return {
        "speed_mps": np.where(none, np.nan, found[:, 1]),
        "yaw_rate_radps": np.where(none, np.nan, -found[:, 6]),
    }


def _measurements(path: str) -> _Measurements:
    """Return what one file holds."""
    lines = array("q")
    values = {word: array("d") for word in _WORDS}
    other = cut = 0
    with Path(path).open(encoding="utf-8-sig", errors="replace", newline=None) as file:
        for number, line in enumerate(file, start=1):
            words = line.split()
            if not words:
                continue
            needed = _WORDS.get(words[0])
            if not line.endswith("\n") and (needed is None or len(words) < needed + 1):
                cut = 1
            elif needed is None:
                _check_other(path, number, words)
                other += 1
            else:
                values[words[0]].extend(_floats(path, number, words, needed))
                if words[0] == "point3":
                    lines.append(number)
                    rows, row_bytes = len(lines), 8 * (needed + 1)
                    trip = f"{Path(path).stem}/car"
                    require_fitting(path, trip, rows, row_bytes=row_bytes, held_bytes=HELD_BYTES)
    point, odometry = (_table(values[word], needed) for word, needed in _WORDS.items())
    return _Measurements(np.asarray(lines, np.int64), point, odometry, other, cut)


def _table(values: "array[float]", width: int) -> FloatArray:
    return np.array(values, dtype=np.float64).reshape(-1, width)


def _check_other(path: str, number: int, words: list[str]) -> None:
    """Refuse lines that are no measurement of any kind."""
    if not words[0].isidentifier() or len(words) < 2:
        raise DataFormatError(
            path, f"{words[0]!r} is no kind of measurement", row=number,
            remedy="A line is a word and its numbers.",
        )  # fmt: skip
    if any(word in _WORDS for word in words[1:]):
        raise DataFormatError(
            path, f"a second measurement in a line of {words[0]}", row=number,
            remedy="A measurement is a line: put a line end between the two.",
        )  # fmt: skip


def _floats(path: str, number: int, words: list[str], needed: int) -> list[float]:
    """Return the numbers after the word, checked."""
    if len(words) < needed + 1:
        raise DataFormatError(path, f"{words[0]} has {len(words) - 1} numbers, not {needed}", row=number)
    if len(words) > _MOST_NUMBERS + 1:
        raise DataFormatError(
            path, f"{words[0]} has {len(words) - 1} fields, more than {_MOST_NUMBERS}", row=number,
            remedy="A measurement is a line: put a line end between the two.",
        )  # fmt: skip
    found: list[float] = []
    for text in words[1 : needed + 1]:
        try:
            value = float(text)
        except ValueError:
            value = np.nan
        if not abs(value) <= LARGEST:
            raise DataFormatError(
                path, f"{words[0]} holds {text!r}, not a finite number", row=number,
                remedy="Correct or remove the line.",
            )  # fmt: skip
        found.append(value)
    return found
