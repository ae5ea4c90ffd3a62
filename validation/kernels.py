"""Whether kernel expressions predict what scikit-learn predicts, on every window of every trip.

``kernels.py [--every N] [--expressions N]``: each window of ten samples of each trip of the data folder is
fitted by the sub-model of one expression, the next in turn, each axis on its own; scikit-learn is given the
same hyper-parameters, and both predict up to 2 s ahead. Seven kernels, all sums and products of two, and two
nested ones take turns. Dense algebra in extended precision is the judge. Prints the worst of each source and
expression: ours from the judge, scikit-learn's from it, ours from scikit-learn's. Exit code 1 where ours is
above 5e-6 m.
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
EXACT_M = 5e-6
HORIZONS_S = np.array([0.0, 0.1, 0.5, 1.0, 2.0])
EXPRESSIONS = (
    *LEAVES,
    *(f"{a}+{b}" for a, b in itertools.combinations_with_replacement(LEAVES, 2)),
    *(f"{a}*{b}" for a, b in itertools.combinations(LEAVES, 2)),
    "matern32*(linear+rbf)",
    "(linear+rq)*(matern12+periodic)+rbf*linear",
)
PEERS: dict[str, Any] = runpy.run_path(str(Path(__file__).parents[1] / "benchmarks" / "peer_kernels.py"))


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


def differences_m(expression: str, y: Array, dt_s: float) -> Array:
    """Return the largest distances of predictions: ours from exact, peer from exact, ours from peer."""
    model = KernelProcess(expression)
    ready = model.point_functions(dt_s)
    count = len(model.kernel.hyperparameters) + 1
    fits = np.empty((len(y), count + SAMPLES + 1))
    fit_axes(y, ready.constants, fits)
    own = fits[:, :-1]
    ours = model.predict(np.concatenate([own, own], axis=1), HORIZONS_S, dt_s=dt_s)[:, :, 0]
    exact = PEERS["extended_prediction"](expression, y, own[:, :count], dt_s, HORIZONS_S)
    times = (np.arange(SAMPLES, dtype=np.float64) - SAMPLES + 1)[:, None] * dt_s
    theirs = np.empty_like(ours)
    for row, window in enumerate(y):
        kernel = PEERS["peer_of"](expression, own[row, :count])
        peer = GaussianProcessRegressor(kernel, alpha=0, optimizer=None)
        theirs[row] = peer.fit(times, window).predict(HORIZONS_S[:, None])
    pairs = (ours - exact, theirs - exact, ours - theirs)
    return np.array([np.abs(one).max(initial=0.0) for one in pairs])


def told(worst: Array) -> str:
    """Return three distances as a text."""
    return f"{worst[0]:.1e} {worst[1]:.1e} {worst[2]:.1e} m"


def main() -> int:
    """Compare all and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--every", type=int, default=1, help="take every N-th window only")
    parser.add_argument("--expressions", type=int, default=1, help="expressions in turn for each window")
    given = parser.parse_args()
    of_expression = {expression: np.zeros(3) for expression in EXPRESSIONS}
    total = 0
    with threadpool_limits(1):
        for source in folders(Path(os.environ["MODELCAST_DATA"])):
            seen, worst = 0, np.zeros(3)
            for dt_s, y in windows(source, given.every).items():
                for at, expression in enumerate(EXPRESSIONS):
                    turns = (np.arange(len(y)) + at) % len(EXPRESSIONS) < given.expressions
                    found = differences_m(expression, np.ascontiguousarray(y[turns]), dt_s)
                    worst = np.maximum(worst, found)
                    of_expression[expression] = np.maximum(of_expression[expression], found)
                seen += len(y)
            total += seen
            print(f"{source.name:28s} {seen:8d} windows of an axis, worst {told(worst)}", flush=True)
    for expression, found in sorted(of_expression.items(), key=lambda one: -one[1][2]):
        print(f"{expression:44s} worst {told(found)}")
    worst = np.max(list(of_expression.values()), axis=0)
    print(f"{total} windows of an axis, {len(EXPRESSIONS)} expressions: worst {told(worst)}")
    return int(worst[0] > EXACT_M)


if __name__ == "__main__":
    sys.exit(main())
