"""Compiled errors of all members of a bank over a trip, whatever was in use."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, IntVector
from modelcast.station.arrays import Fits, Sensed
from modelcast.station.sender.fitting_kernels import SenderModels, distance_to

__all__ = ["member_errors"]


@kernel
def member_errors(
    models: SenderModels, s: Sensed, fits: Fits, update_index: IntVector, out: FloatMatrix
) -> None:
    """Error at each sample of every member fitted at the update before it, into ``out`` (T, M).

    ``update_index`` (T,) is the last update at or before each sample; at the first there is none before.
    """
    scratch, origin = np.empty(2), np.empty(3)
    count = update_index.size
    offsets = models.members.offsets
    for i in range(count):
        before = update_index[i - 1] if i > 0 else -1
        served = False
        for m in range(out.shape[1]):
            out[i, m] = np.inf
            if before < 0 or s.history[0, before] < models.members.windows[m]:
                continue
            if not (m == models.fallback and served):
                origin[0] = s.stated_s[0, before]
                origin[1], origin[2] = s.stated_m[0, before, 0], s.stated_m[0, before, 1]
                own = fits.parameters[0, before, offsets[m] : offsets[m + 1]]
                out[i, m] = distance_to(models, m, own, origin, s.t_s[0, i], s.samples[0, i], scratch)
            served = True
