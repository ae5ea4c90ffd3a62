"""Compiled fitting: a sub-model's parameters as its receivers hold them, once for every sample and member."""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntVector
from modelcast.messages.codes_kernels import quantise_parameters
from modelcast.models.member_kernels import Members, fit_member, predict_member
from modelcast.models.point_kernels import EAST, NORTH
from modelcast.station.arrays import Fits, Sensed
from modelcast.station.sender.motion_kernels import PartOne

__all__ = ["SenderModels", "distance_to", "fit", "fit_each"]


class SenderModels(NamedTuple):
    """Sub-models of a sender.

    ``members`` (M); ``table`` (P, `codes_kernels.COLUMNS`) of what a message can say of their parameters,
    empty where receivers hold them as they were fitted; ``sizes`` (M,) of an update by the one in use
    [bytes]. ``fallback`` is the member that serves only for want of another, ``guard`` constant
    velocity where lanes are guarded, ``free`` the plain sub-model that other plain ones must clearly
    outdo under timers; -1 for none. ``selector`` is the address of the function that
    predicts which member lasts, 0 for none, and ``selector_window`` the samples it looks at. ``dt_s`` is the
    sampling interval, ``part_one`` how messages carry motion.
    """

    members: Members
    table: FloatMatrix
    sizes: IntVector
    fallback: int
    guard: int
    free: int
    selector: int
    selector_window: int
    dt_s: float
    part_one: PartOne


@kernel(inlined=True)
def fit(models: SenderModels, s: Sensed, fits: Fits, v: int, number: int, m: int) -> bool:
    """Fit a member that has a full window at a sample of a vehicle, unless that is done; whether it could be.

    Its parameters are written as its receivers hold them. Where one is not a number, the fit failed.
    """
    place = number % fits.parameters.shape[1]
    if fits.number[v, place, m] == number:
        return True
    members = models.members
    end = number % s.stated_m.shape[1] + s.stated_m.shape[1] + 1
    first, last = members.offsets[m], members.offsets[m + 1]
    out = fits.parameters[v, place, first:last]
    fit_member(members, m, s.samples[v, end - members.windows[m] : end], out)
    failed = -1
    if models.table.shape[0] > 0:
        failed = quantise_parameters(models.table[first:last], out, fits.codes[v, place, first:last], out)
    else:
        for i in range(out.size):
            if np.isnan(out[i]):
                failed = i
    if failed >= 0:
        return False
    fits.number[v, place, m] = number
    return True


@kernel
def fit_each(models: SenderModels, s: Sensed, fits: Fits, numbers: IntVector) -> None:
    """Fit every member that has a full window at the given samples of the first vehicle."""
    for number in numbers:
        for m in range(models.members.windows.size):
            if s.history[0, number % s.stated_m.shape[1]] < models.members.windows[m]:
                continue
            if not fit(models, s, fits, 0, number, m):
                fits.parameters[0, number % fits.parameters.shape[1], models.members.offsets[m]] = np.nan


@kernel(inlined=True)
def distance_to(
    models: SenderModels,
    m: int,
    parameters: FloatVector,
    origin: FloatVector,
    t_s: float,
    sample: FloatVector,
    scratch: FloatVector,
) -> float:
    """Distance between a sample and where a member predicts it [m].

    ``parameters`` (P,) are the member's own, ``origin`` (3,) its instant and position; ``scratch`` (2,) is
    overwritten.
    """
    predict_member(models.members, m, parameters, t_s - origin[0], scratch)
    east = origin[1] + scratch[0] - sample[EAST]
    north = origin[2] + scratch[1] - sample[NORTH]
    return np.sqrt(east * east + north * north)
