"""Training of a finite bank of kernels: one set of hyper-parameters for each driving regime.

Windows are grouped by what the sender knows of them at their last sample (`modelcast.models.regimes`). Each
group trains a sub-model of its own.
"""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.regimes import Regimes, nearest_centre, regime_features
from modelcast.study.training.families import AbstractFamily
from modelcast.study.training.hyperparameters import (
    Progress,
    TrainedPair,
    train_hyperparameters,
)
from modelcast.study.training.windows import TrainingWindows

__all__ = ["TrainedRegimes", "train_regimes"]

_STEPS = 200


@dataclass(frozen=True, slots=True)
class TrainedRegimes:
    """Regimes, and what the searches found in each.

    Parameters
    ----------
    regimes
        With the better sub-model of each regime, the most frequent first.
    pairs
        Both searches of each, in the same order.
    """

    regimes: Regimes
    pairs: tuple[TrainedPair, ...]


def train_regimes(
    training: TrainingWindows,
    family: AbstractFamily,
    count: int,
    *,
    label: str,
    rng: np.random.Generator,
    evaluations: int = 100,
    progress: Progress | None = None,
) -> TrainedRegimes:
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
        The sub-models are named ``<label>-1`` and so on.
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
    regime = nearest_centre(features / scales, found)
    size = np.bincount(regime, minlength=count)
    order = np.argsort(-size, kind="stable")
    every = 2 * evaluations * count
    pairs: list[TrainedPair] = []
    for which, at in enumerate(order):
        before = 2 * evaluations * which

        def step(done: int, _total: int, before: int = before) -> None:
            if progress is not None:
                progress(before + done, every)

        one = family.renamed(f"{label}-{which + 1}")
        pairs.append(
            train_hyperparameters(training.select(regime == at), one, evaluations=evaluations, progress=step)
        )
    regimes = Regimes(
        tuple(pair.better.model for pair in pairs),
        tuple(tuple(row) for row in (found[order] * scales).tolist()),
        scales=tuple(scales.tolist()),
        shares=tuple((size[order] / len(training)).tolist()),
    )
    return TrainedRegimes(regimes, tuple(pairs))


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
        regime = nearest_centre(features, centres)
        moved = centres.copy()
        for at in np.unique(regime):
            moved[at] = features[regime == at].mean(axis=0)
        if np.array_equal(moved, centres):
            break
        centres = moved
    return centres
