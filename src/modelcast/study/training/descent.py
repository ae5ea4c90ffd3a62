"""Descent on the survival loss, with scikit-learn's network and optimiser.

scikit-learn minimises squares only. But the slope of half a square is prediction less target, so that a batch
whose targets are "prediction less slope of our own loss" makes its step the step of our loss. Every batch is
one call of ``partial_fit``, which keeps the optimiser's state.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.chance import child_generator
from modelcast.core.exceptions import MissingExtraError
from modelcast.models.learned.features import NOISES
from modelcast.study.training.survival_kernels import survival_slopes

__all__ = ["Descent", "LayerAverage", "Lesson", "descend", "make_regressor"]


@dataclass(frozen=True, slots=True)
class Descent:
    """Loss and optimiser.

    Parameters
    ----------
    thresholds_m
        Thresholds whose survivals count [m].
    softness
        Width of the step at a threshold, as a share of it.
    hidden
        Sizes of the two hidden layers.
    steps, averaged
        Batches; over the last so many of them the weights are averaged.
    batch
        Windows in a batch.
    learning_rate, penalty
        Of the optimiser (Adam), and weight of the squared weights (scikit-learn's ``alpha``).
    resize
        Greatest logarithm of the factor by which a window's road is resized.
    report_every
        Batches between two calls of ``step``.

    Raises
    ------
    ValueError
        Where a value is out of its range.
    """

    thresholds_m: tuple[float, ...] = (0.2, 0.3, 0.5)
    softness: float = 0.25
    _: KW_ONLY
    hidden: tuple[int, int] = (96, 96)
    steps: int = 2500
    averaged: int = 800
    batch: int = 1024
    learning_rate: float = 1e-3
    penalty: float = 0.1
    resize: float = 0.3
    report_every: int = 50

    def __post_init__(self) -> None:
        if not self.thresholds_m or min(self.thresholds_m) <= 0.0:
            raise ValueError(f"thresholds_m must be positive, and at least one, got {self.thresholds_m}")
        if not 1 <= self.averaged <= self.steps:
            raise ValueError(f"averaged must be from 1 to steps = {self.steps}, got {self.averaged}")
        for name in ("softness", "batch", "learning_rate", "report_every"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")

    @property
    def reports(self) -> int:
        """How often ``step`` is called."""
        return -(-self.steps // self.report_every)


@dataclass(frozen=True, slots=True)
class Lesson:
    """What one network is to learn.

    Parameters
    ----------
    inputs
        (B, I); the last `NOISES` are no lengths and are not resized.
    errors_m
        What the outputs are to correct, along and to the left, (B, H, 2) [m].
    centre, width
        The network sees ``asinh((input - centre) / width)``, (I,).
    mirrors
        Sign of every input in the mirror, (I,).
    basis
        Value of each coefficient's function at each horizon, (H, k).
    steps_s
        Time that each horizon stands for, (H,) [s].
    """

    inputs: FloatArray
    errors_m: FloatArray
    _: KW_ONLY
    centre: FloatArray
    width: FloatArray
    mirrors: FloatArray
    basis: FloatArray
    steps_s: FloatArray


def descend(
    lesson: Lesson, how: Descent, *, seed: int, key: str, step: Callable[[int], None]
) -> tuple[list[FloatArray], list[FloatArray]]:
    """Weights and biases of the three layers, averaged over the last batches.

    Parameters
    ----------
    lesson
        Windows and what they lack.
    how
        Loss and optimiser.
    seed, key
        Of first weights, order, mirrors and sizes.
    step
        Called with the number of reports so far.

    Raises
    ------
    MissingExtraError
        Where scikit-learn is not installed.
    """
    network, limits = make_regressor(how, seed)
    rng = child_generator(seed, "batches", key)
    outputs = 2 * lesson.basis.shape[1]
    slopes = np.empty((how.batch, outputs))
    thresholds_m = np.array(how.thresholds_m)
    average = LayerAverage()
    with limits(1):  # one thread: the same sums on any machine, and no waiting for busy cores
        for done, chosen in enumerate(_batches(len(lesson.inputs), how, rng), start=1):
            inputs, errors_m = _varied(lesson, chosen, how, rng)
            squashed = np.arcsinh((inputs - lesson.centre) / lesson.width).astype(np.float32)
            if done == 1:
                network.partial_fit(squashed, np.zeros((how.batch, outputs), dtype=np.float32))
                # Begin with next to no correction.
                network.coefs_[-1] *= np.float32(0.1)
                network.intercepts_[-1] *= np.float32(0.1)
            given = np.ascontiguousarray(network.predict(squashed), dtype=np.float64)
            survival_slopes(given, errors_m, lesson.basis, lesson.steps_s, thresholds_m, how.softness, slopes)
            network.partial_fit(squashed, (given - slopes).astype(np.float32))
            if done > how.steps - how.averaged:
                average.add([*network.coefs_, *network.intercepts_])
            if done % how.report_every == 0 or done == how.steps:
                step(-(-done // how.report_every))
    layers = average.mean
    return layers[:3], layers[3:]


def _batches(count: int, how: Descent, rng: np.random.Generator) -> Iterator[IntArray]:
    """Rows of every batch: pass after pass in a new order."""
    order: IntArray = np.empty(0, dtype=np.int64)
    for _ in range(how.steps):
        while order.size < how.batch:
            order = np.concatenate([order, rng.permutation(count)])
        yield order[: how.batch]
        order = order[how.batch :]


def _varied(
    lesson: Lesson, chosen: IntArray, how: Descent, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Mirror half the windows, and play each on a road somewhat larger or smaller."""
    mirrored = rng.random(chosen.size) < 0.5
    inputs = np.where(mirrored[:, None], lesson.inputs[chosen] * lesson.mirrors, lesson.inputs[chosen])
    size = np.exp(how.resize * rng.uniform(-1.0, 1.0, chosen.size))
    inputs[:, :-NOISES] *= size[:, None]
    errors_m = lesson.errors_m[chosen] * size[:, None, None]
    errors_m[mirrored, :, 1] *= -1.0
    return inputs, errors_m


class LayerAverage:
    """Running mean of the weights: what a falling learning rate would reach."""

    def __init__(self) -> None:
        self._sums: list[FloatArray] = []
        self._count = 0

    def add(self, layers: Sequence[FloatArray]) -> None:
        """Count one set of weights."""
        if not self._sums:
            self._sums = [np.zeros(layer.shape) for layer in layers]
        for at, layer in enumerate(layers):
            self._sums[at] += layer
        self._count += 1

    @property
    def mean(self) -> list[FloatArray]:
        """Mean of all sets."""
        return [total / self._count for total in self._sums]


def make_regressor(how: Descent, seed: int) -> tuple[Any, Any]:
    """scikit-learn's network, and the limit of threads that comes with it.

    Parameters
    ----------
    how
        Layers and optimiser.
    seed
        Of the first weights.

    Raises
    ------
    MissingExtraError
        Where scikit-learn is not installed.
    """
    try:
        from sklearn.neural_network import MLPRegressor  # noqa: PLC0415 - an optional extra
        from threadpoolctl import threadpool_limits  # noqa: PLC0415 - comes with scikit-learn
    except ImportError as error:
        raise MissingExtraError("modelcast train", "train") from error
    regressor: Any = MLPRegressor  # its stubs know batch_size as a text alone
    network = regressor(
        hidden_layer_sizes=how.hidden,
        batch_size=how.batch,
        learning_rate_init=how.learning_rate,
        alpha=how.penalty,
        shuffle=False,
        random_state=seed,
    )
    return network, threadpool_limits
