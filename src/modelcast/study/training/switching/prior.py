"""What is believed of a mode before any data: a matrix-normal inverse-Wishart prior of its linear dynamics.

With regressors ``φ = (x, 1)`` and next values y, ``y = W φ + w``, ``w ~ N(0, Q)``: Q is inverse Wishart with
scale S and d degrees of freedom, W matrix normal round the mean with row covariance Q and column precision K.
The prior is conjugate, so the weighted sums of a mode (`mode_sums`) are all it needs of the data.

References
----------
E. B. Fox, E. B. Sudderth, M. I. Jordan, A. S. Willsky, "Bayesian Nonparametric Inference of Switching Dynamic
Linear Models", IEEE Transactions on Signal Processing 59(4), 2011, section III.
https://doi.org/10.1109/TSP.2010.2102756
"""

from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.scientific import scientific

__all__ = ["ModePrior", "Posterior", "mode_sums", "step_densities"]

_AXES = 2
_REGRESSORS = 3


def _mean() -> FloatArray:
    return np.array([[0.9, 0.0, 0.0], [0.0, 0.9, 0.0]])


def _precision() -> FloatArray:
    return np.array([0.1**2, 0.01**2, 1.0])


def _scale() -> FloatArray:
    return np.diag([0.05**2, 0.005**2])


@dataclass(frozen=True, slots=True)
class ModePrior:
    """Belief of a mode's dynamics and noise.

    Parameters
    ----------
    mean
        Of W = (A, b), (2, 3): rates that fade within a second.
    precision
        Diagonal of K, (3,): as much as one step at 10 cm/s² and 10 mrad/s.
    degrees
        d, above 1.
    scale
        S/d, (2, 2): noise of 5 cm/s² and 5 mrad/s, which also keeps a mode of rates that never change from
        a density without bound.
    """

    mean: FloatArray = field(default_factory=_mean)
    _: KW_ONLY
    precision: FloatArray = field(default_factory=_precision)
    degrees: float = 5.0
    scale: FloatArray = field(default_factory=_scale)

    def posterior(self, sums: FloatArray) -> "Posterior":
        """Belief of M modes after their data.

        Parameters
        ----------
        sums
            As `mode_sums` returns them, (M, 5, 5).
        """
        own = np.diag(self.precision)
        squares = sums[:, :_REGRESSORS, :_REGRESSORS] + own
        mixed = sums[:, _REGRESSORS:, :_REGRESSORS] + self.mean @ own
        mean: FloatArray = np.linalg.solve(squares, np.swapaxes(mixed, 1, 2)).astype(np.float64)
        targets = sums[:, _REGRESSORS:, _REGRESSORS:] + self.mean @ own @ self.mean.T
        scale = self.degrees * self.scale + targets - mixed @ mean
        scale = 0.5 * (scale + np.swapaxes(scale, 1, 2))
        degrees = self.degrees + sums[:, _REGRESSORS - 1, _REGRESSORS - 1]  # the regressor 1 squared counts
        return Posterior(np.swapaxes(mean, 1, 2), squares, degrees=degrees, scale=scale)

    def log_density(self, weights: FloatArray, covariance: FloatArray) -> float:
        """Logarithm of the prior's density of M modes, up to what does not depend on them.

        Parameters
        ----------
        weights
            W, (M, 2, 3).
        covariance
            Q, (M, 2, 2).
        """
        off = weights - self.mean
        inverse = np.linalg.inv(covariance)
        spread = self.degrees * self.scale + off @ np.diag(self.precision) @ np.swapaxes(off, 1, 2)
        power = self.degrees + _AXES + 1 + _REGRESSORS
        log_size = np.linalg.slogdet(covariance).logabsdet
        return float(-0.5 * (power * log_size + np.einsum("mij,mji->m", spread, inverse)).sum())

    def log_evidence(self, sums: FloatArray) -> FloatArray:
        """Logarithm of the probability of each mode's data, dynamics and noise integrated out, (M,).

        Parameters
        ----------
        sums
            As `mode_sums` returns them, (M, 5, 5).
        """
        after = self.posterior(sums)
        count = sums[:, _REGRESSORS - 1, _REGRESSORS - 1]
        size = np.linalg.slogdet(after.precision).logabsdet - np.log(self.precision).sum()
        before = self.degrees * np.linalg.slogdet(self.degrees * self.scale).logabsdet
        later = after.degrees * np.linalg.slogdet(after.scale).logabsdet
        special = scientific("special", "training switching models", "train")
        gamma = special.multigammaln(0.5 * after.degrees, _AXES) - special.multigammaln(
            0.5 * self.degrees, _AXES
        )
        return -0.5 * _AXES * (count * np.log(np.pi) + size) + gamma + 0.5 * (before - later)


