"""Algorithm 1 of the paper, once: the compiled step that trip walker and fleet engine both call."""

from typing import Any

import numba
import numpy as np

__all__ = [
    "IDENTIFICATION",
    "IDENTIFY_BEST",
    "IDENTIFY_FINAL",
    "IDENTIFY_NEVER",
    "IDENTIFY_ON_FAILURE",
    "KEEP_ALIVE",
    "NOTHING",
    "START_KEEP",
    "START_ORDER",
    "START_SURVIVOR",
    "UPDATE",
    "start_member",
    "step",
    "step_each",
]

NOTHING, UPDATE, IDENTIFICATION, KEEP_ALIVE = range(4)
"""Kinds of decision; a keep-alive is a model update that silence, not error, called for."""

START_ORDER, START_KEEP, START_SURVIVOR = range(3)
IDENTIFY_ON_FAILURE, IDENTIFY_FINAL, IDENTIFY_BEST, IDENTIFY_NEVER = range(4)

_TIME_SLACK_S = 1e-9
"""Sums of sampling steps may fall short of a whole number of seconds by rounding."""


@numba.njit(cache=True, nogil=True)
def start_member(available: Any, first_failure_s: Any, in_use: int, start: int) -> int:
    """Sub-model to use after an update; -1 where none has a full window."""
    first = -1
    for m in range(available.size):
        if available[m]:
            first = m
            break
    if start == START_KEEP and in_use >= 0 and available[in_use]:
        return in_use
    if start == START_SURVIVOR:
        chosen, longest = first, -1.0
        for m in range(available.size):
            if available[m] and first_failure_s[m] > longest:
                chosen, longest = m, first_failure_s[m]
        return chosen
    return first


@numba.njit(cache=True, nogil=True)
def step(
    tracking_error_m: Any,
    available: Any,
    first_failure_s: Any,
    in_use: int,
    age_s: float,
    silence_s: float,
    threshold_m: float,
    max_inter_transmit_time_s: float,
    start: int,
    identify: int,
) -> tuple[int, int]:
    """Decide at one instant: (kind, sub-model in use afterwards). Writes ``first_failure_s`` (M,).

    ``tracking_error_m`` (M,) is the error now of every sub-model fitted at the last update, infinite where it
    had no full window then; ``available`` (M,) says which have a full window now.
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
    if best < 0 or (identify == IDENTIFY_NEVER and tracking_error_m[in_use] >= threshold_m):
        return UPDATE, start_member(available, first_failure_s, in_use, start)
    if silence_s >= max_inter_transmit_time_s - _TIME_SLACK_S:
        return KEEP_ALIVE, start_member(available, first_failure_s, in_use, start)
    if identify == IDENTIFY_BEST:
        if best != in_use:
            return IDENTIFICATION, best
    elif tracking_error_m[in_use] >= threshold_m:
        return IDENTIFICATION, best
    return NOTHING, in_use


@numba.njit(cache=True, nogil=True)
def step_each(
    tracking_error_m: Any,
    available: Any,
    first_failure_s: Any,
    in_use: Any,
    age_s: Any,
    silence_s: Any,
    threshold_m: float,
    max_inter_transmit_time_s: float,
    start: int,
    identify: int,
    out_kind: Any,
    out_in_use: Any,
) -> None:
    """Decide for every vehicle, a row each; an update clears its row of ``first_failure_s`` (B, M)."""
    for row in range(in_use.size):
        kind, member = step(
            tracking_error_m[row],
            available[row],
            first_failure_s[row],
            in_use[row],
            age_s[row],
            silence_s[row],
            threshold_m,
            max_inter_transmit_time_s,
            start,
            identify,
        )
        if kind in (UPDATE, KEEP_ALIVE):
            first_failure_s[row] = np.inf
        out_kind[row], out_in_use[row] = kind, member
