"""Compiled online estimate of white position noise from divided differences of past positions."""

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector

__all__ = ["difference_variance", "settled"]


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
    """Take one square into the running mean, clipped at a multiple of it: (mean, how many were seen).

    ``count`` values are averaged (exponentially), fewer at the start; the first ``free`` are not clipped. The
    mean starts at ``share * prior * prior`` with none seen; the noise is ``sqrt(mean / share)``, where
    ``share`` is what clipping leaves of the mean of white noise. A square of zero is passed over: the
    receiver froze.
    """
    if square > 0.0:
        seen += 1.0
        square = share * square if seen <= free else min(square, clip * mean)
        mean += (square - mean) / min(prior_count + seen, count)
    return mean, seen