@dataclass(frozen=True, slots=True)
class Posterior:
    """Belief of M modes after their data: as `ModePrior`, with a matrix of precision each.

    Parameters
    ----------
    mean, precision
        (M, 2, 3) and (M, 3, 3).
    degrees, scale
        (M,) and (M, 2, 2).
    """

    mean: FloatArray
    precision: FloatArray
    _: KW_ONLY
    degrees: FloatArray
    scale: FloatArray

    def mode(self) -> tuple[FloatArray, FloatArray]:
        """The most probable W (M, 2, 3) and Q (M, 2, 2) together."""
        power = self.degrees + _AXES + 1 + _REGRESSORS
        return self.mean, self.scale / power[:, None, None]

    def draw(self, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
        """W (M, 2, 3) and Q (M, 2, 2) drawn from it.

        Parameters
        ----------
        rng
            Draws them: as many numbers whatever the data.
        """
        count = len(self.degrees)
        normal = rng.standard_normal((count, _AXES, _REGRESSORS))
        lower = rng.standard_normal(count)
        chi = np.sqrt(np.stack([rng.chisquare(self.degrees), rng.chisquare(self.degrees - 1.0)], axis=1))
        bartlett = np.zeros((count, _AXES, _AXES))  # of a Wishart matrix with unit scale
        bartlett[:, 0, 0], bartlett[:, 1, 1], bartlett[:, 1, 0] = chi[:, 0], chi[:, 1], lower
        half = np.linalg.cholesky(self.scale) @ np.linalg.inv(np.swapaxes(bartlett, 1, 2))
        columns = np.linalg.inv(np.linalg.cholesky(self.precision))
        return self.mean + half @ normal @ columns, half @ np.swapaxes(half, 1, 2)


def mode_sums(regressors: FloatArray, after: FloatArray, weights: FloatArray) -> FloatArray:
    """Weighted sums of all products of regressors and next values, by mode, (M, 5, 5).

    Parameters
    ----------
    regressors, after
        (N, 3) and (N, 2).
    weights
        Chance or membership of each step in each mode, (N, M).
    """
    joined = np.column_stack([regressors, after])
    pairs = (joined[:, :, None] * joined[:, None, :]).reshape(len(joined), -1)
    return (weights.T @ pairs).reshape(-1, joined.shape[1], joined.shape[1])


def step_densities(
    regressors: FloatArray, after: FloatArray, weights: FloatArray, covariance: FloatArray
) -> FloatArray:
    """Logarithm of the density of each step in each mode, (N, M).

    Parameters
    ----------
    regressors, after
        (N, 3) and (N, 2).
    weights, covariance
        W and Q of each mode, (M, 2, 3) and (M, 2, 2).
    """
    off = after[:, None] - np.einsum("mij,nj->nmi", weights, regressors)
    scaled = np.einsum("mij,nmj->nmi", np.linalg.inv(np.linalg.cholesky(covariance)), off)
    log_size = np.linalg.slogdet(covariance).logabsdet
    return -0.5 * (_AXES * np.log(2.0 * np.pi) + log_size + (scaled**2).sum(axis=2))
