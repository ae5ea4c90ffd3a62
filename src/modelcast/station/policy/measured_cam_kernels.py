"""Compiled sending at intervals that follow a Markov chain, under congestion control."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatMatrix, FloatVector
from modelcast.core.markov_kernels import next_state
from modelcast.station.policy import dcc_kernels

__all__ = ["LAST_S", "STATE", "STATE_COLUMNS", "step_each"]

LAST_S, STATE = range(2)
"""Columns of a vehicle's state: when it sent last, and the chain's state, which is the interval since."""

STATE_COLUMNS = 2

_TIME_SLACK_S = 1e-9


@kernel
def step_each(
    rows: FloatMatrix,
    control_rows: FloatMatrix,
    control: int,
    seen: tuple[FloatVector, FloatVector, FloatVector],
    intervals_s: FloatVector,
    up_to: FloatMatrix,
    control_constants: FloatVector,
    uniform: FloatVector,
    out_send: BoolVector,
) -> None:
    """Decide for every vehicle, ``out_send`` (B,); ``rows`` (B, 2) and ``control_rows`` (B, 5) are written.

    ``seen`` are time, channel busy ratio and airtime of the message, (B,) each; ``control`` is one of the
    codes of `dcc_kernels`; ``uniform`` (B,) in [0, 1).
    """
    t_s, busy_ratio, airtime_s = seen
    longest_s = intervals_s[intervals_s.size - 1]
    for i in range(t_s.size):
        shortest_s = 0.0
        if control != dcc_kernels.NONE:
            asked_s = dcc_kernels.step(
                control_rows[i], control, t_s[i], busy_ratio[i], airtime_s[i], control_constants
            )
            shortest_s = min(asked_s, longest_s)
        row = rows[i]
        out_send[i] = row[LAST_S] == -np.inf
        if not out_send[i]:
            interval_s = max(intervals_s[int(row[STATE])], shortest_s)
            out_send[i] = t_s[i] - row[LAST_S] >= interval_s - _TIME_SLACK_S
        if out_send[i]:
            row[LAST_S] = t_s[i]
            row[STATE] = next_state(int(row[STATE]), uniform[i], up_to)
