"""Compiled receiver and carrier sense of one IEEE 802.11p station.

A station is a row of numbers; this module names them. `begin_reception` and `finish_reception` are what a
frame's beginning and end do to one receiver, `sense_medium` what follows for its access to the medium.
"""

from typing import NamedTuple

import numpy as np

from modelcast.channel.error_kernels import hazard_at
from modelcast.channel.random_kernels import LUCK, uniform, uniform_of
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, UInt64Vector

__all__ = [
    "ACCESS_S",
    "AIR",
    "AIR_BYTES",
    "BACKOFF",
    "BUSY",
    "BUSY_RATIO",
    "BUSY_S",
    "BYTES",
    "CALM_FROM_MW",
    "CALM_TO_MW",
    "CAPTURED_S",
    "CHANGED_S",
    "COLUMNS",
    "CONCURRENT",
    "COUNT",
    "DBM",
    "END_S",
    "EXPOSURE",
    "FIRST",
    "HALF_DUPLEX",
    "HIDDEN",
    "IDLE_S",
    "IS_CONCURRENT",
    "IS_HIDDEN",
    "LOAD",
    "LOADED_S",
    "LOCK",
    "LOCKABLE",
    "LOCKED",
    "LOCK_MW",
    "LOCK_S",
    "MESSAGE",
    "NEVER",
    "RECEIVED",
    "RECENT_MW",
    "RECENT_S",
    "SEED",
    "SENDING_S",
    "SIGNAL",
    "SIGNALS",
    "START_S",
    "WEAK",
    "DsrcConstants",
    "begin_reception",
    "disturb",
    "draw_backoff",
    "finish_reception",
    "sense_medium",
    "silent_station",
]

# Columns of ``station`` (V, COLUMNS); first those that a frame too weak to lock on to changes, side by side.
SIGNAL, SIGNALS, RECENT_S, RECENT_MW, CALM_FROM_MW, CALM_TO_MW, SENDING_S, LOCK = 0, 1, 2, 3, 4, 5, 6, 7
LOCK_MW, LOCK_S, CHANGED_S, EXPOSURE, HIDDEN, CONCURRENT, CAPTURED_S = 8, 9, 10, 11, 12, 13, 14
BUSY, BUSY_S, IDLE_S, BACKOFF, ACCESS_S, LOADED_S, LOAD, BUSY_RATIO = 15, 16, 17, 18, 19, 20, 21, 22
BYTES, DBM = 23, 24
START_S, END_S, AIR_BYTES, FIRST, LOCKABLE, COUNT = 25, 26, 27, 28, 29, 30
COLUMNS = 32
"""One is not used: rows of 32 numbers lie on whole cache lines."""

MESSAGE, AIR, SEED = 0, 1, 2
"""Columns of ``message`` (V, 3): the message that waits, the one on the air (-1 for none), and its chance."""

LOCKED, HALF_DUPLEX, WEAK, IS_HIDDEN, IS_CONCURRENT = 0, 1, 2, 3, 4
RECEIVED = 0
NEVER = -1e9
_SPOILT = 1e30
"""Exposure that no frame survives."""

_TIE_S = 1e-10
"""Frames that begin within this begin at once."""


class DsrcConstants(NamedTuple):
    """Parameters as numbers; made by `Dsrc`. Powers are in mW, times in s."""

    slot_s: float
    aifs_s: float
    extended_s: float
    window: int
    sensing_s: float
    immediate: bool
    arrival_aifs_s: float
    preamble_s: float
    symbol_s: float
    bits_per_symbol: int
    capture_s: float
    capture_ratio: float
    ties_spoil: bool
    preamble_ratio: float
    noise_mw: float
    sensitivity_mw: float
    decodable_mw: float
    energy_mw: float
    load_mw: float
    quiet_mw: float
    weak_quiet_mw: float
    gain_db: float
    range_m: float
    bin_m: float
    bins: int
    window_s: float
    by_stretch: bool
    units_fixed: float
    units_per_byte: float
    shadowed: bool
    safe_ratio: float


@kernel
def silent_station(vehicles: int) -> FloatMatrix:
    """Return the station columns of a silent channel, (V, COLUMNS)."""
    station = np.zeros((vehicles, COLUMNS))
    for v in range(vehicles):
        station[v, LOCK] = -1.0
        for column in (CAPTURED_S, RECENT_S, BUSY_S, IDLE_S, SENDING_S, START_S, END_S):
            station[v, column] = NEVER
        station[v, ACCESS_S] = np.inf
        station[v, LOADED_S] = -1.0
        station[v, CALM_FROM_MW], station[v, CALM_TO_MW] = np.inf, -np.inf
    return station


