"""Compiled counting for selection: how long a prediction made at every sample of a trip would have lasted."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatCube, FloatMatrix, FloatVector, IntVector
from modelcast.models.member_kernels import Members, predict_member
from modelcast.models.point_kernels import EAST, NORTH
from modelcast.station.policy.error_driven_kernels import class_of

__all__ = ["count_residual", "survivals"]


@kernel
def survivals(
    members: Members,
    m: int,
    parameters: FloatMatrix,
    available: BoolVector,
    t_s: FloatVector,
    samples: FloatMatrix,
    thresholds_m: FloatVector,
    longest_s: float,
    out: FloatMatrix,
) -> None:
    """Write the age at which each sample's prediction by a member first reaches each threshold, (T, K) [s].

    ``parameters`` (T, P) are those fitted at every sample, ``available`` (T,) says where there was a full
    window: elsewhere the age is 0. ``thresholds_m`` (K,) rise. What holds for ``longest_s`` counts that; what
    the trip's end cuts off is NaN.
    """
    displacement = np.empty(2)
    count = t_s.size
    for i in range(count):
        if not available[i]:
            out[i, :] = 0.0
            continue
        at = 0
        for j in range(i + 1, count):
            age_s = t_s[j] - t_s[i]
            if age_s >= longest_s:
                break
            predict_member(members, m, parameters[i], age_s, displacement)
            east = samples[i, EAST] + displacement[0] - samples[j, EAST]
            north = samples[i, NORTH] + displacement[1] - samples[j, NORTH]
            error_m = np.sqrt(east * east + north * north)
            while at < thresholds_m.size and error_m >= thresholds_m[at]:
                out[i, at] = age_s
                at += 1
            if at == thresholds_m.size:
                break
        held = longest_s if t_s[count - 1] - t_s[i] >= longest_s else np.nan
        out[i, at:] = held


@kernel
def count_residual(
    members: Members,
    parameters: FloatMatrix,
    t_s: FloatVector,
    samples: FloatMatrix,
    update_index: IntVector,
    tracking_error_m: FloatMatrix,
    threshold_m: float,
    longest_s: float,
    age_edges_s: FloatVector,
    share_edges: FloatVector,
    total_s: FloatCube,
    count: FloatCube,
) -> None:
    """Add how long members held on that held where a walk under the rule ``never`` updated.

    ``update_index`` (T,) and ``tracking_error_m`` (T, M) are the walk's; ``total_s`` and ``count`` (M, ages,
    shares) are added to. What the trip's end cuts off is left out; ``longest_s`` bounds the rest.
    """
    displacement = np.empty(2)
    last = t_s.size - 1
    for i in range(1, t_s.size):
        if update_index[i] != i or t_s[last] - t_s[i] < longest_s:
            continue
        origin = update_index[i - 1]
        for m in range(count.shape[0]):
            if not tracking_error_m[i, m] < threshold_m:
                continue
            own = parameters[origin, members.offsets[m] : members.offsets[m + 1]]
            held_s = longest_s
            for j in range(i + 1, t_s.size):
                if t_s[j] - t_s[i] >= longest_s:
                    break
                age_s = t_s[j] - t_s[origin]
                predict_member(members, m, own, age_s, displacement)
                east = samples[origin, EAST] + displacement[0] - samples[j, EAST]
                north = samples[origin, NORTH] + displacement[1] - samples[j, NORTH]
                if np.sqrt(east * east + north * north) >= threshold_m:
                    held_s = t_s[j] - t_s[i]
                    break
            row = class_of(age_edges_s, t_s[i] - t_s[origin])
            column = class_of(share_edges, tracking_error_m[i, m] / threshold_m)
            total_s[m, row, column] += held_s
            count[m, row, column] += 1
