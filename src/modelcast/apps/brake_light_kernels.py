"""Compiled emergency electronic brake light."""

from math import inf, nan
from typing import NamedTuple

from modelcast.apps.pair_kernels import (
    CAUTION,
    NONE,
    WARNING,
    Columns,
    Found,
    Lane,
    ahead,
    chance,
    closed_by_braking,
    contact_time,
    known,
    spread,
)
from modelcast.core.kernel import kernel

__all__ = ["Settings", "assess"]


class Settings(NamedTuple):
    """What `modelcast.apps.brake_light.BrakeLight` has beside a lane."""

    hard: float
    delay: float
    braking: float
    half_width: float


@kernel
def assess(settings: Settings, lane: Lane, host: Columns, remote: Columns, found: Found) -> None:
    """Assess pairs row by row."""
    for i in range(found.level.shape[0]):
        found.level[i], found.time[i], found.certainty[i] = NONE, inf, 0.0
        if not (known(host, i) and known(remote, i)):
            found.margin[i] = nan
            continue
        found.margin[i] = inf
        if remote.acceleration[i] > -settings.hard:
            continue
        gap, offset, east, north = ahead(host, remote, lane, i)
        if gap == inf:
            continue
        found.level[i] = CAUTION
        if abs(offset) > settings.half_width:
            continue
        speed, gain = host.speed[i], host.acceleration[i]
        margin = gap - closed_by_braking(
            speed, gain, remote.speed[i], remote.acceleration[i], settings.delay, settings.braking
        )
        found.margin[i] = margin
        found.time[i] = contact_time(gap, speed, gain, remote.speed[i], remote.acceleration[i])
        found.certainty[i] = chance(margin, spread(host, remote, i, east, north))
        if margin <= 0.0:
            found.level[i] = WARNING
