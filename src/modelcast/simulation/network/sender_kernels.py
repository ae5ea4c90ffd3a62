"""Compiled senders of the closed loop: samples come in, the rule decides, the message is composed."""

from math import ceil, cos, hypot, sin, sqrt
from typing import Any

import numba
import numpy as np

from modelcast.models.noise_kernels import difference_variance, settled
from modelcast.models.point_kernels import (
    ACCELERATION,
    EAST,
    NORTH,
    POSITION_NOISE,
    VELOCITY_EAST,
    VELOCITY_NORTH,
    YAW_RATE,
)
from modelcast.models.rates import NO_RATES_BELOW_MPS
from modelcast.models.trusted_kernels import predict_trusted
from modelcast.policy import cam_kernels, dcc_kernels, error_driven_kernels, j2945_kernels, periodic_kernels
from modelcast.policy.belief_kernels import LOCAL_COLUMNS, tracking_error_of_model
from modelcast.policy.neighbours_kernels import count, survey
from modelcast.simulation.network.layout_kernels import (
    AIRTIME_S,
    BELIEF_NUMBER,
    BELIEF_STEP,
    CERTIFICATES,
    CONTENT_BYTES,
    CONTENT_EAST_M,
    CONTENT_FIT_S,
    CONTENT_HEAD,
    CONTENT_MEMBER,
    CONTENT_NORTH_M,
    CONTENT_NUMBER,
    CONTENT_SENT_S,
    CONTENT_VEHICLE,
    FRAME_BYTES,
    MESSAGES,
    MESSAGES_KEPT,
    MODELS,
    PAYLOAD_BYTES,
    POWER_DBM,
    RULE_CAM,
    RULE_ERROR_DRIVEN,
    RULE_J2945,
    RULE_PERIODIC,
    SENDER_BITS,
)

__all__ = ["CERTIFICATE_RULES", "compose", "decide", "take_samples"]

CERTIFICATE_RULES = ("gap", "timer", "always", "digest", "unsigned")
_GAP, _TIMER, _ALWAYS = range(3)
_TIME_SLACK_S = 1e-9

_SCORE_WEIGHT = 0.2
"""Of the newest error in the mean that chooses a sub-model: about the last five messages count."""


@numba.njit(cache=True, nogil=True)
def take_samples(
    t_s: float,
    at: int,
    seen_m: Any,
    speed_mps: Any,
    heading_rad: Any,
    acceleration_mps2: Any,
    yaw_rate_radps: Any,
    vehicle_id: Any,
    active: Any,
    s: Any,
    order: int,
    noise: Any,
    out_started: Any,
) -> None:
    """Take what V vehicles see at one instant into their windows, at place ``at`` of the rings.

    The row is that of `modelcast.models.velocity.sample_matrix` for a log that reports speed, heading,
    acceleration and yaw rate. ``noise`` holds the constants of `noise_kernels.settled`, after the mean at the
    start. ``out_started`` (V,) tells whose slot has a new vehicle.
    """
    first_mean, samples, clip, share, prior_samples, free = noise
    length = s.times.size // 2
    s.times[at] = s.times[at + length] = t_s
    for v in range(vehicle_id.size):
        out_started[v] = False
        if not active[v]:
            s.vehicle[v], s.history[v] = -1, 0
            continue
        if s.vehicle[v] != vehicle_id[v]:
            out_started[v] = True
            s.vehicle[v], s.history[v] = vehicle_id[v], 0
            s.noise[v, 0], s.noise[v, 1] = first_mean, 0.0
        own = s.samples[v]
        row = own[at + length]
        row[EAST], row[NORTH] = seen_m[v, 0], seen_m[v, 1]
        row[VELOCITY_EAST] = speed_mps[v] * sin(heading_rad[v])
        row[VELOCITY_NORTH] = speed_mps[v] * cos(heading_rad[v])
        moving = hypot(row[VELOCITY_EAST], row[VELOCITY_NORTH]) >= NO_RATES_BELOW_MPS
        row[ACCELERATION] = acceleration_mps2[v] if moving else 0.0
        row[YAW_RATE] = yaw_rate_radps[v] if moving else 0.0
        s.history[v] += 1
        if s.history[v] > order:
            square = difference_variance(s.times, own, at + length, order)
            s.noise[v, 0], s.noise[v, 1] = settled(
                square, s.noise[v, 0], s.noise[v, 1], samples, clip, share, prior_samples, free
            )
        row[POSITION_NOISE] = sqrt(s.noise[v, 0] / share)
        own[at] = row


