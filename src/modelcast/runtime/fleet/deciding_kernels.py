"""Compiled decisions of the closed loop's senders: every vehicle asks its rule once a step."""

from math import hypot, sqrt

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatMatrix, FloatVector
from modelcast.messages.airtime_kernels import StackNumbers, airtime, frame_bytes
from modelcast.models.member_kernels import parameter_count
from modelcast.models.point_kernels import EAST, NORTH, VELOCITY_EAST, VELOCITY_NORTH
from modelcast.runtime.fleet.arrays import Contents, Outbox, SenderArrays, Tally
from modelcast.runtime.fleet.composing_kernels import LoopModels, moved
from modelcast.runtime.fleet.emitting_kernels import emit
from modelcast.runtime.fleet.layout_kernels import (
    CONTENT_EAST_M,
    CONTENT_FIT_S,
    CONTENT_HEAD,
    CONTENT_MEMBER,
    CONTENT_NORTH_M,
    MESSAGES_KEPT,
    RULE_CAM,
    RULE_ERROR_DRIVEN,
    RULE_J2945,
    RULE_PERIODIC,
)
from modelcast.station.policy import (
    cam_kernels,
    dcc_kernels,
    error_driven_kernels,
    j2945_kernels,
    periodic_kernels,
)
from modelcast.station.policy.belief_kernels import tracking_error_of_model
from modelcast.station.policy.neighbours_kernels import NeighbourTables, count, survey

__all__ = ["decide"]


@kernel(inlined=True)
def _start(
    s: SenderArrays, v: int, rule: int, t_s: float, constants: FloatVector, start_share: float
) -> None:
    """Forget the last vehicle of a slot: the new one has sent nothing."""
    s.believed[v] = -1
    s.sent_s[v] = s.certified_s[v] = s.due_s[v] = -np.inf
    s.pending[v] = np.inf
    s.trials[v, :, -1] = 0.0
    s.scores[v] = -1.0
    if rule == RULE_J2945:
        j2945_kernels.start(s.rows[v], t_s, s.phase[v], constants)
    elif rule == RULE_CAM:
        cam_kernels.start(s.rows[v, : cam_kernels.STATE_COLUMNS], constants)
        s.control[v] = 0.0
        s.control[v, dcc_kernels.SHARE] = start_share
        s.control[v, dcc_kernels.DUE_S] = t_s


@kernel(inlined=True)
def _j2945(
    models: LoopModels,
    s: SenderArrays,
    v: int,
    sample: FloatVector,
    t_s: float,
    ask_s: float,
    until_s: float,
    event: bool,
    busy_ratio: float,
    tables: NeighbourTables,
    uniforms: FloatVector,
    c: FloatVector,
    contents: Contents,
    local: FloatVector,
    scratch: FloatVector,
) -> tuple[int, float, float, bool]:
    """Ask the rules of SAE J2945/1 about one vehicle."""
    hosts, slots, _, _ = tables
    row = s.rows[v]
    error_m = np.inf
    if s.believed[v] >= 0:
        members = models.members
        held = contents.rows[v, s.believed[v] % MESSAGES_KEPT]
        member = int(held[CONTENT_MEMBER])
        local[0], local[1], local[2] = t_s, sample[EAST], sample[NORTH]
        local[3], local[4] = sample[VELOCITY_EAST], sample[VELOCITY_NORTH]
        error_m = tracking_error_of_model(
            members,
            member,
            held[CONTENT_HEAD : CONTENT_HEAD + parameter_count(members, member)],
            ask_s,
            local,
            held[CONTENT_FIT_S],
            held[CONTENT_EAST_M],
            held[CONTENT_NORTH_M],
            c,
            scratch,
        )
    near, ratio = 0.0, np.nan
    sub_interval_s, range_m = c[j2945_kernels.PER_SUB_INTERVAL_S], c[j2945_kernels.PER_RANGE_M]
    soon_s = ask_s + c[j2945_kernels.TIME_ACCURACY_S]
    if soon_s >= row[j2945_kernels.SURVEY_S]:
        near, ratio = survey(hosts, slots, v, ask_s, sample[EAST], sample[NORTH], sub_interval_s, range_m)
    elif soon_s >= row[j2945_kernels.COUNT_S]:
        near = count(hosts, slots, v, ask_s, sample[EAST], sample[NORTH], sub_interval_s, range_m)
    return j2945_kernels.step(row, ask_s, until_s, error_m, busy_ratio, near, ratio, event, uniforms, c)


@kernel(inlined=True)
def _error_driven(
    models: LoopModels,
    s: SenderArrays,
    v: int,
    sample: FloatVector,
    t_s: float,
    constants: FloatVector,
    contents: Contents,
    scratch: FloatVector,
) -> bool:
    """Ask Algorithm 1, where only the sub-model in use is sent."""
    if s.believed[v] < 0:
        return True
    held = contents.rows[v, s.believed[v] % MESSAGES_KEPT]
    member = int(held[CONTENT_MEMBER])
    age_s = t_s - held[CONTENT_FIT_S]
    moved(
        models,
        member,
        held[CONTENT_HEAD : CONTENT_HEAD + parameter_count(models.members, member)],
        age_s,
        scratch,
    )
    east = held[CONTENT_EAST_M] + scratch[0] - sample[EAST]
    north = held[CONTENT_NORTH_M] + scratch[1] - sample[NORTH]
    scratch[0], scratch[1] = sqrt(east * east + north * north), np.inf
    kind, _ = error_driven_kernels.step(
        scratch[:1],
        scratch[1:2],
        0,
        age_s,
        age_s,
        constants[0],
        constants[1],
        error_driven_kernels.IDENTIFY_NEVER,
        scratch[2:2],
    )
    return kind != error_driven_kernels.NOTHING


