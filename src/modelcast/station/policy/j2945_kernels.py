"""Compiled congestion control of SAE J2945/1: each rule one function, and the step of one vehicle."""

import math
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatMatrix, FloatVector, IntVector
from modelcast.station.policy.timer_kernels import next_due

__all__ = [
    "CAUSE_CRITICAL",
    "CAUSE_DYNAMICS",
    "CAUSE_NOTHING",
    "CAUSE_TIME",
    "STATE_COLUMNS",
    "Vehicles",
    "assume_received",
    "control",
    "critical",
    "error_growth",
    "max_inter_transmit_time",
    "power_for",
    "sent",
    "start",
    "step",
    "step_each",
    "survey",
    "transmit_probability",
]

(
    PER_INTERVAL_S,
    PER_SUB_INTERVAL_S,
    PER_RANGE_M,
    MAX_PACKET_ERROR_RATIO,
    CHANNEL_QUALITY_WEIGHT,
    DENSITY_INTERVAL_S,
    DENSITY_WEIGHT,
    DENSITY_COEFFICIENT,
    MIN_INTER_TRANSMIT_TIME_S,
    MAX_INTER_TRANSMIT_TIME_S,
    RATE_CONTROL_INTERVAL_S,
    BUSY_WEIGHT,
    LOCAL_AS_IS_AGE_S,
    LOCAL_MAX_AGE_S,
    REMOTE_AS_IS_AGE_S,
    REMOTE_MAX_AGE_S,
    TRACKING_ERROR_TRIGGER,
    MIN_TRACKING_ERROR_M,
    MAX_TRACKING_ERROR_M,
    ERROR_SENSITIVITY,
    SQUARED_EXPONENT,
    RESCHEDULE_THRESHOLD_S,
    JITTER_S,
    TIME_ACCURACY_S,
    MAX_SUCCESSIVE_FAILURES,
    CRITICAL_INTERVAL_S,
    CRITICAL_DECELERATION_MPS2,
    POWER_CONTROL,
    MIN_POWER_DBM,
    MAX_POWER_DBM,
    START_POWER_DBM,
    POWER_GAIN,
    MIN_BUSY_RATIO,
    MAX_BUSY_RATIO,
    MAX_ERROR_GROWTH,
    FOLLOW_UP_S,
) = range(36)
"""Constants, in the order of the fields of `J2945Parameters`."""

(
    LAST_S,
    NEXT_S,
    CONTROL_S,
    COUNT_S,
    SURVEY_S,
    NEIGHBOURS,
    DENSITY,
    CHANNEL_QUALITY,
    BUSY_RATIO,
    INTER_TRANSMIT_TIME_S,
    PROBABILITY,
    POWER_DBM,
    FAILURES,
    CAUSE,
    CRITICAL,
) = range(15)
"""Columns of a vehicle's state: last and next message; next rate control, count and survey; what they gave:
remotes counted, smoothed density, channel quality, smoothed busy ratio, maximum inter-transmit time, transmit
probability; base power; successive losses believed; cause of the next message; whether a critical event goes
on."""

STATE_COLUMNS = 15

CAUSE_NOTHING, CAUSE_TIME, CAUSE_DYNAMICS, CAUSE_CRITICAL = range(4)
"""Why a message is sent: the maximum inter-transmit time, the tracking error, a critical event."""

_TIME_SLACK_S = 1e-9
"""Sums of steps may fall short of a threshold by rounding."""


@kernel
def max_inter_transmit_time(density: float, c: FloatVector) -> float:
    """Longest time between messages at a smoothed vehicle density [s]."""
    if density <= c[DENSITY_COEFFICIENT]:
        return c[MIN_INTER_TRANSMIT_TIME_S]
    time_s = c[MIN_INTER_TRANSMIT_TIME_S] * density / c[DENSITY_COEFFICIENT]
    return min(time_s, c[MAX_INTER_TRANSMIT_TIME_S])


@kernel
def transmit_probability(tracking_error_m: float, c: FloatVector) -> float:
    """Probability p(k) of a message for a tracking error; 0 where that is NaN."""
    if not tracking_error_m >= c[MIN_TRACKING_ERROR_M]:
        return 0.0
    if tracking_error_m >= c[MAX_TRACKING_ERROR_M]:
        return 1.0
    beyond = tracking_error_m - c[MIN_TRACKING_ERROR_M]
    if c[SQUARED_EXPONENT] != 0.0:
        beyond *= beyond
    return 1.0 - math.exp(-c[ERROR_SENSITIVITY] * beyond)


@kernel
def error_growth(density: float, c: FloatVector) -> float:
    """By how much a tracking error may be larger at a smoothed vehicle density; 1 up to the coefficient."""
    return max(1.0, min(density / c[DENSITY_COEFFICIENT], c[MAX_ERROR_GROWTH]))


