"""KITTI raw data: the packets of the inertial unit with satellite positioning (OXTS) of a drive.

A recording is a drive's folder (it holds ``oxts/data``), or the folder ``oxts`` itself. The trip is
``<drive folder>/car``. Line k + 1 of ``timestamps.txt`` is the time of the packet
``data/<k, ten digits>.txt``, a line of 30 numbers.

========  ===========================  ==================================================================
No.       Value                        Use
========  ===========================  ==================================================================
0-2       lat, lon [deg], alt [m]      position and height
3-4       roll, pitch [rad]            not used
5         yaw [rad]                    heading: 0 is east and positive anticlockwise, so it is turned round
6-7       vn, ve [m/s]                 not used: forward speed goes with the heading, also in reverse
8         vf [m/s]                     speed, forward and level
9-13      vl, vu; ax, ay, az           not used: leftward, upward; along the vehicle's axes, with gravity
14        af [m/s²]                    acceleration, forward and level
15-21     al, au; wx, wy, wz; wf, wl   not used
22        wu [rad/s]                   yaw rate about the upward axis, positive anticlockwise: turned round
23-29     accuracies, states           not used: the states' meanings are not in the data
========  ===========================  ==================================================================

Times are dates with nanoseconds and without a zone, so a trip has no absolute time. They are taken as whole
nanoseconds from the first. Positions are those of the unit, not of the vehicle's middle.

Both kinds of a drive are read: ``_sync`` with a packet a picture (10 Hz), and ``_extract`` as recorded
(100 Hz), whose times jump back and forth and leave gaps.

Rows are packets and times, paired by number. Skipped and counted: "packet missing" (a time without a file),
"packet empty", "time missing" (a packet without a time, or a blank line), "position unavailable", "duplicate
time". Repaired: "out of time order". Files in ``data`` that are no packets are reported. A drive's used
numbers are held, its packets are read one by one.

References
----------
KITTI raw data development kit, readme.txt and ``oxts/dataformat.txt``; Geiger, Lenz, Stiller, Urtasun: Vision
meets robotics, IJRR 32 (2013), doi 10.1177/0278364913491297.
"""

from array import array
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import ClassVar

import numpy as np
import polars as pl

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin, wrap_angle_rad
from modelcast.io.base import OnSkipped, Tally, ignore_skipped
from modelcast.io.holding import AbstractHoldingReader
from modelcast.io.reading_limits import require_fitting
from modelcast.io.rows import LARGEST, Rows, located, make_trip, ordered
from modelcast.io.spmd import valid_position
from modelcast.io.time_column import TimeColumn, holds_dates
from modelcast.trips.trajectory import Trajectory

__all__ = ["KittiOxtsReader"]

_FOLDER, _DATA, _TIMES = "oxts", "data", "timestamps.txt"
_NUMBERS = 30
_FIELDS = {
    "latitude_deg": 0,
    "longitude_deg": 1,
    "altitude_m": 2,
    "yaw_rad": 5,
    "speed_mps": 8,
    "acceleration_mps2": 14,
    "up_rate_radps": 22,
}
_LARGEST_PACKET = 4096
"""Octets; an honest packet has about 400."""


class KittiOxtsReader(AbstractHoldingReader):
    """Reads the OXTS folders of KITTI's raw data; the module's docstring has the numbers."""

    name: ClassVar[str] = "kitti-oxts"

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether this is a drive's folder, or the folder ``oxts`` in it."""
        del head
        return (_oxts(path) / _DATA).is_dir() and (_oxts(path) / _TIMES).exists()

    def stands_for(self, path: Path) -> Path:
        """Return the folder ``oxts``."""
        return _oxts(path)

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield the drive's trip."""
        folder = _oxts(Path(path))
        if not (folder / _DATA).is_dir() or not (folder / _TIMES).is_file():
            raise DataFormatError(
                path, f"no {_FOLDER}/{_DATA} with {_FOLDER}/{_TIMES} in it", remedy="Give a drive's folder."
            )
        trip_id = f"{folder.resolve().parent.name}/car"
        tally = Tally()
        named = _named(folder / _DATA, trip_id, on_skipped)
        row_bytes = 8 * (len(_FIELDS) + 2)
        require_fitting(path, trip_id, len(named), row_bytes=row_bytes, held_bytes=self.held_bytes)
        rows = _packets(folder, named, tally)
        count = len(rows) + tally.left_out
        rows = _usable(rows, tally)
        trip = None
        if len(rows):
            columns = rows.columns
            origin = Origin(
                float(columns["latitude_deg"][0]),
                float(columns["longitude_deg"][0]),
                float(columns["altitude_m"][0]),
            )
            rows = located(ordered(rows, tally), origin)
            trip = make_trip(str(folder), trip_id, rows, tally, count=count, source=self.name, origin=origin)
        if trip is None:
            on_skipped(trip_id, tally.why_empty())
        else:
            yield trip


