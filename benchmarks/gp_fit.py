"""How fast is the exact fit, and does it find the likelihood's maximum? scikit-learn in the same run.

Likelihoods are computed anew by dense algebra in extended precision from the hyper-parameters that each
program returns, so that neither program's bookkeeping counts. Processor times of one thread throughout; needs
the real trips.
"""

import argparse
import time
import warnings
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, DotProduct, WhiteKernel
from threadpoolctl import threadpool_limits

from measured import record
from modelcast.models.base import Windows
from modelcast.models.gp import GaussianProcess, fit_axis
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from windows import real_windows

__all__ = ["main"]

Array = npt.NDArray[np.float64]
DT_S = 0.1
WIDE = (1e-8, 1e8)
TOLERANCE = 1e-3


def peer(form: str, starts: int) -> GaussianProcessRegressor:
    """Return scikit-learn's regressor with the same kernel and bounds."""
    kernel = ConstantKernel(1, WIDE) * RBF(1, (0.1, 10))
    kernel += ConstantKernel(100, WIDE) * DotProduct(0, "fixed") + WhiteKernel(1e-3, (1e-6, 1))
    if form == "intercept":
        # A wide fixed constant stands for the flat prior.
        kernel += ConstantKernel(1e4, "fixed")
    return GaussianProcessRegressor(kernel, alpha=0, n_restarts_optimizer=starts - 1, random_state=0)


def peer_fits(y: Array, form: str, starts: int) -> tuple[Array, float]:
    """Return (lengthscale, noise, slope, variance), (B, 4), and the seconds of the processor a fit."""
    t = times(y.shape[1])[:, None]
    found: list[Array] = []
    begin = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for window in y:
            theta = np.exp(peer(form, starts).fit(t, np.squeeze(window)).kernel_.theta)
            found.append(theta[[1, 3, 2, 0]])
    return np.array(found), (time.process_time() - begin) / len(y)


def times(samples: int) -> Array:
    """Return the times of the samples [s]."""
    return (np.arange(samples, dtype=np.float64) - samples + 1) * DT_S


def log_likelihood(y: Array, form: str, hyper: Array) -> Array:
    """Return dense log-likelihoods of (B, n, D) in extended precision, for rows as in `peer_fits`."""
    count, n, axes = y.shape
    t = times(n).astype(np.longdouble)
    lengthscale, noise, slope, variance = hyper.astype(np.longdouble).T[:, :, None, None]
    C = variance * np.exp(-0.5 * np.square((t[:, None] - t) / lengthscale))
    C += noise * np.eye(n) + slope * np.outer(t, t)
    L = np.zeros_like(C)
    Z = np.concatenate([y.astype(np.longdouble), np.ones((count, n, 1))], axis=2)
    for i in range(n):
        for j in range(i + 1):
            rest = C[:, i, j] - (L[:, i, :j] * L[:, j, :j]).sum(axis=1)
            L[:, i, j] = np.sqrt(rest) if i == j else rest / L[:, j, j]
        Z[:, i] = (Z[:, i] - (L[:, i, :i, None] * Z[:, :i]).sum(axis=1)) / L[:, i, i][:, None]
    total = 2 * np.log(np.einsum("bii->bi", L)).sum(axis=1)
    square = (Z[:, :, :axes] ** 2).sum(axis=(1, 2))
    m = n
    if form == "intercept":
        o = (Z[:, :, axes] ** 2).sum(axis=1)
        square -= ((Z[:, :, :axes] * Z[:, :, axes:]).sum(axis=1) ** 2).sum(axis=1) / o
        total += np.log(o)
        m = n - 1
    return (-0.5 * (square + axes * total + m * axes * np.log(2 * np.pi))).astype(np.float64)


def least_seconds(work: Callable[[], object], repeats: int = 15) -> float:
    """Return the least processor time of several runs, after one that compiles."""
    work()
    spent: list[float] = []
    for _ in range(repeats):
        begin = time.process_time()
        work()
        spent.append(time.process_time() - begin)
    return min(spent)


