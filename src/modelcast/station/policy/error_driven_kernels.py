"""Algorithm 1 of the paper, once: the compiled steps that the stations of trips and fleets both call."""

from math import isnan
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolMatrix, BoolVector, FloatMatrix, FloatVector, IntVector

__all__ = [
    "COST_HEADER",
    "IDENTIFICATION",
    "IDENTIFY_BEST",
    "IDENTIFY_CHEAPEST",
    "IDENTIFY_FINAL",
    "IDENTIFY_NEVER",
    "IDENTIFY_ON_FAILURE",
    "KEEP_ALIVE",
    "NOTHING",
    "START_GUARDED",
    "START_HINDSIGHT",
    "START_KEEP",
    "START_ORDER",
    "START_PREDICTED",
    "START_RECENT",
    "START_SURVIVOR",
    "UPDATE",
    "Vehicles",
    "class_of",
    "longest_silence_s",
    "residual_life_s",
    "start_member",
    "step",
    "step_each",
]

NOTHING, UPDATE, IDENTIFICATION, KEEP_ALIVE = range(4)
"""Kinds of decision; a keep-alive is a model update that silence, not error, called for."""

START_ORDER, START_KEEP, START_SURVIVOR, START_PREDICTED, START_HINDSIGHT, START_GUARDED, START_RECENT = (
    range(7)
)
"""Start rules; those from `START_PREDICTED` to `START_GUARDED` read scores."""

IDENTIFY_ON_FAILURE, IDENTIFY_FINAL, IDENTIFY_BEST, IDENTIFY_NEVER, IDENTIFY_CHEAPEST = range(5)

COST_HEADER = 4
"""Cost of an identification, cost a second of updates, number of ages, number of error shares."""

_TIME_SLACK_S = 1e-9
"""Sums of sampling steps may fall short of a whole number of seconds by rounding."""


@kernel(inlined=True)
def longest_silence_s(silence_s: float, approach_m: float, speed_mps: float) -> float:
    """Longest silence at a speed: two vehicles that meet come closer by no more than ``approach_m``."""
    if 2.0 * speed_mps * silence_s <= approach_m:
        return silence_s
    return 0.5 * approach_m / speed_mps


@kernel
def start_member(
    available: BoolVector, first_failure_s: FloatVector, scores: FloatVector, in_use: int, start: int
) -> int:
    """Sub-model to use after an update; -1 where none has a full window.

    ``scores`` (M,) say how long each is predicted to last if sent now, in any unit that rises with it; NaN
    where nothing is predicted. Rules from `START_PREDICTED` to `START_GUARDED` read them.
    """
    first = -1
    for m in range(available.size):
        if available[m]:
            first = m
            break
    if start == START_KEEP and in_use >= 0 and available[in_use]:
        return in_use
    chosen = first
    if start == START_SURVIVOR:
        longest_s = -1.0
        for m in range(available.size):
            if available[m] and first_failure_s[m] > longest_s:
                chosen, longest_s = m, first_failure_s[m]
    elif (
        start in (START_PREDICTED, START_HINDSIGHT, START_GUARDED) and first >= 0 and not isnan(scores[first])
    ):
        for m in range(first + 1, available.size):
            if available[m] and scores[m] > scores[chosen]:
                chosen = m
    return chosen


@kernel
def class_of(edges: FloatVector, value: float) -> int:
    """Class of a value between rising edges; a value at an edge belongs above it."""
    at = 0
    while at < edges.size and value >= edges[at]:
        at += 1
    return at


@kernel
def residual_life_s(costs: FloatVector, member: int, age_s: float, share: float) -> float:
    """How long a sub-model that holds now is expected to hold on, by its age and error over threshold.

    ``costs`` is `COST_HEADER` numbers, the upper edges of all age classes but the last, those of all share
    classes but the last, then the table (M, ages, shares) [s].
    """
    ages, shares = int(costs[2]), int(costs[3])
    middle = COST_HEADER + ages - 1
    table = middle + shares - 1
    row = class_of(costs[COST_HEADER:middle], age_s)
    column = class_of(costs[middle:table], share)
    return float(costs[table + (member * ages + row) * shares + column])


