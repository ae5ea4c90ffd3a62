"""Maximum-likelihood fits of one axis, in batch: for studies and for comparison with other programs."""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.gp import gaussian_process_kernels as kernels
from modelcast.models.gp import layout
from modelcast.models.gp.tables import Bounds, Form, pack
from modelcast.models.gp.time_grid import TimeGrid, check_window

__all__ = ["AxisFits", "fit_axis"]


@dataclass(frozen=True, slots=True)
class AxisFits:
    """What the likelihood's maximum is for each of B windows.

    Parameters
    ----------
    lengthscale_s
        Lengthscale, (B,) [s].
    variance_m2
        Variance of the RBF part, (B,) [m²].
    noise_ratio
        White noise variance relative to it, (B,).
    linear_ratio_per_s2
        Variance of the slope relative to it, (B,) [1/s²].
    slope_mps
        Slope of the fitted line, (B,) [m/s].
    intercept_m
        Its value at the last sample, 0 in the anchored form, (B,) [m].
    weights_m
        What each sample adds to the displacement at horizon 0, (B, n) [m].
    floored
        1 where the noise lies on its floor, (B,).
    log_likelihood
        Logarithm of the (restricted, in the intercept form) likelihood, (B,).
    """

    lengthscale_s: FloatArray
    variance_m2: FloatArray
    noise_ratio: FloatArray
    linear_ratio_per_s2: FloatArray
    slope_mps: FloatArray
    intercept_m: FloatArray
    weights_m: FloatArray
    floored: FloatArray
    log_likelihood: FloatArray


def fit_axis(
    displacements_m: FloatArray, *, dt_s: float, form: Form = "anchored", noise_floor_m: float = 0.001
) -> AxisFits:
    """Fit one axis of every window by maximum likelihood.

    Parameters
    ----------
    displacements_m
        Positions, oldest first; only differences to the last one count, (B, n) [m].
    dt_s
        Sampling interval [s].
    form
        Form of the linear part, as in `GaussianProcess`.
    noise_floor_m
        Least standard deviation of the white noise [m].

    Raises
    ------
    ValueError
        Where the windows are too short, too long or not finite.

    Examples
    --------
    >>> fits = fit_axis(np.linspace(-9.0, 0.0, 10)[None], dt_s=0.1)
    >>> fits.slope_mps.round(3), fits.floored
    (array([10.]), array([1.]))
    """
    samples = displacements_m.shape[1]
    check_window(samples)
    if not np.isfinite(displacements_m).all():
        raise ValueError("displacements_m must be finite: skip a vehicle without a full window")
    constants = pack(TimeGrid(samples, round(dt_s, 6)), form, Bounds(noise_floor_m))
    out = np.empty((displacements_m.shape[0], layout.OUT_WEIGHTS + samples))
    windows = np.ascontiguousarray(displacements_m, dtype=np.float64)[:, :, None]
    kernels.fit_axes(windows, constants, out)
    return AxisFits(
        lengthscale_s=out[:, layout.OUT_LENGTHSCALE],
        variance_m2=out[:, layout.OUT_VARIANCE],
        noise_ratio=out[:, layout.OUT_NOISE_RATIO],
        linear_ratio_per_s2=out[:, layout.OUT_LINEAR_RATIO],
        slope_mps=out[:, layout.OUT_SLOPE],
        intercept_m=out[:, layout.OUT_CONSTANT],
        weights_m=out[:, layout.OUT_WEIGHTS :],
        floored=out[:, layout.OUT_FLOORED],
        log_likelihood=out[:, layout.OUT_LOG_LIKELIHOOD],
    )
