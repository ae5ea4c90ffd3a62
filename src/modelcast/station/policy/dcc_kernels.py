"""Compiled decentralised congestion control: the time a vehicle must wait between its messages."""

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector
from modelcast.station.policy.timer_kernels import next_due

__all__ = [
    "ADAPTIVE",
    "BUSY_RATIO",
    "DUE_S",
    "MEASURES",
    "NONE",
    "PREVIOUS_BUSY_RATIO",
    "REACTIVE",
    "SHARE",
    "STATE_COLUMNS",
    "adapt",
    "adaptive_interval",
    "react",
    "reactive_interval",
    "step",
]

NONE, ADAPTIVE, REACTIVE = range(3)
"""Codes of what controls."""

SHARE, BUSY_RATIO, PREVIOUS_BUSY_RATIO, MEASURES, DUE_S = range(5)
"""Columns of a vehicle's state: delta (adaptive) or the state's number (reactive), smoothed and previous
channel busy ratio, measures taken, when the next is due."""

STATE_COLUMNS = 5

(
    RELAXATION,
    GAIN,
    TARGET_BUSY_RATIO,
    MIN_SHARE,
    MAX_SHARE,
    MAX_RISE,
    MAX_FALL,
    BUSY_WEIGHT,
    MEASURES_AN_UPDATE,
    SHORTEST_S,
    LONGEST_S,
    MEASURING_INTERVAL_S,
) = range(12)
"""Constants of the adaptive approach, in the order of the fields of `AdaptiveDcc`."""

_NEIGHBOURING_ONLY, _REACTIVE_INTERVAL_S, _TABLE = range(3)
"""Constants of the reactive approach: two numbers, then S-1 bounds and S intervals."""

_TIME_SLACK_S = 1e-6
"""A step that comes this much before a measure is due takes it."""


@kernel
def adapt(row: FloatVector, channel_busy_ratio: float, c: FloatVector) -> None:
    """Take one measure in; every so many measures, move the share of the channel (clause 5.4, steps 1-5)."""
    row[MEASURES] += 1.0
    if row[MEASURES] >= c[MEASURES_AN_UPDATE]:
        row[MEASURES] = 0.0
        mean = 0.5 * (channel_busy_ratio + row[PREVIOUS_BUSY_RATIO])
        row[BUSY_RATIO] = (1.0 - c[BUSY_WEIGHT]) * row[BUSY_RATIO] + c[BUSY_WEIGHT] * mean
        offset = c[GAIN] * (c[TARGET_BUSY_RATIO] - row[BUSY_RATIO])
        offset = min(max(offset, c[MAX_FALL]), c[MAX_RISE])
        share = (1.0 - c[RELAXATION]) * row[SHARE] + offset
        row[SHARE] = min(max(share, c[MIN_SHARE]), c[MAX_SHARE])
    row[PREVIOUS_BUSY_RATIO] = channel_busy_ratio


@kernel
def adaptive_interval(row: FloatVector, airtime_s: float, c: FloatVector) -> float:
    """Time from the start of one message to that of the next: airtime over share, within bounds (B.1)."""
    return min(max(airtime_s / row[SHARE], c[SHORTEST_S]), c[LONGEST_S])


@kernel
def react(row: FloatVector, channel_busy_ratio: float, c: FloatVector) -> None:
    """Choose the state for a measure of the channel busy ratio."""
    states = (c.size - _TABLE + 1) // 2
    state = 0
    while state < states - 1 and channel_busy_ratio >= c[_TABLE + state]:
        state += 1
    if c[_NEIGHBOURING_ONLY] != 0.0:
        held = int(row[SHARE])
        state = min(max(state, held - 1), held + 1)
    row[SHARE] = state


@kernel
def reactive_interval(row: FloatVector, c: FloatVector) -> float:
    """Shortest time between messages in the state held."""
    states = (c.size - _TABLE + 1) // 2
    return c[_TABLE + states - 1 + int(row[SHARE])]


@kernel
def step(
    row: FloatVector,
    control: int,
    t_s: float,
    channel_busy_ratio: float,
    airtime_s: float,
    constants: FloatVector,
) -> float:
    """Take a measure where one is due; return the shortest time between messages. Writes ``row`` (5,)."""
    interval_s = constants[MEASURING_INTERVAL_S] if control == ADAPTIVE else constants[_REACTIVE_INTERVAL_S]
    if t_s >= row[DUE_S] - _TIME_SLACK_S:
        row[DUE_S] = next_due(row[DUE_S], t_s + _TIME_SLACK_S, interval_s)
        if control == ADAPTIVE:
            adapt(row, channel_busy_ratio, constants)
        else:
            react(row, channel_busy_ratio, constants)
    if control == ADAPTIVE:
        return adaptive_interval(row, airtime_s, constants)
    return reactive_interval(row, constants)
