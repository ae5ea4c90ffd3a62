"""OpenACC platoons: one file, several cars on one clock, 10 Hz; all campaigns that give positions.

Five metadata lines (``Date``, ``Vehicle_order``, ``Number_of_vehicles``, ``ACC``, ``Distance_setting``), a
header, then one row per 0.1 s. Car k is the k-th name of ``Vehicle_order``; that was checked on one car's
repeated positions, which follow its name through files with different orders. Some cars have no columns.

=================  ==========  ============================================================
Column             Unit        Use
=================  ==========  ============================================================
Time               s           time; not absolute
Speed<k>           m/s         speed; slightly negative at standstill in places, kept
E<k>, N<k>         m           east, north, shifted so that the file's first valid sample
                               is (0, 0)
Alt<k>, else U<k>  m           height above that sample, where every car has it
Lat<k>, Lon<k>     deg or rad  of the first valid sample: the frame's origin; positions
                               where a car has no E, N
Acc<k>             m/s²        acceleration (also A, Accel, Acceleration)
VE, VN, VU<k>      m/s         not used
IVS<k>             m           inter-vehicle spacing; not used
Driver<k>          -           ``Human`` or ``ACC``; not used
=================  ==========  ============================================================

Another column is an error. E, N are used rather than longitude and latitude: the two agree within 0.1 m over
550 m in every file seen. There is no heading or yaw rate.

The campaigns on Italian roads give latitude and longitude in radians, those at ZalaZONE in degrees. Each
car's are told apart by its motion in E, N, where it has moved over `_TOLD_M`; otherwise a latitude of over
pi/2 in one row is degrees. Degrees within 1.57 of the equator, without E, N, would be taken for radians.

Skipped and counted: rows without a position ("position missing") or time ("time missing"), a cut last line
("partial last line"). Repaired: single missing speeds, heights or accelerations (the last value is held). A
car named in ``Vehicle_order`` without columns, or with none but blank cells, is reported as skipped.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.io.base import AbstractTripReader, OnSkipped, Tally, ignore_skipped
from modelcast.io.openacc_layout import GEODETIC, LOCAL, Layout, openacc_layout
from modelcast.io.packed import recording_stem
from modelcast.io.reading_limits import HELD_BYTES, require_fitting
from modelcast.io.rows import Rows, joined, located, make_trip
from modelcast.io.text_blocks import number_column, read_blocks
from modelcast.io.text_head import first_lines, split_fields
from modelcast.trips.trajectory import Trajectory
from modelcast.trips.understood import Understood
from modelcast.world.scenario.recorded import Replay, make_replay

__all__ = ["OpenAccReader", "read_platoon"]

_TOLD_M = 20.0
"""Motion in E, N that tells degrees from radians [m]."""
_METRES_PER_RAD = 6.37e6


@dataclass(frozen=True, slots=True)
class _Frame:
    """Where the file's plane begins, and what that point is in the file's own E, N and height [m]."""

    origin: Origin | None
    east_m: float
    north_m: float
    up_m: float


class OpenAccReader(AbstractTripReader):
    """Reads OpenACC ZalaZONE files; the module's docstring has the columns and the repairs."""

    name: ClassVar[str] = "openacc"
    streams: ClassVar[bool] = True

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether the metadata lines of the format are there."""
        del path
        return any(split_fields(line)[0] == "Vehicle_order" for line in first_lines(head)[:5])

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per car, ``<stem>/<name in Vehicle_order>``; the file is held whole."""
        for trip in _trips_on_one_clock(path, on_skipped):
            yield replace(trip, start_unix_s=None, clock_s=trip.start_unix_s)


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
    layout = openacc_layout(path)
    stem = recording_stem(path)
    cars, partial, understood = _cars(path, layout)
    frame = _frame(cars, absolute=layout.height == "altitude_m")
    for number, name in enumerate(layout.names, start=1):
        if number not in cars:
            lacks = "position columns" if number in layout.unplaced else "columns"
            on_skipped(f"{stem}/{name}", f"named in Vehicle_order but without {lacks}")
            continue
        rows, tally = cars[number], Tally()
        tally.understand(understood)
        tally.skip("partial last line", int(partial))
        count = len(rows) + int(partial)
        rows = rows.without(np.isnan(rows.columns["t_s"]), "time missing", tally)
        rows = rows.without(_unplaced(rows), "position missing", tally)
        trip = make_trip(
            path,
            f"{stem}/{name}",
            _framed(rows, frame),
            tally,
            count=count,
            source=OpenAccReader.name,
            origin=frame.origin,
            unix_offset_s=0.0,
        )
        if trip is None:
            on_skipped(f"{stem}/{name}", tally.why_empty())
        else:
            yield trip


def _cars(path: str, layout: Layout) -> tuple[dict[int, Rows], bool, Understood]:
    """Return every car's rows, angles in degrees, whether the last line is cut, and what was understood."""
    parts: dict[int, list[Rows]] = {number: [] for number in layout.cars}
    time = layout.header.index("Time")
    wanted = [time, *(place for fields in layout.cars.values() for place in fields.values())]
    partial = False
    rows = 0
    for block in read_blocks(path, counts=[len(layout.header)], fields=wanted, skip_lines=layout.line):
        partial = partial or block.partial > 0
        rows += len(block.line)
        require_fitting(
            path, recording_stem(path), rows, row_bytes=16 * len(wanted), held_bytes=2 * HELD_BYTES
        )
        t_s = number_column(path, block, time, "Time")
        for number, pieces in parts.items():
            columns = {"t_s": t_s}
            for fills, place in layout.cars[number].items():
                columns[fills] = number_column(path, block, place, layout.header[place])
            pieces.append(Rows(block.line, columns))
    if not any(len(piece) for pieces in parts.values() for piece in pieces):
        raise DataFormatError(
            path, "no rows after the header", row=layout.line, remedy="Check that it is complete."
        )
    raw = {number: _with_height(joined(pieces), layout.height) for number, pieces in parts.items()}
    cars = {number: _in_degrees(path, rows, geodetic=layout.geodetic) for number, rows in raw.items()}
    return cars, partial, _understood(raw, geodetic=layout.geodetic)


