"""Compiled errors of all members of a bank over a trip, whatever was in use."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntVector
from modelcast.models.member_kernels import absorb_member
from modelcast.station.arrays import Fits, Sensed
from modelcast.station.sender.fitting_kernels import SenderModels, distance_to

__all__ = ["member_errors"]


@kernel(inlined=True)
def _take(
    models: SenderModels, s: Sensed, fits: Fits, at: int, member: int, origin: FloatVector, held: FloatVector
) -> None:
    """Take the update of sample ``at`` for what is held, (P,) and ``origin`` (3,).

    ``member`` is in use before and after it; -1 where that changes or nothing was held.
    """
    offsets = models.members.offsets
    stated_s, stated_m = s.stated_s[0, at], s.stated_m[0, at]
    origin[0] = stated_s - origin[0]
    origin[1], origin[2] = stated_m[0] - origin[1], stated_m[1] - origin[2]
    for m in range(offsets.size - 1):
        own = fits.parameters[0, at, offsets[m] : offsets[m + 1]]
        absorb_member(models.members, m, own, origin, m == member, held[offsets[m] : offsets[m + 1]])
    origin[0], origin[1], origin[2] = stated_s, stated_m[0], stated_m[1]


@kernel
def member_errors(
    models: SenderModels, s: Sensed, fits: Fits, in_use: IntVector, update_index: IntVector, out: FloatMatrix
) -> None:
    """Error at each sample of every member fitted at the update before it, into ``out`` (T, M).

    ``update_index`` (T,) is the last update at or before each sample, at the first there is none before;
    ``in_use`` (T,) the member in use then.
    """
    offsets = models.members.offsets
    scratch, origin, held = np.empty(2), np.zeros(3), np.zeros(offsets[-1])
    for i in range(update_index.size):
        before = update_index[i - 1] if i > 0 else -1
        if before >= 0 and before == i - 1:
            same = before > 0 and update_index[before - 1] >= 0 and in_use[before - 1] == in_use[before]
            _take(models, s, fits, before, in_use[before] if same else -1, origin, held)
        served = False
        for m in range(out.shape[1]):
            out[i, m] = np.inf
            if before < 0 or s.history[0, before] < models.members.windows[m]:
                continue
            if not (m == models.fallback and served):
                own = held[offsets[m] : offsets[m + 1]]
                out[i, m] = distance_to(models, m, own, origin, s.t_s[0, i], s.samples[0, i], scratch)
            served = True
