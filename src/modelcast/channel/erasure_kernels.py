"""Compiled walk of the Gilbert-Elliott chain."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatVector

__all__ = ["burst_losses"]


@kernel
def burst_losses(t_s: FloatVector, uniform: FloatVector, ratio: float, relaxation_s: float) -> BoolVector:
    """State of the chain at every instant: True in the bad state, (T,)."""
    lost = np.empty(t_s.size, dtype=np.bool_)
    chance = ratio
    for j in range(t_s.size):
        if j > 0:
            memory = np.exp(-(t_s[j] - t_s[j - 1]) / relaxation_s)
            chance = ratio + ((1.0 if lost[j - 1] else 0.0) - ratio) * memory
        lost[j] = uniform[j] < chance
    return lost
