"""Compiled choice of the sub-model that a message carries."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector
from modelcast.models.address_kernels import fit_at
from modelcast.station.arrays import Fits, LaneRules, Lanes, Sensed
from modelcast.station.policy.error_driven_kernels import (
    START_GUARDED,
    START_HINDSIGHT,
    START_PREDICTED,
    START_RECENT,
    start_member,
)
from modelcast.station.policy.hindsight_kernels import LAGS_S, MARGIN, log_life
from modelcast.station.sender.fitting_kernels import SenderModels, distance_to, fit

__all__ = ["available", "chosen"]

_SCORE_WEIGHT = 0.2
"""Of the newest error in the mean that chooses a sub-model: about the last five messages count."""

_CLEARLY = 0.25
"""Mean squares of five errors differ by chance: another must err less than half as far as the free one."""


@kernel(inlined=True)
def available(models: SenderModels, s: Sensed, rules: LaneRules, lanes: Lanes, b: int, number: int) -> None:
    """Write which members a lane may use at a sample, ``lanes.available``."""
    members, v = models.members, rules.vehicle[b]
    history = s.history[v, number % s.history.shape[1]]
    served, only = False, rules.only[b]
    if only >= 0 and models.guard >= 0 and history < members.windows[only]:
        only = models.guard  # as constant velocity completes a bank of that member alone
    for m in range(members.windows.size):
        found = history >= members.windows[m] and (only < 0 or only == m)
        found = found and not (m == models.fallback and served)
        lanes.available[b, m] = found
        served = served or found


@kernel(inlined=True)
def _hindsight(
    models: SenderModels,
    s: Sensed,
    fits: Fits,
    rules: LaneRules,
    lanes: Lanes,
    b: int,
    number: int,
    scratch: FloatVector,
) -> None:
    """Score the members by what they would have predicted a moment ago; NaN where nothing can be said.

    A lag counts where every member available now had a full window then, in the same part of the trip.
    """
    members, v = models.members, rules.vehicle[b]
    ring = s.stated_m.shape[1]
    history = s.history[v, number % ring]
    at = number % ring + ring
    t_s = float(s.t_s[v, at])
    longest = 1
    for m in range(members.windows.size):
        lanes.chances[b, m] = 0.0
        if lanes.available[b, m]:
            longest = max(longest, members.windows[m])
    count, before = 0, 0
    for lag_s in LAGS_S:
        back = max(int(lag_s / models.dt_s + 0.5), 1)
        if back == before or history - back < longest:
            continue
        before = back
        then = number - back
        place = then % ring
        age_s = t_s - float(s.t_s[v, place])
        scratch[2], scratch[3], scratch[4] = (
            s.stated_s[v, place],
            s.stated_m[v, place, 0],
            s.stated_m[v, place, 1],
        )
        for m in range(members.windows.size):
            if lanes.available[b, m] and fit(models, s, fits, v, then, m):
                own = fits.parameters[
                    v, then % fits.parameters.shape[1], members.offsets[m] : members.offsets[m + 1]
                ]
                error_m = distance_to(models, m, own, scratch[2:5], t_s, s.samples[v, at], scratch)
                lanes.chances[b, m] += log_life(age_s, error_m, rules.threshold_m[b])
        count += 1
    for m in range(members.windows.size):
        known = count > 0 and lanes.available[b, m]
        lanes.chances[b, m] = lanes.chances[b, m] / count if known else np.nan
    lanes.chances[b, 0] += MARGIN


@kernel(inlined=True)
def _recent(
    models: SenderModels, s: Sensed, rules: LaneRules, lanes: Lanes, b: int, number: int, scratch: FloatVector
) -> int:
    """Smallest sub-model that erred no more than the best of late, but for a resolution; -1 for no score.

    Of those of one size, the one that erred least; and none but ``models.free`` where it did not err clearly
    less than that one (`_CLEARLY`).

    Every member fitted at the last message is set against the newest sample first.
    """
    members, v = models.members, rules.vehicle[b]
    at = number % s.stated_m.shape[1] + s.stated_m.shape[1]
    best = np.inf
    for m in range(members.windows.size):
        if lanes.last_usable[b, m]:
            own = lanes.last[b, members.offsets[m] : members.offsets[m + 1]]
            error_m = distance_to(
                models, m, own, lanes.last_origin[b], float(s.t_s[v, at]), s.samples[v, at], scratch
            )
            square, before = error_m * error_m, lanes.scores[b, m]
            lanes.scores[b, m] = square if before < 0.0 else before + _SCORE_WEIGHT * (square - before)
    bound = np.inf
    if models.free >= 0 and lanes.available[b, models.free] and lanes.scores[b, models.free] >= 0.0:
        best, bound = lanes.scores[b, models.free], _CLEARLY * lanes.scores[b, models.free]
    for m in range(members.windows.size):
        if lanes.available[b, m] and 0.0 <= lanes.scores[b, m] <= bound:
            best = min(best, lanes.scores[b, m])
    found = -1
    for m in range(members.windows.size):
        usable = lanes.available[b, m] and lanes.scores[b, m] >= 0.0
        usable = usable and (m == models.free or lanes.scores[b, m] <= bound)
        good = usable and lanes.scores[b, m] <= best + rules.within_m * rules.within_m
        if not good:
            continue
        better = found < 0 or models.sizes[m] < models.sizes[found]
        if not better and models.sizes[m] == models.sizes[found]:
            better = lanes.scores[b, m] < lanes.scores[b, found]
        if better:
            found = m
    return found


@kernel
def chosen(
    models: SenderModels,
    s: Sensed,
    fits: Fits,
    rules: LaneRules,
    lanes: Lanes,
    b: int,
    number: int,
    scratch: FloatVector,
) -> int:
    """Sub-model that a lane's message at a sample carries, of those in ``lanes.available``; -1 for none.

    ``scratch`` (5,) is overwritten.
    """
    start, v = rules.start[b], rules.vehicle[b]
    if start == START_RECENT:
        found = _recent(models, s, rules, lanes, b, number, scratch)
        if found >= 0:
            return found
    elif start == START_PREDICTED:
        ring = s.stated_m.shape[1]
        at = number % ring + ring
        first = at - min(models.selector_window, s.history[v, number % ring]) + 1
        fit_at(models.selector, s.samples[v, first : at + 1], rules.selector[b], lanes.chances[b])
    elif start in (START_HINDSIGHT, START_GUARDED):
        _hindsight(models, s, fits, rules, lanes, b, number, scratch)
    return start_member(lanes.available[b], lanes.failed_s[b], lanes.chances[b], lanes.in_use[b], start)
