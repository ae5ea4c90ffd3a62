"""Compiled look-up of an error model's hazard."""

import numpy as np

from modelcast.channel.error_models import HAZARD_MIN_DB, HAZARD_PER_DB, HAZARD_SIZE
from modelcast.channel.frame_errors import CELLS, GROUP, FrameErrors
from modelcast.core.exponential_kernels import fast_log
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector

__all__ = ["hazard_at", "survives"]

_DB_PER_LN = 10.0 / np.log(10.0)
_HIGHEST = 10.0 ** (0.1 * (HAZARD_MIN_DB + (HAZARD_SIZE - 1) / HAZARD_PER_DB))


@kernel(inlined=True)
def hazard_at(ratio: float, table: FloatVector) -> float:
    """Return the hazard of a unit at a power ratio."""
    if ratio >= _HIGHEST:
        return table[HAZARD_SIZE - 1]
    at = (fast_log(ratio) * _DB_PER_LN - HAZARD_MIN_DB) * HAZARD_PER_DB
    if at <= 0.0:
        return table[0]
    if at >= HAZARD_SIZE - 1:
        return table[HAZARD_SIZE - 1]
    k = int(at)
    return table[k] + (at - k) * (table[k + 1] - table[k])


@kernel(inlined=True)
def survives(ratio: float, chance: float, size_bytes: int, errors: FrameErrors) -> bool:
    """Return whether a frame of so many bytes is received at a power ratio with a chance in 0..1."""
    group, cell = size_bytes // GROUP, int(chance * CELLS)
    if ratio >= errors.certain[group, cell, 0]:
        return True
    if ratio < errors.certain[group, cell, 1]:
        return False
    return bool(errors.units[size_bytes] * hazard_at(ratio, errors.hazard) <= -np.log(1.0 - chance))