@kernel(inlined=True)
def settle(station: FloatMatrix, j: int, t_s: float, hazard: FloatVector, constants: DsrcConstants) -> None:
    """Count what a locked receiver suffered since its surroundings last changed."""
    holder = int(station[j, LOCK])
    airtime_s = station[holder, END_S] - station[holder, START_S]
    payload_from = station[j, LOCK_S] + constants.preamble_s
    since = max(station[j, CHANGED_S], payload_from)
    station[j, CHANGED_S] = t_s
    if t_s <= since:
        return
    other_mw = max(station[j, SIGNAL] - station[j, LOCK_MW], 0.0)
    if station[j, SIGNALS] < 1.5:
        other_mw = 0.0
    if constants.by_stretch:
        if station[j, LOCK_MW] >= constants.safe_ratio * (constants.noise_mw + other_mw):
            return
        share = (t_s - since) / (airtime_s - constants.preamble_s)
        ratio = station[j, LOCK_MW] / (constants.noise_mw + other_mw)
        units = constants.units_fixed + constants.units_per_byte * station[holder, AIR_BYTES]
        station[j, EXPOSURE] += units * share * hazard_at(ratio, hazard)
    else:
        station[j, EXPOSURE] += other_mw * (t_s - since)


@kernel(inlined=True)
def _find_calm(station: FloatMatrix, j: int, sending: bool, constants: DsrcConstants) -> None:
    """Write between which sums of power nothing changes for a station that no frame locks."""
    low_mw, high_mw = (
        min(constants.load_mw, constants.energy_mw),
        max(constants.load_mw, constants.energy_mw),
    )
    signal_mw = station[j, SIGNAL]
    from_mw = high_mw if signal_mw >= high_mw else (low_mw if signal_mw >= low_mw else -np.inf)
    to_mw = low_mw if signal_mw < low_mw else (high_mw if signal_mw < high_mw else np.inf)
    locked = station[j, LOCK] >= 0.0
    station[j, CALM_FROM_MW] = np.inf if locked else (-np.inf if sending else from_mw)
    station[j, CALM_TO_MW] = np.inf if sending else to_mw


@kernel(inlined=True)
def disturb(station: FloatMatrix, j: int, change_mw: float, frames: float) -> bool:
    """Change the power of weak frames at a station; return False where that has consequences.

    Then nothing is written: it is up to `begin_reception`, `finish_reception` and `sense_medium`. ``frames``
    is 1 at the beginning of a frame, -1 at its end.
    """
    signals = station[j, SIGNALS] + frames
    signal_mw = max(station[j, SIGNAL] + change_mw, 0.0) if signals > 0.5 else 0.0
    if signal_mw < station[j, CALM_FROM_MW] or signal_mw >= station[j, CALM_TO_MW]:
        return False
    station[j, SIGNAL], station[j, SIGNALS] = signal_mw, signals
    return True


@kernel(inlined=True)
def sense_medium(station: FloatMatrix, j: int, t_s: float, constants: DsrcConstants) -> int:
    """Bring carrier sense and load up to date; return 1 where it turned busy, -1 where it turned idle."""
    sending = station[j, SENDING_S] > t_s
    busy = (
        sending
        or (station[j, LOCK] >= 0.0 and station[j, LOCK_MW] >= constants.decodable_mw)
        or station[j, SIGNAL] >= constants.energy_mw
    )
    loaded = sending or station[j, SIGNAL] >= constants.load_mw
    _find_calm(station, j, sending, constants)
    if loaded:
        if station[j, LOADED_S] < 0.0:
            station[j, LOADED_S] = t_s
    elif station[j, LOADED_S] >= 0.0:
        station[j, LOAD] += t_s - station[j, LOADED_S]
        station[j, LOADED_S] = -1.0
    if busy:
        if station[j, BUSY] == 0.0:
            station[j, BUSY], station[j, BUSY_S] = 1.0, t_s
            if station[j, BACKOFF] > 0.0 and not (station[j, ACCESS_S] < t_s + constants.sensing_s):
                passed = np.floor((t_s - station[j, IDLE_S] - constants.aifs_s) / constants.slot_s + 1e-6)
                station[j, BACKOFF] = max(station[j, BACKOFF] - max(passed, 0.0), 0.0)
            return 1
        return 0
    if station[j, BUSY] == 1.0:
        station[j, BUSY], station[j, IDLE_S] = 0.0, t_s
        return -1
    return 0


@kernel(inlined=True)
def draw_backoff(random: UInt64Vector, window: int) -> float:
    """Return a number of slots in 0..window."""
    return np.floor(uniform(random) * (window + 1))


@kernel(inlined=True)
def is_concurrent(first_s: float, second_s: float, slot_s: float) -> bool:
    return abs(first_s - second_s) < slot_s


