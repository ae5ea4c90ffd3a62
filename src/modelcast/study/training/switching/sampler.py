"""A sticky hierarchical Dirichlet process over modes, drawn from by a blocked Gibbs sampler, weak limit.

The process has no bound on the number of modes; with L of them it is close while the data use fewer. A round
draws the path of modes (forward, then back), then how rows of the chain share modes, the chain, and each
mode's dynamics and noise. Of all rounds the one is kept whose path and data are the most probable together,
dynamics, noise and chain integrated out; modes that it hardly uses are dropped.

References
----------
E. B. Fox, E. B. Sudderth, M. I. Jordan, A. S. Willsky, "A Sticky HDP-HMM with Application to Speaker
Diarization", Annals of Applied Statistics 5(2A), 2011, algorithm 3. https://doi.org/10.1214/10-AOAS395
"""

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.scientific import scientific
from modelcast.models.switching import MOST_MODES
from modelcast.study.training.switching.prior import ModePrior, mode_sums, step_densities
from modelcast.study.training.switching.sequences import Sequences
from modelcast.study.training.switching.switching_kernels import draw_path, forward

__all__ = ["SampledModes", "SamplerSettings", "sample_modes"]


@dataclass(frozen=True, slots=True)
class SamplerSettings:
    """How modes are drawn.

    Parameters
    ----------
    most
        L: modes at most.
    rounds
        Rounds of the sampler.
    shared
        Concentration (gamma) of the shares that all rows of the chain have in common.
    concentration
        How closely (alpha) rows follow those shares.
    sticky
        Moves to itself (kappa) that each mode is believed to make beyond.
    least_share
        A mode with a smaller share of the steps is dropped, 0 to 1.
    prior
        Of every mode.

    Raises
    ------
    ValueError
        Where a number is out of its range.
    """

    most: int = MOST_MODES
    _: KW_ONLY
    rounds: int = 150
    shared: float = 1.0
    concentration: float = 1.0
    sticky: float = 50.0
    least_share: float = 0.002
    prior: ModePrior = field(default_factory=ModePrior)

    def __post_init__(self) -> None:
        if not 1 <= self.most <= MOST_MODES:
            raise ValueError(f"most must be from 1 to {MOST_MODES}, got {self.most}")
        if self.rounds < 1:
            raise ValueError(f"rounds must be positive, got {self.rounds}")
        if min(self.shared, self.concentration) <= 0.0 or self.sticky < 0.0:
            raise ValueError("shared and concentration must be positive, and sticky not negative")
        if not 0.0 <= self.least_share < 1.0:
            raise ValueError(f"least_share must be from 0 to below 1, got {self.least_share}")


@dataclass(frozen=True, slots=True)
class SampledModes:
    """Modes and their chain as found, the most used first.

    Parameters
    ----------
    chain
        (M, M), from row to column.
    weights, covariance
        W = (A, b) and Q of each mode, (M, 2, 3) and (M, 2, 2).
    shares
        Of the steps in each mode, (M,).
    score
        By round: logarithm of the probability of path and data together.
    log_likelihood
        Of the data, by what was drawn in the best round.
    """

    chain: FloatArray
    weights: FloatArray
    covariance: FloatArray
    _: KW_ONLY
    shares: FloatArray
    score: tuple[float, ...]
    log_likelihood: float


