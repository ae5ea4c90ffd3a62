"""Compiled point functions of a sub-model that is written in Python: each calls it and passes failures on.

They are the only kernels that raise: `modelcast.models.python_function.KeptFailure`, which stands for what
the called function raised.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from modelcast.core.kernel import COMPILES, kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.address_kernels import called_plain
from modelcast.models.python_function import DONE, KeptFailure

__all__ = [
    "AT_CONTEXT",
    "AT_FIT",
    "AT_OBSERVE",
    "AT_PREDICT",
    "AT_STATE",
    "AT_TRACK",
    "HEADER",
    "fit",
    "observe",
    "predict",
    "track",
]

AT_FIT, AT_PREDICT, AT_TRACK, AT_OBSERVE, AT_STATE, AT_CONTEXT = range(6)
HEADER = 6
"""The constants: addresses of the Python functions; the first column of state and of context in a sample."""

_ir: Any = ir  # untyped


def _caller() -> Any:
    """Return what calls a `PythonFunction` at an address."""
    if not COMPILES:
        return called_plain

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        whole = _ir.IntType(64)
        given: list[Any] = []
        for kind, value in zip(signature.args[1:], arguments[1:], strict=True):
            if not isinstance(kind, types.Array):
                given.append(value)
                continue
            array = context.make_array(kind)(context, builder, value)
            sizes = [builder.extract_value(array.shape, axis) for axis in range(kind.ndim)]
            given += [builder.ptrtoint(array.data, whole), *sizes]
        function = _ir.FunctionType(whole, [one.type for one in given])
        return builder.call(builder.inttoptr(arguments[0], function.as_pointer()), given)

    @intrinsic
    def call(_typing: Any, _address: Any, _first: Any, _second: Any, _number: Any, _out: Any) -> Any:
        vector, matrix = types.float64[::1], types.float64[:, ::1]
        return types.int64(types.int64, matrix, vector, types.float64, vector), generate

    return call


_call_python: Any = _caller()
"""``_call_python(address, first (n, C), second (K,), number, out)``: a status, `DONE` or not."""


@kernel
def fit(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Have Python fit a window; it is told the constants, for the columns."""
    if _call_python(np.int64(constants[AT_FIT]), window, constants, 0.0, out) != DONE:
        raise KeptFailure


@kernel
def predict(parameters: FloatVector, horizon_s: float, constants: FloatVector, out: FloatVector) -> None:
    """Have Python predict one displacement."""
    rows = parameters.reshape((1, parameters.size))
    if _call_python(np.int64(constants[AT_PREDICT]), rows, constants, horizon_s, out) != DONE:
        raise KeptFailure


@kernel
def track(parameters: FloatVector, horizons_s: FloatVector, constants: FloatVector, out: FloatMatrix) -> None:
    """Have Python predict the displacements (H, 2) at all horizons."""
    rows = parameters.reshape((1, parameters.size))
    if _call_python(np.int64(constants[AT_TRACK]), rows, horizons_s, 0.0, out.reshape(out.size)) != DONE:
        raise KeptFailure


@kernel
def observe(before: FloatVector, sample: FloatVector, constants: FloatVector, out: FloatVector) -> None:
    """Have Python carry state to a sample; no row before is a start. It is told the first column of state."""
    rows = before.reshape((min(before.size, 1), before.size))
    if _call_python(np.int64(constants[AT_OBSERVE]), rows, sample, constants[AT_STATE], out) != DONE:
        raise KeptFailure
