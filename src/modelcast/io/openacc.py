"""OpenACC platoons recorded at the ZalaZONE proving ground: one file, several cars on one clock, 10 Hz.

Five metadata lines (``Date``, ``Vehicle_order``, ``Number_of_vehicles``, ``ACC``, ``Distance_setting``), a
header, then one row per 0.1 s. Car k is the k-th name of ``Vehicle_order``; that was checked on one car's
repeated positions, which follow its name through files with different orders. Some cars have no columns.

=============  ======  ====================================================================
Column         Unit    Use
=============  ======  ====================================================================
Time           s       time; not absolute
Speed<k>       m/s     speed; slightly negative at standstill in places, kept
E<k>, N<k>     m       east, north, shifted so that the file's first valid sample is (0, 0)
Alt<k>         m       height above that sample
Lon<k>, Lat<k> deg     of the first valid sample only: the frame's origin
IVS<k>         m       inter-vehicle spacing; not used
=============  ======  ====================================================================

E, N are used rather than longitude and latitude: the two agree within 0.1 m over 550 m in every file seen.
There is no heading, acceleration or yaw rate.

Skipped and counted: rows without a position ("position missing") or time ("time missing"), a cut last line
("partial last line"). Repaired: single missing speeds or heights (the last value is held). A car named in
``Vehicle_order`` without columns, or with none but blank cells, is reported as skipped.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.core.trajectory import Trajectory
from modelcast.io.base import AbstractTripReader, OnSkipped, Tally, ignore_skipped
from modelcast.io.rows import Rows, joined, make_trip
from modelcast.io.text_blocks import number_column, read_blocks
from modelcast.io.text_head import file_head, first_lines, split_fields
from modelcast.simulation.scenario.replay import Replay, make_replay

__all__ = ["OpenAccReader", "read_platoon"]

_COLUMNS = {"Speed": "speed_mps", "E": "east_m", "N": "north_m", "Lon": "lon", "Lat": "lat", "Alt": "up_m"}


class OpenAccReader(AbstractTripReader):
    """Reads OpenACC ZalaZONE files; the module's docstring has the columns and the repairs."""

    name: ClassVar[str] = "openacc"

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether the metadata lines of the format are there."""
        del path
        return any(line.startswith("Vehicle_order,") for line in first_lines(head)[:5])

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per car, ``<stem>/<name in Vehicle_order>``; the file is held whole."""
        for trip in _trips_on_one_clock(path, on_skipped):
            yield replace(trip, start_unix_s=None)


def read_platoon(path: str | Path, *, length_m: float = 4.5) -> Replay:
    """Return the cars of a file on their one clock, as a scenario.

    Parameters
    ----------
    path
        The file.
    length_m
        Length of the cars, which the format does not say [m].

    Raises
    ------
    DataFormatError
        Where the file breaks a rule of the format, or holds no car.
    """
    trips = list(_trips_on_one_clock(str(path), ignore_skipped))
    if not trips:
        raise DataFormatError(str(path), "holds no car with a position", remedy="See docs/formats.md.")
    return make_replay(trips, [trip.start_unix_s or 0.0 for trip in trips], length_m=length_m)


def _trips_on_one_clock(path: str, on_skipped: OnSkipped) -> Iterator[Trajectory]:
    """Yield a trip per car, with the file's time of its first sample as `start_unix_s`."""
    names, header, header_line = _layout(path)
    stem = Path(path).stem
    cars, partial = _cars(path, header, header_line)
    origin, east_m, north_m = _origin(cars)
    for number, name in enumerate(names, start=1):
        if number not in cars:
            on_skipped(f"{stem}/{name}", "named in Vehicle_order but without columns")
            continue
        rows, tally = cars[number], Tally()
        tally.skip("partial last line", int(partial))
        count = len(rows) + int(partial)
        rows = rows.without(np.isnan(rows.columns["t_s"]), "time missing", tally)
        rows = rows.without(_unplaced(rows), "position missing", tally)
        columns = rows.columns
        rows = rows.having(
            east_m=columns["east_m"] - east_m,
            north_m=columns["north_m"] - north_m,
            up_m=columns["up_m"] - origin.altitude_m,
        )
        trip = make_trip(
            path,
            f"{stem}/{name}",
            rows,
            tally,
            count=count,
            source=OpenAccReader.name,
            origin=origin,
            unix_offset_s=0.0,
        )
        if trip is None:
            on_skipped(f"{stem}/{name}", tally.why_empty())
        else:
            yield trip


