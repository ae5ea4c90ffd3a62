"""Compiled passes over a hidden Markov chain: forward, backward, and backward with a path drawn."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatMatrix, FloatVector, IntVector

__all__ = ["backward", "draw_path", "forward"]


@kernel
def forward(
    density: FloatMatrix, begins: BoolVector, first: FloatVector, chain: FloatMatrix, out: FloatMatrix
) -> float:
    """Write the filtered chance of each mode at each step (N, M); returns the logarithm of the likelihood.

    ``density`` (N, M) holds the logarithm of each step's density in each mode; where a sequence ``begins``,
    modes have the chances ``first`` (M,).
    """
    total = 0.0
    modes = first.size
    for k in range(begins.size):
        best = -np.inf
        for j in range(modes):
            best = max(best, density[k, j])
        norm = 0.0
        for j in range(modes):
            chance = first[j]
            if not begins[k]:
                chance = 0.0
                for i in range(modes):
                    chance += out[k - 1, i] * chain[i, j]
            out[k, j] = chance * np.exp(density[k, j] - best)
            norm += out[k, j]
        for j in range(modes):
            out[k, j] /= norm
        total += best + np.log(norm)
    return total


@kernel
def backward(
    filtered: FloatMatrix, begins: BoolVector, chain: FloatMatrix, out: FloatMatrix, moves: FloatMatrix
) -> None:
    """Write the smoothed chance of each mode (N, M), and the expected moves of the chain (M, M).

    ``filtered`` (N, M) is what `forward` wrote; ``out`` may not be the same array.
    """
    count, modes = filtered.shape
    for i in range(modes):
        for j in range(modes):
            moves[i, j] = 0.0
    ahead = np.empty(modes)
    for back in range(count):
        k = count - 1 - back
        if k == count - 1 or begins[k + 1]:
            for j in range(modes):
                out[k, j] = filtered[k, j]
            continue
        for j in range(modes):
            ahead[j] = 0.0
            for i in range(modes):
                ahead[j] += filtered[k, i] * chain[i, j]
        for i in range(modes):
            out[k, i] = 0.0
            for j in range(modes):
                if ahead[j] > 0.0:
                    both = filtered[k, i] * chain[i, j] * out[k + 1, j] / ahead[j]
                    out[k, i] += both
                    moves[i, j] += both


@kernel
def draw_path(
    filtered: FloatMatrix, begins: BoolVector, chain: FloatMatrix, uniforms: FloatVector, out: IntVector
) -> None:
    """Draw a path of modes (N,) given all data, from the last step back; ``uniforms`` (N,) in [0, 1)."""
    count, modes = filtered.shape
    weight = np.empty(modes)
    for back in range(count):
        k = count - 1 - back
        last = k == count - 1 or begins[k + 1]
        total = 0.0
        for j in range(modes):
            weight[j] = filtered[k, j] * (1.0 if last else chain[j, out[k + 1]])
            total += weight[j]
        left = uniforms[k] * total
        chosen = modes - 1
        for j in range(modes):
            left -= weight[j]
            if left < 0.0:
                chosen = j
                break
        out[k] = chosen
