"""Compiled rounding of model updates to what their codes stand for, many at once."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix
from modelcast.messages.bsm_kernels import code_of, value_of

__all__ = ["MEMBER", "quantise"]

_STEP, _LOW, _HIGH, MEMBER = 0, 1, 2, 3
"""Columns of ``fields``: step, lowest and highest code of a coefficient, and the sub-model it is of."""


@kernel
def quantise(
    parameters: FloatMatrix, meaning: FloatMatrix, fields: FloatMatrix, carries_all: bool, held: FloatMatrix
) -> tuple[int, int]:
    """Write what a receiver holds, (B, F + 1 + C); return row and column of the first refused, or -1, -1.

    ``meaning`` (F, 7) is that of `bsm_kernels`, ``fields`` is (C, 4). Between the two kinds of columns stands
    the sub-model in use. Coefficients that are not carried become not a number.
    """
    core = meaning.shape[0]
    for row in range(parameters.shape[0]):
        for f in range(core):
            code, known = code_of(parameters[row, f], meaning, f)
            if not known:
                return row, f
            # A whole number in between, as on the wire: no zero with a sign.
            held[row, f] = value_of(float(np.int64(code)), meaning, f)
        in_use = parameters[row, core]
        held[row, core] = in_use
        for i in range(fields.shape[0]):
            column = core + 1 + i
            if not carries_all and fields[i, MEMBER] != in_use:
                held[row, column] = np.nan
                continue
            value, step = parameters[row, column], fields[i, _STEP]
            if np.isnan(value):
                return row, column
            nearest = min(max(value, fields[i, _LOW] * step), fields[i, _HIGH] * step)
            held[row, column] = float(np.int64(np.rint(nearest / step))) * step
    return -1, -1