@kernel
def power_for(channel_busy_ratio: float, c: FloatVector) -> float:
    """Power f(CBP) that a channel busy ratio calls for [dBm]."""
    if channel_busy_ratio <= c[MIN_BUSY_RATIO]:
        return c[MAX_POWER_DBM]
    if channel_busy_ratio >= c[MAX_BUSY_RATIO]:
        return c[MIN_POWER_DBM]
    slope = (c[MAX_POWER_DBM] - c[MIN_POWER_DBM]) / (c[MAX_BUSY_RATIO] - c[MIN_BUSY_RATIO])
    return c[MAX_POWER_DBM] - slope * (channel_busy_ratio - c[MIN_BUSY_RATIO])


@kernel
def start(row: FloatVector, start_s: float, phase: float, c: FloatVector) -> None:
    """Make a state before the first message, (15,): it falls due within one rate control interval.

    ``phase`` in [0, 1) places the vehicle's timers.
    """
    first_s = start_s + phase * c[RATE_CONTROL_INTERVAL_S]
    row[:] = 0.0
    row[LAST_S] = -np.inf
    row[NEXT_S] = first_s
    row[CONTROL_S] = first_s
    row[COUNT_S] = start_s + phase * c[DENSITY_INTERVAL_S]
    row[SURVEY_S] = start_s + phase * c[PER_SUB_INTERVAL_S]
    row[INTER_TRANSMIT_TIME_S] = c[MIN_INTER_TRANSMIT_TIME_S]
    row[POWER_DBM] = c[START_POWER_DBM]
    row[CAUSE] = CAUSE_TIME


@kernel
def survey(row: FloatVector, t_s: float, packet_error_ratio: float, c: FloatVector) -> None:
    """Take in the mean packet error ratio at the end of a sub-interval; NaN counts as 0."""
    mean = 0.0
    if packet_error_ratio > 0.0:
        mean = min(packet_error_ratio, c[MAX_PACKET_ERROR_RATIO])
    weight = c[CHANNEL_QUALITY_WEIGHT]
    smoothed = (1.0 - weight) * row[CHANNEL_QUALITY] + weight * mean
    row[CHANNEL_QUALITY] = min(smoothed, c[MAX_PACKET_ERROR_RATIO])
    row[SURVEY_S] = next_due(row[SURVEY_S], t_s + c[TIME_ACCURACY_S], c[PER_SUB_INTERVAL_S])


@kernel
def control(
    row: FloatVector,
    t_s: float,
    tracking_error_m: float,
    channel_busy_ratio: float,
    uniform: float,
    c: FloatVector,
) -> None:
    """Run rate control: smooth, and bring the next message forward where error or density call for it."""
    weight = c[BUSY_WEIGHT]
    row[BUSY_RATIO] = weight * channel_busy_ratio + (1.0 - weight) * row[BUSY_RATIO]
    weight = c[DENSITY_WEIGHT]
    row[DENSITY] = weight * row[NEIGHBOURS] + (1.0 - weight) * row[DENSITY]
    longest_s = max_inter_transmit_time(row[DENSITY], c)
    row[INTER_TRANSMIT_TIME_S] = longest_s
    row[PROBABILITY] = 0.0
    if c[TRACKING_ERROR_TRIGGER] != 0.0:
        row[PROBABILITY] = transmit_probability(tracking_error_m / error_growth(row[DENSITY], c), c)
    threshold_s = c[RESCHEDULE_THRESHOLD_S] - _TIME_SLACK_S
    if uniform < row[PROBABILITY] and row[NEXT_S] - t_s >= threshold_s:
        row[NEXT_S], row[CAUSE] = t_s, CAUSE_DYNAMICS
    elif row[LAST_S] > -np.inf and row[NEXT_S] - (row[LAST_S] + longest_s) >= threshold_s:
        row[NEXT_S], row[CAUSE] = max(t_s, row[LAST_S] + longest_s), CAUSE_TIME
    row[CONTROL_S] = next_due(row[CONTROL_S], t_s + c[TIME_ACCURACY_S], c[RATE_CONTROL_INTERVAL_S])


@kernel
def critical(row: FloatVector, t_s: float, event: bool, c: FloatVector) -> None:
    """Send at once when a critical event begins, and every critical interval while it goes on."""
    if event:
        due_s = row[LAST_S] + c[CRITICAL_INTERVAL_S]
        row[NEXT_S] = t_s if row[CRITICAL] == 0.0 else min(row[NEXT_S], max(due_s, t_s))
        row[CAUSE] = CAUSE_CRITICAL
    elif row[CAUSE] == CAUSE_CRITICAL:
        # The event ended between two of its messages: the timers rule again.
        row[NEXT_S], row[CAUSE] = row[LAST_S] + row[INTER_TRANSMIT_TIME_S], CAUSE_TIME
    row[CRITICAL] = 1.0 if event else 0.0


