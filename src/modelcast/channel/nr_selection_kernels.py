"""Compiled choice of resources by sensing: what others reserved excludes, then chance decides."""

from typing import NamedTuple

import numpy as np

from modelcast.channel.pool_constants import PoolConstants
from modelcast.channel.random_kernels import uniform
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import Float32Cube, IntVector, UInt64Vector

__all__ = ["NrConstants", "select_resources"]

_RAISE = 10.0**0.3
"""By 3 dB; TS 38.214, 8.1.4, step 7."""

_LOUDEST_MW = 1e6


class NrConstants(NamedTuple):
    """Parameters as numbers, beside those of the ``pool``; made by `Nr`. Times are in slots."""

    pool: PoolConstants
    overlapping: bool
    slots_a_ms: int
    first: int
    last: int
    interval: int
    longest: int
    ahead: int
    span: int
    copies: int
    dynamic: bool
    keep_ratio: float
    reselect_after: int
    free_ratio: float
    reserved_by_total: bool


@kernel(inlined=True)
def _is_taken(at: int, count: int, slots: IntVector) -> bool:
    """Return whether one of the copies chosen so far is in a slot."""
    taken = False
    for k in range(count):
        taken = taken or slots[k] == at
    return taken


@kernel
def select_resources(
    v: int,
    now: int,
    length: int,
    span: int,
    reserved: Float32Cube,
    random: UInt64Vector,
    slots: IntVector,
    bands: IntVector,
    constants: NrConstants,
) -> int:
    """Write slots and first sub-channels of the copies of a message; return how many there are.

    ``reserved`` (ahead, V, sub-channels) is what ``v`` knows of coming slots, by slot modulo ``ahead``. The
    first copy is any that is free; each other is one as free in another slot, all within ``span`` slots.
    """
    step = 1 if constants.overlapping else length
    starts = (constants.pool.sub_channels - length) // step + 1
    total = (constants.last - constants.first + 1) * starts
    strongest = np.empty(total, dtype=np.float32)
    possible = 0
    for k in range(total):
        row, band = (now + constants.first + k // starts) % constants.ahead, (k % starts) * step
        power = np.float32(0.0)
        for s in range(band, band + length):
            power = max(power, reserved[row, v, s])
        strongest[k] = power
        possible += np.isfinite(power)
    wanted = int(np.ceil(constants.free_ratio * possible))
    limit = constants.pool.reserved_mw
    free = (strongest <= limit).sum()
    while free < wanted and limit < _LOUDEST_MW:
        limit *= _RAISE
        free = (strongest <= limit).sum()
    count = 0
    while count < constants.copies:
        low, high = now, now + constants.last
        if count > 0:  # they are in order of time
            low, high = slots[count - 1] - span + 1, slots[0] + span - 1
        number = 0
        pick = -1
        for turn in range(2):
            seen = 0
            for k in range(total):
                at = now + constants.first + k // starts
                usable = strongest[k] <= limit or free == 0
                if not usable or at < low or at > high or _is_taken(at, count, slots):
                    continue
                if turn == 1 and seen == number:
                    pick = k
                    break
                seen += 1
            if turn == 0:
                if seen == 0:
                    break
                number = int(uniform(random) * seen)
        if pick < 0:
            break
        # In order of time.
        at, place = now + constants.first + pick // starts, count
        while place > 0 and slots[place - 1] > at:
            slots[place], bands[place] = slots[place - 1], bands[place - 1]
            place -= 1
        slots[place], bands[place] = at, (pick % starts) * step
        count += 1
    return count
