"""Compiled sending by timers: when a lane sends by SAE J2945/1, by the rules of CAM, or at a fixed rate."""

from math import hypot
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatMatrix, FloatVector
from modelcast.models.point_kernels import EAST, NORTH, VELOCITY_EAST, VELOCITY_NORTH
from modelcast.station.arrays import LaneRules, Lanes, Sensed
from modelcast.station.policy import cam_kernels, dcc_kernels, j2945_kernels, periodic_kernels
from modelcast.station.policy.believed_loss_kernels import believed_loss
from modelcast.station.policy.neighbours_kernels import NeighbourTables, count, survey
from modelcast.station.policy.policy_numbers import (
    RULE_CAM,
    RULE_ERROR_DRIVEN,
    RULE_J2945,
    PolicyNumbers,
)
from modelcast.station.policy.tracking_error_kernels import LOCAL_COLUMNS, tracking_error_of_model
from modelcast.station.sender.fitting_kernels import SenderModels

__all__ = ["LOCAL", "Timers", "ask_cam", "ask_j2945", "ask_periodic", "observe_loss", "start", "timers"]

LOCAL = LOCAL_COLUMNS
"""Numbers of a vehicle's own estimate, that `ask_j2945` overwrites."""


class Timers(NamedTuple):
    """Timers of V stations.

    ``rows`` (V, 15) and ``control`` (V, 5) state of the rule; ``due_s`` (V,) of the periodic one; ``phase``
    (V,) where in a step each decides, in [0, 1); ``begins_s`` and ``begun`` (V,) when each begins to send,
    and whether it has; ``pending`` (V, 4) a message of a later step: time, power, whether believed received,
    cause.
    """

    rows: FloatMatrix
    control: FloatMatrix
    due_s: FloatVector
    phase: FloatVector
    begins_s: FloatVector
    begun: BoolVector
    pending: FloatMatrix


def timers(phase: FloatVector) -> Timers:
    """Return the timers of stations that have sent nothing, one a phase (V,)."""
    count_ = phase.size
    return Timers(
        rows=np.zeros((count_, j2945_kernels.STATE_COLUMNS)),
        control=np.zeros((count_, dcc_kernels.STATE_COLUMNS)),
        due_s=np.full(count_, -np.inf),
        phase=np.array(phase, dtype=np.float64),
        begins_s=np.zeros(count_),
        begun=np.zeros(count_, dtype=np.bool_),
        pending=np.full((count_, 4), np.inf),
    )


@kernel(inlined=True)
def start(timers: Timers, policy: PolicyNumbers, v: int, t_s: float) -> None:
    """Begin the timers of a station anew: it has sent nothing."""
    timers.due_s[v] = -np.inf
    for column in range(4):
        timers.pending[v, column] = np.inf
    if policy.rule == RULE_J2945 or (policy.rule == RULE_ERROR_DRIVEN and policy.constants.size > 1):
        j2945_kernels.start(timers.rows[v], t_s, timers.phase[v], policy.constants)
    elif policy.rule == RULE_CAM:
        cam_kernels.start(timers.rows[v, : cam_kernels.STATE_COLUMNS], policy.constants)
        for column in range(timers.control.shape[1]):
            timers.control[v, column] = 0.0
        timers.control[v, dcc_kernels.SHARE] = policy.start_share
        timers.control[v, dcc_kernels.DUE_S] = t_s