def report(label: str, ours: Array, theirs: Array) -> None:
    """Print and keep how often we do not fall short, and print how far we do."""
    short = theirs - ours
    share = float((short <= TOLERANCE).mean())
    record(f"{label}: likelihood at least scikit-learn's less {TOLERANCE}", 100 * share, "% of windows")
    print(
        f"  {label}: no worse by more than {TOLERANCE} on {share:.2%} of {len(short)}; "
        f"worst {max(0.0, short.max()):.4f}; better by more than that on {(short < -TOLERANCE).mean():.1%}"
    )


def told(what: str, seconds: float, peer_seconds: float) -> None:
    """Print and keep both times of a fit."""
    record(what, 1e6 * seconds, "µs", peer=("scikit-learn", 1e6 * peer_seconds))
    print(f"  ours {seconds * 1e6:.2f} µs a fit, scikit-learn {peer_seconds * 1e3:.2f} ms: ratio", end=" ")
    print(f"{peer_seconds / seconds:.0f}")


def axis_study(windows: Array, timed: int, restarted: int) -> None:
    """Compare the anchored fit of one axis."""
    y = np.ascontiguousarray(windows[:, :, 0] - windows[:, -1:, 0])
    seconds = least_seconds(lambda: fit_axis(y, dt_s=DT_S)) / len(y)
    fits = fit_axis(y, dt_s=DT_S)
    s = fits.variance_m2
    hyper = np.stack([fits.lengthscale_s, fits.noise_ratio * s, fits.linear_ratio_per_s2 * s, s], axis=1)
    ours = log_likelihood(y[:, :, None], "anchored", hyper)
    _, peer_seconds = peer_fits(y[:timed], "anchored", 1)
    print(f"anchored, one axis, noise floor 1 mm, {np.mean(fits.floored):.0%} on the floor")
    told("anchored fit, one axis", seconds, peer_seconds)
    theirs, _ = peer_fits(y, "anchored", 1)
    report("anchored, its one start", ours, log_likelihood(y[:, :, None], "anchored", theirs))
    theirs, _ = peer_fits(y[:restarted], "anchored", 10)
    report(
        "anchored, its ten starts",
        ours[:restarted],
        log_likelihood(y[:restarted, :, None], "anchored", theirs),
    )


def joint_study(windows: Array, timed: int) -> None:
    """Compare the intercept form, both axes together."""
    model = GaussianProcess(form="intercept")
    y = windows - windows[:, -1:]
    full = Windows(
        np.concatenate([windows, np.zeros((*windows.shape[:2], SAMPLE_COLUMNS - 2))], axis=2), dt_s=DT_S
    )
    seconds = least_seconds(lambda: model.fit(full)) / len(windows)
    parameters = model.fit(full)
    names = model.parameter_names
    lengthscale, b, a, s = (
        parameters[:, names.index(name)]
        for name in ("lengthscale_s", "noise_ratio", "linear_ratio_per_s2", "variance_m2")
    )
    # A slope's prior about the window's middle differs from one about its end by a constant, which is flat.
    ours = log_likelihood(y, "intercept", np.stack([lengthscale, b * s, a * s, s], axis=1))
    theirs, peer_seconds = peer_fits(y[:timed], "intercept", 1)
    print("intercept, east and north jointly")
    told("intercept fit, both axes", seconds, peer_seconds)
    report("intercept, its one start", ours[:timed], log_likelihood(y[:timed], "intercept", theirs))
    horizons = np.linspace(0.1, 3.0, 500)
    few = parameters[:40]
    per = least_seconds(lambda: model.predict(few, horizons, dt_s=DT_S)) / (len(few) * horizons.size)
    record("predict, intercept", per * 1e9, "ns")
    print(f"  predict, called through its pointer: {per * 1e9:.0f} ns")


def main() -> None:
    """Run both studies."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--windows", type=int, default=5000)
    parser.add_argument("--timed", type=int, default=200)
    parser.add_argument("--restarted", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    windows = real_windows(given.windows, given.seed)
    with threadpool_limits(1):
        axis_study(windows, given.timed, given.restarted)
        joint_study(windows, given.timed)


if __name__ == "__main__":
    main()
