"""Which trips hold the most manoeuvres."""

from collections.abc import Iterable

import numpy as np

from modelcast.trips.inspection import STOP_SPEED_MPS, TripInspection
from modelcast.trips.manoeuvres.base import ManoeuvreCounts
from modelcast.trips.manoeuvres.bends import find_bends
from modelcast.trips.manoeuvres.lane_changes import find_lane_changes
from modelcast.trips.manoeuvres.motion import read_motion
from modelcast.trips.manoeuvres.stops import find_hard_brakes, find_stops
from modelcast.trips.recorder import parts
from modelcast.trips.trajectory import Trajectory

__all__ = ["count_manoeuvres", "rank_trips"]


def count_manoeuvres(trip: Trajectory, inspection: TripInspection | None = None) -> ManoeuvreCounts:
    """Lane changes, turns, U-turns, roundabouts, stops and hard brakes of a trip.

    Parameters
    ----------
    trip
        As the reader returned it; it is conditioned where its inspection says so.
    inspection
        Its inspection, where it is there already.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.trips.trajectory import build_trajectory
    >>> t = np.arange(0.0, 40.0, 0.1)
    >>> north = np.where(t < 20.0, 15.0 * t, 300.0)
    >>> found = count_manoeuvres(build_trajectory("made/1", t, np.stack([0.0 * t, north], axis=1)))
    >>> [(one.kind.value, round(one.size)) for one in found.manoeuvres]
    [('hard brake', 15), ('stop', 19)]
    """
    motion = read_motion(trip, inspection)
    bends = find_bends(motion)
    lanes = [one for one in find_lane_changes(motion) if not any(one.overlaps(bend) for bend in bends)]
    found = sorted(
        [*lanes, *bends, *find_stops(motion), *find_hard_brakes(motion)],
        key=lambda one: (one.start_s, one.end_s, one.kind),
    )
    path = motion.trip.position_m
    moving = motion.travelled_mps > STOP_SPEED_MPS
    distance = sum(
        float(np.hypot(*np.diff(path[part][moving[part]], axis=0).T).sum()) for part in parts(motion.trip)
    )
    return ManoeuvreCounts(trip.trip_id, trip.duration_s, distance_m=distance, manoeuvres=tuple(found))


def rank_trips(counts: Iterable[ManoeuvreCounts]) -> list[ManoeuvreCounts]:
    """Trips by `ManoeuvreCounts.merit`, the richest first, equal ones by name.

    Parameters
    ----------
    counts
        One a trip.
    """
    return sorted(counts, key=lambda one: (tuple(-value for value in one.merit), one.trip_id))
