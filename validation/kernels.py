"""Whether kernel expressions predict what scikit-learn predicts, on every window of every trip.

``kernels.py [--every N] [--expressions N]``: each window of ten samples of each trip of the data folder is
fitted by the sub-model of one expression, the next in turn, each axis on its own; scikit-learn is given the same
hyper-parameters, and both predict up to 2 s ahead. Seven kernels, all sums and products of two, and two nested
ones take turns. Prints the worst difference of each source and expression. Exit code 1 where one is above
1e-6 m.
"""

import argparse
import itertools
import os
import runpy
import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from sklearn.gaussian_process import GaussianProcessRegressor
from threadpoolctl import threadpool_limits

from modelcast.io.trips import read_trips
from modelcast.models.gp import KernelProcess
from modelcast.models.gp.expression_kernels import fit_axes
from modelcast.models.gp.kernels import LEAVES
from trip_sources import folders

__all__ = ["main"]

Array = npt.NDArray[np.float64]

SAMPLES = 10
CLAIM_M = 1e-6
HORIZONS_S = np.array([0.0, 0.1, 0.5, 1.0, 2.0])
EXPRESSIONS = (
    *LEAVES,
    *(f"{a}+{b}" for a, b in itertools.combinations_with_replacement(LEAVES, 2)),
    *(f"{a}*{b}" for a, b in itertools.combinations(LEAVES, 2)),
    "matern32*(linear+rbf)",
    "(linear+rq)*(matern12+periodic)+rbf*linear",
)
peer_of: Any = runpy.run_path(str(Path(__file__).parents[1] / "benchmarks" / "peer_kernels.py"))["peer_of"]


def windows(source: Path, every: int) -> dict[float, Array]:
    """Return every N-th gapless window of all trips, both axes one below the other, (B, n), by interval."""
    found: dict[float, list[Array]] = {}
    for trip in read_trips(source):
        for first, end in zip(trip.segments[:-1], trip.segments[1:], strict=True):
            if end - first >= SAMPLES:
                part = trip.position_m[first:end]
                view = np.lib.stride_tricks.sliding_window_view(part, SAMPLES, axis=0)[::every]
                flat = view.reshape(-1, SAMPLES)
                # To the millisecond: the tables are made anew for every interval.
                found.setdefault(round(trip.dt_s, 3), []).append(flat - flat[:, -1:])
    return {dt_s: np.concatenate(parts) for dt_s, parts in found.items()}


def difference_m(expression: str, y: Array, dt_s: float) -> float:
    """Return the largest difference of two predictions of windows, (B, n)."""
    model = KernelProcess(expression)
    ready = model.point_functions(dt_s)
    count = len(model.kernel.hyperparameters) + 1
    fits = np.empty((len(y), count + SAMPLES + 1))
    fit_axes(y, ready.constants, fits)
    own = fits[:, :-1]
    found = model.predict(np.concatenate([own, own], axis=1), HORIZONS_S, dt_s=dt_s)[:, :, 0]
    times = (np.arange(SAMPLES, dtype=np.float64) - SAMPLES + 1)[:, None] * dt_s
    worst = 0.0
    for row, window in enumerate(y):
        peer = GaussianProcessRegressor(peer_of(expression, own[row, :count]), alpha=0, optimizer=None)
        theirs = peer.fit(times, window).predict(HORIZONS_S[:, None])
        worst = max(worst, float(np.abs(found[row] - theirs).max()))
    return worst


def main() -> int:
    """Compare all and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--every", type=int, default=1, help="take every N-th window only")
    parser.add_argument("--expressions", type=int, default=1, help="expressions in turn for each window")
    given = parser.parse_args()
    of_expression = dict.fromkeys(EXPRESSIONS, 0.0)
    total = 0
    with threadpool_limits(1):
        for source in folders(Path(os.environ["MODELCAST_DATA"])):
            seen, worst = 0, 0.0
            for dt_s, y in windows(source, given.every).items():
                for at, expression in enumerate(EXPRESSIONS):
                    turns = (np.arange(len(y)) + at) % len(EXPRESSIONS) < given.expressions
                    found = difference_m(expression, np.ascontiguousarray(y[turns]), dt_s)
                    worst = max(worst, found)
                    of_expression[expression] = max(of_expression[expression], found)
                seen += len(y)
            total += seen
            print(f"{source.name:28s} {seen:8d} windows of an axis, worst {worst:.1e} m", flush=True)
    for expression, found in sorted(of_expression.items(), key=lambda one: -one[1])[:10]:
        print(f"{expression:44s} worst {found:.1e} m")
    worst = max(of_expression.values())
    print(f"{total} windows of an axis, {len(EXPRESSIONS)} expressions: worst {worst:.1e} m")
    return int(worst > CLAIM_M)


if __name__ == "__main__":
    sys.exit(main())