def _layout(path: str) -> tuple[list[str], list[str], int]:
    """Return the cars' names in order, the header's fields and its one-based line."""
    lines = first_lines(file_head(path))
    order = next((line for line in lines[:5] if line.startswith("Vehicle_order,")), None)
    at = next((at for at, line in enumerate(lines[:20]) if line.startswith("Time,")), None)
    if order is None or at is None:
        raise DataFormatError(
            path,
            "no Vehicle_order line with a header row that begins with Time after it",
            remedy="OpenACC files begin with five metadata lines and a header row.",
        )
    names = [name for name in split_fields(order)[1:] if name]
    header = split_fields(lines[at])
    repeated = {field for field in header if header.count(field) > 1}
    if repeated:
        raise DataFormatError(path, f"columns {sorted(repeated)} occur more than once", row=at + 1)
    if len(set(names)) != len(names):
        names = [f"{name}-{number}" for number, name in enumerate(names, start=1)]
    for number in _numbers(header):
        missing = [f"{word}{number}" for word in _COLUMNS if f"{word}{number}" not in header]
        if missing or not 1 <= number <= len(names):
            problem = f"column {missing[0]} is missing" if missing else f"Speed{number} has no name"
            raise DataFormatError(
                path, f"{problem}; Vehicle_order names {len(names)} cars", row=at + 1,
                remedy="Car k needs Speedk, Ek, Nk, Lonk, Latk, Altk and the k-th name of Vehicle_order.",
            )  # fmt: skip
    if not _numbers(header):
        raise DataFormatError(path, "no Speed<k> column", row=at + 1, remedy="See docs/formats.md.")
    return names, header, at + 1


def _numbers(header: list[str]) -> list[int]:
    return [int(field[5:]) for field in header if field.startswith("Speed") and field[5:].isdecimal()]


def _cars(path: str, header: list[str], header_line: int) -> tuple[dict[int, Rows], bool]:
    """Return every car's rows as they stand, and whether the last line is cut."""
    field = {name: at for at, name in enumerate(header)}
    parts: dict[int, list[Rows]] = {number: [] for number in _numbers(header)}
    wanted = [field["Time"], *(field[f"{word}{number}"] for word in _COLUMNS for number in parts)]
    partial = False
    for block in read_blocks(path, counts=[len(header)], fields=wanted, skip_lines=header_line):
        partial = partial or block.partial > 0
        t_s = number_column(path, block, field["Time"], "Time")
        for number, pieces in parts.items():
            columns: dict[str, FloatArray] = {"t_s": t_s}
            for word, name in _COLUMNS.items():
                column = f"{word}{number}"
                columns[name] = number_column(path, block, field[column], column)
            pieces.append(Rows(block.line, columns))
    if not any(len(piece) for pieces in parts.values() for piece in pieces):
        raise DataFormatError(path, "no rows after the header", row=header_line, remedy="The file is empty.")
    return {number: joined(pieces) for number, pieces in parts.items()}, partial


def _unplaced(rows: Rows) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    return np.isnan(rows.columns["east_m"]) | np.isnan(rows.columns["north_m"])


def _origin(cars: dict[int, Rows]) -> tuple[Origin, float, float]:
    """Return the frame's origin: the earliest row with a full position, of the first car that has one."""
    best: tuple[int, int] | None = None
    for number, rows in cars.items():
        columns = rows.columns
        full = np.isfinite(columns["lat"] + columns["lon"] + columns["up_m"]) & ~_unplaced(rows)
        if full.any() and (best is None or int(np.argmax(full)) < best[0]):
            best = (int(np.argmax(full)), number)
    if best is None:
        return Origin(0.0, 0.0), 0.0, 0.0
    columns = {name: float(column[best[0]]) for name, column in cars[best[1]].columns.items()}
    origin = Origin(columns["lat"], columns["lon"], columns["up_m"])
    return origin, columns["east_m"], columns["north_m"]
