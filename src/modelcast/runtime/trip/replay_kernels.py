"""Compiled replay of what a host held at every sample of a trip, given what was sent and what was lost."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    BoolMatrix,
    FloatCube,
    FloatMatrix,
    FloatVector,
    IntMatrix,
    IntVector,
)
from modelcast.models.member_kernels import Members, predict_member
from modelcast.station.policy.error_driven_kernels import IDENTIFICATION, NOTHING

__all__ = ["replay"]

_TIME_SLACK_S = 1e-9


@kernel
def replay(
    members: Members,
    t_s: FloatVector,
    stated_m: FloatMatrix,
    parameters: FloatMatrix,
    truth_m: FloatMatrix,
    direction: FloatMatrix,
    kind: IntMatrix,
    in_use: IntMatrix,
    update_index: IntMatrix,
    lost: BoolMatrix,
    delay_s: float,
    expiry_s: float,
    errors: FloatCube,
    gaps_s: FloatMatrix,
    gap_count: IntVector,
) -> None:
    """Replay R runs over one trip of T samples.

    ``kind``, ``in_use`` and ``update_index`` are S schedules, (S, T); run r follows schedule r modulo S.
    ``lost`` (R, T) says which instants' messages never arrive; ``truth_m`` (T, 2) and the unit vectors
    ``direction`` (T, 2) are joined only here. Writes ``errors`` (5, R, T): the tracking error after and
    before the instant's message, its parts along and across the track, and the age of the model held, all
    NaN where the host holds nothing (nothing came yet, or it expired). ``stated_m`` (T, 2) are the positions
    that messages state. ``gaps_s`` (R, T) receives the gaps
    between receptions of each run and ``gap_count`` (R,) their number.
    """
    runs, count = lost.shape
    displacement = np.empty(2)
    for run in range(runs):
        schedule = run % kind.shape[0]
        held = -1
        # The slice is taken once a message, not once a sample: it costs a reference count.
        own = parameters[0, :0]
        member = 0
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
                    predict_member(members, member, own, t_s[j] - t_s[held], displacement)
                    east = stated_m[held, 0] + displacement[0] - truth_m[j, 0]
                    north = stated_m[held, 1] + displacement[1] - truth_m[j, 1]
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
                own = parameters[held, members.offsets[member] : members.offsets[member + 1]]
            if held < 0 or t_s[j] - received_s > expiry_s:
                errors[:, run, j] = np.nan
                continue
            predict_member(members, member, own, t_s[j] - t_s[held], displacement)
            east = stated_m[held, 0] + displacement[0] - truth_m[j, 0]
            north = stated_m[held, 1] + displacement[1] - truth_m[j, 1]
            after = np.sqrt(east * east + north * north)
            errors[0, run, j] = after
            errors[1, run, j] = before if touched else after
            errors[2, run, j] = east * direction[j, 0] + north * direction[j, 1]
            errors[3, run, j] = north * direction[j, 0] - east * direction[j, 1]
            errors[4, run, j] = t_s[j] - t_s[held]
        gap_count[run] = written
