"""Compiled vulnerable road user warning."""

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
    path_offset,
    path_way,
    spread,
)
from modelcast.core.kernel import kernel
from modelcast.core.kinds import Kind

__all__ = ["Settings", "assess"]

_PEDESTRIAN, _ROAD_WORKER = int(Kind.PEDESTRIAN), int(Kind.ROAD_WORKER)
_VEHICLE = int(Kind.VEHICLE)


class Settings(NamedTuple):
    """Fields of `modelcast.apps.vulnerable_road_user.VulnerableRoadUserWarning`."""

    aside: float
    apart: float
    longest: float
    least_speed: float
    delay: float
    braking: float
    person_delay: float
    person_braking: float


@kernel(inlined=True)
def _is_person(kind: int) -> bool:
    """Whether a kind is one of people: their numbers follow each other."""
    return _PEDESTRIAN <= kind <= _ROAD_WORKER


@kernel(inlined=True)
def _within(offset: float, across: float, reach: float) -> tuple[float, float]:
    """When a person is in the strip, from now on; never: infinity and minus infinity."""
    if across == 0.0:
        return (0.0, inf) if abs(offset) <= reach else (inf, -inf)
    one, other = (-reach - offset) / across, (reach - offset) / across
    last = max(one, other)
    return (max(min(one, other), 0.0), last) if last >= 0.0 else (inf, -inf)


@kernel(inlined=True)
def _meeting(
    settings: Settings, car: Columns, person: Columns, i: int
) -> tuple[float, float, float, float, float, float, float]:
    """When they meet, the gap, and when the person enters the strip; how its margins depend on places.

    Time, infinite where they do not meet; gap; speed of the person along the path; when it enters the strip;
    gradient of the gap by the person's place, east and north; and of the offset, per way along the course.
    """
    east = person.position[i, 0] - car.position[i, 0]
    north = person.position[i, 1] - car.position[i, 1]
    heading, speed = car.heading[i], car.speed[i]
    forth_east, forth_north = sin(heading), cos(heading)
    onward, right = east * forth_east + north * forth_north, east * forth_north - north * forth_east
    curvature = car.yaw_rate[i] / speed if speed >= settings.least_speed and speed > 0.0 else 0.0
    way, by_onward, by_right = path_way(onward, right, curvature)
    offset = path_offset(onward, right, curvature)
    turn = person.heading[i] - heading - curvature * way
    along, across = cos(turn), sin(turn)
    half = 0.5 * (car.length[i] + person.length[i] * abs(along) + person.width[i] * abs(across))
    reach = 0.5 * (car.width[i] + person.length[i] * abs(across) + person.width[i] * abs(along))
    reach += settings.aside
    by_east = by_onward * forth_east + by_right * forth_north
    by_north = by_onward * forth_north - by_right * forth_east
    if way + half <= 0.0:
        return inf, inf, 0.0, inf, by_east, by_north, across
    closing, gain, pace = speed - person.speed[i] * along, car.acceleration[i], person.speed[i]
    if speed == 0.0 and gain <= 0.0:
        return inf, inf, 0.0, inf, by_east, by_north, across
    comes = 0.0 if way - half <= 0.0 else first_root(0.5 * gain, closing, way - half)
    gone = first_root(0.5 * gain, closing, way + half)
    enters, leaves = _within(offset, pace * across, reach)
    both = max(comes, enters)
    if not both <= settings.longest or comes > leaves + settings.apart or enters > gone + settings.apart:
        both = inf
    return both, way - half, pace * along, enters, by_east, by_north, across


@kernel
def assess(settings: Settings, host: Columns, remote: Columns, found: Found) -> None:
    """Assess pairs row by row: a vehicle and a person each, whoever the host is."""
    for i in range(found.level.shape[0]):
        found.level[i], found.time[i], found.certainty[i] = NONE, inf, 0.0
        if not (known(host, i) and known(remote, i)):
            found.margin[i] = nan
            continue
        found.margin[i] = inf
        walks = _is_person(host.kind[i])
        if walks and remote.kind[i] == _VEHICLE:
            both, _, _, enters, by_east, by_north, across = _meeting(settings, remote, host, i)
            if both == inf:
                continue
            pace = host.speed[i]
            need = pace * settings.person_delay + pace * pace / (2.0 * settings.person_braking)
            margin, deviation = pace * enters - need, 0.0
            if enters > 0.0:
                # Across the path the offset's gradient is the gap's, turned by a right angle.
                deviation = spread(host, remote, i, by_north / across, -by_east / across)
        elif _is_person(remote.kind[i]) and host.kind[i] == _VEHICLE:
            both, gap, along, _, by_east, by_north, _ = _meeting(settings, host, remote, i)
            if both == inf:
                continue
            speed, gain = host.speed[i], host.acceleration[i]
            need = closed_by_braking(speed, gain, max(along, 0.0), 0.0, settings.delay, settings.braking)
            need += max(-along, 0.0) * (settings.delay + speed / settings.braking)
            margin, deviation = gap - need, spread(host, remote, i, by_east, by_north)
        else:
            continue
        found.margin[i], found.time[i] = margin, both
        found.certainty[i] = chance(margin, deviation)
        found.level[i] = WARNING if margin <= 0.0 else CAUTION
