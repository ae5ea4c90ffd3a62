"""comma2k19 segments: one minute of a drive each, GNSS at 10 Hz with CAN and IMU.

A recording is a segment folder (it holds ``processed_log``), or any folder above segments: those are found.
The trip is ``<drive folder>/<segment number>``, the vehicle the device that a drive folder's name begins with
(``<device>|<start>``, the bar also written as an underscore). Every log is a pair of NumPy arrays without a
suffix: ``t``, seconds since the device started, and ``value``.

==============================  ===============================  ==========================================
Log                             Value                            Use
==============================  ===============================  ==========================================
GNSS/live_gnss_ublox            latitude, longitude [deg],       position and height; heading from the
                                speed [m/s], UTC [ms],           bearing (clockwise from north); time from
                                altitude [m], bearing [deg]      UTC, absolute
CAN/speed                       m/s                              speed
IMU/gyro                        rad/s about forward, right,      yaw rate: the third, clockwise positive
                                down
==============================  ===============================  ==========================================

Choices, each open to doubt:

- *Time* is the fix's UTC, on an exact 0.1 s grid, not ``t``, when it was logged 60-130 ms apart: positions
  belong to the former, and ``t`` would show as 10 % noise in speed.
- *Speed* is the last CAN value at or before the fix was logged (``t``): what a sender would have had. The
  ~0.1 s from fix to log is not known exactly and not removed.
- *Yaw rate* is the mean of the gyro over the 0.1 s before the fix was logged: 10 samples; single ones carry
  engine vibration. The axis was checked on the development segment against the camera's rotation in
  ``global_pose``: about its down axis the correlation is 0.98 and the slope 0.98. A gyro in the windscreen
  is tilted by a few degrees; that is not removed.
- *Heading* is the bearing, not the pose: the pose is optimised afterwards over the whole minute.

Skipped and counted: "no fix" (latitude and longitude 0 or out of range), "repeated fix", "no first value
yet". Repaired: "out of time order". Missing epochs are missing. A missing CAN or IMU log leaves its column
out. Numbers that are not finite, and arrays of other shapes, are errors.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from tokenize import TokenError
from typing import ClassVar, cast

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin, wrap_angle_rad
from modelcast.io.base import AbstractTripReader, OnSkipped, Tally, ignore_skipped
from modelcast.io.rows import Rows, are_numbers, located, make_trip, ordered
from modelcast.io.spmd import valid_position
from modelcast.trips.trajectory import Trajectory

__all__ = ["MOST_BYTES", "Comma2k19Reader"]

MOST_BYTES = 32 * 2**20
"""Octets of one log of a segment; those of a minute have at most some hundred thousand."""

_LOG = "processed_log"
_GNSS, _SPEED, _GYRO = "GNSS/live_gnss_ublox", "CAN/speed", "IMU/gyro"
_YAW_WINDOW_S = 0.1
"""The gyro is averaged over one GNSS step."""
_DRIVE = re.compile(r"([0-9a-f]{16})[|_]\d{4}-\d\d-\d\d--")
_DEPTH = 4
"""Levels of folders above a segment at which segments are looked for."""


class Comma2k19Reader(AbstractTripReader):
    """Reads comma2k19 segments; the module's docstring has the logs and the choices."""

    name: ClassVar[str] = "comma2k19"

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether this is a segment's folder; `read` also takes folders above."""
        del head
        return (path / _LOG).is_dir()

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per segment, drives and segments in order; a segment is held whole."""
        found = sorted(_segments(Path(path)), key=_segment_order)
        if not found:
            raise DataFormatError(path, f"no folder with {_LOG} in it", remedy="Give a segment's folder.")
        for segment in found:
            whole = segment.resolve()
            trip_id = f"{whole.parent.name}/{whole.name}"
            tally = Tally()
            rows, count, start_unix_s = _gnss(segment, tally)
            trip = None
            if len(rows):
                first = {name: float(column[0]) for name, column in rows.columns.items()}
                origin = Origin(first["latitude_deg"], first["longitude_deg"], first["altitude_m"])
                rows = located(ordered(rows, tally, duplicate="repeated fix"), origin)
                trip = make_trip(
                    str(segment), trip_id, rows, tally,
                    count=count, source=self.name, origin=origin, unix_offset_s=start_unix_s,
                    vehicle=device[1] if (device := _DRIVE.match(whole.parent.name)) else "",
                )  # fmt: skip
            if trip is None:
                on_skipped(trip_id, tally.why_empty())
            else:
                yield trip


def _segments(path: Path) -> Iterator[Path]:
    """Yield the segment folders at or under a folder."""
    for depth in range(_DEPTH):
        for log in path.glob("*/" * depth + _LOG):
            if log.is_dir():
                yield log.parent


def _segment_order(segment: Path) -> tuple[str, int, str]:
    number = segment.name
    return str(segment.parent), int(number) if number.isdecimal() else -1, number


def _gnss(segment: Path, tally: Tally) -> tuple[Rows, int, float]:
    """Return the fixes with speed and yaw rate of when each was logged, their number, the Unix start."""
    logged_s, value = _log(segment, _GNSS, 6)
    rows = Rows(
        np.arange(1, logged_s.size + 1, dtype=np.int64),
        {
            "t_s": (value[:, 3] - value[0, 3]) * 1e-3,
            "latitude_deg": value[:, 0],
            "longitude_deg": value[:, 1],
            "altitude_m": value[:, 4],
            "heading_rad": wrap_angle_rad(np.radians(value[:, 5])),
        },
    )
    if (segment / _LOG / _SPEED / "value").exists():
        rows = rows.having(speed_mps=_last_before(logged_s, *_log(segment, _SPEED, 1)))
    if (segment / _LOG / _GYRO / "value").exists():
        rows = rows.having(yaw_rate_radps=_mean_before(logged_s, *_log(segment, _GYRO, 3)))
    placed = valid_position(value[:, 0], value[:, 1])
    return rows.without(~placed, "no fix", tally), int(logged_s.size), float(value[0, 3]) * 1e-3


def _last_before(at_s: FloatArray, t_s: FloatArray, value: FloatArray) -> FloatArray:
    """Return the last value at or before each time, NaN before the first."""
    last = np.searchsorted(t_s, at_s, side="right") - 1
    return np.where(last < 0, np.nan, value[np.maximum(last, 0), 0])


def _mean_before(at_s: FloatArray, t_s: FloatArray, rate: FloatArray) -> FloatArray:
    """Return the mean rate about the down axis over the window before each time, NaN before the first."""
    total = np.concatenate([[0.0], np.cumsum(rate[:, 2])])
    end = np.searchsorted(t_s, at_s, side="right")
    begin = np.minimum(np.searchsorted(t_s, at_s - _YAW_WINDOW_S, side="right"), np.maximum(end - 1, 0))
    return np.where(end == 0, np.nan, (total[end] - total[begin]) / np.maximum(end - begin, 1))


def _log(segment: Path, name: str, width: int) -> tuple[FloatArray, FloatArray]:
    """Return the times, (T,), and values, (T, width), of one log, checked."""
    folder = segment / _LOG / name
    t_s, value = _array(folder / "t"), _array(folder / "value")
    if t_s.ndim != 1 or not t_s.size or value.size != t_s.size * width or len(value) != t_s.size:
        raise DataFormatError(
            str(folder), f"t and value have shapes {t_s.shape} and {value.shape}, not (T,) and (T, {width})"
        )
    value = value.reshape(t_s.size, width)
    bad = ~are_numbers(value).all(axis=1) | ~are_numbers(t_s)
    bad[1:] |= t_s[1:] < t_s[:-1]
    if bad.any():
        at = int(np.argmax(bad))
        raise DataFormatError(
            str(folder),
            f"time or value is not a finite number, or time runs backwards: {t_s[at]}, {value[at].tolist()}",
            row=at + 1,
            remedy="Leave this segment out.",
        )
    return t_s, value


def _array(path: Path) -> FloatArray:
    try:
        if path.stat().st_size > MOST_BYTES:
            raise DataFormatError(str(path), f"has over {MOST_BYTES:,} octets: a segment is a minute long")
        with path.open("rb") as file:
            loaded = cast("object", np.load(file, allow_pickle=False))
    except (ValueError, EOFError, OSError, SyntaxError, MemoryError, TokenError) as error:
        raise DataFormatError(str(path), f"is not a NumPy array: {error}") from error
    if not isinstance(loaded, np.ndarray) or loaded.dtype.kind not in "fiu":
        raise DataFormatError(str(path), "holds no numbers")
    return cast("FloatArray", loaded).astype(np.float64)
