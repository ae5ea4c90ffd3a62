"""Compiled causal velocity estimates from past positions."""

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector

__all__ = ["end_slope"]


@kernel
def end_slope(
    t_s: FloatVector, values: FloatMatrix, first: int, last: int, column: int, degree: int
) -> tuple[float, float]:
    """Slope at row ``last`` of a least-squares polynomial of degree 1 or 2 through rows from ``first`` on.

    The values are those of ``column`` and the next, at the times ``t_s``. Two rows give a straight line,
    fewer a slope of zero.
    """
    count = last - first + 1
    if count < 2:
        return 0.0, 0.0
    s1 = s2 = s3 = s4 = 0.0
    e0 = e1 = e2 = n0 = n1 = n2 = 0.0
    for j in range(first, last + 1):
        h = t_s[j] - t_s[last]
        east = values[j, column] - values[last, column]
        north = values[j, column + 1] - values[last, column + 1]
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
        return (count * e1 - s1 * e0) / bottom, (count * n1 - s1 * n0) / bottom
    # Cramer's rule on the 3 x 3 normal equations, for the linear coefficient only.
    bottom = count * (s2 * s4 - s3 * s3) - s1 * (s1 * s4 - s3 * s2) + s2 * (s1 * s3 - s2 * s2)
    east = count * (e1 * s4 - s3 * e2) - e0 * (s1 * s4 - s3 * s2) + s2 * (s1 * e2 - e1 * s2)
    north = count * (n1 * s4 - s3 * n2) - n0 * (s1 * s4 - s3 * s2) + s2 * (s1 * n2 - n1 * s2)
    return east / bottom, north / bottom