@kernel
def assume_received(row: FloatVector, uniform: float, c: FloatVector) -> bool:
    """Whether the remotes are believed to hold the message just sent.

    It is lost with the probability that the channel quality gives, but no more than so many times in a row.
    """
    if uniform < row[CHANNEL_QUALITY]:
        row[FAILURES] += 1.0
        if row[FAILURES] <= c[MAX_SUCCESSIVE_FAILURES]:
            return False
    row[FAILURES] = 0.0
    return True


@kernel
def sent(row: FloatVector, at_s: float, jitter: float, loss: float, c: FloatVector) -> tuple[float, bool]:
    """Account for a message: (power [dBm], whether it is believed received); schedules the next.

    ``jitter`` and ``loss`` are uniform in [0, 1).
    """
    power_dbm = c[MAX_POWER_DBM]
    if c[POWER_CONTROL] != 0.0 and row[CAUSE] == CAUSE_TIME:
        row[POWER_DBM] += c[POWER_GAIN] * (power_for(row[BUSY_RATIO], c) - row[POWER_DBM])
        power_dbm = row[POWER_DBM]
    believed = assume_received(row, loss, c)
    row[LAST_S] = at_s
    wait_s = row[INTER_TRANSMIT_TIME_S]
    if row[CAUSE] == CAUSE_DYNAMICS and c[FOLLOW_UP_S] > 0.0:
        wait_s = min(wait_s, c[FOLLOW_UP_S])
    row[NEXT_S] = at_s + wait_s + c[JITTER_S] * (2.0 * jitter - 1.0)
    row[CAUSE] = CAUSE_TIME
    return power_dbm, believed


@kernel
def step(
    row: FloatVector,
    t_s: float,
    until_s: float,
    tracking_error_m: float,
    channel_busy_ratio: float,
    neighbours: float,
    packet_error_ratio: float,
    event: bool,
    uniforms: FloatVector,
    c: FloatVector,
) -> tuple[int, float, float, bool]:
    """Decide what one vehicle sends in [t, until): (cause, time [s], power [dBm], believed received).

    Count, survey and rate control run where they are due at ``t_s``. ``uniforms`` (3,) in [0, 1) are for the
    dynamics, the jitter and the loss believed. Writes ``row`` (15,).
    """
    if t_s >= row[COUNT_S] - c[TIME_ACCURACY_S]:
        row[NEIGHBOURS] = neighbours
        row[COUNT_S] = next_due(row[COUNT_S], t_s + c[TIME_ACCURACY_S], c[DENSITY_INTERVAL_S])
    if t_s >= row[SURVEY_S] - c[TIME_ACCURACY_S]:
        survey(row, t_s, packet_error_ratio, c)
    if t_s >= row[CONTROL_S] - c[TIME_ACCURACY_S]:
        control(row, t_s, tracking_error_m, channel_busy_ratio, uniforms[0], c)
    critical(row, t_s, event, c)
    if row[NEXT_S] >= until_s:
        return CAUSE_NOTHING, np.inf, np.nan, False
    at_s = max(row[NEXT_S], t_s)
    cause = int(row[CAUSE])
    power_dbm, believed = sent(row, at_s, uniforms[1], uniforms[2], c)
    return cause, at_s, power_dbm, believed


class Vehicles(NamedTuple):
    """What `step` is given for each of B vehicles: (B,) each, ``uniforms`` (B, 3)."""

    t_s: FloatVector
    until_s: FloatVector
    tracking_error_m: FloatVector
    channel_busy_ratio: FloatVector
    neighbours: FloatVector
    packet_error_ratio: FloatVector
    event: BoolVector
    uniforms: FloatMatrix


@kernel
def step_each(
    rows: FloatMatrix,
    seen: Vehicles,
    c: FloatVector,
    out_cause: IntVector,
    out_send_s: FloatVector,
    out_power_dbm: FloatVector,
    out_believed: BoolVector,
) -> None:
    """Decide for every vehicle: all arrays (B,), ``rows`` (B, 15)."""
    for i in range(seen.t_s.size):
        out_cause[i], out_send_s[i], out_power_dbm[i], out_believed[i] = step(
            rows[i],
            seen.t_s[i],
            seen.until_s[i],
            seen.tracking_error_m[i],
            seen.channel_busy_ratio[i],
            seen.neighbours[i],
            seen.packet_error_ratio[i],
            seen.event[i],
            seen.uniforms[i],
            c,
        )
