"""Where the packed constants, and the result of a search, hold what.

The packed constants are a header, the fine rows, and the coarse grid. Vectors are in the folded basis of
`modelcast.models.gp.spectrum`, even half (he) before odd half (ho).

Fine row: even vectors (he, hp), odd vectors (ho, hp), each padded with zeros to hp, a multiple of `LANES`;
then eigenvalues, linear direction, constant direction (n each).

Coarse grid: for all its lengthscales side by side, even vectors (he, NC·he) and odd vectors (ho, NC·ho); then
for each lengthscale linear direction, constant direction (n each), 1/(λ + b) as (n, NB), and tau, 1/tau, 1/o
and log|M| (NB each).
"""

__all__ = [
    "AT_COARSE_START",
    "AT_COARSE_STRIDE",
    "AT_DT",
    "AT_FLAT",
    "AT_LOG_LENGTHSCALE_START",
    "AT_LOG_LENGTHSCALE_STRIDE",
    "AT_LOG_RATIO_HIGH",
    "AT_LOG_RATIO_LOW",
    "AT_NOISE_HIGH",
    "AT_NOISE_LOW",
    "AT_SAMPLES",
    "AT_VARIANCE_HIGH",
    "AT_VARIANCE_LOW",
    "COARSE_LENGTHSCALES",
    "COARSE_NOISES",
    "COARSE_STEP",
    "FINE_LENGTHSCALES",
    "HEADER",
    "LANES",
    "OUT_CONSTANT",
    "OUT_FLOORED",
    "OUT_LENGTHSCALE",
    "OUT_LINEAR_RATIO",
    "OUT_LOG_LIKELIHOOD",
    "OUT_NOISE_RATIO",
    "OUT_SLOPE",
    "OUT_VARIANCE",
    "OUT_WEIGHTS",
    "POINTS",
]

LANES = 8
"""Doubles in the widest vector register."""
POINTS = 16
"""Noise ratios looked at together in one fine row; the compiler vectorises a loop of 16, not of 8."""

COARSE_LENGTHSCALES = 16
COARSE_NOISES = 16
COARSE_STEP = 34
"""Fine steps between two coarse lengthscales: neighbouring fine ones then differ by 0.9 %."""
FINE_LENGTHSCALES = COARSE_STEP * (COARSE_LENGTHSCALES - 1) + 1

AT_SAMPLES, AT_DT, AT_FLAT, AT_NOISE_LOW, AT_NOISE_HIGH, AT_VARIANCE_LOW, AT_VARIANCE_HIGH = range(7)
AT_LOG_RATIO_LOW, AT_LOG_RATIO_HIGH, AT_COARSE_START, AT_COARSE_STRIDE = range(7, 11)
AT_LOG_LENGTHSCALE_START, AT_LOG_LENGTHSCALE_STRIDE = range(11, 13)
HEADER = 16

OUT_LENGTHSCALE, OUT_NOISE_RATIO, OUT_VARIANCE, OUT_LINEAR_RATIO, OUT_FLOORED, OUT_LOG_LIKELIHOOD = range(6)
OUT_SLOPE = 6
OUT_CONSTANT = 8
OUT_WEIGHTS = 10
