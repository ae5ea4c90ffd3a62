"""Compiled causal velocity estimates from past positions."""

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntVector

__all__ = ["end_slopes"]


@kernel
def end_slopes(
    t_s: FloatVector,
    position_m: FloatMatrix,
    segment_start: IntVector,
    window: int,
    degree: int,
    out: FloatMatrix,
) -> None:
    """Slope at the newest sample of a least-squares polynomial of degree 1 or 2 over the last samples.

    Parts shorter than the window use what they have; a first sample has slope zero.
    """
    for i in range(t_s.size):
        first = max(segment_start[i], i - window + 1)
        count = i - first + 1
        out[i, 0] = 0.0
        out[i, 1] = 0.0
        if count < 2:
            continue
        s1 = s2 = s3 = s4 = 0.0
        e0 = e1 = e2 = n0 = n1 = n2 = 0.0
        for j in range(first, i + 1):
            h = t_s[j] - t_s[i]
            east = position_m[j, 0] - position_m[i, 0]
            north = position_m[j, 1] - position_m[i, 1]
            s1 += h
            s2 += h * h
            s3 += h * h * h
            s4 += h * h * h * h
            e0 += east
            e1 += east * h
            e2 += east * h * h
            n0 += north
            n1 += north * h
            n2 += north * h * h
        if degree == 1 or count < 3:
            bottom = count * s2 - s1 * s1
            out[i, 0] = (count * e1 - s1 * e0) / bottom
            out[i, 1] = (count * n1 - s1 * n0) / bottom
            continue
        # Cramer's rule on the 3 x 3 normal equations, for the linear coefficient only.
        bottom = count * (s2 * s4 - s3 * s3) - s1 * (s1 * s4 - s3 * s2) + s2 * (s1 * s3 - s2 * s2)
        east = count * (e1 * s4 - s3 * e2) - e0 * (s1 * s4 - s3 * s2) + s2 * (s1 * e2 - e1 * s2)
        north = count * (n1 * s4 - s3 * n2) - n0 * (s1 * s4 - s3 * s2) + s2 * (s1 * n2 - n1 * s2)
        out[i, 0] = east / bottom
        out[i, 1] = north / bottom