def sample_modes(
    data: Sequences,
    settings: SamplerSettings | None = None,
    *,
    rng: np.random.Generator,
    progress: Callable[[int, int], None] | None = None,
) -> SampledModes:
    """Draw modes, and return the best draw's.

    Parameters
    ----------
    data
        Steps.
    settings
        How.
    rng
        Of all draws.
    progress
        Called with rounds done and all.
    """
    settings = SamplerSettings() if settings is None else settings
    most, regressors = settings.most, data.regressors
    begin = data.begins
    path: IntArray = rng.integers(0, most, len(data) // 50 + 1).repeat(50)[: len(data)]
    shares = np.full(most, 1.0 / most)
    filtered, scores = np.empty((len(data), most)), list[float]()
    best, best_likelihood = path.copy(), -np.inf
    for done in range(settings.rounds):
        member = np.eye(most)[path]
        sums = mode_sums(regressors, data.after, member)
        moves = _moves(path, begin, most)
        weights, covariance = settings.prior.posterior(sums).draw(rng)
        shares = _draw_shares(moves, np.bincount(path[begin], minlength=most), shares, settings, rng)
        chain = _draw_rows(settings.concentration * shares + settings.sticky * np.eye(most) + moves, rng)
        first = _draw_rows(settings.concentration * shares + np.bincount(path[begin], minlength=most), rng)
        density = step_densities(regressors, data.after, weights, covariance)
        likelihood = forward(density, begin, first, chain, filtered)
        path = np.empty(len(data), dtype=np.int64)
        draw_path(filtered, begin, chain, rng.random(len(data)), path)
        scores.append(_score(path, data, shares, settings))
        if scores[-1] == max(scores):
            best, best_likelihood = path.copy(), float(likelihood)
        if progress is not None:
            progress(done + 1, settings.rounds)
    return _served(best, data, settings, tuple(scores), best_likelihood)


def _moves(path: IntArray, begins: BoolArray, most: int) -> FloatArray:
    """Moves of the chain along a path, (M, M)."""
    within = ~begins[1:]
    pairs = path[:-1][within] * most + path[1:][within]
    return np.bincount(pairs, minlength=most * most).reshape(most, most).astype(np.float64)


def _draw_rows(counts: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Rows drawn from Dirichlet distributions, along the last axis; none is exactly zero."""
    drawn = np.maximum(rng.standard_gamma(counts), 1e-300)
    return drawn / drawn.sum(axis=-1, keepdims=True)


def _draw_shares(
    moves: FloatArray,
    starts: IntArray,
    shares: FloatArray,
    settings: SamplerSettings,
    rng: np.random.Generator,
) -> FloatArray:
    """The shares that rows have in common, from how often each was asked for: algorithm 3, steps 2 and 3."""
    most = len(shares)
    weight = settings.concentration * shares + settings.sticky * np.eye(most)
    tables = np.array(
        [[_tables(weight[i, j], int(moves[i, j]), rng) for j in range(most)] for i in range(most)]
    )
    own = np.arange(most)
    kept = settings.sticky / (settings.sticky + settings.concentration * shares)
    overridden = rng.binomial(tables[own, own], kept)
    tables[own, own] -= overridden
    first = np.array([_tables(settings.concentration * shares[j], int(starts[j]), rng) for j in range(most)])
    return _draw_rows(settings.shared / most + tables.sum(axis=0) + first, rng)


def _tables(weight: float, customers: int, rng: np.random.Generator) -> int:
    """Tables that so many customers take in a Chinese restaurant of this concentration."""
    if customers == 0 or weight <= 0.0:
        return min(customers, 1)
    return int((rng.random(customers) * (weight + np.arange(customers)) < weight).sum())


def _score(path: IntArray, data: Sequences, shares: FloatArray, settings: SamplerSettings) -> float:
    """Logarithm of the probability of a path and the data, all but the shares integrated out."""
    most = len(shares)
    sums = mode_sums(data.regressors, data.after, np.eye(most)[path])
    before = settings.concentration * shares + settings.sticky * np.eye(most)
    counts = np.vstack([_moves(path, data.begins, most), np.bincount(path[data.begins], minlength=most)])
    before = np.vstack([before, settings.concentration * shares])
    own, every = before.sum(axis=1), before.sum(axis=1) + counts.sum(axis=1)
    parts = (_log_gamma(own) - _log_gamma(every), _log_gamma(before + counts) - _log_gamma(before))
    return float(settings.prior.log_evidence(sums).sum() + sum(part.sum() for part in parts))


def _log_gamma(values: FloatArray) -> FloatArray:
    special = scientific("special", "training switching models", "train")
    return np.asarray(special.gammaln(values), dtype=np.float64)


def _served(
    path: IntArray,
    data: Sequences,
    settings: SamplerSettings,
    score: tuple[float, ...],
    log_likelihood: float,
) -> SampledModes:
    """Modes of a path, the most used first, hardly used ones dropped; the most probable values of each."""
    most = settings.most
    count = np.bincount(path, minlength=most)
    order = np.argsort(-count, kind="stable")
    kept = [int(m) for m in order if count[m] > 0 and count[m] >= settings.least_share * len(path)]
    sums = mode_sums(data.regressors, data.after, np.eye(most)[path])[kept]
    weights, covariance = settings.prior.posterior(sums).mode()
    moves = _moves(path, data.begins, most)[np.ix_(kept, kept)]
    chain = moves + settings.concentration / len(kept) + settings.sticky * np.eye(len(kept))
    return SampledModes(
        chain / chain.sum(axis=1, keepdims=True),
        weights,
        covariance,
        shares=count[kept] / len(path),
        score=score,
        log_likelihood=log_likelihood,
    )
