"""Whose sentences are whose: the fixes of an NMEA log shared out over the receivers that sent them.

One receiver may use several talkers: GGA from one and RMC from another, every epoch twice, or GP until
GLONASS joins and GN from then on. Several receivers may write into one log. They are told apart by what is
sent at the same time: the same position (within `_SAME_M`, or within `_OTHER_KIND_M` of a GGA and an RMC,
whose digits may differ) is one receiver, another position is another one. Talkers that never meet are one
receiver too, unless they take turns or the track would jump between them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, hypot, isfinite, radians
from statistics import median

from modelcast.io.nmea_sentences import Fix

__all__ = ["Heard", "apart_m", "receivers"]

_SAME_M = 0.5
_OTHER_KIND_M = 20.0
_NEAR_SENTENCES = 200
"""Sentences of one instant are not further apart in a log; the same time of another day is."""
_FASTEST_MPS = 70.0
_NOISE_M = 2.0
_TURNS_RATIO = 0.4
_METRES_PER_DEG = 111_200.0


@dataclass(frozen=True, slots=True)
class Heard:
    """A GGA or RMC sentence in a log.

    Parameters
    ----------
    order
        Number among the GGA and RMC sentences, from 0.
    line
        One-based line.
    talker
        Who sent it: ``GP``, ``GN``, ...
    days
        Midnights since the first sentence.
    fix
        What it says.
    """

    order: int
    line: int
    talker: str
    days: int
    fix: Fix

    @property
    def instant(self) -> tuple[int, float]:
        """When: midnights and time of day."""
        return self.days, self.fix.time_of_day_s

    @property
    def placed(self) -> bool:
        """Whether it has a fix, a time and a position."""
        fix = self.fix
        return fix.valid and isfinite(fix.time_of_day_s + fix.latitude_deg + fix.longitude_deg)


def receivers(heard: Sequence[Heard]) -> dict[str, list[Heard]]:
    """Return the sentences of each receiver, in order, by the first of its talkers.

    Parameters
    ----------
    heard
        All sentences of the log. A talker that never has a fix counts with the first receiver.
    """
    talkers: dict[str, list[Heard]] = {}
    for one in heard:
        talkers.setdefault(one.talker, [])
        if one.placed:
            talkers[one.talker].append(one)
    groups: dict[str, list[Heard]] = {}
    owner: dict[str, str] = {}
    for talker, placed in talkers.items():
        if placed:
            owner[talker] = next((name for name in groups if _same(groups[name], placed)), talker)
            groups.setdefault(owner[talker], []).extend(placed)
    first = next(iter(groups), next(iter(talkers), ""))
    found: dict[str, list[Heard]] = {name: [] for name in groups or talkers}
    for one in heard:
        found[owner.get(one.talker, first)].append(one)
    return {name: own for name, own in found.items() if own}


def apart_m(one: Fix, other: Fix) -> float:
    """Return the distance of two positions that are near each other [m]."""
    north = one.latitude_deg - other.latitude_deg
    east = (one.longitude_deg - other.longitude_deg + 180.0) % 360.0 - 180.0
    return _METRES_PER_DEG * hypot(north, east * cos(radians(one.latitude_deg)))


def _same(group: Sequence[Heard], placed: Sequence[Heard]) -> bool:
    """Return whether a talker's sentences come from the receiver of a group."""
    alike: list[float] = []
    unlike: list[float] = []
    at: dict[tuple[int, float], list[Heard]] = {}
    for one in group:
        at.setdefault(one.instant, []).append(one)
    for one in placed:
        for other in at.get(one.instant, []):
            if abs(one.order - other.order) <= _NEAR_SENTENCES:
                (alike if one.fix.kind == other.fix.kind else unlike).append(apart_m(one.fix, other.fix))
    if alike:
        return median(alike) <= _SAME_M
    if unlike:
        return median(unlike) <= _OTHER_KIND_M
    return not _jumps(group, placed)


def _jumps(group: Sequence[Heard], placed: Sequence[Heard]) -> bool:
    """Return whether one track of two talkers that never meet would jump, or they take turns."""
    talkers = {one.talker for one in group}
    first, last = placed[0].order, placed[-1].order
    track = sorted((*group, *placed), key=lambda one: one.order)
    inside = [one for one in track if first - 1 <= one.order <= last + 1]
    changes = [(a, b) for a, b in pairwise(track) if (a.talker in talkers) != (b.talker in talkers)]
    if len(changes) > 3 and len(changes) > _TURNS_RATIO * len(inside):
        return True
    wild = [apart_m(a.fix, b.fix) > _NOISE_M + _FASTEST_MPS * abs(_since_s(a, b)) for a, b in changes]
    return sum(wild) * 2 > len(wild)


def _since_s(before: Heard, after: Heard) -> float:
    days = after.days - before.days
    return after.fix.time_of_day_s - before.fix.time_of_day_s + 86400.0 * days
