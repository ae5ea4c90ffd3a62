"""Compiled online estimate of white position noise from divided differences of past positions."""

from math import sqrt

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntVector

__all__ = ["difference_variance", "difference_variances", "settle", "settled"]


@kernel
def difference_variance(t_s: FloatVector, position_m: FloatMatrix, i: int, order: int) -> float:
    """Mean square of both axes' difference of an order that ends at sample ``i``, at unit noise gain [m²].

    The weights are those of a divided difference at the times given, so that no polynomial of a lower degree
    enters however uneven the steps. ``t_s`` (T,) and ``position_m`` (T, 2 or more) hold the ``order`` samples
    before too.
    """
    east = north = gain = 0.0
    for a in range(i - order, i + 1):
        weight = 1.0
        for b in range(i - order, i + 1):
            if a != b:
                weight *= (t_s[i] - t_s[i - 1]) / (t_s[a] - t_s[b])
        east += weight * (position_m[a, 0] - position_m[i, 0])
        north += weight * (position_m[a, 1] - position_m[i, 1])
        gain += weight * weight
    return (east * east + north * north) / (2.0 * gain)


@kernel
def difference_variances(
    t_s: FloatVector, position_m: FloatMatrix, segment_start: IntVector, order: int, out: FloatVector
) -> None:
    """`difference_variance` at every sample into ``out`` (T,); -1 where a part has too few samples yet."""
    for i in range(t_s.size):
        out[i] = -1.0
        if i - segment_start[i] >= order:
            out[i] = difference_variance(t_s, position_m, i, order)


@kernel
def settled(
    square: float,
    mean: float,
    seen: float,
    count: float,
    clip: float,
    share: float,
    prior_count: float,
    free: float,
) -> tuple[float, float]:
    """Take one square into the running mean: (mean, how many were seen); arguments as in `settle`.

    The mean starts at ``share * prior * prior`` with none seen; the noise is ``sqrt(mean / share)``.
    """
    if square > 0.0:
        seen += 1.0
        square = share * square if seen <= free else min(square, clip * mean)
        mean += (square - mean) / min(prior_count + seen, count)
    return mean, seen


@kernel
def settle(
    squares: FloatVector,
    count: float,
    clip: float,
    share: float,
    prior: float,
    prior_count: float,
    free: int,
    out: FloatVector,
) -> None:
    """Running mean of squares, each clipped at a multiple of the mean so far; its root into ``out`` (T,).

    ``count`` values are averaged (exponentially), fewer at the start; the first ``free`` are not clipped.
    ``share`` is what clipping leaves of the mean of white noise. Negative and zero values are passed over:
    they say that there was no difference, or that the receiver froze.
    """
    mean = share * prior * prior
    seen = 0.0
    for i in range(squares.size):
        mean, seen = settled(squares[i], mean, seen, count, clip, share, prior_count, free)
        out[i] = sqrt(mean / share)