@kernel(inlined=True)
def ask_j2945(
    models: SenderModels,
    s: Sensed,
    rules: LaneRules,
    lanes: Lanes,
    timers: Timers,
    policy: PolicyNumbers,
    b: int,
    air: tuple[float, float, float, bool],
    tables: NeighbourTables,
    uniforms: FloatVector,
    scratch: FloatVector,
) -> tuple[int, float, float, bool]:
    """Ask the rules of SAE J2945/1 about one lane: cause, time, power, whether believed received.

    ``air`` is when it is asked, until when it answers, the channel busy ratio, and whether a critical event
    goes on; ``uniforms`` (3,) in [0, 1). ``scratch`` (2 + `LOCAL`,) is overwritten.
    """
    ask_s, until_s, busy_ratio, event = air
    v, c = rules.vehicle[b], policy.constants
    at = (s.taken[v] - 1) % s.stated_m.shape[1]
    sample = s.samples[v, at]
    error_m = np.inf
    if lanes.update[b] >= 0:
        m = lanes.in_use[b]
        local = scratch[2:]
        local[0], local[1], local[2] = s.t_s[v, at], sample[EAST], sample[NORTH]
        local[3], local[4] = sample[VELOCITY_EAST], sample[VELOCITY_NORTH]
        error_m = tracking_error_of_model(
            models.members,
            m,
            lanes.held[b, models.members.offsets[m] : models.members.offsets[m + 1]],
            ask_s,
            local,
            lanes.origin[b, 0],
            lanes.origin[b, 1],
            lanes.origin[b, 2],
            c,
            scratch,
        )
    near, ratio = 0.0, np.nan
    sub_interval_s, range_m = c[j2945_kernels.PER_SUB_INTERVAL_S], c[j2945_kernels.PER_RANGE_M]
    soon_s, row = ask_s + c[j2945_kernels.TIME_ACCURACY_S], timers.rows[v]
    if soon_s >= row[j2945_kernels.SURVEY_S]:
        near, ratio = survey(
            tables.hosts, tables.slots, v, ask_s, sample[EAST], sample[NORTH], sub_interval_s, range_m
        )
    elif soon_s >= row[j2945_kernels.COUNT_S]:
        near = count(
            tables.hosts, tables.slots, v, ask_s, sample[EAST], sample[NORTH], sub_interval_s, range_m
        )
    return j2945_kernels.step(row, ask_s, until_s, error_m, busy_ratio, near, ratio, event, uniforms, c)


@kernel(inlined=True)
def observe_loss(
    s: Sensed, timers: Timers, policy: PolicyNumbers, v: int, ask_s: float, tables: NeighbourTables
) -> float:
    """Share of its messages that a station believes lost, from the remotes that it hears.

    It is the mean packet error ratio of the remotes in range, as the channel quality of SAE J2945/1 is.
    """
    row, c = timers.rows[v], policy.constants
    if ask_s + c[j2945_kernels.TIME_ACCURACY_S] >= row[j2945_kernels.SURVEY_S]:
        sample = s.samples[v, (s.taken[v] - 1) % s.stated_m.shape[1]]
        _, ratio = survey(
            tables.hosts, tables.slots, v, ask_s, sample[EAST], sample[NORTH],
            c[j2945_kernels.PER_SUB_INTERVAL_S], c[j2945_kernels.PER_RANGE_M],
        )  # fmt: skip
        j2945_kernels.survey(row, ask_s, ratio, c)
    return believed_loss(row[j2945_kernels.CHANNEL_QUALITY])


@kernel(inlined=True)
def ask_cam(
    s: Sensed,
    timers: Timers,
    policy: PolicyNumbers,
    v: int,
    ask_s: float,
    busy_ratio: float,
    airtime_s: float,
) -> bool:
    """Ask the triggering rules of cooperative awareness messages."""
    shortest_s = policy.interval_s
    if policy.control != dcc_kernels.NONE:
        asked_s = dcc_kernels.step(
            timers.control[v], policy.control, ask_s, busy_ratio, airtime_s, policy.control_constants
        )
        longest_s = policy.constants[cam_kernels.MAX_INTER_TRANSMIT_TIME_S]
        shortest_s = min(max(asked_s, policy.interval_s), longest_s)
    sample = s.samples[v, (s.taken[v] - 1) % s.stated_m.shape[1]]
    speed = hypot(sample[VELOCITY_EAST], sample[VELOCITY_NORTH])
    heading = np.arctan2(sample[VELOCITY_EAST], sample[VELOCITY_NORTH])
    return cam_kernels.step(
        timers.rows[v, : cam_kernels.STATE_COLUMNS],
        ask_s,
        sample[EAST],
        sample[NORTH],
        speed,
        heading,
        shortest_s,
        policy.constants,
    )


@kernel(inlined=True)
def ask_periodic(timers: Timers, policy: PolicyNumbers, v: int, ask_s: float, uniform: float) -> bool:
    """Ask whether a message falls due."""
    sends, timers.due_s[v] = periodic_kernels.step(timers.due_s[v], ask_s, policy.interval_s, uniform)
    return sends
