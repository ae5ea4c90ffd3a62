"""A finite bank of kernels: one set of hyper-parameters for each driving regime.

Windows are grouped by what the sender knows of them at their last sample: speed, how hard it brakes or speeds
up, how fast it turns. Each group trains a sub-model of its own.
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.evaluation.training.families import AbstractFamily
from modelcast.evaluation.training.hyperparameters import (
    Progress,
    TrainedPair,
    train_hyperparameters,
)
from modelcast.evaluation.training.windows import TrainingWindows
from modelcast.models.point_kernels import ACCELERATION, VELOCITY_EAST, VELOCITY_NORTH, YAW_RATE

__all__ = ["Regimes", "regime_features", "train_regimes"]

_STEPS = 200


@dataclass(frozen=True, slots=True)
class Regimes:
    """Driving regimes, each with its trained sub-models; the most frequent first.

    Parameters
    ----------
    centres
        Mean features of each regime, (R, 3) [m/s, m/s², rad/s].
    scales
        Standard deviation of each feature over all windows, (3,).
    trained
        What the searches found in each regime, R of them, named ``<label>-1`` and so on.
    shares
        Share of the windows in each regime, (R,).
    """

    centres: FloatArray
    scales: FloatArray
    _: KW_ONLY
    trained: tuple[TrainedPair, ...]
    shares: FloatArray

    def of(self, samples: FloatArray) -> IntArray:
        """Return the regime of each window, the one with the nearest centre, (B,).

        Parameters
        ----------
        samples
            Windows, (B, n, 7).
        """
        return _nearest(regime_features(samples) / self.scales, self.centres / self.scales)


def regime_features(samples: FloatArray) -> FloatArray:
    """Speed, size of the acceleration along the course and of the yaw rate at the last sample, (B, 3).

    Parameters
    ----------
    samples
        Windows, (B, n, 7).
    """
    last = samples[:, -1]
    speed = np.hypot(last[:, VELOCITY_EAST], last[:, VELOCITY_NORTH])
    return np.stack([speed, np.abs(last[:, ACCELERATION]), np.abs(last[:, YAW_RATE])], axis=1)


def train_regimes(
    training: TrainingWindows,
    family: AbstractFamily,
    count: int,
    *,
    label: str,
    rng: np.random.Generator,
    evaluations: int = 100,
    progress: Progress | None = None,
) -> Regimes:
    """Group windows by their features and train the family in each group.

    Parameters
    ----------
    training
        Windows of many trips and what followed them.
    family
        Which sub-models.
    count
        How many regimes, 2 or more.
    label
        The sub-models' names begin with it.
    rng
        Draws the first centres.
    evaluations
        Of the objective, at most, in each of the two searches of a regime.
    progress
        Called with evaluations done and all.

    Raises
    ------
    ValueError
        Where there are too few windows or regimes.
    """
    if not 2 <= count <= len(training) // 2:
        raise ValueError(f"count must be 2 to half the {len(training)} windows, got {count}")
    features = regime_features(training.samples)
    scales = np.maximum(features.std(axis=0), 1e-9)
    found = _centres(features / scales, count, rng)
    regime = _nearest(features / scales, found)
    size = np.bincount(regime, minlength=count)
    order = np.argsort(-size, kind="stable")
    every = 2 * evaluations * count
    trained: list[TrainedPair] = []
    for which, at in enumerate(order):
        before = 2 * evaluations * which

        def step(done: int, _total: int, before: int = before) -> None:
            if progress is not None:
                progress(before + done, every)

        one = family.renamed(f"{label}-{which + 1}")
        trained.append(
            train_hyperparameters(training.select(regime == at), one, evaluations=evaluations, progress=step)
        )
    return Regimes(found[order] * scales, scales, trained=tuple(trained), shares=size[order] / len(training))


def _centres(features: FloatArray, count: int, rng: np.random.Generator) -> FloatArray:
    """K-means: centres drawn far from each other (k-means++), then Lloyd's steps until none moves."""
    centres = features[[rng.integers(len(features))]]
    while len(centres) < count:
        away = ((features[:, None] - centres) ** 2).sum(axis=2).min(axis=1)
        if not away.any():
            raise ValueError(f"the windows form fewer than {count} regimes: ask for fewer")
        drawn = rng.choice(len(features), p=away / away.sum())
        centres = np.vstack([centres, features[drawn]])
    for _ in range(_STEPS):
        regime = _nearest(features, centres)
        moved = centres.copy()
        for at in np.unique(regime):
            moved[at] = features[regime == at].mean(axis=0)
        if np.array_equal(moved, centres):
            break
        centres = moved
    return centres


def _nearest(features: FloatArray, centres: FloatArray) -> IntArray:
    """Index of the nearest centre, (B,)."""
    return ((features[:, None] - centres) ** 2).sum(axis=2).argmin(axis=1)
