"""Compiled choice of a resource by sensing: reservations exclude, power ranks, then chance decides."""

from typing import NamedTuple

import numpy as np

from modelcast.channel.pool_constants import PoolConstants
from modelcast.channel.random_kernels import uniform
from modelcast.channel.sidelink_parameters import MEMORY, STEP
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import Float32Cube, Float32Vector, FloatMatrix, IntVector, UInt64Vector

__all__ = ["SidelinkConstants", "select_resource"]

_COPY_GAP = 15
"""Most subframes between the two copies of a message; TS 36.213, 14.1.1.4C and 14.1.1.7."""


class SidelinkConstants(NamedTuple):
    """Parameters as numbers, beside those of the ``pool``; made by `Sidelink`. Times are in subframes."""

    pool: PoolConstants
    overlapping: bool
    first: int
    last: int
    interval: int
    longest: int
    horizon: int
    copies: int
    one_shot: bool
    interleaved: bool
    interval_by_next: bool
    grant_by_next: bool
    shots_low: int
    shots_high: int
    counter_low: int
    counter_high: int
    keep_ratio: float
    reselect_after: int
    best_ratio: float
    best_of_possible: bool
    reserved_by_mean: bool
    first_by_chance: bool


@kernel(inlined=True)
def _add_past(v: int, begin: int, sensed: Float32Cube, past: FloatMatrix) -> None:
    """Add up what a vehicle sensed in the phases of subframes, a second long, in each sub-channel."""
    channels = past.shape[1]
    for n in range(past.shape[0]):
        phase = (begin + n) % sensed.shape[0]
        for k in range(0, sensed.shape[2], channels):
            for s in range(channels):
                past[n, s] += sensed[phase, v, k + s]


@kernel(inlined=True)
def _find_strongest(v: int, at: int, interval: int, reserved: Float32Cube, strongest: Float32Vector) -> None:
    """Write the strongest reservations that a subframe and its returns would meet, by sub-channel."""
    horizon = reserved.shape[0]
    phase = at % horizon
    for s in range(strongest.size):
        strongest[s] = reserved[phase, v, s]
    if interval > 0:
        for later in range(at + interval, at + horizon, interval):
            phase = later % horizon
            for s in range(strongest.size):
                strongest[s] = max(strongest[s], reserved[phase, v, s])


@kernel(inlined=True)
def _second(chosen: IntVector, first: int, bands: int, random: UInt64Vector) -> int:
    """Return a second resource for the same message, within `_COPY_GAP` subframes; -1 for none."""
    near = 0
    for one in chosen:
        near += 1 <= abs(one // bands - first // bands) <= _COPY_GAP
    if near == 0:
        return -1
    left = int(uniform(random) * near)
    for one in chosen:
        if 1 <= abs(one // bands - first // bands) <= _COPY_GAP:
            if left == 0:
                return int(one)
            left -= 1
    return -1


@kernel
def select_resource(
    v: int,
    now: int,
    length: int,
    interval: int,
    blind: bool,
    sensed: Float32Cube,
    reserved: Float32Cube,
    random: UInt64Vector,
    constants: SidelinkConstants,
) -> tuple[int, int, int, int]:
    """Return subframe and first sub-channel of a resource chosen by sensing (TS 36.213, 14.1.1.6).

    It comes back after ``interval``; 0 is for one message alone. ``blind`` leaves all to chance. Behind it
    stand subframe and sub-channel of the second copy's, the later one of the two; -1 where there is one copy,
    or no room for a second.
    """
    step = 1 if constants.overlapping else length
    channels, noise_mw = constants.pool.sub_channels, constants.pool.noise_mw
    bands = (channels - length) // step + 1
    subframes = constants.last - constants.first + 1
    total = subframes * bands
    past, taken = np.zeros((subframes, channels)), np.empty(channels, dtype=np.float32)
    _add_past(v, now + constants.first, sensed, past)
    mean, strongest = np.empty(total), np.empty(total)
    share = 1.0 / (MEMORY // STEP * constants.pool.elements)
    for n in range(subframes):
        _find_strongest(v, now + constants.first + n, interval, reserved, taken)
        for b in range(bands):
            power, rsrp, loudest = 0.0, 0.0, 0.0
            for s in range(b * step, b * step + length):
                rsrp = max(rsrp, taken[s])
                loudest = max(loudest, past[n, s] * share)
                power += past[n, s]
            # A part in a million of chance decides between resources that are equally quiet.
            mean[n * bands + b] = power + (power + noise_mw) * 1e-6 * uniform(random)
            by_mean = constants.reserved_by_mean and rsrp > 0.0
            strongest[n * bands + b] = loudest if by_mean else rsrp
    possible = np.isfinite(mean).sum()
    wanted = int(np.ceil(constants.best_ratio * (possible if constants.best_of_possible else total)))
    wanted = max(min(wanted, possible), 1)
    limit = constants.pool.reserved_mw
    free = np.isfinite(mean) & (strongest <= limit)
    while free.sum() < wanted and limit < 1e6:
        limit *= 2.0
        free = np.isfinite(mean) & (strongest <= limit)
    chosen = np.arange(total) if blind else np.flatnonzero(free)
    second = -1
    if chosen.size == 0:
        pick = int(uniform(random) * total)
    else:
        if chosen.size > wanted and not blind:
            quietest = mean[chosen]
            chosen = chosen[quietest <= np.partition(quietest, wanted - 1)[wanted - 1]]
        pick = chosen[int(uniform(random) * chosen.size)]
        if constants.copies > 1:
            second = _second(chosen, pick, bands, random)
    begin = now + constants.first
    if second < 0:
        return begin + pick // bands, (pick % bands) * step, -1, -1
    if second < pick:
        pick, second = second, pick
    return begin + pick // bands, (pick % bands) * step, begin + second // bands, (second % bands) * step
