"""Compiled tracking error of a sender against what its remotes are believed to hold.

The estimator is a point function of any sub-model: constant velocity with the velocity as parameters is the
coasting of basic safety messages, any other is model-based communication.
"""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector
from modelcast.models.member_kernels import Members, predict_member
from modelcast.station.policy.j2945_kernels import (
    LOCAL_AS_IS_AGE_S,
    LOCAL_MAX_AGE_S,
    REMOTE_AS_IS_AGE_S,
    REMOTE_MAX_AGE_S,
)

__all__ = [
    "LOCAL_COLUMNS",
    "LOCAL_EAST_M",
    "LOCAL_NORTH_M",
    "LOCAL_S",
    "LOCAL_VELOCITY_EAST_MPS",
    "LOCAL_VELOCITY_NORTH_MPS",
    "coast",
    "tracking_error",
    "tracking_error_of_model",
]

LOCAL_S, LOCAL_EAST_M, LOCAL_NORTH_M, LOCAL_VELOCITY_EAST_MPS, LOCAL_VELOCITY_NORTH_MPS = range(5)
"""Columns of what a vehicle last measured of itself: time, position, velocity."""

LOCAL_COLUMNS = 5

_TIME_SLACK_S = 1e-9
"""Differences of times may miss an age by rounding."""


@kernel
def coast(t_s: float, state: FloatVector) -> tuple[float, float]:
    """Position at constant velocity from a state (5,), as a receiver of basic safety messages has it."""
    age_s = t_s - state[LOCAL_S]
    return (
        state[LOCAL_EAST_M] + age_s * state[LOCAL_VELOCITY_EAST_MPS],
        state[LOCAL_NORTH_M] + age_s * state[LOCAL_VELOCITY_NORTH_MPS],
    )


@kernel
def tracking_error(
    t_s: float,
    local: FloatVector,
    believed_s: float,
    believed_east_m: float,
    believed_north_m: float,
    predicted_east_m: float,
    predicted_north_m: float,
    c: FloatVector,
) -> float:
    """Distance between the vehicle's own estimate (5,) and the remotes', each by the rule of its age [m].

    ``believed_*`` is the position in the message they are believed to hold, ``predicted_*`` where its model
    puts the vehicle now. Infinite where they hold none (``believed_s`` minus infinity); ``c`` as in
    `j2945_kernels`.
    """
    if believed_s == -np.inf:
        return np.inf
    local_age_s, remote_age_s = t_s - local[LOCAL_S], t_s - believed_s
    if local_age_s > c[LOCAL_MAX_AGE_S] + _TIME_SLACK_S or remote_age_s > c[REMOTE_MAX_AGE_S] + _TIME_SLACK_S:
        return 0.0
    east_m, north_m = local[LOCAL_EAST_M], local[LOCAL_NORTH_M]
    if local_age_s >= c[LOCAL_AS_IS_AGE_S] - _TIME_SLACK_S:
        east_m, north_m = coast(t_s, local)
    if remote_age_s >= c[REMOTE_AS_IS_AGE_S] - _TIME_SLACK_S:
        return np.hypot(predicted_east_m - east_m, predicted_north_m - north_m)
    return np.hypot(believed_east_m - east_m, believed_north_m - north_m)


@kernel
def tracking_error_of_model(
    members: Members,
    member: int,
    parameters: FloatVector,
    t_s: float,
    local: FloatVector,
    believed_s: float,
    believed_east_m: float,
    believed_north_m: float,
    c: FloatVector,
    scratch: FloatVector,
) -> float:
    """Tracking error of one vehicle whose remotes predict with a point function [m].

    ``parameters`` (P,) are those of ``member``; ``scratch`` (2,) is overwritten.
    """
    if believed_s == -np.inf:
        return np.inf
    predict_member(members, member, parameters, t_s - believed_s, scratch)
    return tracking_error(
        t_s,
        local,
        believed_s,
        believed_east_m,
        believed_north_m,
        believed_east_m + scratch[0],
        believed_north_m + scratch[1],
        c,
    )
