"""How fast is the maximum-likelihood fit of a sum of two kernels, and how good? scikit-learn in the same run.

Every sum of two of the seven kernels, on windows of ten samples of the OpenACC trips, one axis, noise floor
1 mm. scikit-learn has the same kernel and bounds, one start and its default search. ``linear+rbf`` is timed
on the general path too, though its closed form serves. One thread throughout; processor time, the least of
five runs of ours; needs the real trips.
"""

import argparse
import itertools
import time
import warnings
from typing import Any

import numpy as np
import numpy.typing as npt
from sklearn.gaussian_process import GaussianProcessRegressor
from threadpoolctl import threadpool_limits

from measured import record
from modelcast.models.gp import fit_kernel
from modelcast.models.gp.kernels import LEAVES
from peer_kernels import peer_of
from windows import real_windows

__all__ = ["main"]

Array = npt.NDArray[np.float64]
DT_S = 0.1
NOISE_M2 = (1e-6, 1e6)
TOLERANCE = 1e-3


def peer_fits(expression: str, y: Array) -> tuple[Array, float]:
    """Return log-likelihoods of windows, (B,), and the seconds a fit."""
    times = (np.arange(y.shape[1], dtype=np.float64) - y.shape[1] + 1)[:, None] * DT_S
    found: list[float] = []
    begin = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for window in y:
            kernel: Any = peer_of(expression, noise_bounds_m2=NOISE_M2)
            process = GaussianProcessRegressor(kernel, alpha=0).fit(times, window)
            found.append(float(process.log_marginal_likelihood_value_))
    return np.array(found), (time.process_time() - begin) / len(y)


def our_seconds(expression: str, y: Array, repeats: int = 5) -> float:
    """Return the least seconds a fit, after one that compiles."""
    fit_kernel(expression, y, dt_s=DT_S)
    spent: list[float] = []
    for _ in range(repeats):
        begin = time.process_time()
        fit_kernel(expression, y, dt_s=DT_S)
        spent.append(time.process_time() - begin)
    return min(spent) / len(y)


def main() -> None:
    """Compare all sums."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--windows", type=int, default=1000, help="for the time of our fit")
    parser.add_argument("--timed", type=int, default=60, help="for scikit-learn")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    windows = real_windows(given.windows, given.seed)
    y = np.ascontiguousarray(windows[:, :, 0] - windows[:, -1:, 0])
    some = y[: given.timed]
    ratios: list[float] = []
    spent: list[tuple[float, float]] = []
    shorts: list[Array] = []
    print("sum                   ours µs  peer ms  ratio  worse better  mean nats")
    with threadpool_limits(1):
        for expression in (f"{a}+{b}" for a, b in itertools.combinations_with_replacement(LEAVES, 2)):
            ours = our_seconds(expression, y)
            theirs, peer_seconds = peer_fits(expression, some)
            short = theirs - fit_kernel(expression, some, dt_s=DT_S).log_likelihood
            ratios.append(peer_seconds / ours)
            spent.append((ours, peer_seconds))
            shorts.append(short)
            worse, better = (short > TOLERANCE).mean(), (short < -TOLERANCE).mean()
            print(
                f"{expression:20s} {ours * 1e6:8.1f} {peer_seconds * 1e3:8.1f} {ratios[-1]:6.0f} "
                f"{worse:6.1%} {better:6.1%} {-short.mean():+10.4f}",
                flush=True,
            )
    short = np.concatenate(shorts)
    middle = int(np.argsort(ratios)[len(ratios) // 2])
    ours_us, theirs_us = (1e6 * one for one in spent[middle])
    told = "fit of a sum of two kernels, the one with the median ratio"
    record(told, ours_us, "µs", peer=("scikit-learn", theirs_us))
    print(f"ratio: least {min(ratios):.0f}, median {np.median(ratios):.0f}")
    worse, better = (short > TOLERANCE).mean(), (short < -TOLERANCE).mean()
    print(f"log-likelihood of {short.size} fits against scikit-learn's, in nats:", end=" ")
    print(f"worse by over {TOLERANCE} in {worse:.1%}, better in {better:.1%}, mean {-short.mean():+.4f}")


if __name__ == "__main__":
    main()
