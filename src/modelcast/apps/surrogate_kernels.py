"""Compiled surrogate safety measures: first contact of rectangles, and who leaves before who arrives."""

from math import cos, inf, isnan, nan, sin, sqrt

from modelcast.apps.pair_kernels import Columns
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatCube, FloatMatrix, FloatVector

__all__ = ["encroachments", "first_contacts"]


@kernel
def first_contacts(host: Columns, remote: Columns, out: FloatVector) -> None:
    """When rectangles at constant velocity first touch: on all four axes at once (separating axes).

    Axes: the courses of both, and their normals.
    """
    for i in range(out.shape[0]):
        east, north = sin(host.heading[i]), cos(host.heading[i])
        other_east, other_north = sin(remote.heading[i]), cos(remote.heading[i])
        apart_east = remote.position[i, 0] - host.position[i, 0]
        apart_north = remote.position[i, 1] - host.position[i, 1]
        away_east = remote.speed[i] * other_east - host.speed[i] * east
        away_north = remote.speed[i] * other_north - host.speed[i] * north
        if isnan(apart_east + apart_north + away_east + away_north):
            out[i] = nan
            continue
        along, across = (
            abs(east * other_east + north * other_north),
            abs(east * other_north - north * other_east),
        )
        begin, end = 0.0, inf
        for axis in range(4):
            if axis < 2:
                x, y = (east, north) if axis == 0 else (north, -east)
                own, other = (along, across) if axis == 0 else (across, along)
                half = host.length[i] if axis == 0 else host.width[i]
                half = 0.5 * (half + remote.length[i] * own + remote.width[i] * other)
            else:
                x, y = (other_east, other_north) if axis == 2 else (other_north, -other_east)
                own, other = (along, across) if axis == 2 else (across, along)
                half = remote.length[i] if axis == 2 else remote.width[i]
                half = 0.5 * (half + host.length[i] * own + host.width[i] * other)
            apart, away = apart_east * x + apart_north * y, away_east * x + away_north * y
            if away == 0.0:
                if abs(apart) > half:
                    end = -inf
                continue
            first, last = (-half - apart) / away, (half - apart) / away
            begin, end = max(begin, min(first, last)), min(end, max(first, last))
        out[i] = begin if begin <= end else inf


@kernel(inlined=True)
def stay(
    t: FloatVector, track: FloatCube, i: int, east: float, north: float, radius: float
) -> tuple[float, float]:
    """When a track first enters a disc and last leaves it; infinite where it never does."""
    enter, leave = inf, -inf
    for k in range(t.shape[0] - 1):
        x, y = track[i, k, 0] - east, track[i, k, 1] - north
        dx, dy = track[i, k + 1, 0] - track[i, k, 0], track[i, k + 1, 1] - track[i, k, 1]
        square, half, rest = dx * dx + dy * dy, x * dx + y * dy, x * x + y * y - radius * radius
        if square > 0.0:
            root = half * half - square * rest
            if not root >= 0.0:
                continue
            first, last = max((-half - sqrt(root)) / square, 0.0), min((-half + sqrt(root)) / square, 1.0)
        elif rest <= 0.0:
            first, last = 0.0, 1.0
        else:
            continue
        if first <= last:
            step = t[k + 1] - t[k]
            enter, leave = min(enter, t[k] + first * step), max(leave, t[k] + last * step)
    return enter, leave


@kernel
def encroachments(
    t: FloatVector,
    host: FloatCube,
    remote: FloatCube,
    point: FloatMatrix,
    radius: FloatVector,
    out: FloatVector,
) -> None:
    """Time from the first one's leaving a disc to the other's arrival; negative where both were in it."""
    for i in range(out.shape[0]):
        enter, leave = stay(t, host, i, point[i, 0], point[i, 1], radius[i])
        other_enter, other_leave = stay(t, remote, i, point[i, 0], point[i, 1], radius[i])
        if isnan(point[i, 0] + point[i, 1] + radius[i]) or max(enter, other_enter) == inf:
            out[i] = nan
        else:
            out[i] = max(other_enter - leave, enter - other_leave)
