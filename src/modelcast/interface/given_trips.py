"""Trips in whatever form a user has them: paths, data frames, trips, and lists of these."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, TypeAlias, cast

import numpy as np

from modelcast.io.skipped import merge_skipped
from modelcast.io.trips import Trips, TripSources, is_source, read_trips
from modelcast.study.case import SensedTrip
from modelcast.trips.trajectory import Trajectory

__all__ = ["GivenTripList", "GivenTrips"]

GivenTrips: TypeAlias = TripSources | Trajectory | SensedTrip | Iterable[Any]
"""A path, a data frame, a trip, what `read_trips` gave, or several of them."""


class GivenTripList(Iterable[Trajectory | SensedTrip]):
    """Trips in the form a user gave, to iterate over; what is a path or a frame is read as `read_trips` does.

    Iterating raises TypeError where something is neither a trip nor what trips are read from.

    Parameters
    ----------
    given
        A path, a data frame, a trip, what `read_trips` gave, or several of them. Trips of an iterator are
        taken one at a time.

    Examples
    --------
    >>> from modelcast.world.drive import generate_drive
    >>> trip = generate_drive(0, 90.0).truth
    >>> [one.trip_id for one in GivenTripList(trip)] == [one.trip_id for one in GivenTripList([trip])]
    True
    """

    def __init__(self, given: GivenTrips) -> None:
        self._given = given
        self._sources: list[Trips] = []

    @property
    def skipped(self) -> dict[str, str]:
        """What gave no trip so far (a vehicle's identifier, a file in a folder), with the reason."""
        return merge_skipped(one.skipped for one in self._sources)

    def __iter__(self) -> Iterator[Trajectory | SensedTrip]:
        self._sources.clear()
        return self._trips_of(self._given)

    def recorded(self) -> list[Trajectory]:
        """Return all of them, which must be recorded trips.

        Raises
        ------
        TypeError
            Where one is a `SensedTrip`, or none of what a trip may be.
        """
        found: list[Trajectory] = []
        for trip in self:
            if isinstance(trip, SensedTrip):
                raise TypeError("a SensedTrip goes with evaluate alone: give its truth")
            found.append(trip)
        return found

    def _trips_of(self, given: GivenTrips) -> Iterator[Trajectory | SensedTrip]:
        """Yield the trips of one form, and remember what was read, to ask what it skipped."""
        if isinstance(given, Trajectory | SensedTrip):
            yield given
        elif isinstance(given, Trips):
            if not any(source is given for source in self._sources):
                self._sources.append(given)
            yield from given
        elif is_source(given) or (isinstance(given, Sequence) and all(map(is_source, given))):
            yield from self._trips_of(read_trips(given))
        elif isinstance(given, Iterable) and not isinstance(given, Mapping | np.ndarray):
            for one in cast("Iterable[Any]", given):
                yield from self._trips_of(one)
        else:
            raise TypeError(
                "trips are paths, data frames, or what read_trips or build_trajectory gave, not "
                f"{type(cast('object', given)).__name__}: "
                "give arrays to build_trajectory, or make a data frame of them"
            )