@numba.njit(cache=True, nogil=True)
def _moved(models: Any, member: int, parameters: Any, age_s: float, out: Any) -> None:
    """Displacement of one sub-model's decoded parameters into ``out`` (2,)."""
    _, predicts, constants, _, _, trust, _ = models
    predict_trusted(
        predicts[member], parameters, age_s, constants[member], trust[member, 0], trust[member, 1], out
    )


@numba.njit(cache=True, nogil=True)
def _adds_nothing(
    models: Any, member: int, parameters: Any, plain: Any, within_m: float, horizon_s: float, scratch: Any
) -> bool:
    """Whether two paths are the same within a resolution, half-way to a horizon and there."""
    plain_member = len(models[0]) - 1
    for share in (0.5, 1.0):
        _moved(models, member, parameters, share * horizon_s, scratch)
        east, north = scratch[0], scratch[1]
        _moved(models, plain_member, plain, share * horizon_s, scratch)
        if hypot(east - scratch[0], north - scratch[1]) > within_m:
            return False
    return True


@numba.njit(cache=True, nogil=True)
def _judge(models: Any, s: Any, v: int, t_s: float, sample: Any, scratch: Any) -> None:
    """Set every sub-model fitted at the last message against the newest sample."""
    for member in range(len(models[0])):
        trial = s.trials[v, member]
        count = models[4][member]
        if trial[trial.size - 1] == 0.0:
            continue
        _moved(models, member, trial[:count], t_s - s.origin[v, 0], scratch)
        east = s.origin[v, 1] + scratch[0] - sample[EAST]
        north = s.origin[v, 2] + scratch[1] - sample[NORTH]
        square, before = east * east + north * north, s.scores[v, member]
        s.scores[v, member] = square if before < 0.0 else before + _SCORE_WEIGHT * (square - before)


@numba.njit(cache=True, nogil=True)
def _recent_choice(models: Any, s: Any, v: int, within_m: float) -> int:
    """Smallest sub-model that erred no more than the best of late, but for a resolution; -1 for no score."""
    payload_bytes = models[6]
    best = np.inf
    for member in range(len(models[0])):
        if s.trials[v, member, s.trials.shape[2] - 1] != 0.0 and s.scores[v, member] >= 0.0:
            best = min(best, s.scores[v, member])
    chosen = -1
    for member in range(len(models[0])):
        usable = s.trials[v, member, s.trials.shape[2] - 1] != 0.0 and s.scores[v, member] >= 0.0
        good = usable and s.scores[v, member] <= best + within_m * within_m
        if good and (chosen < 0 or payload_bytes[member] < payload_bytes[chosen]):
            chosen = member
    return chosen


@numba.njit(cache=True, nogil=True)
def compose(models: Any, limits: Any, s: Any, v: int, at: int, t_s: float, row: Any, scratch: Any) -> None:
    """Write the content (W,) of a vehicle's message from its newest sample, as a receiver decodes it.

    ``models`` holds the members' compiled fits, predictions and constants as tuples, their windows, numbers
    of parameters, trusted horizons and payload bytes. The last member is that of a plain basic safety
    message. ``limits`` is the resolution below which paths are the same [m], the horizon over which they are
    compared [s], and whether recent errors choose the sub-model.
    """
    fits, _, constants, windows, counts, _, payload_bytes = models
    plain_member = len(fits) - 1
    within_m, horizon_s, by_errors = limits
    end = at + s.times.size // 2 + 1
    own = s.samples[v]
    member = 0
    while member < plain_member and s.history[v] < windows[member]:
        member += 1
    parameters = row[CONTENT_HEAD : CONTENT_HEAD + counts[member]]
    if by_errors > 0.0:
        _judge(models, s, v, t_s, own[end - 1], scratch)
        for m in range(plain_member + 1):
            trial = s.trials[v, m]
            trial[trial.size - 1] = 0.0
            if s.history[v] >= windows[m]:
                fits[m](own[end - windows[m] : end], constants[m], trial[: counts[m]])
                trial[trial.size - 1] = 1.0
        s.origin[v, 0], s.origin[v, 1], s.origin[v, 2] = t_s, own[end - 1, EAST], own[end - 1, NORTH]
        chosen = _recent_choice(models, s, v, within_m)
        member = chosen if chosen >= 0 else member
        parameters = row[CONTENT_HEAD : CONTENT_HEAD + counts[member]]
        parameters[:] = s.trials[v, member, : counts[member]]
    else:
        fits[member](own[end - windows[member] : end], constants[member], parameters)
        if member < plain_member:
            plain = np.empty(counts[plain_member])
            fits[plain_member](own[end - 1 : end], constants[plain_member], plain)
            if _adds_nothing(models, member, parameters, plain, within_m, horizon_s, scratch):
                member = plain_member
                parameters = row[CONTENT_HEAD : CONTENT_HEAD + counts[member]]
                parameters[:] = plain
    last = parameters.size - 1
    # The position sent is on its grid; a receiver has it and no remainder.
    row[CONTENT_EAST_M] = own[end - 1, EAST] + parameters[last - 1]
    row[CONTENT_NORTH_M] = own[end - 1, NORTH] + parameters[last]
    parameters[last - 1] = parameters[last] = 0.0
    row[CONTENT_MEMBER], row[CONTENT_BYTES] = member, payload_bytes[member]


