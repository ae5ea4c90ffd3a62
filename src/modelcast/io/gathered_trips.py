"""Trips out of gathered rows: what the readers share whose formats name a vehicle in every row.

A reader gathers the rows of a vehicle (`modelcast.io.gathering`), says which are usable and what they mean in
SI units, and hands both over here. Rows are then put in order, placed and made a trip, or reported.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import KW_ONLY, dataclass
from typing import TypeAlias

import numpy as np

from modelcast.core.geodesy import Origin
from modelcast.io.base import OnSkipped, Tally
from modelcast.io.packed import recording_stem
from modelcast.io.rows import Rows, located, make_trip, ordered
from modelcast.io.spmd import valid_position
from modelcast.trips.trajectory import Trajectory

__all__ = ["TripRows", "UsableRows", "first_origin", "placed_on_earth", "trips_of"]


@dataclass(frozen=True, slots=True)
class TripRows:
    """The rows of one trip as its file has them.

    Parameters
    ----------
    name
        The vehicle part of its identifier.
    rows
        Its rows in the order of the file.
    partial
        Whether a last row cut short counts with it.
    """

    name: str
    rows: Rows
    partial: bool = False


@dataclass(frozen=True, slots=True)
class UsableRows:
    """The usable rows of one trip, in SI units.

    Parameters
    ----------
    rows
        With ``t_s`` and a position, in any order.
    origin
        Where the plane of ``latitude_deg`` and ``longitude_deg`` touches; None for local positions.
    unix_offset_s, clock_offset_s
        As for `modelcast.io.rows.make_trip`.
    """

    rows: Rows
    _: KW_ONLY
    origin: Origin | None = None
    unix_offset_s: float | None = None
    clock_offset_s: float | None = None


Usable: TypeAlias = Callable[[Rows, Tally], UsableRows]
"""Takes out the unusable rows of a trip, counting them, and returns the others in SI units."""


def trips_of(
    path: str, source: str, found: Iterable[TripRows], usable: Usable, on_skipped: OnSkipped
) -> Iterator[Trajectory]:
    """Yield trips, each as soon as its rows are there.

    Parameters
    ----------
    path, on_skipped
        As for readers.
    source
        Name of the format.
    found
        The rows of each.
    usable
        What becomes of them.
    """
    for one in found:
        tally = Tally()
        tally.skip("partial last line", int(one.partial))
        trip_id = f"{recording_stem(path)}/{one.name}"
        left = usable(one.rows, tally)
        rows = left.rows
        trip = None
        if len(rows):
            rows = ordered(rows, tally)
            trip = make_trip(
                path, trip_id, rows if left.origin is None else located(rows, left.origin), tally,
                count=len(one.rows) + int(one.partial), source=source, origin=left.origin,
                unix_offset_s=left.unix_offset_s, clock_offset_s=left.clock_offset_s,
            )  # fmt: skip
        if trip is None:
            on_skipped(trip_id, tally.why_empty())
        else:
            yield trip


def placed_on_earth(rows: Rows, tally: Tally) -> Rows:
    """Return the rows whose latitude and longitude are a position, the others counted.

    Parameters
    ----------
    rows
        With ``latitude_deg`` and ``longitude_deg``.
    tally
        Gets what is left out.
    """
    placed = valid_position(rows.columns["latitude_deg"], rows.columns["longitude_deg"])
    return rows.without(~placed, "position unavailable", tally)


def first_origin(rows: Rows) -> Origin | None:
    """Return the first position of rows, at height 0 where it has none; None where there is no position.

    Parameters
    ----------
    rows
        With ``latitude_deg``, ``longitude_deg`` and ``altitude_m``, in the order of the file.
    """
    columns = rows.columns
    placed = valid_position(columns["latitude_deg"], columns["longitude_deg"])
    if not placed.any():
        return None
    at = int(np.argmax(placed))
    altitude_m = float(columns["altitude_m"][at])
    return Origin(
        float(columns["latitude_deg"][at]),
        float(columns["longitude_deg"][at]),
        altitude_m if np.isfinite(altitude_m) else 0.0,
    )
