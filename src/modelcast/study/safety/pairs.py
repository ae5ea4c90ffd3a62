"""Who follows whom among trips that were recorded together.

A vehicle follows another where it comes to the places at which the other was some seconds ago. So no road, no
lane and no order of names is needed: at every instant, its place is held against those of the other up
to `LONGEST_HEADWAY_S` before and after, and the nearest of them tells whether it drives there, and behind.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.exceptions import ConfigError
from modelcast.runtime.trip.together import begins_after_s, placed
from modelcast.trips.trajectory import Trajectory

__all__ = [
    "LONGEST_HEADWAY_S",
    "FollowingPair",
    "Recording",
    "following_pairs",
    "instants_together",
    "recordings_of",
]

LONGEST_HEADWAY_S = 12.0
"""A vehicle farther behind follows nobody [s]."""

SAME_PATH_M = 4.0
"""A vehicle is on the path of another where it is no farther from the nearest place of that [m]."""

LEAST_TOGETHER_S = 10.0
"""Time that both must be recorded [s]."""

_FOLLOWING = 0.5
"""Share of the time together in which a follower is on the other's path, and behind."""

_HEADWAY_STEP_S = 0.25
_THINNED_S = 0.5
_MOVES_M = 5.0


@dataclass(frozen=True, slots=True, eq=False)
class FollowingPair:
    """A leader and who follows it.

    Parameters
    ----------
    leader, follower
        Their places among the trips.
    later_s
        How much later the follower's clock began than the leader's [s].
    headway_s
        Median time after which the follower drives where the leader drove [s].
    samples
        Samples of the leader at which the follower is recorded too, (N,).
    follower_at
        The follower's own samples before these instants, (N,), and the share of a step beyond, (N,).
    """

    leader: int
    follower: int
    later_s: float
    headway_s: float
    samples: IntArray
    follower_at: tuple[IntArray, FloatArray]

    def at_follower(self, columns: FloatArray) -> FloatArray:
        """Columns of the follower's samples at the pair's instants, interpolated linearly, (N, C).

        Parameters
        ----------
        columns
            (T, C); angles unwrapped.
        """
        at, share = self.follower_at
        after = np.minimum(at + 1, len(columns) - 1)
        return columns[at] + (columns[after] - columns[at]) * share[:, None]


@dataclass(frozen=True, slots=True)
class Recording:
    """Trips that were recorded together, and who follows whom among them.

    Parameters
    ----------
    name
        For tables: what the identifiers of the trips begin with, and the first leader.
    trips
        The trips.
    pairs
        Places are those among these trips.
    """

    name: str
    trips: Sequence[Trajectory]
    pairs: Sequence[FollowingPair]


def recordings_of(trips: Sequence[Trajectory]) -> list[Recording]:
    """Trips by what hangs together: a platoon each, with its pairs; trips of no pair are left out.

    Parameters
    ----------
    trips
        As for `following_pairs`.

    Raises
    ------
    ConfigError
        As for `following_pairs`.
    """
    pairs = following_pairs(trips)
    group = list(range(len(trips)))
    for pair in pairs:
        low, high = sorted((group[pair.leader], group[pair.follower]))
        group = [low if own == high else own for own in group]
    found: list[Recording] = []
    for own in dict.fromkeys(group[pair.leader] for pair in pairs):
        members = [place for place, of in enumerate(group) if of == own]
        place_in = {place: at for at, place in enumerate(members)}
        inside = [
            replace(pair, leader=place_in[pair.leader], follower=place_in[pair.follower])
            for pair in pairs
            if group[pair.leader] == own
        ]
        first = trips[members[inside[0].leader]].trip_id
        found.append(Recording(first, [trips[place] for place in members], inside))
    return found


