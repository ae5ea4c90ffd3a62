"""Compiled chance of staying within a threshold, and the time until it is crossed."""

from math import cos, exp, pi, sin, sqrt

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatBlock, FloatMatrix, FloatVector

__all__ = ["NODES", "expected_times", "hold_chance"]

NODES = 48
"""Nodes of the quadrature in a quarter turn: good to 1e-4 where one axis is up to 30 times the other."""


@kernel
def _equal_radius(radius: float, radii: FloatVector, gaussian: FloatVector) -> float:
    """Gaussian's radius that holds as much as this one does, straight between the known ones."""
    low, low_gaussian = 0.0, 0.0
    last = radii.size - 1
    for k in range(radii.size):
        if radius < radii[k]:
            return low_gaussian + (gaussian[k] - low_gaussian) * (radius - low) / (radii[k] - low)
        low, low_gaussian = radii[k], gaussian[k]
    return radius * gaussian[last] / radii[last]


@kernel
def hold_chance(
    east_m2: float,
    mixed_m2: float,
    north_m2: float,
    threshold_m: float,
    radii: FloatVector,
    gaussian: FloatVector,
) -> float:
    """Chance that an error with this covariance is shorter than the threshold.

    In the eigen-basis the error is ``rho·(sqrt(l1)·cos t, sqrt(l2)·sin t)``, with t uniform. For a Gaussian,
    rho² is exponential with mean 2, and the chance is one less the mean over t of ``exp(-r²/2)`` with
    ``r² = th²/(l1·cos² t + l2·sin² t)``. The integrand is smooth and periodic: the midpoint rule over a
    quarter turn converges exponentially. Where ``radii`` (L,) hold as much as ``gaussian`` (L,) do for a
    Gaussian, r is first replaced by the Gaussian's radius of equal content.
    """
    middle = 0.5 * (east_m2 + north_m2)
    half = sqrt(0.25 * (east_m2 - north_m2) * (east_m2 - north_m2) + mixed_m2 * mixed_m2)
    large, small = middle + half, max(middle - half, 0.0)
    if large <= 0.0:
        return 1.0
    crossed = 0.0
    for k in range(NODES):
        angle = 0.5 * pi * (k + 0.5) / NODES
        c, s = cos(angle), sin(angle)
        radius = threshold_m / sqrt(large * c * c + small * s * s)
        radius = _equal_radius(radius, radii, gaussian)
        crossed += exp(-0.5 * radius * radius)
    return 1.0 - crossed / NODES


@kernel
def expected_times(
    covariances_m2: FloatBlock,
    horizons_s: FloatVector,
    threshold_m: float,
    radii: FloatMatrix,
    gaussian: FloatVector,
    out_s: FloatVector,
) -> None:
    """Time until the threshold is crossed, up to the last horizon, of (B, H, 2, 2) into ``out_s`` (B,).

    ``radii`` are (H, L), ``gaussian`` (L,). Survival is the running minimum of the chances, taken as straight
    between horizons and as one at zero.
    """
    for row in range(covariances_m2.shape[0]):
        survival, before_s, total_s = 1.0, 0.0, 0.0
        for h in range(horizons_s.size):
            one = covariances_m2[row, h]
            chance = hold_chance(one[0, 0], one[0, 1], one[1, 1], threshold_m, radii[h], gaussian)
            least = min(survival, chance)
            total_s += 0.5 * (survival + least) * (horizons_s[h] - before_s)
            survival, before_s = least, horizons_s[h]
        out_s[row] = total_s