@numba.njit(cache=True, nogil=True)
def _has_certificate(s: Any, v: int, sent_s: float, rule: int, interval_s: float) -> bool:
    """Whether a message carries the certificate, as `modelcast.messages.airtime.Stack` says."""
    if rule == _GAP:
        return sent_s - s.sent_s[v] > interval_s + _TIME_SLACK_S
    if rule == _TIMER:
        return sent_s - s.certified_s[v] >= interval_s - _TIME_SLACK_S
    return rule == _ALWAYS


@numba.njit(cache=True, nogil=True)
def _frame_bytes(payload: float, certificate: bool, stack: Any) -> float:
    return payload + stack[2] + (stack[3] if certificate else 0.0)


@numba.njit(cache=True, nogil=True)
def _airtime(frame_bytes: float, stack: Any) -> float:
    return stack[4] + stack[5] * ceil((stack[6] + 8.0 * frame_bytes) / stack[7])


@numba.njit(cache=True, nogil=True)
def _emit(
    models: Any,
    limits: Any,
    stack: Any,
    s: Any,
    v: int,
    at: int,
    t_s: float,
    message: Any,
    contents: Any,
    out: Any,
    tally: Any,
    scratch: Any,
) -> None:
    """Compose a message, put it into the outbox and account for it.

    ``message`` is when it goes to the radio, its power, whether it is believed received, its cause.
    """
    sent_s, power_dbm, believed, cause = message
    number = s.number[v]
    ring = number % MESSAGES_KEPT
    row = contents.rows[v, ring]
    compose(models, limits, s, v, at, t_s, row, scratch)
    contents.beliefs[v, ring, BELIEF_NUMBER], contents.beliefs[v, ring, BELIEF_STEP] = number, -1
    row[CONTENT_VEHICLE], row[CONTENT_NUMBER] = s.vehicle[v], number
    row[CONTENT_FIT_S], row[CONTENT_SENT_S] = t_s, sent_s
    certificate = _has_certificate(s, v, sent_s, int(stack[0]), stack[1])
    frame = _frame_bytes(row[CONTENT_BYTES], certificate, stack)
    k = out.count[0]
    out.sender[k], out.ready_s[k], out.size_bytes[k] = v, sent_s, int(frame)
    out.power_dbm[k], out.message_id[k] = power_dbm, (number << SENDER_BITS) | v
    out.count[0] = k + 1
    if believed > 0.0:
        s.believed[v] = number
    if certificate:
        s.certified_s[v] = sent_s
    s.sent_s[v], s.number[v] = sent_s, number + 1
    tally.causes[int(cause)] += 1
    tally.sums[MESSAGES] += 1.0
    if row[CONTENT_MEMBER] < len(models[0]) - 1:
        tally.sums[MODELS] += 1.0
    if certificate:
        tally.sums[CERTIFICATES] += 1.0
    tally.sums[PAYLOAD_BYTES] += row[CONTENT_BYTES]
    tally.sums[FRAME_BYTES] += frame
    tally.sums[AIRTIME_S] += _airtime(frame, stack)
    tally.sums[POWER_DBM] += power_dbm


@numba.njit(cache=True, nogil=True)
def _start(s: Any, v: int, rule: int, t_s: float, constants: Any, start_share: float) -> None:
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


