"""Compiled triggering of cooperative awareness messages: one rule, for a whole trip and for a fleet."""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatMatrix, FloatVector, IntVector
from modelcast.station.policy import dcc_kernels

__all__ = [
    "COUNTED",
    "DISTANCE_M",
    "EAST_M",
    "HEADING_CHANGE_RAD",
    "HEADING_RAD",
    "INTERVAL_S",
    "LAST_S",
    "MAX_INTER_TRANSMIT_TIME_S",
    "NORTH_M",
    "SPEED_CHANGE_MPS",
    "SPEED_MPS",
    "STATE_COLUMNS",
    "TIMEOUTS",
    "Vehicles",
    "start",
    "step",
    "step_each",
    "trigger",
]

LAST_S, EAST_M, NORTH_M, SPEED_MPS, HEADING_RAD, INTERVAL_S, COUNTED = range(7)
"""Columns of a vehicle's state: time and content of its last message, T_GenCam, messages without a change."""

STATE_COLUMNS = 7

HEADING_CHANGE_RAD, DISTANCE_M, SPEED_CHANGE_MPS, MAX_INTER_TRANSMIT_TIME_S, TIMEOUTS = range(5)
"""Constants of the rule."""

_TIME_SLACK_S = 1e-9
"""Sums of sampling steps may fall short of a whole number of tenths by rounding."""


@kernel
def start(row: FloatVector, constants: FloatVector) -> None:
    """Make a state before the first message, (7,)."""
    row[:] = 0.0
    row[LAST_S] = -np.inf
    row[INTERVAL_S] = constants[MAX_INTER_TRANSMIT_TIME_S]


@kernel
def step(
    row: FloatVector,
    t_s: float,
    east_m: float,
    north_m: float,
    speed_mps: float,
    heading_rad: float,
    shortest_s: float,
    constants: FloatVector,
) -> bool:
    """Whether one vehicle generates a message now; ``shortest_s`` is its T_GenCam_Dcc; writes ``row``."""
    longest_s = constants[MAX_INTER_TRANSMIT_TIME_S]
    if row[LAST_S] > -np.inf:
        elapsed_s = t_s - row[LAST_S]
        if elapsed_s < shortest_s - _TIME_SLACK_S:
            return False
        turned = np.abs(heading_rad - row[HEADING_RAD]) % (2.0 * np.pi)
        turned = min(turned, 2.0 * np.pi - turned)
        east, north = east_m - row[EAST_M], north_m - row[NORTH_M]
        if (
            turned > constants[HEADING_CHANGE_RAD]
            or east * east + north * north > constants[DISTANCE_M] * constants[DISTANCE_M]
            or np.abs(speed_mps - row[SPEED_MPS]) > constants[SPEED_CHANGE_MPS]
        ):
            row[INTERVAL_S] = min(max(elapsed_s, shortest_s), longest_s)
            row[COUNTED] = 0.0
        elif elapsed_s >= row[INTERVAL_S] - _TIME_SLACK_S:
            row[COUNTED] += 1.0
            if row[COUNTED] >= constants[TIMEOUTS]:
                row[INTERVAL_S] = longest_s
        else:
            return False
    row[LAST_S], row[EAST_M], row[NORTH_M] = t_s, east_m, north_m
    row[SPEED_MPS], row[HEADING_RAD] = speed_mps, heading_rad
    return True


@kernel
def trigger(
    t_s: FloatVector,
    position_m: FloatMatrix,
    speed_mps: FloatVector,
    heading_rad: FloatVector,
    segment_start: IntVector,
    shortest_s: float,
    constants: FloatVector,
    transmits: BoolVector,
) -> None:
    """Write at which samples of one trip a message is generated, ``transmits`` (T,)."""
    row = np.empty(STATE_COLUMNS)
    for i in range(t_s.size):
        if segment_start[i] == i:
            start(row, constants)
        transmits[i] = step(
            row,
            t_s[i],
            position_m[i, 0],
            position_m[i, 1],
            speed_mps[i],
            heading_rad[i],
            shortest_s,
            constants,
        )


class Vehicles(NamedTuple):
    """What B vehicles see of themselves and of the channel: (B,) each, ``position_m`` (B, 2)."""

    t_s: FloatVector
    position_m: FloatMatrix
    speed_mps: FloatVector
    heading_rad: FloatVector
    channel_busy_ratio: FloatVector
    airtime_s: FloatVector


@kernel
def step_each(
    rows: FloatMatrix,
    control_rows: FloatMatrix,
    control: int,
    seen: Vehicles,
    least_s: float,
    constants: FloatVector,
    control_constants: FloatVector,
    out_send: BoolVector,
) -> None:
    """Decide for every vehicle: congestion control gives T_GenCam_Dcc, the rule decides.

    ``rows`` (B, 7) and ``control_rows`` (B, `dcc_kernels.STATE_COLUMNS`) are written; ``control`` is one of
    the codes of `dcc_kernels`.
    """
    t_s = seen.t_s
    for i in range(t_s.size):
        shortest_s = least_s
        if control != dcc_kernels.NONE:
            shortest_s = dcc_kernels.step(
                control_rows[i],
                control,
                t_s[i],
                seen.channel_busy_ratio[i],
                seen.airtime_s[i],
                control_constants,
            )
            # Clause 6.1.3: T_GenCamMin <= T_GenCam_Dcc <= T_GenCamMax.
            shortest_s = min(max(shortest_s, least_s), constants[MAX_INTER_TRANSMIT_TIME_S])
        out_send[i] = step(
            rows[i],
            t_s[i],
            seen.position_m[i, 0],
            seen.position_m[i, 1],
            seen.speed_mps[i],
            seen.heading_rad[i],
            shortest_s,
            constants,
        )
