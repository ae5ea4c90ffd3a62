"""Descent of a small network on any loss, with JAX and optax.

The network is that of `modelcast.models.learned.Perceptron`: two layers of rectifiers and a linear output.
Whoever trains one says what its outputs mean and what they cost; here are the first weights, the slopes, the
optimiser, and the numbers as they come back.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, NamedTuple

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.chance import child_generator
from modelcast.core.exceptions import MissingExtraError
from modelcast.models.learned.perceptron import Perceptron

__all__ = ["Descent", "Weights", "batches", "descend", "numerics", "perceptron_of", "squashing"]

_ONE_THREAD = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
_FIRST_OUTPUTS = 0.05
_LAST_RATE = 0.02


class Weights(NamedTuple):
    """Weights and biases of the three layers, outputs along the second axis."""

    weights_1: FloatArray
    bias_1: FloatArray
    weights_2: FloatArray
    bias_2: FloatArray
    weights_3: FloatArray
    bias_3: FloatArray


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
    steps
        Batches; the learning rate falls along a cosine to a fiftieth.
    batch
        Windows in a batch.
    learning_rate, penalty
        Of the optimiser (Adam), and weight of the squared weights.
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
    batch: int = 1024
    learning_rate: float = 2e-3
    penalty: float = 1e-4
    resize: float = 0.3
    report_every: int = 50

    def __post_init__(self) -> None:
        if not self.thresholds_m or min(self.thresholds_m) <= 0.0:
            raise ValueError(f"thresholds_m must be positive, and at least one, got {self.thresholds_m}")
        for name in ("softness", "steps", "batch", "learning_rate", "report_every"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        if not self.penalty >= 0.0:
            raise ValueError(f"penalty must not be negative, got {self.penalty}")

    @property
    def reports(self) -> int:
        """How often ``step`` is called."""
        return -(-self.steps // self.report_every)


def numerics() -> tuple[Any, Any, Any]:
    """JAX, its NumPy and optax; JAX on one thread, so that sums are the same on any machine.

    Raises
    ------
    MissingExtraError
        Where they are not installed.
    """
    known = os.environ.get("XLA_FLAGS", "")
    if "multi_thread_eigen" not in known:
        os.environ["XLA_FLAGS"] = f"{known} {_ONE_THREAD}".strip()
    try:
        import jax  # noqa: PLC0415 - an optional extra
        import jax.numpy as jnp  # noqa: PLC0415
        import optax  # noqa: PLC0415
    except ImportError as error:
        raise MissingExtraError("modelcast train", "train") from error
    return jax, jnp, optax


def squashing(inputs: FloatArray, mirrors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Centre and width by which inputs are squashed, (I,) both.

    Parameters
    ----------
    inputs
        Of all windows, (B, I).
    mirrors
        Sign of every input in the mirror, (I,): what changes its sign is centred at zero.
    """
    centre = np.where(mirrors > 0, np.median(inputs, axis=0), 0.0)
    return centre, np.maximum(2.0 * np.median(np.abs(inputs), axis=0), 2e-3)


def perceptron_of(
    weights: Weights, centre: FloatArray, width: FloatArray, *, up_to_noise_m: float = np.inf
) -> Perceptron:
    """The network as a profile keeps it: in 32 bits.

    Parameters
    ----------
    weights
        Of its layers.
    centre, width
        By which its inputs are squashed, (I,).
    up_to_noise_m
        It serves windows whose position noise is at most this [m].
    """
    kept = [one.astype(np.float32).astype(np.float64) for one in (centre, width, *weights)]
    layers = dict(zip(Weights._fields, kept[2:], strict=True))
    return Perceptron(up_to_noise_m, centre=kept[0], width=kept[1], **layers)


def batches(shares: FloatArray, how: Descent, rng: np.random.Generator) -> Iterator[IntArray]:
    """Rows of every batch, drawn by their shares.

    Parameters
    ----------
    shares
        Of each row, (B,); they sum to one.
    how
        Size and number of batches.
    rng
        What draws.
    """
    bounds = np.cumsum(shares)
    for _ in range(how.steps):
        drawn: FloatArray = rng.random(how.batch) * bounds[-1]
        yield np.minimum(np.searchsorted(bounds, drawn), shares.size - 1)


def descend(
    cost: Callable[..., Any],
    given: Iterator[tuple[FloatArray, Sequence[FloatArray]]],
    how: Descent,
    *,
    sizes: tuple[int, int],
    seed: int,
    key: str,
    step: Callable[[int], None],
) -> Weights:
    """Weights that make a cost small.

    Parameters
    ----------
    cost
        Mean cost of a batch by the network's outputs (B, O) and the rest of the batch, in terms of JAX.
    given
        Batches: squashed inputs (B, I), and the rest.
    how
        Layers and optimiser.
    sizes
        Inputs I and outputs O.
    seed, key
        Of the first weights.
    step
        Called with the number of reports so far.

    Raises
    ------
    MissingExtraError
        Where JAX and optax are not installed.
    """
    jax, jnp, optax = numerics()
    inputs, outputs = sizes
    layers: Any = [jnp.asarray(one, jnp.float32) for one in _first_weights(inputs, outputs, how, seed, key)]
    optimiser = optax.adam(optax.cosine_decay_schedule(how.learning_rate, how.steps, _LAST_RATE))
    state = optimiser.init(layers)

    def loss(layers: Any, squashed: Any, rest: Any) -> Any:
        hidden = jax.nn.relu(squashed @ layers[0] + layers[1])
        hidden = jax.nn.relu(hidden @ layers[2] + layers[3])
        squares = sum((layers[at] ** 2).sum() for at in (0, 2, 4))
        return cost(hidden @ layers[4] + layers[5], *rest) + how.penalty * squares

    @jax.jit
    def advance(layers: Any, state: Any, squashed: Any, rest: Any) -> Any:
        slopes = jax.grad(loss)(layers, squashed, rest)
        moves, state = optimiser.update(slopes, state)
        return optax.apply_updates(layers, moves), state

    for done, (squashed, rest) in enumerate(given, start=1):
        now = [np.asarray(one, dtype=np.float32) for one in (squashed, *rest)]
        layers, state = advance(layers, state, now[0], now[1:])
        if done % how.report_every == 0 or done == how.steps:
            step(-(-done // how.report_every))
    return Weights(*(np.asarray(one, dtype=np.float64) for one in layers))


def _first_weights(inputs: int, outputs: int, how: Descent, seed: int, key: str) -> list[FloatArray]:
    """Normal weights that keep the size of what goes through; outputs begin next to zero."""
    rng = child_generator(seed, "weights", key)
    first, second = how.hidden
    return [
        rng.standard_normal((inputs, first)) * np.sqrt(2.0 / inputs),
        np.zeros(first),
        rng.standard_normal((first, second)) * np.sqrt(2.0 / first),
        np.zeros(second),
        rng.standard_normal((second, outputs)) * _FIRST_OUTPUTS / np.sqrt(second),
        np.zeros(outputs),
    ]
