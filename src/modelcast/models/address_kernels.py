"""Point functions called by their addresses: one compiled loop serves every model.

A *point function* fits one window, predicts one displacement or carries state to one sample. Loops take it
as an address, an int64 that is asked for just before the call (`point_address`) and never kept, stored or
sent: it means something in one process alone. A loop over a bank takes an array of them.
"""

import functools
import itertools
from collections.abc import Callable
from typing import Any
from weakref import WeakValueDictionary

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from modelcast.core.kernel import COMPILES, Kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, numba_type

__all__ = [
    "FIT_TYPES",
    "OBSERVE_TYPES",
    "PREDICT_TYPES",
    "TRACK_TYPES",
    "called_plain",
    "fit_at",
    "observe_at",
    "plain_number",
    "point_address",
    "predict_at",
    "track_at",
]

FIT_TYPES = (FloatMatrix, FloatVector, FloatVector)
"""``fit(window (n, 9), constants (K,), out_parameters (P,)) -> None``."""

PREDICT_TYPES = (FloatVector, float, FloatVector, FloatVector)
"""``predict(parameters (P,), horizon_s, constants (K,), out_displacement (2,)) -> None``."""

OBSERVE_TYPES = (FloatVector, FloatVector, FloatVector, FloatVector)
"""``observe(before (C,), sample (C,), constants (K,), out_state (S,)) -> None``."""

TRACK_TYPES = (FloatVector, FloatVector, FloatVector, FloatMatrix)
"""``track(parameters (P,), horizons_s (H,), constants (K,), out_displacements (H, 2)) -> None``."""

_code: Any = cgutils  # untyped

_plain: WeakValueDictionary[int, Callable[..., Any]] = WeakValueDictionary()
"""Point functions by number, where nothing is compiled and an address is such a number; no number returns."""

_numbers = itertools.count(1)


def plain_number(function: Callable[..., Any]) -> int:
    """Return a number for a function, where nothing is compiled; it is known as long as the function lives.

    Parameters
    ----------
    function
        Any.
    """
    number = next(_numbers)
    _plain[number] = function
    return number


@functools.cache
def point_address(function: Any, signature: tuple[Any, ...]) -> int:
    """Return where a point function is in this process.

    Parameters
    ----------
    function
        A kernel.
    signature
        `FIT_TYPES`, `PREDICT_TYPES`, `OBSERVE_TYPES` or `TRACK_TYPES`, the types of its arguments.

    Raises
    ------
    TypeError
        Where it is no kernel, or its arguments are others.
    """
    if not COMPILES:
        return plain_number(function)
    if not isinstance(function, Kernel):
        raise TypeError(f"a point function is decorated with kernel, got {function!r}")
    declared = function.declared
    wanted = types.void(*(numba_type(one) for one in signature))
    if declared != wanted:
        raise TypeError(f"{function.label} must be {wanted}, not {declared}")
    return function.address


def _called_at(signature: tuple[Any, ...]) -> Any:
    """Return what calls a point function of this signature at an address, and passes its failures on."""
    if not COMPILES:
        return called_plain
    argument_types = tuple(numba_type(one) for one in signature)

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        convention = context.call_conv
        pointer = convention.get_function_type(types.none, argument_types).as_pointer()
        function = builder.inttoptr(arguments[0], pointer)
        status, _ = convention.call_function(builder, function, types.none, argument_types, arguments[1:])
        with _code.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        return context.get_dummy_value()

    if len(argument_types) == len(FIT_TYPES):

        @intrinsic
        def fit(_typing: Any, _address: Any, _window: Any, _constants: Any, _out: Any) -> Any:
            return types.none(types.int64, *argument_types), generate

        return fit

    @intrinsic
    def call(_typing: Any, _address: Any, _first: Any, _second: Any, _constants: Any, _out: Any) -> Any:
        return types.none(types.int64, *argument_types), generate

    return call


def called_plain(address: int, *arguments: Any) -> Any:
    """Call a function by its number where nothing is compiled, and return what it does.

    Parameters
    ----------
    address
        From `point_address`.
    arguments
        Its own.
    """
    return _plain[address](*arguments)


fit_at: Any = _called_at(FIT_TYPES)
"""``fit_at(address, window, constants, out)``: call a function of `FIT_TYPES`."""

predict_at: Any = _called_at(PREDICT_TYPES)
"""``predict_at(address, parameters, horizon_s, constants, out)``: call a function of `PREDICT_TYPES`."""

observe_at: Any = _called_at(OBSERVE_TYPES)
"""``observe_at(address, before, sample, constants, out)``: call a function of `OBSERVE_TYPES`."""

track_at: Any = _called_at(TRACK_TYPES)
"""``track_at(address, parameters, horizons_s, constants, out)``: call a function of `TRACK_TYPES`."""
