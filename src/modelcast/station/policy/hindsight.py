"""Scores in hindsight: how far off each sub-model would be by now, had it been sent a moment ago."""

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.station.policy import hindsight_kernels as kernels

__all__ = ["LAGS_S", "hindsight_scores"]

LAGS_S = kernels.LAGS_S
"""How long ago the predictions were made that are judged now [s]."""


def hindsight_scores(ages_s: FloatArray, errors_m: FloatArray, threshold_m: float) -> FloatArray:
    """Score sub-models by predictions made in the recent past.

    An error that grows with the square of the age reaches the threshold after ``age * sqrt(threshold /
    error)``. The score is the mean of its logarithm, held between 0.05 and 8 s; the first sub-model gets 0.2
    on top. A sender needs nothing but its own past: it fits its sub-models to the windows that ended
    `LAGS_S` ago, and holds them against the position it measures now.

    Parameters
    ----------
    ages_s
        How long ago each prediction was made, (L,) [s].
    errors_m
        Its error now, one row a sub-model, (M, L) [m].
    threshold_m
        The policy's threshold [m].

    Returns
    -------
    FloatArray
        (M,), for `modelcast.station.policy.base.TransmitInputs.predicted_life`; NaN where there is no
        prediction.

    Raises
    ------
    ValueError
        Where the shapes do not fit.

    Examples
    --------
    >>> import numpy as np
    >>> hindsight_scores(np.array([1.0]), np.array([[0.8], [0.2]]), 0.2).round(3).tolist()
    [-0.493, 0.0]
    """
    members, lags = errors_m.shape
    if ages_s.shape != (lags,):
        raise ValueError(f"ages_s must be ({lags},), one a column of errors_m, got {ages_s.shape}")
    scores = np.zeros(members)
    if not lags:
        scores += np.nan
    for m in range(members):
        for lag in range(lags):
            scores[m] += kernels.log_life(float(ages_s[lag]), float(errors_m[m, lag]), threshold_m) / lags
    scores[0] += kernels.MARGIN
    return scores
