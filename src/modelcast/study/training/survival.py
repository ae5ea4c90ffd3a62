"""The loss of sub-models that networks make: how long a path holds, softened so that it has a slope."""

from typing import Any

from modelcast.core.arrays import FloatArray
from modelcast.study.training.descent import numerics

__all__ = ["FORGIVEN_S", "survival_cost"]

FORGIVEN_S = 0.1
"""Added to every survival [s]: a sender looks once a sample, and no survival is shorter than that."""

_LEAST_ERROR_M = 1e-3


def survival_cost(
    off_m: Any, known: Any, steps_s: FloatArray, *, thresholds_m: tuple[float, ...], softness: float
) -> Any:
    """Mean cost of the paths of a batch, in terms of JAX.

    The error so far, E_h, is the greatest error at any horizon up to h. A path holds at h with weight
    1/(1 + exp((E_h - th)/(softness·th))), and its survival L is the sum of weights times steps. The cost of a
    path is the mean of -log(L + `FORGIVEN_S`) over the thresholds.

    Parameters
    ----------
    off_m
        How far paths are off at each horizon, along and to the left, (B, H, 2) [m].
    known
        1 where the truth is known, 0 beyond its end, (B, H): there a path neither holds nor fails.
    steps_s
        Time that each horizon stands for, (H,) [s].
    thresholds_m
        The thresholds [m].
    softness
        Width of the step at a threshold, as a share of it.

    Examples
    --------
    >>> import numpy as np
    >>> exact = survival_cost(
    ...     np.zeros((1, 3, 2)), np.ones((1, 3)), np.ones(3), thresholds_m=(1.0,), softness=0.01
    ... )
    >>> round(float(exact), 3)  # -log(3.1)
    -1.131
    """
    jax, jnp, _ = numerics()
    errors = jnp.sqrt((jnp.asarray(off_m) ** 2).sum(-1) + _LEAST_ERROR_M**2) * known
    worst = jax.lax.cummax(errors, axis=1)
    limits = jnp.asarray(thresholds_m)
    holds = jax.nn.sigmoid((limits - worst[..., None]) / (softness * limits))
    survival_s = (holds * known[..., None] * jnp.asarray(steps_s)[:, None]).sum(1)
    return -jnp.log(survival_s + FORGIVEN_S).mean()
