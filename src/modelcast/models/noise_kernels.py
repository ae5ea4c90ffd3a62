"""Compiled online estimate of white position noise from divided differences of past positions."""

from math import sqrt
from typing import Any

import numba

__all__ = ["difference_variances", "settle"]


@numba.njit(cache=True, nogil=True)
def difference_variances(t_s: Any, position_m: Any, segment_start: Any, order: int, out: Any) -> None:
    """Mean square of both axes' differences of an order, at unit noise gain, into ``out`` (T,) [m²].

    The weights are those of a divided difference at the times given, so that no polynomial of a lower degree
    enters however uneven the steps. -1 where a part has too few samples yet.
    """
    for i in range(t_s.size):
        out[i] = -1.0
        if i - segment_start[i] < order:
            continue
        east = north = gain = 0.0
        for a in range(i - order, i + 1):
            weight = 1.0
            for b in range(i - order, i + 1):
                if a != b:
                    weight *= (t_s[i] - t_s[i - 1]) / (t_s[a] - t_s[b])
            east += weight * (position_m[a, 0] - position_m[i, 0])
            north += weight * (position_m[a, 1] - position_m[i, 1])
            gain += weight * weight
        out[i] = (east * east + north * north) / (2.0 * gain)


@numba.njit(cache=True, nogil=True)
def settle(
    squares: Any,
    count: float,
    clip: float,
    share: float,
    prior: float,
    prior_count: float,
    free: int,
    out: Any,
) -> None:
    """Running mean of squares, each clipped at a multiple of the mean so far; its root into ``out`` (T,).

    ``count`` values are averaged (exponentially), fewer at the start; the first ``free`` are not clipped.
    ``share`` is what clipping leaves of the mean of white noise. Negative and zero values are passed over:
    they say that there was no difference, or that the receiver froze.
    """
    mean = share * prior * prior
    seen = 0
    for i in range(squares.size):
        value = squares[i]
        if value > 0.0:
            seen += 1
            value = share * value if seen <= free else min(value, clip * mean)
            mean += (value - mean) / min(prior_count + seen, count)
        out[i] = sqrt(mean / share)
