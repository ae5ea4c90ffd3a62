"""Compiled forward collision warnings: ranges of three published algorithms, and a pair's assessment."""

from math import inf, isnan, nan
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
    closed,
    closed_by_braking,
    contact_time,
    known,
    spread,
)
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector

__all__ = ["CAMP", "KNIPLING", "NHTSA", "Rule", "assess", "ranges"]

CAMP, KNIPLING, NHTSA = range(3)


class Rule(NamedTuple):
    """An algorithm and its numbers; what it does not use is 0."""

    algorithm: int
    delay: float
    braking_delay: float
    """Delay where the host brakes by more than `brakes` already."""
    brakes: float
    braking: float
    """Deceleration of the host that is counted on."""
    rest: float
    rest_per_speed: float
    """Distance to be left, and what is added to it for each unit of the host's speed."""
    standing: float
    """A leader up to this speed stands."""
    constant: float
    by_leader: float
    by_moving: float
    by_closing: float
    """Terms of the deceleration that CAMP expects of drivers."""


@kernel(inlined=True)
def warning_range(rule: Rule, host: float, host_gain: float, leader: float, leader_gain: float) -> float:
    """Gap at which an algorithm warns."""
    if leader <= rule.standing:
        leader, leader_gain = 0.0, 0.0
    if rule.algorithm == CAMP:
        delay = rule.delay
        late, leader_late = max(host + host_gain * delay, 0.0), max(leader + leader_gain * delay, 0.0)
        required = (
            rule.constant + rule.by_leader * leader_gain + rule.by_closing * max(late - leader_late, 0.0)
        )
        if leader > 0.0:
            required += rule.by_moving
        lost = (host - leader) * delay + 0.5 * (host_gain - leader_gain) * delay * delay
        pull = leader_gain if leader_late > 0.0 else 0.0
        return max(closed(late, required, leader_late, pull) + lost, 0.0)
    if rule.algorithm == KNIPLING:
        stopping = rule.delay * host + host * host / (2.0 * rule.braking)
        if leader <= 0.0:
            return stopping
        if leader_gain >= 0.0 or host <= leader:
            return 0.0
        return max(stopping - leader * leader / (-2.0 * leader_gain), 0.0)
    delay = rule.braking_delay if host_gain < -rule.brakes else rule.delay
    way = closed_by_braking(host, host_gain, leader, leader_gain, delay, rule.braking)
    return way + rule.rest + rule.rest_per_speed * host if way > 0.0 else 0.0


@kernel
def ranges(
    rule: Rule,
    host: FloatVector,
    host_gain: FloatVector,
    leader: FloatVector,
    leader_gain: FloatVector,
    out: FloatVector,
) -> None:
    """Warning ranges, row by row."""
    for i in range(out.shape[0]):
        if isnan(host[i] + host_gain[i] + leader[i] + leader_gain[i]):
            out[i] = nan
        else:
            out[i] = warning_range(rule, host[i], host_gain[i], leader[i], leader_gain[i])


@kernel
def assess(rule: Rule, lane: Lane, caution: float, host: Columns, remote: Columns, found: Found) -> None:
    """Assess pairs row by row."""
    for i in range(found.level.shape[0]):
        found.level[i], found.time[i], found.certainty[i] = NONE, inf, 0.0
        if not (known(host, i) and known(remote, i)):
            found.margin[i] = nan
            continue
        found.margin[i] = inf
        gap, _, east, north = ahead(host, remote, lane, i)
        if gap == inf:
            continue
        speed, gain = remote.speed[i], remote.acceleration[i]
        margin = gap - warning_range(rule, host.speed[i], host.acceleration[i], speed, gain)
        found.margin[i] = margin
        found.time[i] = contact_time(gap, host.speed[i], host.acceleration[i], speed, gain)
        found.certainty[i] = chance(margin, spread(host, remote, i, east, north))
        if margin <= 0.0:
            found.level[i] = WARNING
        elif margin <= caution * max(host.speed[i] - speed, 0.0):
            found.level[i] = CAUTION
