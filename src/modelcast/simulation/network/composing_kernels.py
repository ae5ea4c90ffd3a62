"""Compiled composing of a message in the closed loop: fits, and the choice of a sub-model."""

from math import hypot
from typing import Any

import numpy as np

from modelcast.core.borrowing_kernels import borrowing
from modelcast.models.point_kernels import EAST, NORTH
from modelcast.models.trusted_kernels import predict_trusted
from modelcast.simulation.network.layout_kernels import (
    CONTENT_BYTES,
    CONTENT_EAST_M,
    CONTENT_HEAD,
    CONTENT_MEMBER,
    CONTENT_NORTH_M,
)

__all__ = ["compose", "moved"]

_SCORE_WEIGHT = 0.2
"""Of the newest error in the mean that chooses a sub-model: about the last five messages count."""


@borrowing
def moved(models: Any, member: int, parameters: Any, age_s: float, out: Any) -> None:
    """Displacement of one sub-model's decoded parameters into ``out`` (2,)."""
    _, predicts, constants, _, _, trust, _ = models
    predict_trusted(
        predicts[member], parameters, age_s, constants[member], trust[member, 0], trust[member, 1], out
    )


@borrowing
def _adds_nothing(
    models: Any, member: int, parameters: Any, plain: Any, within_m: float, horizon_s: float, scratch: Any
) -> bool:
    """Whether two paths are the same within a resolution, half-way to a horizon and there."""
    plain_member = len(models[0]) - 1
    for share in (0.5, 1.0):
        moved(models, member, parameters, share * horizon_s, scratch)
        east, north = scratch[0], scratch[1]
        moved(models, plain_member, plain, share * horizon_s, scratch)
        if hypot(east - scratch[0], north - scratch[1]) > within_m:
            return False
    return True


@borrowing
def _judge(models: Any, s: Any, v: int, t_s: float, sample: Any, scratch: Any) -> None:
    """Set every sub-model fitted at the last message against the newest sample."""
    for member in range(len(models[0])):
        trial = s.trials[v, member]
        count = models[4][member]
        if trial[trial.size - 1] == 0.0:
            continue
        moved(models, member, trial[:count], t_s - s.origin[v, 0], scratch)
        east = s.origin[v, 1] + scratch[0] - sample[EAST]
        north = s.origin[v, 2] + scratch[1] - sample[NORTH]
        square, before = east * east + north * north, s.scores[v, member]
        s.scores[v, member] = square if before < 0.0 else before + _SCORE_WEIGHT * (square - before)


@borrowing
def _recent_choice(models: Any, s: Any, v: int, within_m: float) -> int:
    """Smallest sub-model that erred no more than the best of late, but for a resolution; -1 for no score."""
    payload_bytes = models[6]
    best = np.inf
    for member in range(len(models[0])):
        if s.trials[v, member, s.trials.shape[2] - 1] != 0.0 and s.scores[v, member] >= 0.0:
            best = min(best, s.scores[v, member])
    chosen = -1
    for member in range(len(models[0])):
        usable = s.trials[v, member, s.trials.shape[2] - 1] != 0.0 and s.scores[v, member] >= 0.0
        good = usable and s.scores[v, member] <= best + within_m * within_m
        if good and (chosen < 0 or payload_bytes[member] < payload_bytes[chosen]):
            chosen = member
    return chosen


@borrowing
def compose(models: Any, limits: Any, s: Any, v: int, at: int, t_s: float, row: Any, scratch: Any) -> None:
    """Write the content (W,) of a vehicle's message from its newest sample, as a receiver decodes it.

    ``models`` holds the members' compiled fits, predictions and constants as tuples, their windows, numbers
    of parameters, trusted horizons and payload bytes. The last member is that of a plain basic safety
    message. ``limits`` is the resolution below which paths are the same [m], the horizon over which they are
    compared [s], and whether recent errors choose the sub-model. ``scratch`` (2 + P,) is overwritten.
    """
    fits, _, constants, windows, counts, _, payload_bytes = models
    plain_member = len(fits) - 1
    within_m, horizon_s, by_errors = limits
    end = at + s.times.size // 2 + 1
    own = s.samples[v]
    member = 0
    while member < plain_member and s.history[v] < windows[member]:
        member += 1
    parameters = row[CONTENT_HEAD : CONTENT_HEAD + counts[member]]
    if by_errors > 0.0:
        _judge(models, s, v, t_s, own[end - 1], scratch)
        for m in range(plain_member + 1):
            trial = s.trials[v, m]
            trial[trial.size - 1] = 0.0
            if s.history[v] >= windows[m]:
                fits[m](own[end - windows[m] : end], constants[m], trial[: counts[m]])
                trial[trial.size - 1] = 1.0
        s.origin[v, 0], s.origin[v, 1], s.origin[v, 2] = t_s, own[end - 1, EAST], own[end - 1, NORTH]
        chosen = _recent_choice(models, s, v, within_m)
        member = chosen if chosen >= 0 else member
        parameters = row[CONTENT_HEAD : CONTENT_HEAD + counts[member]]
        for k in range(counts[member]):
            parameters[k] = s.trials[v, member, k]
    else:
        fits[member](own[end - windows[member] : end], constants[member], parameters)
        if member < plain_member:
            plain = scratch[2 : 2 + counts[plain_member]]
            fits[plain_member](own[end - 1 : end], constants[plain_member], plain)
            if _adds_nothing(models, member, parameters, plain, within_m, horizon_s, scratch):
                member = plain_member
                parameters = row[CONTENT_HEAD : CONTENT_HEAD + counts[member]]
                for k in range(plain.size):
                    parameters[k] = plain[k]
    last = parameters.size - 1
    # The position sent is on its grid; a receiver has it and no remainder.
    row[CONTENT_EAST_M] = own[end - 1, EAST] + parameters[last - 1]
    row[CONTENT_NORTH_M] = own[end - 1, NORTH] + parameters[last]
    parameters[last - 1] = parameters[last] = 0.0
    row[CONTENT_MEMBER], row[CONTENT_BYTES] = member, payload_bytes[member]
