"""Compiled composing of a message in the closed loop: fits, and the choice of a sub-model."""

from math import hypot
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector, IntVector
from modelcast.models.member_kernels import Members, fit_member, parameter_count, predict_member
from modelcast.models.point_kernels import EAST, NORTH
from modelcast.runtime.fleet.arrays import SenderArrays
from modelcast.runtime.fleet.layout_kernels import (
    CONTENT_BYTES,
    CONTENT_EAST_M,
    CONTENT_HEAD,
    CONTENT_MEMBER,
    CONTENT_NORTH_M,
)

__all__ = ["LoopModels", "compose", "moved"]

_SCORE_WEIGHT = 0.2
"""Of the newest error in the mean that chooses a sub-model: about the last five messages count."""


class LoopModels(NamedTuple):
    """A sender's ``members`` (M), the last one that of a plain message; each one's payload [bytes], (M,)."""

    members: Members
    payload_bytes: IntVector


@kernel(inlined=True)
def moved(models: LoopModels, member: int, parameters: FloatVector, age_s: float, out: FloatVector) -> None:
    """Displacement of one sub-model's decoded parameters into ``out`` (2,)."""
    predict_member(models.members, member, parameters, age_s, out)


@kernel(inlined=True)
def _adds_nothing(
    models: LoopModels,
    member: int,
    parameters: FloatVector,
    plain: FloatVector,
    within_m: float,
    horizon_s: float,
    scratch: FloatVector,
) -> bool:
    """Whether two paths are the same within a resolution, half-way to a horizon and there."""
    plain_member = models.payload_bytes.size - 1
    for share in (0.5, 1.0):
        moved(models, member, parameters, share * horizon_s, scratch)
        east, north = scratch[0], scratch[1]
        moved(models, plain_member, plain, share * horizon_s, scratch)
        if hypot(east - scratch[0], north - scratch[1]) > within_m:
            return False
    return True


@kernel(inlined=True)
def _judge(
    models: LoopModels, s: SenderArrays, v: int, t_s: float, sample: FloatVector, scratch: FloatVector
) -> None:
    """Set every sub-model fitted at the last message against the newest sample."""
    for member in range(models.payload_bytes.size):
        trial = s.trials[v, member]
        count = parameter_count(models.members, member)
        if trial[trial.size - 1] == 0.0:
            continue
        moved(models, member, trial[:count], t_s - s.origin[v, 0], scratch)
        east = s.origin[v, 1] + scratch[0] - sample[EAST]
        north = s.origin[v, 2] + scratch[1] - sample[NORTH]
        square, before = east * east + north * north, s.scores[v, member]
        s.scores[v, member] = square if before < 0.0 else before + _SCORE_WEIGHT * (square - before)


@kernel(inlined=True)
def _recent_choice(models: LoopModels, s: SenderArrays, v: int, within_m: float) -> int:
    """Smallest sub-model that erred no more than the best of late, but for a resolution; -1 for no score."""
    payload_bytes = models.payload_bytes
    best = np.inf
    for member in range(models.payload_bytes.size):
        if s.trials[v, member, s.trials.shape[2] - 1] != 0.0 and s.scores[v, member] >= 0.0:
            best = min(best, s.scores[v, member])
    chosen = -1
    for member in range(models.payload_bytes.size):
        usable = s.trials[v, member, s.trials.shape[2] - 1] != 0.0 and s.scores[v, member] >= 0.0
        good = usable and s.scores[v, member] <= best + within_m * within_m
        if good and (chosen < 0 or payload_bytes[member] < payload_bytes[chosen]):
            chosen = member
    return chosen


@kernel(inlined=True)
def compose(
    models: LoopModels,
    limits: tuple[float, float, float],
    s: SenderArrays,
    v: int,
    at: int,
    t_s: float,
    row: FloatVector,
    scratch: FloatVector,
) -> None:
    """Write the content (W,) of a vehicle's message from its newest sample, as a receiver decodes it.

    The last member is that of a plain basic safety message. ``limits`` is the resolution below which paths
    are the same [m], the horizon over which they are compared [s], and whether recent errors choose the sub-
    model. ``scratch`` (2 + P,) is overwritten.
    """
    members, payload_bytes = models.members, models.payload_bytes
    windows = members.windows
    plain_member = payload_bytes.size - 1
    within_m, horizon_s, by_errors = limits
    end = at + s.times.size // 2 + 1
    own = s.samples[v]
    member = 0
    while member < plain_member and s.history[v] < windows[member]:
        member += 1
    parameters = row[CONTENT_HEAD : CONTENT_HEAD + parameter_count(members, member)]
    if by_errors > 0.0:
        _judge(models, s, v, t_s, own[end - 1], scratch)
        for m in range(plain_member + 1):
            trial = s.trials[v, m]
            trial[trial.size - 1] = 0.0
            if s.history[v] >= windows[m]:
                fit_member(members, m, own[end - windows[m] : end], trial[: parameter_count(members, m)])
                trial[trial.size - 1] = 1.0
        s.origin[v, 0], s.origin[v, 1], s.origin[v, 2] = t_s, own[end - 1, EAST], own[end - 1, NORTH]
        chosen = _recent_choice(models, s, v, within_m)
        member = chosen if chosen >= 0 else member
        parameters = row[CONTENT_HEAD : CONTENT_HEAD + parameter_count(members, member)]
        for k in range(parameter_count(members, member)):
            parameters[k] = s.trials[v, member, k]
    else:
        fit_member(members, member, own[end - windows[member] : end], parameters)
        if member < plain_member:
            plain = scratch[2 : 2 + parameter_count(members, plain_member)]
            fit_member(members, plain_member, own[end - 1 : end], plain)
            if _adds_nothing(models, member, parameters, plain, within_m, horizon_s, scratch):
                member = plain_member
                parameters = row[CONTENT_HEAD : CONTENT_HEAD + parameter_count(members, member)]
                for k in range(plain.size):
                    parameters[k] = plain[k]
    last = parameters.size - 1
    # The position sent is on its grid; a receiver has it and no remainder.
    row[CONTENT_EAST_M] = own[end - 1, EAST] + parameters[last - 1]
    row[CONTENT_NORTH_M] = own[end - 1, NORTH] + parameters[last]
    parameters[last - 1] = parameters[last] = 0.0
    row[CONTENT_MEMBER], row[CONTENT_BYTES] = member, payload_bytes[member]