@kernel(inlined=True)
def begin_reception(
    station: FloatMatrix,
    j: int,
    sender: int,
    power_mw: float,
    strong: bool,
    t_s: float,
    end_s: float,
    hazard: FloatVector,
    constants: DsrcConstants,
) -> int:
    """A frame begins at one receiver: add its power, lock or not; return the flag of this pair.

    ``strong`` says whether its power is enough to lock on to it at all.
    """
    slot_s = constants.slot_s
    before_mw = station[j, SIGNAL]
    locked = station[j, LOCK] >= 0.0
    airtime_s = end_s - t_s
    concurrent_before = is_concurrent(station[j, RECENT_S], t_s, slot_s)
    if locked:
        settle(station, j, t_s, hazard, constants)
    flag = LOCKED if strong else WEAK
    if strong and station[j, SENDING_S] > t_s:
        flag = HALF_DUPLEX
    elif strong:
        heard = power_mw >= constants.preamble_ratio * (constants.noise_mw + before_mw)
        if locked:
            heard = t_s - station[
                j, LOCK_S
            ] <= constants.capture_s and power_mw >= constants.capture_ratio * (
                constants.noise_mw + before_mw
            )
        if not heard:
            at_fault_s = station[j, LOCK_S] if locked else station[j, RECENT_S]
            flag = IS_CONCURRENT if is_concurrent(at_fault_s, t_s, slot_s) else IS_HIDDEN
    if flag == LOCKED:
        if locked:
            station[j, CAPTURED_S] = t_s
        station[j, LOCK], station[j, LOCK_MW], station[j, LOCK_S] = sender, power_mw, t_s
        station[j, CHANGED_S], station[j, EXPOSURE] = t_s, 0.0
        recent_mw = min(station[j, RECENT_MW], before_mw) if concurrent_before else 0.0
        station[j, CONCURRENT] = recent_mw * airtime_s
        station[j, HIDDEN] = (before_mw - recent_mw) * airtime_s
    elif locked:
        overlap_s = min(end_s, station[int(station[j, LOCK]), END_S]) - t_s
        if is_concurrent(station[j, LOCK_S], t_s, slot_s):
            station[j, CONCURRENT] += power_mw * overlap_s
        else:
            station[j, HIDDEN] += power_mw * overlap_s
        if constants.ties_spoil and t_s - station[j, LOCK_S] < _TIE_S:
            station[j, EXPOSURE] = _SPOILT
    station[j, SIGNAL] = before_mw + power_mw
    station[j, SIGNALS] += 1.0
    station[j, RECENT_S], station[j, RECENT_MW] = t_s, power_mw
    return flag


@kernel(inlined=True)
def finish_reception(
    station: FloatMatrix,
    j: int,
    sender: int,
    power_mw: float,
    strong: bool,
    flag: int,
    t_s: float,
    hazard: FloatVector,
    constants: DsrcConstants,
    seed: int,
) -> int:
    """A frame ends at one receiver: take its power away; return what became of it."""
    start_s = station[sender, START_S]
    outcome = flag
    mine = strong and station[j, LOCK] == sender
    if station[j, LOCK] >= 0.0:
        settle(station, j, t_s, hazard, constants)
    if station[j, SENDING_S] > start_s:
        outcome = HALF_DUPLEX
    elif mine:
        units = constants.units_fixed + constants.units_per_byte * station[sender, AIR_BYTES]
        if constants.by_stretch:
            suffered = station[j, EXPOSURE]
        else:
            mean_mw = station[j, EXPOSURE] / (t_s - start_s - constants.preamble_s)
            suffered = units * hazard_at(power_mw / (constants.noise_mw + mean_mw), hazard)
        share = uniform_of(seed, j + LUCK)
        # -ln(1 - share), never below share: most frames are safe without the logarithm.
        if suffered <= share or suffered <= -np.log(1.0 - share):
            outcome = RECEIVED
        elif units * hazard_at(power_mw / constants.noise_mw, hazard) > -np.log(1.0 - share):
            outcome = WEAK
        else:
            outcome = IS_CONCURRENT if station[j, CONCURRENT] > station[j, HIDDEN] else IS_HIDDEN
    elif strong and flag == LOCKED:  # a stronger frame took the receiver away
        outcome = (
            IS_CONCURRENT if is_concurrent(station[j, CAPTURED_S], start_s, constants.slot_s) else IS_HIDDEN
        )
    if mine:
        station[j, LOCK], station[j, LOCK_MW] = -1.0, 0.0
    station[j, SIGNALS] -= 1.0
    station[j, SIGNAL] = max(station[j, SIGNAL] - power_mw, 0.0) if station[j, SIGNALS] > 0.5 else 0.0
    return outcome