@kernel(inlined=True)
def _cam(
    s: SenderArrays,
    v: int,
    sample: FloatVector,
    ask_s: float,
    busy_ratio: float,
    airtime_s: float,
    constants: FloatVector,
    control: int,
    control_constants: FloatVector,
    least_s: float,
) -> bool:
    """Ask the triggering rules of cooperative awareness messages."""
    shortest_s = least_s
    if control != dcc_kernels.NONE:
        asked_s = dcc_kernels.step(s.control[v], control, ask_s, busy_ratio, airtime_s, control_constants)
        shortest_s = min(max(asked_s, least_s), constants[cam_kernels.MAX_INTER_TRANSMIT_TIME_S])
    speed = hypot(sample[VELOCITY_EAST], sample[VELOCITY_NORTH])
    heading = np.arctan2(sample[VELOCITY_EAST], sample[VELOCITY_NORTH])
    return cam_kernels.step(
        s.rows[v, : cam_kernels.STATE_COLUMNS],
        ask_s,
        sample[EAST],
        sample[NORTH],
        speed,
        heading,
        shortest_s,
        constants,
    )


@kernel(inlined=True)
def decide(
    models: LoopModels,
    limits: tuple[float, float, float],
    stack: StackNumbers,
    rule: int,
    constants: FloatVector,
    control: int,
    control_constants: FloatVector,
    extra: tuple[float, float, float, float, float],
    t_s: float,
    dt_s: float,
    at: int,
    started: BoolVector,
    critical: BoolVector,
    busy_ratio: FloatVector,
    uniforms: FloatMatrix,
    tables: NeighbourTables,
    s: SenderArrays,
    contents: Contents,
    out: Outbox,
    tally: Tally,
    local: FloatVector,
    scratch: FloatVector,
) -> None:
    """Let every vehicle decide what it sends in [t, t + dt), each at a time of its own in the step.

    ``constants`` and ``control_constants`` are those of the rule; ``extra`` is (power [dBm], jitter [s], time
    between messages or the least one [s], share at the start, time over which new vehicles begin [s]).
    ``uniforms`` (V, 4) in [0, 1). Messages go to the outbox; what falls due after the step
    waits in ``s.pending``. ``local`` (LOCAL_COLUMNS,) and ``scratch`` (2 + P,) are overwritten.
    """
    power_dbm, jitter_s, interval_s, start_share, spread_s = extra
    length = s.times.size // 2
    out.filled[0] = 0
    until_s = t_s + dt_s
    for v in range(s.vehicle.size):
        if s.vehicle[v] < 0:
            continue
        if started[v]:
            s.begins_s[v], s.begun[v] = t_s + spread_s * uniforms[v, 3], False
            _start(s, v, rule, t_s, constants, start_share)
        if not s.begun[v]:
            if t_s < s.begins_s[v]:
                continue
            s.begun[v] = True
            _start(s, v, rule, t_s, constants, start_share)
        sample = s.samples[v, at + length]
        if rule == RULE_J2945:
            waits = s.pending[v]
            if waits[0] < until_s:
                message = (max(waits[0], t_s), waits[1], waits[2], waits[3])
                emit(models, limits, stack, s, v, at, t_s, message, contents, out, tally, scratch)
                waits[0] = np.inf
            ask_s = t_s + s.phase[v] * dt_s
            cause, sent_s, loud_dbm, believed = _j2945(
                models, s, v, sample, t_s, ask_s, ask_s + dt_s, critical[v], busy_ratio[v], tables,
                uniforms[v], constants, contents, local, scratch,
            )  # fmt: skip
            if cause != j2945_kernels.CAUSE_NOTHING:
                message = (sent_s, loud_dbm, 1.0 if believed else 0.0, float(cause))
                if sent_s < until_s:
                    emit(models, limits, stack, s, v, at, t_s, message, contents, out, tally, scratch)
                else:
                    waits[0], waits[1], waits[2], waits[3] = message
            continue
        ask_s = t_s + s.phase[v] * (dt_s - jitter_s)
        sends = False
        if rule == RULE_PERIODIC:
            sends, s.due_s[v] = periodic_kernels.step(s.due_s[v], ask_s, interval_s, uniforms[v, 0])
        elif rule == RULE_ERROR_DRIVEN:
            sends = _error_driven(models, s, v, sample, t_s, constants, contents, scratch)
        else:
            payload = int(models.payload_bytes[models.payload_bytes.size - 1])
            airtime_s = airtime(frame_bytes(payload, True, stack), stack)
            sends = _cam(
                s,
                v,
                sample,
                ask_s,
                busy_ratio[v],
                airtime_s,
                constants,
                control,
                control_constants,
                interval_s,
            )
        if sends:
            message = (ask_s + jitter_s * uniforms[v, 1], power_dbm, 1.0, 1.0)
            emit(models, limits, stack, s, v, at, t_s, message, contents, out, tally, scratch)
