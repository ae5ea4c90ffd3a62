"""Point functions called by their addresses, for compiled wrappers round them.

The address of a model's compiled function stands in a wrapper's constants: so one compiled wrapper serves
every model, as one compiled walk does.
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from modelcast.models.point_kernels import FIT_SIGNATURE, PREDICT_SIGNATURE

__all__ = ["fit_at", "predict_at"]

_code: Any = cgutils  # untyped


def _called(signature: Any) -> Any:
    """Return an intrinsic that turns an address into a function of this signature."""
    function_type = types.FunctionType(signature)

    @intrinsic
    def at_address(_typing: Any, _address: Any) -> Any:
        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            made: Any = _code.create_struct_proxy(function_type)(context, builder)
            made.c_addr = builder.inttoptr(arguments[0], _code.voidptr_t)
            nothing = ir.Constant(_code.voidptr_t, None)
            made.py_addr = nothing
            made.jit_addr = nothing
            return made._getvalue()  # noqa: SLF001 - Numba's own name for it

        return function_type(types.int64), generate

    return at_address


fit_at = _called(FIT_SIGNATURE)
"""Function of `FIT_SIGNATURE` at an address."""

predict_at = _called(PREDICT_SIGNATURE)
"""Function of `PREDICT_SIGNATURE` at an address."""
