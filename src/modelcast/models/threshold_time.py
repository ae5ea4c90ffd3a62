"""How long a prediction is expected to hold: from its covariance to the time until a threshold is crossed.

Errors of one prediction hardly change their course: who is out stays out. Survival to a horizon is therefore
taken as the smallest chance so far of being within the threshold. A product of the chances over the horizons
would take every look as a new, independent throw, and depend on how many there are.
"""

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models import threshold_time_kernels
from modelcast.models.calibration import LEVELS, gaussian_radius

__all__ = ["expected_time_to_threshold", "hold_chance"]


def hold_chance(covariances_m2: FloatArray, threshold_m: float) -> FloatArray:
    """Chance that a Gaussian error of this covariance and mean zero is shorter than the threshold, (...).

    Parameters
    ----------
    covariances_m2
        (..., 2, 2) [m²].
    threshold_m
        Length [m].

    Examples
    --------
    >>> float(hold_chance(np.diag([0.04, 0.01]), 0.3).round(4))
    0.8351
    """
    covariances_m2 = np.asarray(covariances_m2, dtype=np.float64)
    known = gaussian_radius(LEVELS)
    chances = [
        threshold_time_kernels.hold_chance(one[0], one[1], one[3], threshold_m, known, known)
        for one in covariances_m2.reshape(-1, 4)
    ]
    return np.array(chances, dtype=np.float64).reshape(covariances_m2.shape[:-2])


def expected_time_to_threshold(
    covariances_m2: FloatArray,
    horizons_s: FloatArray,
    threshold_m: float,
    *,
    radii: FloatArray | None = None,
) -> FloatArray:
    """Expected time until the tracking error reaches a threshold, at most the last horizon, (B,) [s].

    Parameters
    ----------
    covariances_m2
        Of the errors at each horizon, calibrated, (B, H, 2, 2) [m²].
    horizons_s
        Horizons, positive and rising, (H,) [s]; close together where the chance falls.
    threshold_m
        Tracking error at which a sub-model has failed [m].
    radii
        Radii of the ellipses of `modelcast.models.calibration.LEVELS` at each horizon, positive and not
        falling, (H, 3), where errors are not Gaussian (`Calibration.level_radii`); None where they are.

    Raises
    ------
    ValueError
        Where shapes disagree, horizons do not rise or the threshold is not positive.

    Notes
    -----
    The integral of survival from zero to the last horizon. A sub-model that certainly holds until then has
    the last horizon as its time: compare such times only at equal horizons.

    Examples
    --------
    >>> horizons_s = np.arange(1, 51) * 0.1
    >>> sure, unsure = 0.05 * horizons_s**2, 0.5 * horizons_s**2
    >>> covariances = np.stack([s[:, None, None] ** 2 * np.eye(2) for s in (sure, unsure)])
    >>> expected_time_to_threshold(covariances, horizons_s, 0.5).round(1).tolist()
    [3.1, 1.0]
    """
    covariances_m2 = np.ascontiguousarray(covariances_m2, dtype=np.float64)
    horizons_s = np.ascontiguousarray(horizons_s, dtype=np.float64)
    if covariances_m2.ndim != 4 or covariances_m2.shape[1:] != (horizons_s.size, 2, 2):
        raise ValueError(
            f"covariances_m2 must be (B, {horizons_s.size}, 2, 2), one a horizon, got {covariances_m2.shape}"
        )
    if not (np.diff(horizons_s, prepend=0.0) > 0).all():
        raise ValueError(f"horizons_s must be positive and rise, got {horizons_s}")
    if not threshold_m > 0:
        raise ValueError(f"threshold_m must be positive, got {threshold_m}")
    known = gaussian_radius(LEVELS)
    radii = np.tile(known, (horizons_s.size, 1)) if radii is None else np.ascontiguousarray(radii)
    if radii.shape != (horizons_s.size, known.size):
        raise ValueError(f"radii must be ({horizons_s.size}, {known.size}), got {radii.shape}")
    out_s = np.empty(covariances_m2.shape[0])
    threshold_time_kernels.expected_times(covariances_m2, horizons_s, float(threshold_m), radii, known, out_s)
    return out_s
