"""Hyper-parameters of a Gaussian process from many windows: by likelihood, and by predictive survival.

The likelihood asks how well a process explains the windows; survival asks how long its predictions hold,
which is what messages cost. Neither is always better, so both are returned with their figures.

Windows are drawn evenly over time, updates are not: they crowd where predictions fail soon. A sender whose
prediction made now would hold for L sends about 1/L messages a second just now, so the mean of 1/L over the
windows is the rate to expect, and that is what the search by survival makes small. The plain mean of L is
ruled by stops and straight roads, where every process holds.
"""

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Literal

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.scientific import scientific
from modelcast.models.base import AbstractSubModel
from modelcast.study.training.families import AbstractFamily
from modelcast.study.training.windows import TrainingWindows, survival_s

__all__ = ["DEFAULT_THRESHOLDS_M", "Progress", "Trained", "TrainedPair", "train_hyperparameters"]

Progress = Callable[[int, int], None]
"""Called with evaluations done and all."""

DEFAULT_THRESHOLDS_M = (0.2, 0.3, 0.5)
"""Thresholds whose survivals a search maximises [m]."""


@dataclass(frozen=True, slots=True)
class Trained:
    """One sub-model found by a search.

    Parameters
    ----------
    by
        What the search made best.
    model
        The sub-model.
    log_likelihood
        Mean logarithm of the likelihood of a window and axis.
    mean_survival_s
        Mean time until each threshold is crossed, one a threshold [s].
    message_rate_hz
        Mean of the inverse of that time, half a sample added for the sampling, one a threshold [Hz].
    """

    by: Literal["likelihood", "survival"]
    model: AbstractSubModel
    _: KW_ONLY
    log_likelihood: float
    mean_survival_s: tuple[float, ...]
    message_rate_hz: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class TrainedPair:
    """What both searches found.

    Parameters
    ----------
    likelihood, survival
        Sub-models and figures.
    """

    likelihood: Trained
    survival: Trained

    @property
    def better(self) -> Trained:
        """The one with fewer messages to expect, by the geometric mean over the thresholds."""
        one, other = (
            float(np.log(found.message_rate_hz).sum()) for found in (self.likelihood, self.survival)
        )
        return self.survival if other <= one else self.likelihood


def train_hyperparameters(
    training: TrainingWindows,
    family: AbstractFamily,
    *,
    thresholds_m: Sequence[float] = DEFAULT_THRESHOLDS_M,
    evaluations: int = 150,
    progress: Progress | None = None,
) -> TrainedPair:
    """Search a family by type-II likelihood, then from there by predictive survival.

    Parameters
    ----------
    training
        Windows of many trips and what followed them.
    family
        Which sub-models.
    thresholds_m
        Thresholds of the tracking error; the geometric mean of the message rates to expect is minimised [m].
    evaluations
        Of the objective, at most, in each search.
    progress
        Called with evaluations done and all.

    Returns
    -------
    TrainedPair
        Both; the same windows give the same numbers.
    """
    thresholds = np.asarray(thresholds_m, dtype=np.float64)
    done = 0

    def counted(objective: Callable[[FloatArray], float]) -> Callable[[FloatArray], float]:
        def call(theta: FloatArray) -> float:
            nonlocal done
            done += 1
            if progress is not None:
                progress(min(done, 2 * evaluations), 2 * evaluations)
            return objective(theta)

        return call

    def lasting_s(theta: FloatArray) -> FloatArray:
        return survival_s(family.build(theta), training, thresholds)

    def log_rate(theta: FloatArray) -> float:
        return float(np.log(_rate_hz(lasting_s(theta), training.dt_s)).sum())

    def figures(by: Literal["likelihood", "survival"], theta: FloatArray) -> Trained:
        return Trained(
            by,
            family.build(theta),
            log_likelihood=family.log_likelihood(theta, training),
            mean_survival_s=tuple(lasting_s(theta).mean(axis=0).tolist()),
            message_rate_hz=tuple(_rate_hz(lasting_s(theta), training.dt_s).tolist()),
        )

    likely = _search(
        counted(lambda theta: -family.log_likelihood(theta, training)), family.start, family, evaluations
    )
    starts = sorted((likely, family.start), key=log_rate)
    lasting = _search(counted(log_rate), starts[0], family, evaluations)
    return TrainedPair(figures("likelihood", likely), figures("survival", lasting))


def _rate_hz(lasting_s: FloatArray, dt_s: float) -> FloatArray:
    """Messages a second to expect from survivals, (B, thresholds), at each threshold."""
    return (1.0 / (lasting_s + 0.5 * dt_s)).mean(axis=0)


def _search(
    objective: Callable[[FloatArray], float], start: FloatArray, family: AbstractFamily, evaluations: int
) -> FloatArray:
    """Bounded simplex search (Nelder-Mead) from a start, with a first simplex of half a unit an edge."""
    low, high = np.array(family.bounds).T
    start = np.clip(start, low, high)
    edge = np.where(start + 0.5 <= high, 0.5, -0.5)
    simplex = np.vstack([start, start + np.diag(edge)])
    optimize = scientific("optimize", "training hyper-parameters", "train")
    found = optimize.minimize(
        objective,
        start,
        method="Nelder-Mead",
        bounds=family.bounds,
        options={"maxfev": evaluations, "initial_simplex": simplex, "xatol": 1e-2, "fatol": 1e-4},
    )
    return np.asarray(found.x, dtype=np.float64)
