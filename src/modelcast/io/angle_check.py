"""Whether positions and headings of a table can be the angles, or the metres, that their columns say."""

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.io.column_map import ColumnMap
from modelcast.io.rows import Rows
from modelcast.io.unit_check import LEAST_WAY_M, steps_m
from modelcast.trips.heading_unit import degrees_at

__all__ = [
    "refuse_degrees",
    "refuse_degrees_as_metres",
    "refuse_other_angles",
    "refuse_radians",
    "refuse_swapped",
]

_NO_ROADS_BELOW_DEG = -60.0
_ROADS_UP_TO_DEG = 75.0
_RADIANS_LATITUDE, _RADIANS_LONGITUDE = 0.5 * np.pi, np.pi
_RADIANS_BELOW_MPS = 2.0
"""Radians read as degrees move 57 times too slowly: 2 m/s were 115 m/s."""
_FEWEST_ROWS = 3
_LATITUDE_DEG, _LONGITUDE_DEG = 90.0, 180.0
_MINUTES = 60.0
_M_PER_DEG = 111_195.0
"""A degree of latitude on a sphere of the Earth's mean radius, 6,371 km."""
_FITS_RATIO = 0.02
"""Positions and speeds of good recordings agree to 1 % over a trip."""
_FITS_NOT_RATIO = 0.08
_PIECES = 10
"""Pieces of a drive whose ratios of positions to speeds are looked at."""
_FITS_EVENLY = 0.1
"""In the true order every piece fits this well."""
_UNEVEN = 3.0
"""In the wrong order ratios of pieces, which change with the course, differ this many times as much."""
_STEADY_MPS = (0.5, 70.0)
_STANDS_MPS = 0.1
_FEWEST_STEPS = 20


def refuse_other_angles(path: str, rows: Rows, found: ColumnMap) -> None:
    """Refuse latitudes and longitudes that are none.

    Parameters
    ----------
    path
        The file.
    rows
        Its rows, in the units that the names state; of positions, infinite ones are not known.
    found
        Which columns they are from.

    Raises
    ------
    DataFormatError
        Where a latitude or longitude is beyond its range, or lies where no road is while the other way round
        it would lie where roads are.
    """
    if "latitude_deg" not in rows.columns:
        return
    latitude, longitude = rows.columns["latitude_deg"], rows.columns["longitude_deg"]
    known = np.isfinite(latitude) & np.isfinite(longitude)
    lat_name, lon_name = found.numbers["latitude_deg"][0], found.numbers["longitude_deg"][0]
    swapped = f"Are latitude and longitude swapped? --columns with lat={lon_name},lon={lat_name}."
    for name, column, bound in (("latitude_deg", latitude, 90.0), ("longitude_deg", longitude, 360.0)):
        bad = (np.abs(column) > bound) & np.isfinite(column)
        if bad.any():
            at = int(np.argmax(bad))
            turned_round = bound == 90.0 and np.abs(latitude[at]) <= 180.0 and np.abs(longitude[at]) <= 90.0
            other = _other_unit(latitude[known], longitude[known], (lat_name, lon_name))
            raise DataFormatError(
                path, f"{name} is {column[at]}, beyond {bound:.0f}", row=int(rows.line[at]),
                remedy=swapped if turned_round else other or "Correct the value or the column map.",
            )  # fmt: skip
    if known.sum() < _FEWEST_ROWS:
        return
    latitude, longitude, line = latitude[known], longitude[known], rows.line[known]
    if (latitude < _NO_ROADS_BELOW_DEG).all() and (np.abs(longitude) < _ROADS_UP_TO_DEG).all():
        raise DataFormatError(
            path, f"latitude_deg is {latitude[0]:g}, south of all roads", row=int(line[0]), remedy=swapped
        )


