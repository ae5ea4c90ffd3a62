"""When the trips of a training were driven, as far as their logs say."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from modelcast.trips.trajectory import Trajectory

__all__ = ["training_dates"]

_LAST_UNIX_S = 253_402_300_800.0
"""Begin of the year 10000 [s]."""


def training_dates(trips: Sequence[Trajectory]) -> dict[str, Any]:
    """Return the first and last date (UTC) of those trips whose log gives the absolute time.

    Parameters
    ----------
    trips
        The trips.

    Returns
    -------
    dict[str, Any]
        ``first`` and ``last`` as ``YYYY-MM-DD``, and ``trips``, how many have a date; empty where none has.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from modelcast.world.drive import generate_drive
    >>> trip = generate_drive(seed=1, duration_s=90.0).truth
    >>> training_dates([trip, replace(trip, start_unix_s=1_334_102_350.0)])
    {'first': '2012-04-10', 'last': '2012-04-11', 'trips': 1}
    """
    given = [(trip.start_unix_s, trip.duration_s) for trip in trips]
    known = [(start_s, start_s + took_s) for start_s, took_s in given if start_s is not None]
    known = [(begin_s, end_s) for begin_s, end_s in known if 0.0 <= begin_s <= end_s < _LAST_UNIX_S]
    if not known:
        return {}
    begins_s, ends_s = zip(*known, strict=True)
    first, last = (
        str(np.datetime64(int(time_s), "s").astype("datetime64[D]"))
        for time_s in (min(begins_s), max(ends_s))
    )
    return {"first": first, "last": last, "trips": len(known)}
