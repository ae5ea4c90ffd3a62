"""Floating-car data of any origin as frames: CSV, Parquet or SUMO's XML, read as a stream.

`modelcast.io.fcd_rows` has the table of columns. Rows are in order of time; each vehicle has one row a time.
Speed, heading, acceleration and yaw rate are taken from the frames around where the file has none. In SUMO's
files x and y are the middle of the front bumper: positions are moved back by half a length.
"""

from collections.abc import Iterator
from math import cos, sin
from pathlib import Path

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.io.fcd_rows import FcdRow, is_sumo, read_rows
from modelcast.io.fleet_slots import RAW_COLUMNS, FleetSlots
from modelcast.simulation.scenario.base import FleetFrame
from modelcast.simulation.scenario.completion import completed

__all__ = ["most_vehicles", "read_fcd"]

_HEADING, _LENGTH = RAW_COLUMNS.index("heading_rad"), RAW_COLUMNS.index("length_m")


def read_fcd(
    path: str | Path,
    *,
    slots: int | None = None,
    vehicle_length_m: float = 4.5,
    front_bumper: bool | None = None,
) -> Iterator[FleetFrame]:
    """Yield a file's frames at the file's own times, counted from its first.

    Only a few frames are held at a time. A step of 0.1 s is what senders need; `resampled`, in
    `modelcast.simulation.scenario.resampling`, makes it of a coarser one.

    Parameters
    ----------
    path
        The file.
    slots
        Number of slots V; where None the file is read once more beforehand to count its vehicles.
    vehicle_length_m
        Length of vehicles whose length the file does not say [m].
    front_bumper
        Whether positions are those of the front bumper; where None, in SUMO's files they are.

    Raises
    ------
    DataFormatError
        Where the file is not what it should be, with file, row and value: among others time that runs back,
        a vehicle twice at one time, or more vehicles than slots.
    """
    at = str(path)
    places = most_vehicles(at) if slots is None else slots
    if places < 1:
        raise DataFormatError(at, "no vehicle in the file", remedy="Check that it is complete.")
    shifted = is_sumo(at) if front_bumper is None else front_bumper
    return completed(_frames(at, places, vehicle_length_m, front_bumper=shifted))


def most_vehicles(path: str | Path) -> int:
    """Return how many vehicles a file has at most at one time; it is read whole, and held not at all."""
    return max((len(rows) for rows in _by_time(str(path))), default=0)


def _by_time(path: str) -> Iterator[list[FcdRow]]:
    """Yield the rows of each time, checked for order."""
    gathered: list[FcdRow] = []
    for row in read_rows(path):
        if gathered and row.t_s != gathered[0].t_s:
            if row.t_s < gathered[0].t_s:
                raise DataFormatError(
                    path,
                    f"time runs back from {gathered[0].t_s} to {row.t_s}",
                    row=row.row,
                    remedy="Sort the file by time.",
                )
            yield gathered
            gathered = []
        gathered.append(row)
    if gathered:
        yield gathered


def _frames(path: str, slots: int, length_m: float, *, front_bumper: bool) -> Iterator[FleetFrame]:
    seats = FleetSlots(slots)
    start_s: float | None = None
    for rows in _by_time(path):
        start_s = rows[0].t_s if start_s is None else start_s
        labels: dict[str, int] = {}
        for row in rows:
            if row.vehicle in labels:
                raise DataFormatError(
                    path,
                    f"vehicle {row.vehicle} occurs twice at {row.t_s} s, also in row {labels[row.vehicle]}",
                    row=row.row,
                    remedy="Leave one row a vehicle and time.",
                )
            labels[row.vehicle] = row.row
        numbers = np.array([row.numbers for row in rows])
        unknown = np.isnan(numbers[:, _LENGTH])
        numbers[unknown, _LENGTH] = length_m
        numbers[:, _HEADING] = wrap_angle_rad(numbers[:, _HEADING])
        if front_bumper:
            _shift_back(path, rows, numbers)
        frame = seats.frame(round(rows[0].t_s - start_s, 6), list(labels), numbers)
        if frame is None:
            raise DataFormatError(
                path,
                f"{len(rows)} vehicles at time {rows[0].t_s} do not fit into {slots} slots",
                row=rows[-1].row,
                remedy="Raise slots, or leave it out.",
            )
        yield frame


def _shift_back(path: str, rows: list[FcdRow], numbers: FloatArray) -> None:
    """Move positions from front bumpers to middles, in place."""
    for row, entry in zip(rows, numbers, strict=True):
        heading, half = float(entry[_HEADING]), 0.5 * float(entry[_LENGTH])
        if np.isnan(heading):
            raise DataFormatError(
                path,
                f"vehicle {row.vehicle} has no heading, which is needed to find its middle",
                row=row.row,
                remedy="Add the heading, or say front_bumper=False.",
            )
        entry[0] -= half * sin(heading)
        entry[1] -= half * cos(heading)