@numba.njit(cache=True, nogil=True)
def _j2945(
    models: Any,
    s: Any,
    v: int,
    sample: Any,
    t_s: float,
    ask_s: float,
    until_s: float,
    event: bool,
    busy_ratio: float,
    tables: Any,
    uniforms: Any,
    c: Any,
    contents: Any,
    local: Any,
    scratch: Any,
) -> tuple[int, float, float, bool]:
    """Ask the rules of SAE J2945/1 about one vehicle."""
    hosts, slots, _, _ = tables
    row = s.rows[v]
    error_m = np.inf
    if s.believed[v] >= 0:
        _, predicts, constants, _, counts, trust, _ = models
        held = contents.rows[v, s.believed[v] % MESSAGES_KEPT]
        member = int(held[CONTENT_MEMBER])
        local[0], local[1], local[2] = t_s, sample[EAST], sample[NORTH]
        local[3], local[4] = sample[VELOCITY_EAST], sample[VELOCITY_NORTH]
        error_m = tracking_error_of_model(
            predicts[member],
            held[CONTENT_HEAD : CONTENT_HEAD + counts[member]],
            constants[member],
            trust[member, 0],
            trust[member, 1],
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


@numba.njit(cache=True, nogil=True)
def _error_driven(
    models: Any, s: Any, v: int, sample: Any, t_s: float, constants: Any, contents: Any
) -> bool:
    """Ask Algorithm 1, where only the sub-model in use is sent."""
    if s.believed[v] < 0:
        return True
    _, _, _, _, counts, _, _ = models
    held = contents.rows[v, s.believed[v] % MESSAGES_KEPT]
    member = int(held[CONTENT_MEMBER])
    moved = np.empty(2)
    age_s = t_s - held[CONTENT_FIT_S]
    _moved(models, member, held[CONTENT_HEAD : CONTENT_HEAD + counts[member]], age_s, moved)
    east = held[CONTENT_EAST_M] + moved[0] - sample[EAST]
    north = held[CONTENT_NORTH_M] + moved[1] - sample[NORTH]
    error_m, failures_s = np.empty(1), np.full(1, np.inf)
    error_m[0] = sqrt(east * east + north * north)
    kind, _ = error_driven_kernels.step(
        error_m,
        failures_s,
        0,
        age_s,
        age_s,
        constants[0],
        constants[1],
        error_driven_kernels.IDENTIFY_NEVER,
        np.empty(0),
    )
    return kind != error_driven_kernels.NOTHING


@numba.njit(cache=True, nogil=True)
def _cam(
    s: Any,
    v: int,
    sample: Any,
    ask_s: float,
    busy_ratio: float,
    airtime_s: float,
    constants: Any,
    control: int,
    control_constants: Any,
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


@numba.njit(cache=True, nogil=True)
def decide(
    models: Any,
    limits: Any,
    stack: Any,
    rule: int,
    constants: Any,
    control: int,
    control_constants: Any,
    extra: Any,
    t_s: float,
    dt_s: float,
    at: int,
    started: Any,
    critical: Any,
    busy_ratio: Any,
    uniforms: Any,
    tables: Any,
    s: Any,
    contents: Any,
    out: Any,
    tally: Any,
) -> None:
    """Let every vehicle decide what it sends in [t, t + dt), each at a time of its own in the step.

    ``constants`` and ``control_constants`` are those of the rule; ``extra`` is (power [dBm], jitter [s], time
    between messages or the least one [s], share at the start, time over which new vehicles begin [s]).
    ``uniforms`` (V, 4) in [0, 1). Messages go to
    the outbox; what falls due after the step waits in ``s.pending``.
    """
    power_dbm, jitter_s, interval_s, start_share, spread_s = extra
    length = s.times.size // 2
    local, scratch = np.empty(LOCAL_COLUMNS), np.empty(2)
    out.count[0] = 0
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
                _emit(models, limits, stack, s, v, at, t_s, message, contents, out, tally, scratch)
                waits[0] = np.inf
            ask_s = t_s + s.phase[v] * dt_s
            cause, sent_s, loud_dbm, believed = _j2945(
                models, s, v, sample, t_s, ask_s, ask_s + dt_s, critical[v], busy_ratio[v], tables,
                uniforms[v], constants, contents, local, scratch,
            )  # fmt: skip
            if cause != j2945_kernels.CAUSE_NOTHING:
                message = (sent_s, loud_dbm, 1.0 if believed else 0.0, float(cause))
                if sent_s < until_s:
                    _emit(models, limits, stack, s, v, at, t_s, message, contents, out, tally, scratch)
                else:
                    waits[0], waits[1], waits[2], waits[3] = message
            continue
        ask_s = t_s + s.phase[v] * (dt_s - jitter_s)
        sends = False
        if rule == RULE_PERIODIC:
            sends, s.due_s[v] = periodic_kernels.step(s.due_s[v], ask_s, interval_s, uniforms[v, 0])
        elif rule == RULE_ERROR_DRIVEN:
            sends = _error_driven(models, s, v, sample, t_s, constants, contents)
        else:
            payload = float(models[6][len(models[0]) - 1])
            airtime_s = _airtime(_frame_bytes(payload, True, stack), stack)
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
            _emit(models, limits, stack, s, v, at, t_s, message, contents, out, tally, scratch)