def _other_unit(latitude: FloatArray, longitude: FloatArray, names: tuple[str, str]) -> str:
    """Return what to do where all of a table's angles would be some in another unit, else nothing."""
    lat_name, lon_name = names
    e7 = 1e-7 * np.abs(latitude) <= _LATITUDE_DEG, 1e-7 * np.abs(longitude) <= _LONGITUDE_DEG
    if np.all(e7) and (np.abs(latitude) > 1e4 * _LATITUDE_DEG).any():
        return f"If they count 1e-7 degrees: --columns lat_e7={lat_name},lon_e7={lon_name}."
    bounds = (latitude, _LATITUDE_DEG), (longitude, _LONGITUDE_DEG)
    if all(
        (np.abs(one) <= 100 * most).all() and (np.abs(one) % 100 < _MINUTES).all() for one, most in bounds
    ):
        return (
            f"If they are degrees and minutes as NMEA writes them (4807.04 is 48° 7.04'), write degrees: "
            f"int({lat_name} / 100) + ({lat_name} mod 100) / 60, the same of {lon_name}, negative where they "
            "are south or west. A log of NMEA sentences is read as it is."
        )
    return ""


def refuse_swapped(path: str, rows: Rows, names: tuple[str, str]) -> bool:
    """Return whether speeds fit latitude and longitude as they are.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``t_s``, ``latitude_deg``, ``longitude_deg``, ``east_m`` and ``north_m`` of
        them; without ``speed_mps`` nothing is told.
    names
        Columns of latitude and longitude.

    Raises
    ------
    DataFormatError
        Where they fit them the other way round.

    Notes
    -----
    A degree of longitude is as short as the cosine of the latitude says, so that positions which were turned
    round move at other speeds: by another factor on another course. A speedometer that shows too much does so
    on every course, and noise fits nowhere; so every piece of the drive has to fit, and a straight one does
    not tell.
    """
    moved_m, said_m = steps_m(rows)
    latitude, longitude = rows.columns["latitude_deg"], rows.columns["longitude_deg"]
    if moved_m.size < _FEWEST_STEPS or not moved_m.sum() > LEAST_WAY_M:
        return False
    off = abs(said_m.sum() / moved_m.sum() - 1.0)
    if off <= _FITS_NOT_RATIO or np.abs(longitude[0]) > _LATITUDE_DEG:
        return bool(off <= _FITS_RATIO)
    scale = np.cos(np.radians(longitude[0]))
    turned = rows.having(
        east_m=_M_PER_DEG * (latitude - latitude[0]) * scale, north_m=_M_PER_DEG * (longitude - longitude[0])
    )
    other_m, _ = steps_m(turned)
    if abs(said_m.sum() / max(other_m.sum(), 1.0) - 1.0) >= _FITS_RATIO:
        return False
    stated, swapped = (_in_pieces(said_m, way_m) for way_m in (moved_m, other_m))
    uneven = stated.std() >= max(_UNEVEN * swapped.std(), _FITS_RATIO)
    if uneven and np.abs(swapped - 1.0).max() <= _FITS_EVENLY:
        lat_name, lon_name = names
        raise DataFormatError(
            path,
            f"the speeds fit {lat_name} and {lon_name} only if they are the other way round",
            row=int(rows.line[0]),
            remedy=f"Are latitude and longitude swapped? --columns with lat={lon_name},lon={lat_name}. "
            f"Where they are not: --columns latitude_deg={lat_name},longitude_deg={lon_name}.",
        )
    return False


def _in_pieces(said_m: FloatArray, way_m: FloatArray) -> FloatArray:
    """Return what speeds say over what positions move, piece by piece, (`_PIECES`,)."""
    begins = np.arange(_PIECES) * said_m.size // _PIECES
    said_m, way_m = (np.add.reduceat(steps, begins) for steps in (said_m, way_m))
    return said_m / np.maximum(way_m, np.finfo(np.float64).tiny)


