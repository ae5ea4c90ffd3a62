"""Trips in whatever form a user has them: paths, data frames, trips, and lists of these."""

from collections.abc import Callable, Iterable, Sequence
from functools import wraps
from itertools import chain
from typing import Any, Concatenate, ParamSpec, TypeAlias, TypeVar, cast

from modelcast.io.trips import Trips, TripSources, is_source, read_trips
from modelcast.study.case import SensedTrip
from modelcast.trips.trajectory import Trajectory

__all__ = ["GivenTrips", "given_trips", "recorded_trips", "takes_given_trips"]

GivenTrips: TypeAlias = TripSources | Trajectory | SensedTrip | Iterable[Any]
"""A path, a data frame, a trip, what `read_trips` gave, or several of them."""

P = ParamSpec("P")
T = TypeVar("T")


def given_trips(given: GivenTrips) -> Iterable[Trajectory | SensedTrip]:
    """Return trips to iterate over; what is a path or a frame is read as `read_trips` reads it.

    Parameters
    ----------
    given
        A path, a data frame, a trip, what `read_trips` gave, or several of them. Trips of an iterator are
        taken one at a time.

    Raises
    ------
    TypeError
        Where it is something else.

    Examples
    --------
    >>> from modelcast.world.drive import generate_drive
    >>> trip = generate_drive(0, 90.0).truth
    >>> [one.trip_id for one in given_trips(trip)] == [one.trip_id for one in given_trips([trip])]
    True
    """
    if isinstance(given, Trajectory | SensedTrip):
        return (given,)
    if isinstance(given, Trips):
        return given
    if is_source(given):
        return read_trips(given)
    if not isinstance(given, Iterable):
        raise TypeError(
            f"trips are paths, data frames, or what read_trips or build_trajectory gave, not "
            f"{type(given).__name__}"
        )
    several = cast("Iterable[Any]", given)
    if isinstance(several, Sequence) and all(map(is_source, several)):
        return read_trips(several)
    return chain.from_iterable(map(given_trips, several))


def takes_given_trips(
    function: Callable[Concatenate[Sequence[Trajectory], P], T],
) -> Callable[Concatenate[GivenTrips, P], T]:
    """Return a function of recorded trips that takes them in any form of `GivenTrips`.

    Parameters
    ----------
    function
        Takes a sequence of trips first.
    """

    @wraps(function)
    def taking(trips: GivenTrips, /, *args: P.args, **kwargs: P.kwargs) -> T:
        return function(recorded_trips(trips), *args, **kwargs)

    return taking


def recorded_trips(given: GivenTrips) -> list[Trajectory]:
    """Return recorded trips as a list.

    Parameters
    ----------
    given
        As for `given_trips`.

    Raises
    ------
    TypeError
        Where one is a `SensedTrip`, or as for `given_trips`.
    """
    found: list[Trajectory] = []
    for trip in given_trips(given):
        if isinstance(trip, SensedTrip):
            raise TypeError("a SensedTrip goes with evaluate alone: give its truth")
        found.append(trip)
    return found
