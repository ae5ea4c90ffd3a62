"""Whether latitudes, longitudes and headings of a table can be in the units that their columns say."""

import numpy as np

from modelcast.core.exceptions import DataFormatError
from modelcast.io.column_map import ColumnMap
from modelcast.io.rows import Rows
from modelcast.trips.trajectory import MAX_HEADING_RAD

__all__ = ["refuse_other_angles"]

_NO_ROADS_BELOW_DEG = -60.0
_ROADS_UP_TO_DEG = 75.0
_RADIANS_LATITUDE, _RADIANS_LONGITUDE = 0.5 * np.pi, np.pi
_FEWEST_ROWS = 3


def refuse_other_angles(path: str, rows: Rows, found: ColumnMap) -> None:
    """Refuse degrees that are none.

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
        Where a latitude or longitude is beyond its range, lies where no road is while the other way round
        it would lie where roads are, or is in radians; where a heading in radians is one in degrees.

    Notes
    -----
    Within 1.6 degrees of the equator and 3.2 of Greenwich all is sea; any place on Earth is there in radians.
    """
    heading = rows.columns.get("heading_rad", np.zeros(0))
    if found.numbers.get("heading_rad", ("", 0.0))[1] == 1.0:
        turned = np.isfinite(heading) & (np.abs(heading) > MAX_HEADING_RAD)
        if turned.any():
            at = int(np.argmax(turned))
            name = found.numbers["heading_rad"][0]
            raise DataFormatError(
                path, f"{name} is {heading[at]:g}, too large for radians", row=int(rows.line[at]),
                remedy=f"If it is in degrees: --columns with heading_deg={name}.",
            )  # fmt: skip
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
    in_radians = (np.abs(latitude) <= _RADIANS_LATITUDE) & (np.abs(longitude) <= _RADIANS_LONGITUDE)
    if in_radians.all() and latitude.any() and longitude.any():
        raise DataFormatError(
            path,
            f"latitude_deg {latitude[0]:g} and longitude_deg {longitude[0]:g} are a place at sea",
            row=int(line[0]),
            remedy=f"If they are in radians, write {lat_name} and {lon_name} in degrees: times 180 / pi.",
        )
