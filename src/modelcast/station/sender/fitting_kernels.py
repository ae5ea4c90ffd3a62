"""Compiled fitting: a sub-model's parameters as its receivers hold them, once for every sample and member."""

from math import atan2, cos, hypot, sin
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntVector
from modelcast.models.member_kernels import Members, fit_member, predict_member
from modelcast.models.point_kernels import EAST, NORTH
from modelcast.station.arrays import Fits, Sensed

__all__ = ["Codes", "SenderModels", "coded", "distance_to", "fit", "fit_each"]


class Codes(NamedTuple):
    """What a message can say of P parameters of M members.

    ``fields`` (P, 3): step (0: as it is), lowest and highest code; ``velocity`` (M,) where the velocity of
    each member begins among its parameters, -1 for none; ``polar`` (3,) step [m/s] and last code of the
    speed, step of the heading [rad].
    """

    fields: FloatMatrix
    velocity: IntVector
    polar: FloatVector


class SenderModels(NamedTuple):
    """Sub-models of a sender.

    ``members`` (M); their ``codes``; ``sizes`` (M,) of an update by the sub-model in use [bytes].
    ``fallback`` is the member that serves only for want of another, ``guard`` the one that serves where the
    bank has fallen behind it; -1 for none. ``selector`` is the address of the function that predicts which
    member lasts, 0 for none, and ``selector_window`` the samples it looks at. ``dt_s`` is the sampling
    interval.
    """

    members: Members
    codes: Codes
    sizes: IntVector
    fallback: int
    guard: int
    selector: int
    selector_window: int
    dt_s: float


@kernel
def coded(codes: Codes, m: int, first: int, parameters: FloatVector) -> None:
    """Put a member's parameters (P,), whose codes stand from ``first`` on, where their codes put them."""
    for i in range(parameters.size):
        step = codes.fields[first + i, 0]
        if step > 0.0:
            low, high = codes.fields[first + i, 1], codes.fields[first + i, 2]
            parameters[i] = min(max(np.rint(parameters[i] / step), low), high) * step
    velocity = codes.velocity[m]
    if velocity >= 0 and codes.polar[0] > 0.0:
        east, north = parameters[velocity], parameters[velocity + 1]
        speed = min(np.rint(hypot(east, north) / codes.polar[0]), codes.polar[1]) * codes.polar[0]
        heading = np.rint(atan2(east, north) / codes.polar[2]) * codes.polar[2]
        parameters[velocity], parameters[velocity + 1] = speed * sin(heading), speed * cos(heading)


@kernel(inlined=True)
def fit(models: SenderModels, s: Sensed, fits: Fits, v: int, number: int, m: int) -> None:
    """Fit a member that has a full window at a sample of a vehicle, unless that is done."""
    place = number % fits.parameters.shape[1]
    if fits.number[v, place, m] == number:
        return
    members = models.members
    end = number % s.stated_m.shape[1] + s.stated_m.shape[1] + 1
    first, last = members.offsets[m], members.offsets[m + 1]
    out = fits.parameters[v, place, first:last]
    fit_member(members, m, s.samples[v, end - members.windows[m] : end], out)
    coded(models.codes, m, first, out)
    fits.number[v, place, m] = number


@kernel
def fit_each(models: SenderModels, s: Sensed, fits: Fits, numbers: IntVector) -> None:
    """Fit every member that has a full window at the given samples of the first vehicle."""
    for number in numbers:
        for m in range(models.members.windows.size):
            if s.history[0, number % s.stated_m.shape[1]] >= models.members.windows[m]:
                fit(models, s, fits, 0, number, m)


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
