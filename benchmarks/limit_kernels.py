"""Kernels that do nothing but move octets, or nothing but multiply and add: what the machine can do."""

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector

__all__ = ["FLOPS_EACH", "move", "multiply_add"]

FLOPS_EACH = 32
"""Multiplications and additions of `multiply_add` a number and round."""


@kernel(fast=True)
def move(source: FloatVector, out: FloatVector) -> float:
    """Read all of the source and write all of ``out``; return the sum of the source."""
    total = 0.0
    for i in range(source.size):
        total += source[i]
    for i in range(out.size):
        out[i] = 1.0
    return total


@kernel(fast=True)
def multiply_add(rounds: int, numbers: FloatVector, factor: float, term: float) -> None:
    """Replace every number by factor times itself plus term, sixteen times a round."""
    for _ in range(rounds):
        for i in range(numbers.size):
            x = numbers[i]
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            numbers[i] = x