def _oxts(path: Path) -> Path:
    return path if path.name == _FOLDER else path / _FOLDER


def _named(data: Path, trip_id: str, on_skipped: OnSkipped) -> dict[int, Path]:
    """Return the packets by number."""
    named: dict[int, Path] = {}
    for entry in sorted(data.iterdir()):
        if entry.suffix == ".txt" and entry.stem.isdecimal() and int(entry.stem) not in named:
            named[int(entry.stem)] = entry
        else:
            on_skipped(f"{trip_id}/{entry.name}", "is no packet, <number>.txt")
    return named


def _packets(folder: Path, named: Mapping[int, Path], tally: Tally) -> Rows:
    """Return the packets in order with their times, those that are missing or empty counted."""
    times = _times(folder / _TIMES)
    tally.skip("packet missing", len(times) - sum(number < len(times) for number in named))
    numbers, values, t_s = array("q"), array("d"), array("d")
    for number in sorted(named):
        packet = _packet(named[number])
        if packet:
            numbers.append(number + 1)
            values.extend(packet)
            t_s.append(times[number] if number < len(times) else np.nan)
    tally.skip("packet empty", len(named) - len(numbers))
    table = np.array(values).reshape(-1, len(_FIELDS))
    columns = {name: table[:, at] for at, name in enumerate(_FIELDS)}
    return Rows(np.array(numbers, np.int64), {"t_s": np.array(t_s), **columns})


def _usable(rows: Rows, tally: Tally) -> Rows:
    """Return the packets with a time and a position, in SI units and our senses of turning."""
    rows = rows.without(np.isnan(rows.columns["t_s"]), "time missing", tally)
    placed = valid_position(rows.columns["latitude_deg"], rows.columns["longitude_deg"])
    rows = rows.without(~placed, "position unavailable", tally)
    columns = rows.columns
    return Rows(
        rows.line,
        {
            "t_s": columns["t_s"],
            "latitude_deg": columns["latitude_deg"],
            "longitude_deg": columns["longitude_deg"],
            "altitude_m": columns["altitude_m"],
            "speed_mps": columns["speed_mps"],
            "heading_rad": wrap_angle_rad(0.5 * np.pi - columns["yaw_rad"]),
            "acceleration_mps2": columns["acceleration_mps2"],
            "yaw_rate_radps": -columns["up_rate_radps"],
        },
    )


def _times(path: Path) -> FloatArray:
    """Return the times of packets from the first [s], NaN where a line is blank, (T,)."""
    lines = path.read_text(encoding="utf-8-sig", errors="replace").splitlines()
    while lines and not lines[-1].strip():
        lines.pop()
    text = pl.Series("timestamp", [line.strip() or None for line in lines], pl.String)
    if not text.count():
        return np.full(len(lines), np.nan)
    line = np.arange(1, len(lines) + 1)
    if not holds_dates(text):
        first = int(text.is_not_null().arg_max() or 0)
        raise DataFormatError(
            str(path), f"the time is {text[first]!r}, not as 2011-09-26 13:02:25.964389445", row=first + 1,
            remedy="Give the drive's own timestamps.txt.",
        )  # fmt: skip
    times = TimeColumn(str(path), "timestamp", 1.0, stated=True)
    return times.read(text, line) * times.unit.unit_s


def _packet(path: Path) -> list[float]:
    """Return a packet's wanted numbers, none where the file is empty."""
    with path.open("rb") as file:
        content = file.read(_LARGEST_PACKET + 1)
    words = content.decode("ascii", "replace").split()
    if not words:
        return []
    if len(words) != _NUMBERS or len(content) > _LARGEST_PACKET:
        raise DataFormatError(
            str(path), f"holds {len(words)} words, not {_NUMBERS} numbers", row=1,
            remedy="Leave the packet out; it is then counted as missing.",
        )  # fmt: skip
    wanted: list[float] = []
    for field in _FIELDS.values():
        word = words[field]
        try:
            value = float(word)
        except ValueError:
            value = np.nan
        if not abs(value) <= LARGEST:
            raise DataFormatError(
                str(path), f"number {field} is {word!r}, not a finite number", row=1,
                remedy="Leave the packet out; it is then counted as missing.",
            )  # fmt: skip
        wanted.append(value)
    return wanted