@kernel
def step(
    tracking_error_m: FloatVector,
    first_failure_s: FloatVector,
    in_use: int,
    age_s: float,
    silence_s: float,
    threshold_m: float,
    max_inter_transmit_time_s: float,
    identify: int,
    costs: FloatVector,
) -> tuple[int, int]:
    """Decide at one instant: (kind, sub-model in use afterwards). Writes ``first_failure_s`` (M,).

    After `UPDATE` and `KEEP_ALIVE` the sub-model is left as it was: `start_member` names the new one.
    ``tracking_error_m`` (M,) is the error now of every sub-model fitted at the last update, infinite where it
    had no full window then; ``costs`` are read by `IDENTIFY_CHEAPEST` alone.
    """
    best = -1
    best_error = np.inf
    for m in range(tracking_error_m.size):
        error = tracking_error_m[m]
        if error >= threshold_m:
            if first_failure_s[m] == np.inf:
                first_failure_s[m] = age_s
        elif error < best_error and (identify != IDENTIFY_FINAL or first_failure_s[m] == np.inf):
            best, best_error = m, error
    if best < 0:
        return UPDATE, in_use
    failed = tracking_error_m[in_use] >= threshold_m
    if failed and identify in (IDENTIFY_NEVER, IDENTIFY_CHEAPEST):
        longest_s = 0.0
        if identify == IDENTIFY_CHEAPEST:
            for m in range(tracking_error_m.size):
                error = tracking_error_m[m]
                if error < threshold_m:
                    life_s = residual_life_s(costs, m, age_s, error / threshold_m)
                    if life_s > longest_s:
                        best, longest_s = m, life_s
        if longest_s == 0.0 or costs[0] >= costs[1] * longest_s:
            return UPDATE, in_use
    if silence_s >= max_inter_transmit_time_s - _TIME_SLACK_S:
        return KEEP_ALIVE, in_use
    if identify == IDENTIFY_BEST:
        if best != in_use:
            return IDENTIFICATION, best
    elif failed:
        return IDENTIFICATION, best
    return NOTHING, in_use


@kernel(inlined=True)
def for_legacy(kind: int, error_m: float, threshold_m: float) -> int:
    """What is sent where legacy receivers are minded: an update where they err by a threshold or more.

    ``kind`` is what is sent else; ``error_m`` their error by what Part I of the last update states.
    """
    return kind if error_m < threshold_m or kind in (UPDATE, KEEP_ALIVE) else UPDATE


class Vehicles(NamedTuple):
    """B vehicles with a bank of M: what each sub-model does, (B, M), and what is in use since when, (B,).

    ``speed_mps`` (B,) bears on the longest silence alone; ``legacy_error_m`` (B,) is the error of legacy
    receivers, and calls for an update from ``legacy_m`` on.
    """

    tracking_error_m: FloatMatrix
    available: BoolMatrix
    scores: FloatMatrix
    in_use: IntVector
    age_s: FloatVector
    silence_s: FloatVector
    speed_mps: FloatVector
    legacy_error_m: FloatVector
    legacy_m: float


@kernel
def step_each(
    seen: Vehicles,
    first_failure_s: FloatMatrix,
    start: int,
    threshold_m: float,
    silence_s: float,
    approach_m: float,
    identify: int,
    costs: FloatVector,
    out_kind: IntVector,
    out_in_use: IntVector,
) -> None:
    """Decide for every vehicle, a row each; an update clears its row of ``first_failure_s`` (B, M)."""
    for row in range(seen.in_use.size):
        kind, member = step(
            seen.tracking_error_m[row],
            first_failure_s[row],
            seen.in_use[row],
            seen.age_s[row],
            seen.silence_s[row],
            threshold_m,
            longest_silence_s(silence_s, approach_m, seen.speed_mps[row]),
            identify,
            costs,
        )
        if seen.legacy_m < np.inf:
            kind = for_legacy(kind, seen.legacy_error_m[row], seen.legacy_m)
        if kind in (UPDATE, KEEP_ALIVE):
            member = start_member(
                seen.available[row], first_failure_s[row], seen.scores[row], seen.in_use[row], start
            )
            first_failure_s[row] = np.inf
        out_kind[row], out_in_use[row] = kind, member
