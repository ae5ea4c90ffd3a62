"""Python functions that compiled loops call: by an address too, with their errors kept and raised again.

A compiled loop knows point functions by addresses (`modelcast.models.address_kernels`). A `PythonFunction`
has one as well, of a small piece of code that takes the interpreter's lock, copies what the loop gave into
arrays, calls Python and answers with a status. What Python raised is kept for the thread and comes out of
the outermost compiled function as it was raised: nothing is swallowed on the way.
"""

import ctypes
import hashlib
import pickle
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import SubModelError
from modelcast.core.kernel import COMPILES
from modelcast.models.address_kernels import point_address

__all__ = ["DONE", "KeptFailure", "PythonFunction"]

DONE = 0
"""What a call answers where nothing was raised."""

_RAISED = 1

_Whole = ctypes.c_int64
_Native: Any = ctypes.CFUNCTYPE(
    _Whole, _Whole, _Whole, _Whole, _Whole, _Whole, ctypes.c_double, _Whole, _Whole
)
"""``(first, rows, columns, second, size, number, out, size) -> status``: addresses and sizes of arrays."""

_kept = threading.local()

_native: dict[bytes, Any] = {}
"""What has an address, by `PythonFunction.key`; never let go, since a loop may hold the address."""

_making = threading.Lock()


class KeptFailure(Exception):  # noqa: N818 - it is never seen: another exception stands for it
    """Raised by a compiled function, it is the exception that Python raised in a call of this thread."""

    def __new__(cls, *raised: object) -> Any:
        """Return what was kept, or what is given: whoever raises a class may call it again, with its result.

        It stays kept until the next failure of this thread: compiled code asks for it twice.
        """
        return raised[0] if raised else _kept.error


@dataclass(frozen=True, slots=True)
class PythonFunction:
    """A Python function that compiled loops call by its address; it travels, its address does not.

    Parameters
    ----------
    body
        ``body(first, second, number, out)``: ``first`` and ``second`` are arrays of its own, (n, C) or (n,)
        and (K,); what it has to say it writes into ``out``. It pickles; two that pickle alike are the same.

    Raises
    ------
    SubModelError
        Where it does not pickle.
    """

    body: Callable[[FloatArray, FloatArray, float, FloatArray], None] = field(compare=False)
    key: bytes = field(init=False, repr=False)

    def __post_init__(self) -> None:
        try:
            content = pickle.dumps(self.body)
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            raise SubModelError(
                f"A sub-model goes to other processes and must pickle: {error}. Keep numbers, text and "
                "arrays in its fields, and functions in its module."
            ) from error
        object.__setattr__(self, "key", hashlib.sha256(content).digest())

    def __call__(self, first: FloatArray, second: FloatArray, number: float, out: FloatArray) -> int:
        """Run the body; keep what it raises, and say whether it did."""
        try:
            self.body(first, second, number, out)
        except BaseException as error:  # noqa: BLE001 - it is raised again: `KeptFailure`
            _kept.error = error
            return _RAISED
        return DONE

    @property
    def address(self) -> int:
        """Where compiled loops of this process find it."""
        if not COMPILES:
            return point_address(self, ())
        with _making:
            if self.key not in _native:
                _native[self.key] = _Native(self._called)
            return int(ctypes.cast(_native[self.key], ctypes.c_void_p).value or 0)

    def _called(  # noqa: PLR0917 - the native signature
        self, first: int, rows: int, columns: int, second: int, size: int, number: float, out: int, most: int
    ) -> int:
        """Take addresses for arrays: copies of what is given, the place itself of what is wanted."""
        given = _array(first, rows * columns).copy().reshape(rows, columns)
        return self(given, _array(second, size).copy(), number, _array(out, most))


def _array(address: int, size: int) -> FloatArray:
    """The numbers at an address, (size,), without a copy."""
    memory: Any = (ctypes.c_double * size).from_address(address)
    return np.ndarray((size,), np.float64, memory)
