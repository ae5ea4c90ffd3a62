"""Compiled walks over one recorded trip: the sender's policy, and the baseline's messages alone."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatMatrix, FloatVector, IntVector
from modelcast.models.address_kernels import fit_at
from modelcast.models.member_kernels import Members, fit_member, predict_member
from modelcast.models.point_kernels import EAST, NORTH
from modelcast.station.policy.error_driven_kernels import (
    KEEP_ALIVE,
    NOTHING,
    START_GUARDED,
    START_HINDSIGHT,
    START_PREDICTED,
    UPDATE,
    start_member,
    step,
)
from modelcast.station.policy.guard_kernels import falls_back
from modelcast.station.policy.hindsight_kernels import LAGS_S, MARGIN, log_life

__all__ = ["fit_each", "walk"]


@kernel
def _fit_members(
    members: Members,
    samples: FloatMatrix,
    history: int,
    i: int,
    parameters: FloatMatrix,
    fitted: BoolVector,
) -> None:
    """Fit, once, every member that has a full window at sample ``i``."""
    if fitted[i]:
        return
    for m in range(members.windows.size):
        if history >= members.windows[m]:
            window = samples[i - members.windows[m] + 1 : i + 1]
            fit_member(members, m, window, parameters[i, members.offsets[m] : members.offsets[m + 1]])
    fitted[i] = True


@kernel
def fit_each(
    members: Members,
    samples: FloatMatrix,
    segment_start: IntVector,
    indices: IntVector,
    parameters: FloatMatrix,
    fitted: BoolVector,
) -> None:
    """Fit every member at the given samples into the memo ``parameters`` (T, P), ``fitted`` (T,)."""
    for i in indices:
        history = i - segment_start[i] + 1
        _fit_members(members, samples, history, i, parameters, fitted)


@kernel
def _hindsight(
    members: Members,
    available: BoolVector,
    t_s: FloatVector,
    samples: FloatMatrix,
    history: int,
    i: int,
    dt_s: float,
    parameters: FloatMatrix,
    fitted: BoolVector,
    threshold_m: float,
    scores: FloatVector,
) -> None:
    """Score the members (M,) by what they would have predicted a moment ago; NaN where nothing can be said.

    A lag counts where every member available now had a full window then, in the same part of the trip.
    """
    longest = 1
    for m in range(members.windows.size):
        if available[m]:
            longest = max(longest, members.windows[m])
    scores[:] = 0.0
    displacement = np.empty(2)
    count, before = 0, 0
    for lag_s in LAGS_S:
        back = max(int(lag_s / dt_s + 0.5), 1)
        if back == before or history - back < longest:
            continue
        before = back
        j = i - back
        age_s = t_s[i] - t_s[j]
        _fit_members(members, samples, history - back, j, parameters, fitted)
        for m in range(members.windows.size):
            if available[m]:
                own = parameters[j, members.offsets[m] : members.offsets[m + 1]]
                predict_member(members, m, own, age_s, displacement)
                east = samples[j, EAST] + displacement[0] - samples[i, EAST]
                north = samples[j, NORTH] + displacement[1] - samples[i, NORTH]
                scores[m] += log_life(age_s, np.sqrt(east * east + north * north), threshold_m)
        count += 1
    for m in range(members.windows.size):
        scores[m] = scores[m] / count if count and available[m] else np.nan
    scores[0] += MARGIN


@kernel
def walk(
    members: Members,
    fallback: int,
    guard: int,
    free_sends: BoolVector,
    guard_sends: BoolVector,
    t_s: FloatVector,
    samples: FloatMatrix,
    segment_start: IntVector,
    parameters: FloatMatrix,
    fitted: BoolVector,
    select: int,
    select_constants: FloatVector,
    select_window: int,
    dt_s: float,
    start: int,
    threshold_m: float,
    max_inter_transmit_time_s: float,
    identify: int,
    costs: FloatVector,
    tracking_error_m: FloatMatrix,
    kind: IntVector,
    in_use: IntVector,
    update_index: IntVector,
) -> None:
    """Walk one trip with the error-driven policy.

    ``members`` are the bank's; ``fallback`` is the last one where that serves only for want of another, else
    -1; ``guard`` the one that serves where `falls_back` says so, with ``free_sends`` and ``guard_sends``
    (T,) whether the same bank unguarded, and that member alone, would send; -1 for none. ``parameters`` (T,
    P) and ``fitted`` (T,) are the memo of fits by instant, shared by all walks over the trip and bank.
    ``select`` is the address of the selector, which, with its constants and its window, scores the members
    at an update where ``start`` asks for it; in hindsight they are scored by fits some multiples of ``dt_s``
    ago. Writes, for every sample, the members' errors before its message ``tracking_error_m`` (T, M), the
    message ``kind`` (T,), and the sub-model ``in_use`` (T,) and index of its update ``update_index`` (T,)
    after the message.
    """
    count = members.windows.size
    available = np.empty(count, dtype=np.bool_)
    usable = np.zeros(count, dtype=np.bool_)
    first_failure_s = np.full(count, np.inf)
    displacement = np.empty(2)
    errors = np.empty(count)
    scores = np.full(count, np.nan)
    current = -1
    last_update = 0
    last_message = 0
    behind, lead = 0, 0
    for i in range(t_s.size):
        history = i - segment_start[i] + 1
        served = False
        for m in range(count):
            available[m] = history >= members.windows[m] and not (m == fallback and served)
            served = served or available[m]
            error = np.inf
            if usable[m]:
                own = parameters[last_update, members.offsets[m] : members.offsets[m + 1]]
                age_s = t_s[i] - t_s[last_update]
                predict_member(members, m, own, age_s, displacement)
                east = samples[last_update, EAST] + displacement[0] - samples[i, EAST]
                north = samples[last_update, NORTH] + displacement[1] - samples[i, NORTH]
                error = np.sqrt(east * east + north * north)
            errors[m] = error
            tracking_error_m[i, m] = error
        sent = UPDATE
        if i > 0:
            sent, current = step(
                errors,
                first_failure_s,
                current,
                t_s[i] - t_s[last_update],
                t_s[i] - t_s[last_message],
                threshold_m,
                max_inter_transmit_time_s,
                identify,
                costs,
            )
        if guard >= 0:
            if guard_sends[i] and sent == NOTHING and current == guard and falls_back(behind, lead):
                sent = UPDATE  # in step with it from now on
            behind += int(sent != NOTHING) - int(guard_sends[i])
            lead += int(guard_sends[i]) - int(free_sends[i])
        if sent != NOTHING:
            last_message = i
        if sent in (UPDATE, KEEP_ALIVE):
            last_update = i
            if start == START_PREDICTED:
                first = max(i - select_window + 1, segment_start[i])
                fit_at(select, samples[first : i + 1], select_constants, scores)
            elif start in (START_HINDSIGHT, START_GUARDED):
                _hindsight(
                    members,
                    available,
                    t_s,
                    samples,
                    history,
                    i,
                    dt_s,
                    parameters,
                    fitted,
                    threshold_m,
                    scores,
                )
            current = start_member(available, first_failure_s, scores, current, start)
            if guard >= 0 and falls_back(behind, lead):
                current = guard
            for m in range(count):
                usable[m] = available[m]
                first_failure_s[m] = np.inf
            _fit_members(members, samples, history, i, parameters, fitted)
        kind[i] = sent
        in_use[i] = current
        update_index[i] = last_update
