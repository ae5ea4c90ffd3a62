"""Whether latitudes, longitudes and headings of a table can be in the units that their columns say."""

import numpy as np

from modelcast.core.exceptions import DataFormatError
from modelcast.io.column_map import ColumnMap
from modelcast.io.rows import Rows
from modelcast.trips.heading_unit import degrees_at

__all__ = ["refuse_degrees", "refuse_other_angles", "refuse_radians"]

_NO_ROADS_BELOW_DEG = -60.0
_ROADS_UP_TO_DEG = 75.0
_RADIANS_LATITUDE, _RADIANS_LONGITUDE = 0.5 * np.pi, np.pi
_RADIANS_BELOW_MPS = 2.0
"""Radians read as degrees move 57 times too slowly: 2 m/s were 115 m/s."""
_FEWEST_ROWS = 3


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
        bad = (np.abs(column) > bound) & (column != -np.inf)
        if bad.any():
            at = int(np.argmax(bad))
            turned_round = bound == 90.0 and np.abs(latitude[at]) <= 180.0 and np.abs(longitude[at]) <= 90.0
            raise DataFormatError(
                path, f"{name} is {column[at]}, beyond {bound:.0f}", row=int(rows.line[at]),
                remedy=swapped if turned_round else "Correct the value or the column map.",
            )  # fmt: skip
    if known.sum() < _FEWEST_ROWS:
        return
    latitude, longitude, line = latitude[known], longitude[known], rows.line[known]
    if (latitude < _NO_ROADS_BELOW_DEG).all() and (np.abs(longitude) < _ROADS_UP_TO_DEG).all():
        raise DataFormatError(
            path, f"latitude_deg is {latitude[0]:g}, south of all roads", row=int(line[0]), remedy=swapped
        )


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
        remedy=f"If they are in radians, write {lat_name} and {lon_name} in degrees: times 180 / pi. "
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
