"""Which trips share a route, so that a model trained on some of them is not judged on the same ground.

Two trips share a route where they drove over the same ground, or where one file holds both and nothing keeps
them apart: a platoon. Sharing is handed on: where A shares with B and B with C, all three are one route.
"""

from collections.abc import Sequence
from typing import Literal

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.exceptions import ConfigError
from modelcast.core.geodesy import enu_to_surface
from modelcast.trips.trajectory import Trajectory

__all__ = ["CELL_M", "SHARED_RATIO", "RouteRule", "ground_cells", "route_names", "routes"]

RouteRule = Literal["auto", "file", "trip"]

CELL_M = 40.0
"""Edge of the cells that ground is counted in [m]."""

SHARED_RATIO = 0.1
"""Trips share a route where this share of the cells of one of them lies in or next to cells of the other."""

_NEIGHBOURS = np.stack(np.meshgrid(*[[-1, 0, 1]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
_BITS = 21  # 2**21 cells of 40 m are more than the Earth is wide


def routes(trips: Sequence[Trajectory], rule: RouteRule = "auto") -> IntArray:
    """The route of every trip: 0, 1, ... in the order of their first trips, (N,).

    Parameters
    ----------
    trips
        The trips.
    rule
        ``auto``: same ground, or one file that nothing keeps apart. ``file``: one route a file. ``trip``: one
        route a trip, for recordings known to lie apart.

    Raises
    ------
    ConfigError
        Where the rule is unknown.

    Notes
    -----
    Ground is counted in cells of `CELL_M` in an Earth-centred frame, heights dropped; a trip's cells are
    widened by one on all sides before they are compared, so that no border of the grid runs between two
    lanes. Trips of one file are kept apart by absolute times that do not overlap, or by places whose bounds
    do not meet. Without an origin a trip's place is unknown, and only its file counts.

    Examples
    --------
    >>> from modelcast.world.drive import generate_drive
    >>> one, other = (generate_drive(seed, 90.0).truth for seed in (1, 2))
    >>> routes([one, other]).tolist(), routes([one, other], "trip").tolist()
    ([0, 0], [0, 1])
    """
    if rule == "trip":
        return np.arange(len(trips), dtype=np.int64)
    if rule not in {"auto", "file"}:
        raise ConfigError(f"routes are told apart by auto, file or trip, not by {rule!r}")
    count = len(trips)
    files = np.array([trip.trip_id.partition("/")[0] for trip in trips], dtype=object)
    linked: BoolArray = np.equal.outer(files, files).astype(np.bool_)
    if rule == "auto":
        placed = [at for at, trip in enumerate(trips) if trip.origin is not None]
        surfaces = [_surface(trips[at]) for at in placed]
        part = np.ix_(placed, placed)
        linked &= ~_apart_in_time(trips)
        linked[part] &= _bounds_meet(surfaces)
        linked[part] |= _same_ground(surfaces)
    return np.unique(_first_linked(linked), return_inverse=True)[1] if count else np.empty(0, dtype=np.int64)


def route_names(trips: Sequence[Trajectory], route: IntArray) -> list[str]:
    """What each route is called: its first file, and how many more it spans.

    Parameters
    ----------
    trips
        The trips.
    route
        Route of each, (N,), as `routes` gives them.
    """
    names: list[str] = []
    for number in range(int(route.max(initial=-1)) + 1):
        members = [trip.trip_id for trip, own in zip(trips, route.tolist(), strict=True) if own == number]
        files = list(dict.fromkeys(name.partition("/")[0] for name in members))
        if len(members) == 1:
            names.append(members[0])
        else:
            names.append(files[0] + (f" and {len(files) - 1} more" if len(files) > 1 else ""))
    return names


def ground_cells(trips: Sequence[Trajectory]) -> int:
    """How many cells of ground some trips drive over, each counted once.

    Parameters
    ----------
    trips
        Of one route. Those without an origin lie together where one file holds them.

    Examples
    --------
    >>> from modelcast.world.drive import generate_drive
    >>> once = generate_drive(1, 90.0).truth
    >>> ground_cells([once]) == ground_cells([once, once])
    True
    """
    placed = [_cells(_surface(trip)) for trip in trips if trip.origin is not None]
    count = len(np.unique(np.concatenate(placed), axis=0)) if placed else 0
    by_file: dict[str, list[IntArray]] = {}
    for trip in trips:
        if trip.origin is None:
            by_file.setdefault(trip.trip_id.partition("/")[0], []).append(_cells(trip.position_m))
    return count + sum(len(np.unique(np.concatenate(own), axis=0)) for own in by_file.values())


def _cells(points: FloatArray) -> IntArray:
    """The cells that points lie in, each once, (C, 2 or 3)."""
    return np.unique(np.floor(points / CELL_M).astype(np.int64), axis=0)


def _surface(trip: Trajectory) -> FloatArray:
    """Earth-centred points under a trip, (T, 3) [m]."""
    assert trip.origin is not None  # noqa: S101 - the caller picked trips with one
    up_m = np.zeros(len(trip)) if trip.up_m is None else trip.up_m
    return enu_to_surface(np.column_stack([trip.position_m, up_m]), trip.origin)


def _apart_in_time(trips: Sequence[Trajectory]) -> BoolArray:
    """Which pairs have absolute times that do not overlap, (N, N)."""
    unknown = np.array([trip.start_unix_s is None for trip in trips], dtype=np.bool_)
    start = np.array([trip.start_unix_s or 0.0 for trip in trips])
    end = start + np.array([trip.t_s[-1] for trip in trips])
    apart = (start[:, None] > end) | (start[:, None] > end).T
    return apart & ~unknown[:, None] & ~unknown


def _bounds_meet(surfaces: Sequence[FloatArray]) -> BoolArray:
    """Which pairs have bounding boxes that meet, widened by one cell, (K, K)."""
    if not surfaces:
        return np.zeros((0, 0), dtype=np.bool_)
    low = np.stack([points.min(axis=0) for points in surfaces]) - 0.5 * CELL_M
    high = np.stack([points.max(axis=0) for points in surfaces]) + 0.5 * CELL_M
    meet: BoolArray = np.all((low[:, None] <= high) & (low <= high[:, None]), axis=2)
    return meet


def _same_ground(surfaces: Sequence[FloatArray]) -> BoolArray:
    """Which pairs share ground, (K, K)."""
    own = [_cells(points) for points in surfaces]
    wide = [np.unique(_packed((cells[:, None] + _NEIGHBOURS).reshape(-1, 3))) for cells in own]
    packed = [_packed(cells) for cells in own]
    shared = _shared_cells(packed, wide)
    ratio = shared / np.array([cells.size for cells in packed])[:, None]
    return np.maximum(ratio, ratio.T) >= SHARED_RATIO


def _packed(cells: IntArray) -> IntArray:
    """One number a cell, (C,)."""
    shifted = cells + (1 << (_BITS - 1))
    return (shifted[:, 0] << (2 * _BITS)) | (shifted[:, 1] << _BITS) | shifted[:, 2]


def _shared_cells(cells: Sequence[IntArray], others: Sequence[IntArray]) -> IntArray:
    """How many cells of one trip lie in those of another, (K, K); no trip names a cell twice."""
    owner = np.repeat(np.arange(len(others)), [one.size for one in others])
    known = np.concatenate([*others, np.empty(0, dtype=np.int64)])
    order = np.argsort(known, kind="stable")
    known, owner = known[order], owner[order]
    shared = np.zeros((len(cells), len(others)), dtype=np.int64)
    for row, own in zip(shared, cells, strict=True):
        first = np.searchsorted(known, own, "left")
        count = np.searchsorted(known, own, "right") - first
        before: IntArray = np.cumsum(count) - count
        place: IntArray = np.repeat(first - before, count)
        place += np.arange(place.size)
        row[:] = np.bincount(owner[place], minlength=len(others))
    return shared


def _first_linked(linked: BoolArray) -> IntArray:
    """The first trip that each is linked with, be it through others, (N,); links go both ways."""
    found = np.arange(len(linked))
    while True:
        lowest = np.where(linked, found, len(linked)).min(axis=1, initial=len(linked))
        lowest = np.minimum(found, lowest)
        lowest = lowest[lowest]
        if np.array_equal(lowest, found):
            return found
        found = lowest
