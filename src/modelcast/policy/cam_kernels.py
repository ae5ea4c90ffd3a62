"""Compiled triggering of cooperative awareness messages over one trip."""

from typing import Any

import numba
import numpy as np

__all__ = ["trigger"]

_TIME_SLACK_S = 1e-9
"""Sums of sampling steps may fall short of a whole number of tenths by rounding."""


@numba.njit(cache=True, nogil=True)
def trigger(
    t_s: Any,
    position_m: Any,
    speed_mps: Any,
    heading_rad: Any,
    segment_start: Any,
    heading_change_rad: float,
    distance_m: float,
    speed_change_mps: float,
    shortest_s: float,
    longest_s: float,
    timeouts: int,
    transmits: Any,
) -> None:
    """Write at which samples a message is generated, ``transmits`` (T,)."""
    last = 0
    interval_s = longest_s
    counted = 0
    for i in range(t_s.size):
        transmits[i] = False
        if segment_start[i] == i:
            transmits[i] = True
            last, interval_s, counted = i, longest_s, 0
            continue
        elapsed_s = t_s[i] - t_s[last]
        if elapsed_s < shortest_s - _TIME_SLACK_S:
            continue
        turned = np.abs(heading_rad[i] - heading_rad[last]) % (2.0 * np.pi)
        turned = min(turned, 2.0 * np.pi - turned)
        east = position_m[i, 0] - position_m[last, 0]
        north = position_m[i, 1] - position_m[last, 1]
        if (
            turned > heading_change_rad
            or east * east + north * north > distance_m * distance_m
            or np.abs(speed_mps[i] - speed_mps[last]) > speed_change_mps
        ):
            interval_s = min(max(elapsed_s, shortest_s), longest_s)
            counted = 0
        elif elapsed_s >= interval_s - _TIME_SLACK_S:
            counted += 1
            if counted >= timeouts:
                interval_s = longest_s
        else:
            continue
        transmits[i] = True
        last = i
