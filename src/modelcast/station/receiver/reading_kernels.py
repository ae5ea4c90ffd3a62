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

__all__ = [
    "FREE",
    "LEGACY",
    "MODEL",
    "FreeRule",
    "coast_by_member",
    "coast_freely",
    "coast_straight",
    "state_rates",
]

LEGACY, FREE, MODEL = range(3)

_MOST_PARAMETERS = 4


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
    out[2], out[3] = stated[0] * sin(stated[1]), stated[0] * cos(stated[1])
    out[0], out[1] = out[2] * age_s, out[3] * age_s
    out[BELIEF_SPEED], out[BELIEF_HEADING] = stated[0], stated[1]
    state_rates(stated, out)


@kernel(inlined=True)
def state_rates(stated: FloatVector, out: FloatVector) -> None:
    """Take the rates that Part I states for those believed: a path at constant velocity denies neither."""
    out[BELIEF_ACCELERATION], out[BELIEF_YAW_RATE] = stated[2], stated[3]


@kernel
def coast_freely(rule: FreeRule, stated: FloatVector, age_s: float, out: FloatVector) -> None:
    """Write `coast_by_member` of the free sub-model with the values that Part I states, ``stated`` (4,)."""
    own, values = np.empty(rule.places.size), np.empty(_MOST_PARAMETERS)
    values[0], values[1] = stated[0] * sin(stated[1]), stated[0] * cos(stated[1])
    values[2], values[3] = stated[2], stated[3]
    for i in range(own.size):
        own[i] = values[rule.places[i]]
    coast_by_member(rule.members, 0, own, age_s, stated[1], out)
