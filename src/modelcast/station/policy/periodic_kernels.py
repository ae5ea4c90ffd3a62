"""Compiled sending at a fixed rate: the step that batch and fleet engine both call."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatVector

__all__ = ["step", "step_each"]

_TIME_SLACK_S = 1e-9
"""Sums of periods may pass a sample time by rounding."""


@kernel
def step(due_s: float, t_s: float, period_s: float, uniform: float) -> tuple[bool, float]:
    """Decide at one instant: (whether to send, when the next message falls due).

    ``due_s`` is minus infinity before the first message; ``uniform`` in [0, 1) is its phase.
    """
    if due_s == -np.inf:
        return True, t_s + period_s * (1.0 - uniform)
    if t_s < due_s - _TIME_SLACK_S:
        return False, due_s
    # All that fell due by now leave as one message: a gap in the samples must not end in a burst.
    passed = np.floor((t_s - due_s + _TIME_SLACK_S) / period_s) + 1.0
    return True, due_s + passed * period_s


@kernel
def step_each(
    due_s: FloatVector,
    t_s: FloatVector,
    period_s: float,
    uniform: FloatVector,
    out_send: BoolVector,
    out_due_s: FloatVector,
) -> None:
    """Decide for every vehicle, all arrays (B,)."""
    for row in range(due_s.size):
        out_send[row], out_due_s[row] = step(due_s[row], t_s[row], period_s, uniform[row])
