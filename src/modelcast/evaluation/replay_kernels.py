"""Compiled replay of what a host held at every sample of a trip, given what was sent and what was lost."""

from typing import Any

import numba
import numpy as np

from modelcast.models.point_kernels import EAST, NORTH
from modelcast.models.trusted_kernels import predict_trusted
from modelcast.policy.error_driven_kernels import IDENTIFICATION, NOTHING

__all__ = ["replay"]

_TIME_SLACK_S = 1e-9


@numba.njit(cache=True, nogil=True)
def replay(
    predicts: Any,
    constants: Any,
    offsets: Any,
    trust: Any,
    t_s: Any,
    samples: Any,
    parameters: Any,
    truth_m: Any,
    direction: Any,
    kind: Any,
    in_use: Any,
    update_index: Any,
    lost: Any,
    delay_s: float,
    expiry_s: float,
    errors: Any,
    gaps_s: Any,
    gap_count: Any,
) -> None:
    """Replay R runs over one trip of T samples.

    ``kind``, ``in_use`` and ``update_index`` are S schedules, (S, T); run r follows schedule r modulo S.
    ``lost`` (R, T) says which instants' messages never arrive; ``truth_m`` (T, 2) and the unit vectors
    ``direction`` (T, 2) are joined only here. Writes ``errors`` (5, R, T): the tracking error after and
    before the instant's message, its parts along and across the track, and the age of the model held, all
    NaN where the host holds nothing (nothing came yet, or it expired). ``gaps_s`` (R, T) receives the gaps
    between receptions of each run and ``gap_count`` (R,) their number.
    """
    runs, count = lost.shape
    displacement = np.empty(2)
    for run in range(runs):
        schedule = run % kind.shape[0]
        held = -1
        # Slices and tuple items are taken once a message, not once a sample: each costs reference counts.
        own = parameters[0, :0]
        predict = predicts[0]
        table = constants[0]
        trusted_s, turn_s = trust[0, 0], trust[0, 1]
        received_s = -np.inf
        arriving = 0
        written = 0
        for j in range(count):
            first_arrival = arriving
            while arriving <= j and t_s[arriving] + delay_s <= t_s[j] + _TIME_SLACK_S:
                arriving += 1
            before = np.nan
            touched = False
            for i in range(first_arrival, arriving):
                if kind[schedule, i] == NOTHING or lost[run, i]:
                    continue
                if not touched and held >= 0 and t_s[j] - received_s <= expiry_s:
                    predict_trusted(predict, own, t_s[j] - t_s[held], table, trusted_s, turn_s, displacement)
                    east = samples[held, EAST] + displacement[0] - truth_m[j, 0]
                    north = samples[held, NORTH] + displacement[1] - truth_m[j, 1]
                    before = np.sqrt(east * east + north * north)
                touched = True
                arrival_s = t_s[i] + delay_s
                if arrival_s - received_s > expiry_s:
                    held = -1  # an expired remote is forgotten: only an update brings it back
                if received_s > -np.inf:
                    gaps_s[run, written] = arrival_s - received_s
                    written += 1
                received_s = arrival_s
                if kind[schedule, i] != IDENTIFICATION:
                    held = i
                elif held != update_index[schedule, i]:
                    continue  # one that names an update the host never got tells it nothing
                member = in_use[schedule, i]
                own = parameters[held, offsets[member] : offsets[member + 1]]
                predict = predicts[member]
                table = constants[member]
                trusted_s, turn_s = trust[member, 0], trust[member, 1]
            if held < 0 or t_s[j] - received_s > expiry_s:
                errors[:, run, j] = np.nan
                continue
            predict_trusted(predict, own, t_s[j] - t_s[held], table, trusted_s, turn_s, displacement)
            east = samples[held, EAST] + displacement[0] - truth_m[j, 0]
            north = samples[held, NORTH] + displacement[1] - truth_m[j, 1]
            after = np.sqrt(east * east + north * north)
            errors[0, run, j] = after
            errors[1, run, j] = before if touched else after
            errors[2, run, j] = east * direction[j, 0] + north * direction[j, 1]
            errors[3, run, j] = north * direction[j, 0] - east * direction[j, 1]
            errors[4, run, j] = t_s[j] - t_s[held]
        gap_count[run] = written
