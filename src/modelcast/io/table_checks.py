"""One vehicle's rows of a table held against what its columns were taken for.

A unit that is only assumed, or stated and wrong, gives numbers like any other. What can tell is how the
columns fit one another: each check names the column, what is odd, and the column map that mends it. What a
vehicle may do on good grounds, most vehicles have to do (`modelcast.io.unit_votes`); and what the user's map
says with its unit is not doubted.
"""

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.io.angle_check import refuse_degrees, refuse_degrees_as_metres, refuse_radians, refuse_swapped
from modelcast.io.column_map import ColumnMap
from modelcast.io.column_meanings import GEODETIC, LOCAL, MEANINGS
from modelcast.io.header_names import stated_unit
from modelcast.io.heading_check import heading_si, refuse_other_heading
from modelcast.io.motion_check import refuse_other_motion
from modelcast.io.rows import Rows
from modelcast.io.time_column import TimeUnit
from modelcast.io.unit_check import (
    refuse_feet,
    refuse_long_steps,
    refuse_other_speed,
    refuse_other_unit,
    refuse_short_steps,
)
from modelcast.io.unit_votes import UnitVotes

__all__ = ["check_units", "checked_heading"]


def checked_heading(path: str, rows: Rows, found: ColumnMap, votes: UnitVotes) -> Rows:
    """Return rows with headings in [-pi, pi), once their unit and sense were held against the way.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``east_m``, ``north_m`` and ``heading_rad``, not wrapped yet.
    found
        What its columns were taken for.
    votes
        Where it is counted whether headings are in another unit, or counted from elsewhere.

    Raises
    ------
    DataFormatError
        Where headings in radians are too large.
    """
    name, factor = found.numbers["heading_rad"]
    if factor == 1.0:
        refuse_degrees(path, rows, name)
    heading_rad = rows.columns["heading_rad"]
    meaning = next(word for word in found.meanings if MEANINGS[word].fills == "heading_rad")
    stated = (heading_rad - heading_si(np.zeros(1), factor)) / factor
    if meaning not in found.words:
        votes.ask("heading", lambda: refuse_other_heading(path, rows, stated, meaning, name))
    return rows.having(heading_rad=_wrapped(heading_rad))


def _wrapped(heading_rad: FloatArray) -> FloatArray:
    """Return headings in [-pi, pi), those already there to the bit."""
    inside = (heading_rad >= -np.pi) & (heading_rad < np.pi)
    return np.where(inside, heading_rad, wrap_angle_rad(heading_rad))


def check_units(path: str, rows: Rows, time: TimeUnit, found: ColumnMap, votes: UnitVotes) -> None:
    """Refuse times, positions and speeds in other units than names state or let be assumed.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``t_s`` in seconds, ``east_m`` and ``north_m``.
    time
        What its times were taken for.
    found
        What its columns were taken for.
    votes
        Where it is counted whether positions are degrees, feet or swapped.

    Raises
    ------
    DataFormatError
        Where other columns do not fit one another, or no recording is like that.
    """
    if time.assumed:
        refuse_long_steps(path, rows, time.assumed)
        refuse_short_steps(path, rows, time.assumed)
    x, y = (found.numbers[name][0] for name in (GEODETIC if found.geodetic else LOCAL))
    if not found.geodetic and stated_unit(x) != "m" and found.words.isdisjoint(LOCAL):
        votes.ask("degrees", lambda: refuse_degrees_as_metres(path, rows, (x, y)))
        if found.numbers[LOCAL[0]][1] == 1.0:
            votes.ask("feet", lambda: refuse_feet(path, rows, (x, y)))
    refuse_other_unit(path, rows, time.assumed)
    if found.geodetic and found.words.isdisjoint(GEODETIC):
        votes.ask("order", lambda: refuse_swapped(path, rows, (x, y)))
    if found.speed_assumed:
        refuse_other_speed(path, rows, found.speed_assumed)
    if found.geodetic and not found.degrees_stated:
        refuse_radians(path, rows, (x, y))
    for meaning, name in found.meanings.items():
        if MEANINGS[meaning].fills in {"yaw_rate_radps", "acceleration_mps2"} & rows.columns.keys():
            refuse_other_motion(path, rows, meaning, name)
