"""Turns, U-turns and roundabouts: what the shape of the path tells, at whatever speed it was driven.

The path is laid out by distance, standing left out. Where its radius is small it makes *lobes*, stretches of
one side; a lobe alone is a turn or a U-turn, one between two of the other side is a way round an island.
"""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from itertools import pairwise

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.trips.inspection import STOP_SPEED_MPS
from modelcast.trips.manoeuvres.base import FoundManoeuvre, ManoeuvreKind, Side
from modelcast.trips.manoeuvres.motion import Motion
from modelcast.trips.recorder import parts

__all__ = ["MAX_RADIUS_M", "TURN_RAD", "find_bends"]

MAX_RADIUS_M = 60.0
"""A bend with a larger radius belongs to the road; junctions are turned at 6 m to 30 m."""

MIN_RADIUS_M = 3.0
"""A smaller one is no bend: the vehicle reversed, or stood while its position wandered."""

TURN_RAD = np.deg2rad(45.0)
"""A turn changes the course by more than this in one go; bends and lane changes stay below."""

U_TURN_RAD = np.deg2rad(150.0)
"""A U-turn changes the course by more than this, within `U_TURN_RADIUS_M`."""

U_TURN_RADIUS_M = 16.0
"""Largest mean radius of a U-turn: a lorry's turning circle; a wider loop is a turn."""

ISLAND_RADIUS_M = 35.0
"""Largest radius of a way round an island: inscribed circles of two lanes are up to 67 m wide (NCHRP 672)."""

MIN_ISLAND_RADIUS_M = 4.0
"""Smallest radius of a way round an island: a mini-roundabout is 13 m wide (NCHRP 672)."""

MIN_ISLAND_SPEED_MPS = 2.0
"""Slowest way round an island: who circulates has the right of way, and does not stand."""

ISLAND_SPEED_MPS = 50.0 / 3.6
"""Fastest way round an island: design speeds of entries are at most 30 mph (NCHRP 672)."""

CIRCULATION_RAD = np.deg2rad(45.0)
"""Least change of course round an island, a way straight across it."""

DEFLECTION_RAD = np.deg2rad(15.0)
"""Least change of course to the other side at entry and exit."""

FULL_RAD = np.deg2rad(300.0)
"""A change of course that only a way round an island reaches, without entry or exit in sight."""

_GRID_M = 1.0
_CHORD_M = 5.0  # course over this far: a car's length, and long against 0.1 m of noise
_JOINED_M = 8.0  # lobes of one side nearer than this are one
_NEIGHBOUR_M = 20.0  # entry and exit lie nearer to the circulation than this


@dataclass(frozen=True, slots=True)
class _Lobe:
    """A stretch of small radius to one side: its ends along the path [m] and its change of course [rad]."""

    start_m: float
    end_m: float
    _: KW_ONLY
    turned_rad: float  # clockwise positive

    @property
    def angle_rad(self) -> float:
        return abs(self.turned_rad)

    @property
    def radius_m(self) -> float:
        return (self.end_m - self.start_m) / max(self.angle_rad, 1e-9)

    @property
    def side(self) -> Side:
        return "right" if self.turned_rad > 0.0 else "left"


@dataclass(frozen=True, slots=True)
class _Path:
    """A path by distance: times (N,) [s] and course, unwrapped, clockwise (N,) [rad] at every `_GRID_M`."""

    t_s: FloatArray
    course_rad: FloatArray

    def at(self, way_m: float) -> float:
        """Time at a distance along the path [s]."""
        return float(np.interp(way_m / _GRID_M, np.arange(self.t_s.size), self.t_s))


def find_bends(motion: Motion) -> list[FoundManoeuvre]:
    """Return turns, U-turns and roundabouts; what belongs to a roundabout is no turn too.

    Parameters
    ----------
    motion
        How the vehicle moved.

    References
    ----------
    NCHRP Report 672, "Roundabouts: An Informational Guide", 2nd ed., 2010, exhibit 1-9, DOI
    10.17226/22914.
    """
    found = list[FoundManoeuvre]()
    for part in parts(motion.trip):
        path = _by_distance(motion, part)
        if path is not None:
            found += _classified(path, _lobes(path))
    return found