def refuse_degrees_as_metres(path: str, rows: Rows, names: tuple[str, str]) -> bool:
    """Return whether positions move too far to be longitudes and latitudes.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``t_s``, ``east_m`` and ``north_m``, and ``speed_mps`` where it is known.
    names
        Columns of east and north.

    Raises
    ------
    DataFormatError
        Where positions in metres are longitudes and latitudes.

    Notes
    -----
    Programs for maps write the longitude as ``X``. What moves steadily less than a metre in all, and as
    degrees at the speed of a vehicle, is no vehicle that stands: noise has no steady speed of that size. The
    drift of an inertial platform has: where speeds say that it stands, it does.
    """
    columns, (x, y) = rows.columns, names
    steps_s, east_m, north_m = np.diff(columns["t_s"]), columns["east_m"], columns["north_m"]
    if len(steps_s) < _FEWEST_STEPS or not (steps_s > 0).all():
        return False
    if np.abs(east_m).max() > _LONGITUDE_DEG or np.abs(north_m).max() > _LATITUDE_DEG:
        return True
    scale = np.cos(np.radians(np.mean(north_m)))
    way_m = _M_PER_DEG * np.hypot(np.diff(east_m) * scale, np.diff(north_m))
    direct_m = _M_PER_DEG * np.hypot((east_m[-1] - east_m[0]) * scale, north_m[-1] - north_m[0])
    moves_mps = way_m.sum() / steps_s.sum()
    slow, fast = _STEADY_MPS
    if moves_mps > fast:
        return True
    if np.ptp(east_m) > 1.0 or np.ptp(north_m) > 1.0 or _stands(rows):
        return False
    if moves_mps >= slow and direct_m > max(LEAST_WAY_M, 0.1 * way_m.sum()):
        raise DataFormatError(
            path,
            f"{x} and {y} hardly move as metres, and like a vehicle as degrees",
            row=int(rows.line[0]),
            remedy=f"Longitude and latitude: --columns lon={x},lat={y}. "
            f"Where they are metres: --columns east_m={x},north_m={y}.",
        )
    return False


def _stands(rows: Rows) -> bool:
    """Return whether speeds say that a vehicle stands most of the time."""
    speed_mps = rows.columns.get("speed_mps", np.zeros(0))
    known = speed_mps[np.isfinite(speed_mps)]
    return bool(known.size and np.median(known) < _STANDS_MPS)


def refuse_degrees(path: str, rows: Rows, heading: str) -> None:
    """Raise `DataFormatError` where headings in radians are degrees.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``heading_rad``, not wrapped yet, ``east_m`` and ``north_m``.
    heading
        Name of the column that is said to hold radians.
    """
    headings = rows.columns["heading_rad"]
    at = degrees_at(headings, np.stack([rows.columns["east_m"], rows.columns["north_m"]], axis=1))
    if at is not None:
        raise DataFormatError(
            path, f"{heading} is {headings[at]:g}, too large for radians", row=int(rows.line[at]),
            remedy=f"If it is in degrees: --columns with heading_deg={heading}.",
        )  # fmt: skip


def refuse_radians(path: str, rows: Rows, names: tuple[str, str]) -> None:
    """Raise `DataFormatError` where latitudes and longitudes may as well be radians as degrees.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``t_s``, ``latitude_deg``, ``longitude_deg``, and ``east_m`` and ``north_m``
        of them as degrees.
    names
        Columns of latitude and longitude.

    Notes
    -----
    Within 1.6 degrees of the equator and 3.2 of Greenwich all is sea; any place on Earth is there in radians.
    But simulators lay their plane there. What moves as degrees faster than `_RADIANS_BELOW_MPS` would in
    radians be faster than any car, so these are degrees.
    """
    latitude, longitude = rows.columns["latitude_deg"], rows.columns["longitude_deg"]
    small = (np.abs(latitude) <= _RADIANS_LATITUDE) & (np.abs(longitude) <= _RADIANS_LONGITUDE)
    if len(rows) < _FEWEST_ROWS or not (small.all() and latitude.any() and longitude.any()):
        return
    if _usual_speed_mps(rows) > _RADIANS_BELOW_MPS:
        return
    lat_name, lon_name = names
    raise DataFormatError(
        path,
        f"{lat_name} {latitude[0]:g} and {lon_name} {longitude[0]:g} are a place at sea",
        row=int(rows.line[0]),
        remedy=f"If they are in radians: --columns lat_rad={lat_name},lon_rad={lon_name}. "
        f"If they are in degrees: --columns latitude_deg={lat_name}.",
    )


def _usual_speed_mps(rows: Rows) -> float:
    """Return the speed that a quarter of the moves between different positions exceed [m/s]."""
    columns = rows.columns
    moved = np.concatenate([[True], (np.diff(columns["east_m"]) != 0) | (np.diff(columns["north_m"]) != 0)])
    t_s, east_m, north_m = (columns[name][moved] for name in ("t_s", "east_m", "north_m"))
    later = np.diff(t_s) > 0
    speeds_mps = np.hypot(np.diff(east_m), np.diff(north_m))[later] / np.diff(t_s)[later]
    return float(np.quantile(speeds_mps, 0.75)) if speeds_mps.size else 0.0