def _understood(raw: dict[int, Rows], *, geodetic: bool) -> Understood:
    """Return which of the two positions is used, and the unit of angles that their numbers tell."""
    placed = [rows.columns for rows in raw.values() if set(GEODETIC) <= rows.columns.keys()]
    radians = any(_are_radians(dict(columns)) for columns in placed)
    angles = f"Lat and Lon in {'radians' if radians else 'degrees'}, told by their size or motion"
    plane = "" if geodetic else "E and N in metres"
    return Understood(notes={"position": "; ".join(filter(None, (plane, angles if placed else "")))})


def _with_height(rows: Rows, name: str | None) -> Rows:
    """Return the rows with the one height that is used as ``up_m``."""
    columns = {key: column for key, column in rows.columns.items() if key not in {"altitude_m", "local_up_m"}}
    return Rows(rows.line, columns if name is None else {**columns, "up_m": rows.columns[name]})


def _in_degrees(path: str, rows: Rows, *, geodetic: bool) -> Rows:
    """Return the rows with angles in degrees, checked, and without E, N where they are not to be used."""
    columns = dict(rows.columns)
    if set(GEODETIC) <= columns.keys():
        factor = np.degrees(1.0) if _are_radians(columns) else 1.0
        for name, bound in zip(GEODETIC, (90.0, 180.0), strict=True):
            degrees = columns[name] * factor
            bad = np.abs(degrees) > bound
            if bad.any():
                at = int(np.argmax(bad))
                raise DataFormatError(
                    path, f"{name} is {columns[name][at]}, beyond {bound:.0f} degrees",
                    row=int(rows.line[at]), remedy="Correct the value or leave the cell blank.",
                )  # fmt: skip
            columns[name] = degrees
    if geodetic:
        columns = {name: column for name, column in columns.items() if name not in LOCAL}
    return Rows(rows.line, columns)


def _are_radians(columns: dict[str, FloatArray]) -> bool:
    """Return whether latitudes and longitudes are radians, by the motion in E, N or by their size."""
    lat, lon = columns["lat"], columns["lon"]
    if set(LOCAL) <= columns.keys():
        known = np.isfinite(lat + lon + columns["east_m"] + columns["north_m"])
        moved_m = _range(columns["north_m"][known])
        if moved_m > _TOLD_M and _range(lat[known]) > 0.0:
            scale = moved_m / _range(lat[known])
            return bool(scale > _METRES_PER_RAD * np.sqrt(np.radians(1.0)))
    known = np.isfinite(lat)
    return bool(known.any()) and bool(np.abs(lat[known]).max() <= np.pi / 2)


def _range(values: FloatArray) -> float:
    return float(values.max() - values.min()) if values.size else 0.0


def _unplaced(rows: Rows) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    names = LOCAL if set(LOCAL) <= rows.columns.keys() else GEODETIC
    return np.isnan(rows.columns[names[0]]) | np.isnan(rows.columns[names[1]])


def _framed(rows: Rows, frame: _Frame) -> Rows:
    """Return the rows on the file's plane."""
    columns = {name: column for name, column in rows.columns.items() if name not in GEODETIC}
    if "up_m" in columns:
        columns["up_m"] = columns["up_m"] - frame.up_m
    if set(LOCAL) <= columns.keys():
        columns |= {"east_m": columns["east_m"] - frame.east_m, "north_m": columns["north_m"] - frame.north_m}
        return Rows(rows.line, columns)
    if frame.origin is None:
        return rows
    angles = {"latitude_deg": rows.columns["lat"], "longitude_deg": rows.columns["lon"]}
    return located(Rows(rows.line, columns | angles), replace(frame.origin, altitude_m=0.0))


def _frame(cars: dict[int, Rows], *, absolute: bool) -> _Frame:
    """Return the file's frame, at the earliest row with a full position, of the first car that has one."""
    best = _first_row(cars, (*GEODETIC, "up_m")) or _first_row(cars, GEODETIC)
    if best is None:
        return _Frame(None, 0.0, 0.0, 0.0)
    first = {name: float(column[best[0]]) for name, column in cars[best[1]].columns.items()}
    up_m = first.get("up_m", 0.0)
    up_m = up_m if np.isfinite(up_m) else 0.0
    origin = Origin(first["lat"], first["lon"], up_m if absolute else 0.0) if "lat" in first else None
    return _Frame(origin, first.get("east_m", 0.0), first.get("north_m", 0.0), up_m)


def _first_row(cars: dict[int, Rows], complete: tuple[str, ...]) -> tuple[int, int] | None:
    """Return the earliest row that has a position and these columns, and its car."""
    best: tuple[int, int] | None = None
    for number, rows in cars.items():
        full = ~_unplaced(rows)
        for name in complete:
            full &= np.isfinite(rows.columns.get(name, np.zeros(len(rows))))
        if full.any() and (best is None or int(np.argmax(full)) < best[0]):
            best = (int(np.argmax(full)), number)
    return best
