"""Who can cut in on whom: a vehicle a little ahead in the lane beside, and room for it there."""

import numpy as np

from modelcast.core.arrays import BoolArray, IntArray
from modelcast.world.scenario import braking_kernels as kernels
from modelcast.world.scenario import following_kernels as following
from modelcast.world.scenario import highway_kernels as rows
from modelcast.world.scenario.highway import HighwayState

__all__ = ["find_cut_in"]

_WITHIN_S = 0.1  # of the time gap that was drawn
_SLOWEST_MPS = 10.0
_CLOSING_MPS = 2.0  # both drive about equally fast, so that the gap lasts
_FRONT_S = 0.5  # from the place cut in to, to the next ahead in that lane


def find_cut_in(
    road: HighwayState,
    stream: kernels.Stream,
    *,
    length_m: float,
    forward: int,
    gap_s: float,
) -> tuple[int, int] | None:
    """The vehicle that can cut in with the time gap nearest to one, and its new lane; None for nobody.

    Parameters
    ----------
    road
        The traits.
    stream
        The vehicles.
    length_m
        Of the periodic road [m].
    forward
        Slots on the first carriageway.
    gap_s
        The time gap asked for [s]; what is found is within 0.1 s of it.
    """
    numbers, integers = stream.numbers, stream.integers
    place, speed, lane = numbers[rows.S], numbers[rows.V], integers[rows.LANE]
    half = 0.5 * road.drivers[following.LENGTH]
    calm = (integers[kernels.PHASE] == kernels.DRIVES) & (numbers[rows.PROGRESS] >= 1.0)
    calm &= (integers[kernels.TOUCHES] == 0) & (speed >= _SLOWEST_MPS)
    ready = np.flatnonzero(calm)
    same_way = (ready[:, None] < forward) == (ready[None] < forward)
    beside = np.abs(lane[ready][:, None] - lane[ready][None]) == 1
    alike = np.abs(speed[ready][:, None] - speed[ready][None]) <= _CLOSING_MPS
    # row: who cuts in; column: who is cut in on
    gap_m = (place[ready][:, None] - place[ready][None]) % length_m - half[ready][:, None] - half[ready][None]
    off_s = np.where(same_way & beside & alike, np.abs(gap_m / speed[ready][None] - gap_s), np.inf)
    for flat in np.argsort(off_s, axis=None):
        one, other = divmod(int(flat), ready.size)
        if off_s[one, other] > _WITHIN_S:
            return None
        who, behind = int(ready[one]), int(ready[other])
        # nobody else is in that lane, or moves to or from it, up to some way ahead of the new place
        new = int(lane[behind])
        slots: IntArray = np.arange(place.size, dtype=np.int64)
        ours = slots < forward if who < forward else slots >= forward
        others: BoolArray = np.asarray(
            ours & ((lane == new) | (integers[rows.OLD_LANE] == new)), dtype=np.bool_
        )
        others[[who, behind]] = False
        front_m = half[who] + _FRONT_S * speed[who] + half
        reach_m = (place[who] - place[behind]) % length_m + front_m
        if not (others & ((place - place[behind]) % length_m < reach_m)).any():
            return who, new
    return None
