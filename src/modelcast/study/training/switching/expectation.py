"""Expectation and maximisation: modes and chain of a given number, by climbing their posterior density.

Each round follows the chances of the modes forward and backward, then takes the most probable dynamics, noise
and chain given those chances. The density of the data times the prior's never falls. Several starts are
climbed; the best is kept.

References
----------
L. E. Baum, T. Petrie, G. Soules, N. Weiss, "A Maximization Technique Occurring in the Statistical Analysis of
Probabilistic Functions of Markov Chains", Annals of Mathematical Statistics 41(1), 1970.
https://doi.org/10.1214/aoms/1177697196
"""

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.switching import MOST_MODES
from modelcast.study.training.switching.prior import ModePrior, mode_sums, step_densities
from modelcast.study.training.switching.sequences import Sequences
from modelcast.study.training.switching.switching_kernels import backward, forward

__all__ = ["FitSettings", "FittedModes", "fit_modes"]


@dataclass(frozen=True, slots=True)
class FitSettings:
    """How modes of a given number are fitted.

    Parameters
    ----------
    modes
        How many, M.
    starts
        Starts climbed.
    rounds
        Rounds of each at most.
    least_gain
        A start ends where a round gains less than this a step.
    prior
        Of every mode.
    kept_moves
        Moves of the chain that are believed in before any data, to each mode from each.

    Raises
    ------
    ValueError
        Where a number is out of its range.
    """

    modes: int = 4
    _: KW_ONLY
    starts: int = 4
    rounds: int = 100
    least_gain: float = 1e-6
    prior: ModePrior = field(default_factory=ModePrior)
    kept_moves: float = 0.5

    def __post_init__(self) -> None:
        if not 1 <= self.modes <= MOST_MODES:
            raise ValueError(f"modes must be from 1 to {MOST_MODES}, got {self.modes}")
        if self.starts < 1 or self.rounds < 1:
            raise ValueError(f"starts and rounds must be positive, got {self.starts} and {self.rounds}")
        if self.kept_moves <= 0.0 or self.least_gain < 0.0:
            raise ValueError("kept_moves must be positive, and least_gain not negative")


@dataclass(frozen=True, slots=True)
class FittedModes:
    """Modes and their chain as found.

    Parameters
    ----------
    chain
        (M, M), from row to column.
    weights, covariance
        W = (A, b) and Q of each mode, (M, 2, 3) and (M, 2, 2).
    score
        What was climbed, by round: logarithm of the density of the data times the prior's.
    log_likelihood
        Of the data alone, of the last round.
    """

    chain: FloatArray
    weights: FloatArray
    covariance: FloatArray
    _: KW_ONLY
    score: tuple[float, ...]
    log_likelihood: float


def fit_modes(
    data: Sequences,
    settings: FitSettings | None = None,
    *,
    rng: np.random.Generator,
    progress: Callable[[int, int], None] | None = None,
) -> FittedModes:
    """Return the best of several starts.

    Parameters
    ----------
    data
        Steps.
    settings
        How.
    rng
        Draws the starts.
    progress
        Called with starts climbed and all.
    """
    settings = FitSettings() if settings is None else settings
    best: FittedModes | None = None
    for start in range(settings.starts):
        found = _climb(data, settings, _start(data, settings.modes, rng))
        if best is None or found.score[-1] > best.score[-1]:
            best = found
        if progress is not None:
            progress(start + 1, settings.starts)
    if best is None:
        raise ValueError("modes are fitted from one start at least")
    return best


def _start(data: Sequences, modes: int, rng: np.random.Generator) -> FloatArray:
    """Chances of modes to begin with, (N, M): steps by the nearest of M steps drawn, by value and change."""
    features = np.column_stack([data.before, data.after - data.before])
    features = features / np.maximum(features.std(axis=0), 1e-12)
    drawn = features[rng.choice(len(features), modes, replace=len(features) < modes)]
    distance = ((features[:, None] - drawn) ** 2).sum(axis=2)
    near = np.eye(modes)[distance.argmin(axis=1)]
    return 0.9 * near + 0.1 / modes


def _climb(data: Sequences, settings: FitSettings, chances: FloatArray) -> FittedModes:
    modes = settings.modes
    regressors, scores = data.regressors, list[float]()
    first, chain = np.full(modes, 1.0 / modes), np.full((modes, modes), 0.1 / modes) + 0.9 * np.eye(modes)
    filtered, moves = np.empty_like(chances), np.empty((modes, modes))
    while True:
        after = settings.prior.posterior(mode_sums(regressors, data.after, chances))
        weights, covariance = after.mode()
        density = step_densities(regressors, data.after, weights, covariance)
        likelihood = forward(density, data.begins, first, chain, filtered)
        kept = settings.kept_moves * (np.log(chain).sum() + np.log(first).sum())
        scores.append(likelihood + kept + settings.prior.log_density(weights, covariance))
        gained = np.inf if len(scores) == 1 else scores[-1] - scores[-2]
        if len(scores) > settings.rounds or gained < settings.least_gain * len(data):
            return FittedModes(
                chain, weights, covariance, score=tuple(scores), log_likelihood=float(likelihood)
            )
        backward(filtered, data.begins, chain, chances, moves)
        chain = moves + settings.kept_moves
        chain = chain / chain.sum(axis=1, keepdims=True)
        first = chances[data.begins].sum(axis=0) + settings.kept_moves
        first = first / first.sum()
