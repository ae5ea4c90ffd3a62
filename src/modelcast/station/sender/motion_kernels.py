"""Compiled Part I: what a message states of motion, as every receiver of it decodes it.

A sub-model whose parameters Part I carries says them itself; what it has not comes from the others that are
sent along, else from the newest sample (`modelcast.messages.station_codec.StationCodec.codes` makes the same
of octets). Only the position stands elsewhere.
"""

from math import atan2, cos, hypot, sin
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntMatrix, IntVector
from modelcast.messages.field_kernels import code_of, value_of
from modelcast.models.point_kernels import ACCELERATION, VELOCITY_EAST, VELOCITY_NORTH, YAW_RATE
from modelcast.station.arrays import Fits, Sensed
from modelcast.station.sensing.rates import NO_RATES_BELOW_MPS

__all__ = ["MOTION", "PartOne", "displace_straight", "state_motion"]

MOTION = 4
"""Speed [m/s], heading, clockwise from north [rad], acceleration along the course [m/s²], yaw rate, clockwise
[rad/s]."""

_SPEED, _HEADING, _ACCELERATION, _YAW_RATE = range(MOTION)
_CIRCLE = 2.0 * np.pi


class PartOne(NamedTuple):
    """How Part I carries motion.

    ``places`` (M, MOTION) says where in a row of all parameters stand each member's velocity east and north,
    acceleration and yaw rate, -1 where it has none; ``offsets`` (M + 1,) bounds each member's. ``meaning``
    (MOTION, 7) is what codes stand for (`modelcast.messages.field_kernels`); empty where nothing is rounded.
    """

    places: IntMatrix
    offsets: IntVector
    meaning: FloatMatrix


@kernel(inlined=True)
def displace_straight(stated: FloatVector, age_s: float, out: FloatVector) -> None:
    """Write how far who coasts speed and heading of Part I takes a remote to have come, ``out`` (2,).

    So does every legacy receiver; ``stated`` (MOTION,).
    """
    out[0], out[1] = stated[0] * sin(stated[1]) * age_s, stated[0] * cos(stated[1]) * age_s


@kernel(inlined=True)
def _who_says(part: PartOne, fits: Fits, at: tuple[int, int, int], m: int, which: int, others: bool) -> int:
    """Member that says one value where ``m`` is in use, -1 where the newest sample does.

    ``at`` is the vehicle, the place in the ring of fits and the number of the sample; one whose parameters
    are all zero says nothing of its own.
    """
    if part.places[m, which] >= 0:
        return m
    v, place, number = at
    if others:
        for n in range(part.places.shape[0]):
            if part.places[n, which] < 0 or fits.number[v, place, n] != number:
                continue
            for i in range(part.offsets[n], part.offsets[n + 1]):
                if fits.parameters[v, place, i] != 0.0:
                    return n
    return -1


@kernel(inlined=True)
def _decoded(value: float, meaning: FloatMatrix, which: int) -> float:
    """Return a value as Part I says it."""
    if meaning.shape[0] == 0:
        return value
    code, _ = code_of(value, meaning, which)
    return value_of(code, meaning, which)


@kernel(inlined=True)
def state_motion(
    part: PartOne, s: Sensed, fits: Fits, v: int, number: int, m: int, others: bool, out: FloatVector
) -> None:
    """Write what Part I of a message of a vehicle's sample states, ``out`` (MOTION,).

    ``m`` is the sub-model in use; ``others`` says whether all others that were fitted are sent along. The
    heading of a speed that rounds to nothing is the sample's.
    """
    sample = s.samples[v, number % s.stated_m.shape[1]]
    place = number % fits.parameters.shape[1]
    at = (v, place, number)
    east, north = sample[VELOCITY_EAST], sample[VELOCITY_NORTH]
    heading = atan2(east, north) if hypot(east, north) >= NO_RATES_BELOW_MPS else 0.0
    who = _who_says(part, fits, at, m, _SPEED, others)
    if who >= 0:
        east = fits.parameters[v, place, part.places[who, _SPEED]]
        north = fits.parameters[v, place, part.places[who, _HEADING]]
    out[_SPEED] = _decoded(hypot(east, north), part.meaning, _SPEED)
    if who >= 0 and out[_SPEED] != 0.0:
        heading = atan2(east, north)
    out[_HEADING] = _decoded(heading % _CIRCLE, part.meaning, _HEADING)
    out[_ACCELERATION], out[_YAW_RATE] = sample[ACCELERATION], sample[YAW_RATE]
    for which in (_ACCELERATION, _YAW_RATE):
        who = _who_says(part, fits, at, m, which, others)
        if who >= 0:
            out[which] = fits.parameters[v, place, part.places[who, which]]
        out[which] = _decoded(out[which], part.meaning, which)
