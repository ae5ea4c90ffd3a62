"""Compiled intersection movement assist."""

from math import cos, inf, nan, sin
from typing import NamedTuple

from modelcast.apps.pair_kernels import (
    CAUTION,
    NONE,
    WARNING,
    Columns,
    Found,
    chance,
    closed_by_braking,
    first_root,
    known,
    spread,
)
from modelcast.core.kernel import kernel

__all__ = ["Settings", "arrival", "assess"]


class Settings(NamedTuple):
    """Fields of `modelcast.apps.intersection.IntersectionAssist`."""

    sine: float
    apart: float
    longest: float
    delay: float
    braking: float


@kernel(inlined=True)
def arrival(way: float, speed: float, acceleration: float) -> float:
    """When a vehicle that keeps its acceleration has gone a way; infinite where it stands before."""
    if way <= 0.0:
        return 0.0
    return first_root(0.5 * acceleration, speed, way)


@kernel
def assess(settings: Settings, host: Columns, remote: Columns, found: Found) -> None:
    """Assess pairs row by row: straight paths, and the area in which their strips overlap."""
    for i in range(found.level.shape[0]):
        found.level[i], found.time[i], found.certainty[i] = NONE, inf, 0.0
        if not (known(host, i) and known(remote, i)):
            found.margin[i] = nan
            continue
        found.margin[i] = inf
        turn = remote.heading[i] - host.heading[i]
        sine, cosine = sin(turn), abs(cos(turn))
        if abs(sine) < settings.sine:
            continue
        # East and north of the remote, solved for the ways along both courses to where they cross.
        east = remote.position[i, 0] - host.position[i, 0]
        north = remote.position[i, 1] - host.position[i, 1]
        forth_east, forth_north = sin(host.heading[i]), cos(host.heading[i])
        other_east, other_north = sin(remote.heading[i]), cos(remote.heading[i])
        way = (north * other_east - east * other_north) / sine
        other_way = (north * forth_east - east * forth_north) / sine
        half = 0.5 * (host.length[i] + (remote.width[i] + host.width[i] * cosine) / abs(sine))
        other_half = 0.5 * (remote.length[i] + (host.width[i] + remote.width[i] * cosine) / abs(sine))
        if way + half <= 0.0 or other_way + other_half <= 0.0:
            continue
        speed, gain = host.speed[i], host.acceleration[i]
        enter, leave = arrival(way - half, speed, gain), arrival(way + half, speed, gain)
        other_speed, other_gain = remote.speed[i], remote.acceleration[i]
        other_enter = arrival(other_way - other_half, other_speed, other_gain)
        other_leave = arrival(other_way + other_half, other_speed, other_gain)
        both = max(enter, other_enter)
        if not both <= settings.longest or both - min(leave, other_leave) > settings.apart:
            continue
        margin = way - half - closed_by_braking(speed, gain, 0.0, 0.0, settings.delay, settings.braking)
        found.margin[i], found.time[i] = margin, both
        found.certainty[i] = chance(margin, spread(host, remote, i, other_north / -sine, other_east / sine))
        found.level[i] = WARNING if margin <= 0.0 else CAUTION
