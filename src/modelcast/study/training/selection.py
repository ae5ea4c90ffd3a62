"""Training of the selector: from what a window looks like, how long every sub-model would have lasted.

Every training trip, as its sender sees it, is fitted at every sample; the true life of each prediction at
each threshold is what the networks learn, as a logarithm. Networks that differ by their seed are averaged.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import Any

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.core.chance import child_generator
from modelcast.models.bank import Bank
from modelcast.models.learned import FeatureMap, Perceptron, Selector
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.study.case import TripCase
from modelcast.study.training import selection_kernels
from modelcast.study.training.descent import Descent, Weights, batches, descend, perceptron_of, squashing
from modelcast.study.training.inputs import window_inputs

__all__ = ["SelectorSettings", "member_lives_s", "train_selector"]

_LOOK_S = 0.1
"""Added to every life before its logarithm is taken [s]: a sender looks once a sample."""


@dataclass(frozen=True, slots=True)
class SelectorSettings:
    """How a selector is trained.

    Parameters
    ----------
    thresholds_m
        Thresholds, rising [m].
    networks
        How many are averaged.
    margin
        Advantage of the first sub-model, in logarithms of time.
    longest_s
        A longer life counts as this [s].
    every
        Every so many samples of a trip are learnt from.
    seed
        Of the first network; the others take the next ones.
    descent
        Hidden layers, batches and optimiser; its thresholds, softness and sizes play no part.
    features
        What the networks look at.

    Raises
    ------
    ValueError
        Where a value is out of its range.
    """

    thresholds_m: tuple[float, ...] = (0.2, 0.3, 0.4, 0.5)
    _: KW_ONLY
    networks: int = 3
    margin: float = 0.1
    longest_s: float = 8.0
    every: int = 2
    seed: int = 0
    descent: Descent = field(default_factory=lambda: Descent(hidden=(48, 48), steps=600, batch=512))
    features: FeatureMap = field(default_factory=FeatureMap)

    def __post_init__(self) -> None:
        for name in ("networks", "longest_s", "every"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")


def train_selector(
    cases: Sequence[TripCase],
    bank: Bank,
    settings: SelectorSettings | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> Selector:
    """Train a selector for a bank.

    Parameters
    ----------
    cases
        Training trips made ready, best in both protocols. A learned member must not have been trained on
        them: its lives would be too good.
    bank
        The sub-models; completed as in an evaluation.
    settings
        How.
    progress
        Called with networks done and all.

    Raises
    ------
    MissingExtraError
        Where JAX and optax, which the extra ``train`` brings, are not installed.
    ValueError
        Where no case has a window with the whole life ahead.
    """
    settings = SelectorSettings() if settings is None else settings
    bank = bank.complete()
    inputs, lives = _rows(cases, bank, settings)
    signs = settings.features.mirrors
    centre, width = squashing(inputs, signs)
    squashed = np.arcsinh((inputs - centre) / width)
    targets = np.log(np.minimum(lives, settings.longest_s) + _LOOK_S)
    networks: list[Perceptron] = []
    for at in range(settings.networks):
        weights = _descend(squashed, targets, signs, settings, settings.seed + at)
        networks.append(perceptron_of(weights, centre, width))
        if progress is not None:
            progress(at + 1, settings.networks)
    return Selector(
        tuple(member.name for member in bank.members),
        settings.thresholds_m,
        tuple(networks),
        lags=settings.features.lags,
        margin=settings.margin,
    )


def member_lives_s(ready: TripRuntime, thresholds_m: FloatArray, longest_s: float) -> FloatArray:
    """How long every sub-model fitted at every sample holds, (T, thresholds, M) [s].

    0 where a member had no full window, NaN where the trip ends before the answer.

    Parameters
    ----------
    ready
        Bank and trip.
    thresholds_m
        Rising thresholds [m].
    longest_s
        A longer life counts as this [s].
    """
    count, bank = len(ready.trip), ready.bank
    ready.fit_at(np.arange(count))
    history = np.arange(count) - ready.trip.segment_start + 1
    lives = np.empty((count, thresholds_m.size, len(bank.members)))
    for m, window in enumerate(bank.windows):
        own = np.empty((count, thresholds_m.size))
        selection_kernels.survivals(
            ready.own.ready.members,
            m,
            np.ascontiguousarray(ready.parameters[:, bank.offsets[m] : bank.offsets[m + 1]]),
            history >= window,
            ready.trip.t_s,
            ready.samples,
            thresholds_m,
            longest_s,
            own,
        )
        lives[:, :, m] = own
    return lives


def _rows(cases: Sequence[TripCase], bank: Bank, settings: SelectorSettings) -> tuple[FloatArray, FloatArray]:
    """Inputs (B, I) and lives (B, thresholds x members) [s]."""
    inputs: list[FloatArray] = []
    lives: list[FloatArray] = []
    features, thresholds_m = settings.features, np.array(settings.thresholds_m)
    for case in cases:
        ready = TripRuntime(case.seen, bank, case.estimator)
        own = member_lives_s(ready, thresholds_m, settings.longest_s).reshape(len(case.seen), -1)
        window = features.window_at(case.seen.dt_s)
        history = np.arange(len(case.seen)) - case.seen.segment_start + 1
        usable: BoolArray = (history >= max(window, int(bank.windows.max()))) & np.isfinite(own).all(axis=1)
        rows = np.flatnonzero(usable)[:: settings.every]
        inputs.append(window_inputs(ready.samples, rows, window, features, case.seen.dt_s))
        lives.append(own[rows])
    if not sum(len(rows) for rows in inputs):
        raise ValueError(f"no trip has {settings.longest_s:g} s after a full window to learn from")
    return np.concatenate(inputs), np.concatenate(lives)


def _descend(
    inputs: FloatArray, targets: FloatArray, signs: FloatArray, settings: SelectorSettings, seed: int
) -> Weights:
    """Weights that make squares small; half the windows are mirrored."""

    def given() -> Iterator[tuple[FloatArray, Sequence[FloatArray]]]:
        rng = child_generator(seed, "selector")
        for chosen in batches(np.full(len(inputs), 1.0 / len(inputs)), settings.descent, rng):
            mirrored = np.where(rng.random(chosen.size)[:, None] < 0.5, signs, 1.0)
            yield inputs[chosen] * mirrored, [targets[chosen]]

    def cost(outputs: Any, wanted: Any) -> Any:
        return ((outputs - wanted) ** 2).mean()

    return descend(
        cost,
        given(),
        settings.descent,
        sizes=(inputs.shape[1], targets.shape[1]),
        seed=seed,
        key="selector",
        step=lambda _: None,
    )
