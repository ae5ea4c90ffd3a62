"""Compiled readings: how a remote moves by what Part I states, or by a member's parameters.

Motions are those of `belief_kernels`. What Part I states of motion is speed, heading, acceleration and yaw
rate (`modelcast.station.sender.motion_kernels`).
"""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector, IntVector
from modelcast.models.member_kernels import Members, predict_member
from modelcast.station.receiver.belief_kernels import (
    BELIEF_ACCELERATION,
    BELIEF_HEADING,
    BELIEF_SPEED,
    BELIEF_YAW_RATE,
    STEP_S,
    differentiate,
)
from modelcast.station.sender.motion_kernels import displace_straight

__all__ = [
    "FREE",
    "LEGACY",
    "MODEL",
    "MOST_PARAMETERS",
    "FreeRule",
    "coast_by_member",
    "coast_freely",
    "coast_straight",
    "displace_stated",
    "state_rates",
]

LEGACY, FREE, MODEL = range(3)

MOST_PARAMETERS = 4
"""Of a free sub-model: those that Part I carries."""


class FreeRule(NamedTuple):
    """How Part I is coasted: by the one of ``members``, whose P parameters Part I carries.

    ``places`` (P,) says which of velocity east and north, acceleration and yaw rate each parameter is.
    """

    members: Members
    places: IntVector


@kernel
def coast_by_member(
    members: Members, m: int, own: FloatVector, age_s: float, heading: float, out: FloatVector
) -> None:
    """Write how far a remote has come, and how it moves, ``out`` (BELIEF_COLUMNS,), by a member.

    ``own`` (P,) are the member's parameters, ``age_s`` since its fit; ``heading`` is the one stated, that of
    a standing remote. A path begins at its fit: up to one step after that it is differentiated at the step.
    """
    path = np.empty((3, 2))
    middle_s = max(age_s, STEP_S)
    for at in range(3):
        predict_member(members, m, own, middle_s + (at - 1) * STEP_S, path[at])
    differentiate(path, age_s - middle_s, heading, out)
    predict_member(members, m, own, age_s, path[0])
    out[0], out[1] = path[0, 0], path[0, 1]


@kernel(inlined=True)
def coast_straight(stated: FloatVector, age_s: float, out: FloatVector) -> None:
    """Write `coast_by_member` of constant velocity as Part I states it, ``stated`` (4,)."""
    displace_straight(stated, age_s, out)
    out[2], out[3] = stated[0] * sin(stated[1]), stated[0] * cos(stated[1])
    out[BELIEF_SPEED], out[BELIEF_HEADING] = stated[0], stated[1]
    state_rates(stated, out)


@kernel(inlined=True)
def state_rates(stated: FloatVector, out: FloatVector) -> None:
    """Take the rates that Part I states for those believed: a path at constant velocity denies neither."""
    out[BELIEF_ACCELERATION], out[BELIEF_YAW_RATE] = stated[2], stated[3]


@kernel(inlined=True)
def free_parameters(rule: FreeRule, stated: FloatVector, own: FloatVector) -> None:
    """Write the free sub-model's parameters as Part I states them, ``own`` (P,)."""
    for i in range(rule.places.size):
        which = rule.places[i]
        own[i] = stated[which]
        if which == 0:
            own[i] = stated[0] * sin(stated[1])
        elif which == 1:
            own[i] = stated[0] * cos(stated[1])


@kernel(inlined=True)
def displace_stated(
    rule: FreeRule, reading: int, stated: FloatVector, age_s: float, own: FloatVector, out: FloatVector
) -> None:
    """Write how far a remote has come by Part I, ``out`` (2,), as legacy and free receivers read it.

    ``own`` (`MOST_PARAMETERS`,) is overwritten.
    """
    if reading == FREE:
        free_parameters(rule, stated, own)
        predict_member(rule.members, 0, own[: rule.places.size], age_s, out)
        return
    displace_straight(stated, age_s, out)


@kernel
def coast_freely(rule: FreeRule, stated: FloatVector, age_s: float, out: FloatVector) -> None:
    """Write `coast_by_member` of the free sub-model with the values that Part I states, ``stated`` (4,)."""
    own = np.empty(rule.places.size)
    free_parameters(rule, stated, own)
    coast_by_member(rule.members, 0, own, age_s, stated[1], out)