def instants_together(
    leader: Trajectory, follower: Trajectory, later_s: float
) -> tuple[IntArray, tuple[IntArray, FloatArray]]:
    """Samples of one trip at which another has one, or two of one gapless part around it.

    Parameters
    ----------
    leader, follower
        The trips.
    later_s
        How much later the follower's clock began [s].
    """
    own_s = leader.t_s - later_s
    slack_s = 1e-3 * follower.dt_s
    at = np.searchsorted(follower.t_s, own_s + slack_s, side="right") - 1
    inside = (at >= 0) & (own_s <= follower.t_s[-1] + slack_s)
    at = np.clip(at, 0, len(follower) - 1)
    after = np.minimum(at + 1, len(follower) - 1)
    step_s = np.maximum(follower.t_s[after] - follower.t_s[at], 1e-9)
    share = np.clip((own_s - follower.t_s[at]) / step_s, 0.0, 1.0)
    exact = np.abs(own_s - follower.t_s[at]) <= slack_s
    share = np.where(exact, 0.0, share)
    part = np.searchsorted(follower.segments, np.stack([at, after]), side="right")
    whole: BoolArray = exact | ((part[0] == part[1]) & (after > at))
    samples = np.flatnonzero(inside & whole)
    return samples, (at[samples], share[samples])


def following_pairs(trips: Sequence[Trajectory]) -> list[FollowingPair]:
    """Each vehicle with the one that it follows, where there is one.

    Parameters
    ----------
    trips
        Recorded trips; those of one recording share a clock.

    Raises
    ------
    ConfigError
        Where no two trips were recorded together, or none follows another.
    """
    found: list[FollowingPair] = []
    together = 0
    for at, own in enumerate(trips):
        best: FollowingPair | None = None
        for other_at, other in enumerate(trips):
            if other_at == at:
                continue
            later_s = begins_after_s(other, own)
            if later_s is None or later_s > other.t_s[-1] or later_s + own.t_s[-1] < other.t_s[0]:
                continue
            samples, follower_at = instants_together(other, own, later_s)
            if samples.size * other.dt_s < LEAST_TOGETHER_S:
                continue
            together += 1
            headway_s = _headway(other, own, later_s)
            if headway_s is not None and (best is None or headway_s < best.headway_s):
                best = FollowingPair(other_at, at, later_s, headway_s, samples, follower_at)
        if best is not None:
            found.append(best)
    if not found:
        raise ConfigError(_why_none(trips, together))
    return found


def _why_none(trips: Sequence[Trajectory], together: int) -> str:
    if len(trips) < 2:
        return "one trip has nobody ahead: give files that hold several vehicles, as a platoon"
    alone = [trip.trip_id for trip in trips if trip.clock_s is None and trip.start_unix_s is None]
    if together == 0 and len(alone) > len(trips) - 2:
        return (
            f"{alone[0]} and {len(alone) - 1} more of the {len(trips)} trips state no common clock, as where "
            "the times of every vehicle begin at 0: write times of the recording, one clock for all vehicles"
        )
    if together == 0:
        return (
            f"no two of the {len(trips)} trips were recorded together for {LEAST_TOGETHER_S:g} s: give trips "
            "of one file that share a clock (openacc, or parquet with one t_s for all vehicles)"
        )
    return (
        f"trips were recorded together, but no vehicle follows another's path within "
        f"{LONGEST_HEADWAY_S:g} s and {SAME_PATH_M:g} m: this is no platoon"
    )


def _headway(leader: Trajectory, follower: Trajectory, later_s: float) -> float | None:
    """Median headway of a trip on another's path; None where it does not follow it [s]."""
    thin = max(1, round(_THINNED_S / follower.dt_s))
    own = placed(follower.position_m[::thin], follower, leader)
    own_s = follower.t_s[::thin] + later_s
    if np.hypot(*np.ptp(own, axis=0)) < _MOVES_M:
        return None
    headways_s = np.arange(-LONGEST_HEADWAY_S, LONGEST_HEADWAY_S + _HEADWAY_STEP_S / 2, _HEADWAY_STEP_S)
    then_s = own_s[None, :] - headways_s[:, None]
    inside = (then_s >= leader.t_s[0]) & (then_s <= leader.t_s[-1])
    east, north = (np.interp(then_s, leader.t_s, leader.position_m[:, axis]) for axis in (0, 1))
    apart = np.where(inside, np.hypot(east - own[:, 0], north - own[:, 1]), np.nan)
    known = inside.any(axis=0)
    if np.count_nonzero(known) * _THINNED_S < LEAST_TOGETHER_S / 2:
        return None
    apart = apart[:, known]
    nearest = np.nanargmin(apart, axis=0)
    headway_s = headways_s[nearest]
    on_path = (apart[nearest, np.arange(nearest.size)] <= SAME_PATH_M) & (headway_s > 0.0)
    if np.mean(on_path) < _FOLLOWING:
        return None
    return float(np.median(headway_s[on_path]))
