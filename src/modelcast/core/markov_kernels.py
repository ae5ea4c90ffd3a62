"""Compiled steps of a Markov chain."""

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix

__all__ = ["next_state"]


@kernel(inlined=True)
def next_state(state: int, uniform: float, up_to: FloatMatrix) -> int:
    """Return the next state of K, ``up_to`` (K + 1, K) as `MarkovChain.up_to` has it; -1 before the first."""
    states = up_to.shape[1]
    row = states if state < 0 else state
    found = 0
    while found < states - 1 and uniform >= up_to[row, found]:
        found += 1
    return found
