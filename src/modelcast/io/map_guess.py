"""What the first rows of a table say about columns whose names say little: for examples of maps only.

A column names the vehicle where time increases within each of its values, and not in the table. A speed is in
the unit in which it fits the positions. Headings over a circle in radians are degrees.
"""

from collections.abc import Collection, Mapping, Sequence

import numpy as np
import polars as pl

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.io.column_meanings import GEODETIC, LOCAL, MEANINGS
from modelcast.io.heading_check import heading_meaning
from modelcast.io.rows import Rows, located
from modelcast.io.time_column import TimeColumn, over_midnight
from modelcast.io.unit_check import speed_unit

__all__ = ["guessed_heading", "guessed_speed", "guessed_vehicle", "placed_rows", "sampled_times"]

_CIRCLE_RAD = 2.0 * np.pi + 0.01
_FEWEST_TIMES = 2
_POLE_DEG = 90.0


def sampled_times(cells: Sequence[str], meaning: str, name: str) -> FloatArray | None:
    """Return times of the first rows [s], (R,), or None where one of them is none.

    Parameters
    ----------
    cells
        The column.
    meaning, name
        What it is taken for, and its name.
    """
    column = TimeColumn("", name, MEANINGS[meaning].factor, stated=meaning != "t")
    text = pl.Series([cell.replace(",", ".") for cell in cells], dtype=pl.String)
    try:
        t_s = over_midnight(column.read(text, np.arange(len(cells))), column.unit) * column.unit.unit_s
    except DataFormatError:
        return None
    return t_s if np.isfinite(t_s).all() else None


def guessed_vehicle(t_s: FloatArray, cells: Mapping[str, Sequence[str]], free: Collection[str]) -> str | None:
    """Return the column of fewest values within each of which time increases, None where time increases.

    Parameters
    ----------
    t_s
        Times of the rows, (R,) [s].
    cells
        The table's first rows, by column.
    free
        Columns that may name the vehicle.

    Examples
    --------
    >>> import numpy as np
    >>> cells = {"who": list("abab"), "colour": list("rrrr"), "v": list("1234")}
    >>> guessed_vehicle(np.array([0.0, 0.0, 1.0, 1.0]), cells, cells)
    'who'
    """
    if (np.diff(t_s) > 0).all():
        return None
    found: list[tuple[int, str]] = []
    for name in free:
        values, number = np.unique(np.array(cells[name]), return_inverse=True)
        order = np.argsort(number, kind="stable")
        within = np.diff(number[order]) == 0
        several = len(t_s) >= _FEWEST_TIMES * len(values)
        if several and (np.diff(t_s[order])[within] > 0).all():
            found.append((len(values), name))
    return min(found, key=lambda one: one[0])[1] if found else None


def placed_rows(
    t_s: FloatArray, columns: Mapping[str, FloatArray], vehicle: Sequence[str] | None
) -> Rows | None:
    """Return the first vehicle's rows on a plane, None where there is no position.

    Parameters
    ----------
    t_s
        Times of the rows, (R,) [s].
    columns
        Positions in metres or degrees, and others as they stand, by column, (R,) each.
    vehicle
        The vehicle of each row, where there are several.
    """
    rows = Rows(np.arange(t_s.size), {**columns, "t_s": t_s})
    if vehicle is not None:
        rows = rows.taken(np.array(vehicle) == vehicle[0])
    if columns.keys() >= {*LOCAL}:
        return rows
    if not columns.keys() >= {*GEODETIC}:
        return None
    place = rows.columns
    latitude, longitude = place[GEODETIC[0]], place[GEODETIC[1]]
    if not (np.abs(latitude) <= _POLE_DEG).all() or not np.isfinite(longitude).all():
        return None
    return located(rows, Origin(float(latitude[0]), float(longitude[0])))


def guessed_speed(rows: Rows) -> str | None:
    """Return the meaning of a speed column whose numbers are not in m/s, None where they may be.

    Parameters
    ----------
    rows
        Rows of one vehicle with ``speed_mps`` as if it were in m/s.
    """
    told = speed_unit(rows)
    return None if told is None else told[0]


def guessed_heading(values: FloatArray, rows: Rows | None = None) -> str:
    """Return the meaning of a column of headings, by how large they are and how the vehicle moves.

    Parameters
    ----------
    values
        The column, (R,).
    rows
        Rows of one vehicle with positions and ``angle``, what the column says there.

    Examples
    --------
    >>> import numpy as np
    >>> guessed_heading(np.array([0.0, 90.0])), guessed_heading(np.array([-1.0, 3.0]))
    ('heading_deg', 'heading_rad')
    """
    usual = "heading_deg" if (np.abs(values) > _CIRCLE_RAD).any() else "heading_rad"
    if rows is None:
        return usual
    position_m = np.stack([rows.columns["east_m"], rows.columns["north_m"]], axis=1)
    return heading_meaning(usual, rows.columns["angle"], position_m) or usual