def _by_distance(motion: Motion, part: slice) -> _Path | None:
    """Return the part's path at equal distances; None where it is too short to bend."""
    moving = motion.travelled_mps[part] > 2.0 * STOP_SPEED_MPS  # as in the inspection: else it stands
    position = motion.trip.position_m[part][moving]
    if position.shape[0] < 2:
        return None
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(position, axis=0).T))])
    count = int(way[-1] / _GRID_M) + 1
    half = round(0.5 * _CHORD_M / _GRID_M)
    if count < 4 * half + 2:
        return None
    at = np.arange(count) * _GRID_M
    grid = np.stack([np.interp(at, way, position[:, axis]) for axis in (0, 1)], axis=1)
    index = np.arange(count)
    chord = grid[np.minimum(index + half, count - 1)] - grid[np.maximum(index - half, 0)]
    course = np.unwrap(np.arctan2(chord[:, 0], chord[:, 1]))
    return _Path(np.interp(at, way, motion.trip.t_s[part][moving]), course)


def _lobes(path: _Path) -> list[_Lobe]:
    """Stretches whose radius is under `MAX_RADIUS_M`, those of one side joined where they nearly touch."""
    count, half = path.course_rad.size, round(0.5 * _CHORD_M / _GRID_M)
    index = np.arange(count)
    after, before = np.minimum(index + half, count - 1), np.maximum(index - half, 0)
    curvature = (path.course_rad[after] - path.course_rad[before]) / ((after - before) * _GRID_M)
    side = np.sign(curvature) * (np.abs(curvature) > 1.0 / MAX_RADIUS_M)
    edges = np.flatnonzero(np.diff(np.concatenate([[0.0], side, [0.0]])))
    runs = list[tuple[int, int, float]]()
    for a, b in pairwise(edges):
        if side[a] == 0.0:
            continue
        if runs and runs[-1][2] == side[a] and (a - runs[-1][1]) * _GRID_M < _JOINED_M:
            runs[-1] = (runs[-1][0], int(b), float(side[a]))
        else:
            runs.append((int(a), int(b), float(side[a])))
    course = path.course_rad
    return [
        _Lobe(a * _GRID_M, (b - 1) * _GRID_M, turned_rad=float(course[b - 1] - course[a])) for a, b, _ in runs
    ]


def _classified(path: _Path, lobes: Sequence[_Lobe]) -> list[FoundManoeuvre]:
    found = list[FoundManoeuvre]()
    taken = set[int]()
    for at, lobe in enumerate(lobes):
        span = _island(path, lobes, at)
        if span is not None and not taken.intersection(range(span[0], span[1] + 1)):
            taken.update(range(span[0], span[1] + 1))
            start, end = path.at(lobes[span[0]].start_m), path.at(lobes[span[1]].end_m)
            found.append(
                FoundManoeuvre(ManoeuvreKind.ROUNDABOUT, start, end, size=lobe.angle_rad, side=lobe.side)
            )
    for at, lobe in enumerate(lobes):
        if at in taken or lobe.angle_rad < TURN_RAD or lobe.radius_m < MIN_RADIUS_M:
            continue
        back = lobe.angle_rad > U_TURN_RAD and lobe.radius_m < U_TURN_RADIUS_M
        kind = ManoeuvreKind.U_TURN if back else ManoeuvreKind.TURN
        start, end = path.at(lobe.start_m), path.at(lobe.end_m)
        found.append(FoundManoeuvre(kind, start, end, size=lobe.angle_rad, side=lobe.side))
    return found


def _island(path: _Path, lobes: Sequence[_Lobe], at: int) -> tuple[int, int] | None:
    """First and last lobe of the way round an island whose circulation is this lobe, or None."""
    lobe = lobes[at]
    elapsed = path.at(lobe.end_m) - path.at(lobe.start_m)
    flowing = MIN_ISLAND_SPEED_MPS * elapsed < lobe.end_m - lobe.start_m < ISLAND_SPEED_MPS * elapsed
    if not (MIN_ISLAND_RADIUS_M < lobe.radius_m < ISLAND_RADIUS_M and flowing):
        return None
    if lobe.angle_rad > FULL_RAD:
        return at, at
    if lobe.angle_rad < CIRCULATION_RAD or not 0 < at < len(lobes) - 1:
        return None
    entry, leaving = lobes[at - 1], lobes[at + 1]
    near = lobe.start_m - entry.end_m < _NEIGHBOUR_M and leaving.start_m - lobe.end_m < _NEIGHBOUR_M
    other = lobe.side not in (entry.side, leaving.side)
    deflected = min(entry.angle_rad, leaving.angle_rad) > DEFLECTION_RAD
    near = near and min(entry.radius_m, leaving.radius_m) > MIN_ISLAND_RADIUS_M
    return (at - 1, at + 1) if near and other and deflected else None
