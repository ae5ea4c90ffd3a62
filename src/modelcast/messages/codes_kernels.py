"""Compiled codes: what a sub-model's parameters become on the wire, and what a receiver makes of the codes.

One description serves sender, receiver and simulation. A table has one row a parameter: the columns of
`field_kernels` that say what a code stands for, then where the code stands
(`modelcast.messages.code_table`). A velocity is carried as speed and heading. Its two rows are those of the
two fields, and its two codes are theirs; a speed of code 0 has no direction, and its heading is 0.

Sums are never regrouped, so that a value has the same bits wherever it is computed.
"""

from math import atan2, cos, hypot, sin

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntMatrix, IntVector
from modelcast.messages.field_kernels import FIRST, LAST, code_of, value_of

__all__ = [
    "BITS",
    "COLUMNS",
    "HEADING_PLACE",
    "IN_EXTENSION",
    "PLACE",
    "SPEED_PLACE",
    "decoded_parameters",
    "decoded_rows",
    "instant_of",
    "instants_of",
    "motion_codes",
    "motion_rows",
    "quantise_parameters",
    "quantise_rows",
    "state_instant",
    "values_of_codes",
]

PLACE, BITS, COLUMNS = 7, 8, 9
"""Columns behind those of `field_kernels`: the field's place in Part I, or `IN_EXTENSION`; its bits there."""

IN_EXTENSION = -1
SPEED_PLACE, HEADING_PLACE = 10, 11

_MINUTE_S = 60.0
_MINUTE_MS = 60_000


@kernel
def values_of_codes(table: FloatMatrix, codes: IntVector, held: FloatVector) -> None:
    """Write what the codes of one sub-model stand for, (P,) all."""
    for i in range(codes.size):
        held[i] = value_of(float(codes[i]), table, i)
    for i in range(codes.size):
        if table[i, PLACE] == SPEED_PLACE:
            speed, heading = held[i], held[i + 1]
            if codes[i] == 0:
                held[i], held[i + 1] = 0.0, 0.0
            else:
                held[i], held[i + 1] = speed * sin(heading), speed * cos(heading)


@kernel
def quantise_parameters(
    table: FloatMatrix, parameters: FloatVector, codes: IntVector, held: FloatVector
) -> int:
    """Write the nearest codes of one sub-model's parameters, and what a receiver holds, (P,) all.

    Beyond its range a parameter takes the last code that stands for a value. Where one is not a number,
    nothing is written and its place is returned; else -1. ``held`` may be ``parameters``.
    """
    for i in range(parameters.size):
        if np.isnan(parameters[i]):
            return i
    for i in range(parameters.size):
        value = parameters[i]
        if table[i, PLACE] == SPEED_PLACE:
            value = hypot(parameters[i], parameters[i + 1])
        elif table[i, PLACE] == HEADING_PLACE:
            value = atan2(parameters[i - 1], parameters[i])
        code, _ = code_of(value, table, i)
        codes[i] = int(code)
        if table[i, PLACE] == HEADING_PLACE and codes[i - 1] == 0:
            codes[i] = 0
    values_of_codes(table, codes, held)
    return -1


@kernel
def quantise_rows(
    table: FloatMatrix, offsets: IntVector, parameters: FloatMatrix, codes: IntMatrix, held: FloatMatrix
) -> tuple[int, int]:
    """Quantise all sub-models of many rows, (B, P) all; row and place of the first refused, or -1s."""
    for row in range(parameters.shape[0]):
        for m in range(offsets.size - 1):
            first, end = offsets[m], offsets[m + 1]
            at = quantise_parameters(
                table[first:end], parameters[row, first:end], codes[row, first:end], held[row, first:end]
            )
            if at >= 0:
                return row, first + at
    return -1, -1


@kernel
def motion_codes(
    table: FloatMatrix, offsets: IntVector, in_use: int, carries_all: bool, codes: IntVector, core: IntVector
) -> int:
    """Write into Part I the codes (P,) that stand there; the place of a code that contradicts it, or -1.

    Those of the sub-model in use go before. What it has not comes from the first that has it; sub-models with
    zeros only, which may lack a full window, fill what is still unavailable. The others that are sent along
    must agree with Part I.
    """
    filled = np.zeros(core.size, np.bool_)
    count = offsets.size - 1
    for turn in range(1 + 2 * count):
        m = in_use if turn == 0 else (turn - 1) % count
        empty = True
        for i in range(offsets[m], offsets[m + 1]):
            empty = empty and codes[i] == 0
        last = turn > count
        if turn > 0 and empty != last:
            continue
        for i in range(offsets[m], offsets[m + 1]):
            place = int(table[i, PLACE])
            if place == IN_EXTENSION:
                continue
            known = filled[place] or (last and table[i, FIRST] <= core[place] <= table[i, LAST])
            if not known:
                core[place] = codes[i]
                filled[place] = True
            elif carries_all and not empty and core[place] != codes[i]:
                return i
    return -1


@kernel
def motion_rows(
    table: FloatMatrix,
    offsets: IntVector,
    in_use: IntVector,
    carries_all: bool,
    codes: IntMatrix,
    core: IntMatrix,
) -> tuple[int, int]:
    """Write `motion_codes` of many rows; row and place of the first contradiction, or -1s."""
    for row in range(codes.shape[0]):
        at = motion_codes(table, offsets, in_use[row], carries_all, codes[row], core[row])
        if at >= 0:
            return row, at
    return -1, -1


@kernel
def decoded_parameters(table: FloatMatrix, core: IntVector, codes: IntVector, held: FloatVector) -> None:
    """Take from Part I the codes that stand there, and write what all codes stand for, (P,) both.

    What Part I has no value of is 0.
    """
    for i in range(codes.size):
        place = int(table[i, PLACE])
        if place != IN_EXTENSION:
            known = table[i, FIRST] <= core[place] <= table[i, LAST]
            codes[i] = core[place] if known else 0
        if place == HEADING_PLACE and codes[i - 1] == 0:
            codes[i] = 0
    values_of_codes(table, codes, held)


@kernel
def decoded_rows(table: FloatMatrix, core: IntMatrix, codes: IntMatrix, held: FloatMatrix) -> None:
    """Write `decoded_parameters` of many rows."""
    for row in range(codes.shape[0]):
        decoded_parameters(table, core[row], codes[row], held[row])


@kernel
def state_instant(t_s: float, minute_s: float) -> int:
    """Return the code of an instant within its minute [ms]; minutes began at ``minute_s``."""
    return int(np.rint((t_s - minute_s) % _MINUTE_S * 1000.0)) % _MINUTE_MS


@kernel
def instant_of(code: int, near_s: float, minute_s: float) -> float:
    """Return the instant [s] that a code stands for: of all minutes the one next to ``near_s``."""
    mark_s = code / 1000.0
    return minute_s + _MINUTE_S * np.rint((near_s - minute_s - mark_s) / _MINUTE_S) + mark_s


@kernel
def instants_of(codes: IntVector, near_s: FloatVector, minute_s: float, instants_s: FloatVector) -> None:
    """Write the instants [s] that codes stand for, each next to its ``near_s``, (B,) all."""
    for row in range(codes.size):
        instants_s[row] = instant_of(codes[row], near_s[row], minute_s)
