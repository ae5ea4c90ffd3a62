"""Compiled scoring in hindsight: how long a prediction would last, from how far off it is by now."""

from math import log, sqrt

from modelcast.core.kernel import kernel

__all__ = ["LAGS_S", "MARGIN", "log_life"]

LAGS_S = (0.3, 0.5, 0.8, 1.0, 1.5, 2.0)
"""How long ago the predictions were made that are judged now [s]."""

MARGIN = 0.2
"""Advantage of the first sub-model, in logarithms of time."""

_LEAST_ERROR_M = 1e-4
_LEAST_LIFE_S, _MOST_LIFE_S = 0.05, 8.0


@kernel
def log_life(age_s: float, error_m: float, threshold_m: float) -> float:
    """Logarithm of the age [s] at which an error that grows with its square reaches the threshold."""
    life_s = age_s * sqrt(threshold_m / max(error_m, _LEAST_ERROR_M))
    return log(min(max(life_s, _LEAST_LIFE_S), _MOST_LIFE_S))
