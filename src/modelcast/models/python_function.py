"""Python functions that compiled loops call: by an address too, with their errors kept and raised again.

A compiled loop knows point functions by addresses (`modelcast.models.address_kernels`). A `PythonFunction`
has one as well, of a small piece of code that takes the interpreter's lock, copies what the loop gave into
arrays, calls Python and answers with a status. What Python raised is kept for the thread and comes out of
the outermost compiled function as it was raised: nothing is swallowed on the way.

That piece of code lives as long as its `PythonFunction`; an array of addresses keeps alive what it addresses
(`keeping`), wherever it or a view of it goes in this process.
"""

import copyreg
import ctypes
import functools
import hashlib
import io
import pickle
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from types import FunctionType
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import SubModelError
from modelcast.core.kernel import COMPILES
from modelcast.models.address_kernels import plain_number

__all__ = ["DONE", "KeptFailure", "PythonFunction", "keeping"]

DONE = 0
"""What a call answers where nothing was raised."""

_RAISED = 1

_Whole = ctypes.c_int64
_Native: Any = ctypes.CFUNCTYPE(
    _Whole, _Whole, _Whole, _Whole, _Whole, _Whole, ctypes.c_double, _Whole, _Whole
)
"""``(first, rows, columns, second, size, number, out, size) -> status``: addresses and sizes of arrays."""

_kept = threading.local()

_making = threading.Lock()


class KeptFailure(Exception):  # noqa: N818 - it is never seen: another exception stands for it
    """Raised by a compiled function, it is the exception that Python raised in a call of this thread."""

    def __new__(cls, *raised: object) -> Any:
        """Return what was kept, or what is given: whoever raises a class may call it again, with its result.

        It stays kept until the next failure of this thread: compiled code asks for it twice.
        """
        return raised[0] if raised else _kept.error


class _Named(pickle.Pickler):
    """Pickles, and notes the live objects that a pickle names without holding them: classes and functions."""

    def __init__(self, file: io.BytesIO) -> None:
        super().__init__(file)
        self.found: list[object] = []

    def reducer_override(self, obj: Any) -> Any:
        """Note what goes by its name; the rest is pickled as ever."""
        if isinstance(obj, type | FunctionType):
            self.found.append(obj)
            return NotImplemented
        if type(obj) in copyreg.dispatch_table:
            return NotImplemented
        reduced = obj.__reduce_ex__(pickle.DEFAULT_PROTOCOL)
        if isinstance(reduced, str):
            self.found.append(obj)
        return reduced


@dataclass(frozen=True, slots=True, weakref_slot=True)
class PythonFunction:
    """A Python function that compiled loops call by its address; it travels, its address does not.

    Parameters
    ----------
    body
        ``body(first, second, number, out)``: ``first`` and ``second`` are arrays of its own, (n, C) or (n,)
        and (K,); what it has to say it writes into ``out``. It pickles. Two that pickle alike, and name the
        same classes and functions of this process, are the same: a class defined again is another one,
        whatever its name.

    Raises
    ------
    SubModelError
        Where it does not pickle.
    """

    body: Callable[[FloatArray, FloatArray, float, FloatArray], None] = field(compare=False)
    _key: bytes = field(init=False, repr=False)
    _named: tuple[object, ...] = field(init=False, repr=False, compare=False)
    _native: Any = field(default=0, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        content = io.BytesIO()
        pickler = _Named(content)
        try:
            pickler.dump(self.body)
        except (Exception, SystemExit) as error:  # whatever a field raises
            raise SubModelError(
                f"A sub-model goes to other processes and must pickle: {error}. Keep numbers, text and "
                "arrays in its fields, and functions in its module; make it anew where its class was "
                "defined again."
            ) from error
        key = hashlib.sha256(content.getvalue())
        key.update(repr([id(one) for one in pickler.found]).encode())
        object.__setattr__(self, "_key", key.digest())
        object.__setattr__(self, "_named", tuple(pickler.found))  # no other takes their places meanwhile

    def __reduce__(self) -> tuple[type["PythonFunction"], tuple[object, ...]]:
        """Leave key and address behind: in another process they mean nothing."""
        return PythonFunction, (self.body,)

    def __call__(self, first: FloatArray, second: FloatArray, number: float, out: FloatArray) -> int:
        """Run the body; keep what it raises, and say whether it did."""
        return _told(self.body, first, second, number, out)

    @property
    def address(self) -> int:
        """Where compiled loops of this process find it, as long as it lives (`keeping`)."""
        with _making:
            if not self._native:
                made = _Native(functools.partial(_called, self.body)) if COMPILES else plain_number(self)
                object.__setattr__(self, "_native", made)
        native: Any = self._native
        return int(ctypes.cast(native, ctypes.c_void_p).value or 0) if COMPILES else native


def keeping(numbers: FloatArray, functions: tuple[object, ...]) -> FloatArray:
    """Return numbers in an array that keeps functions alive as long as it, or a view of it, lives.

    Parameters
    ----------
    numbers
        Among them their addresses, (K,).
    functions
        Any objects.

    Examples
    --------
    >>> keeping(np.array([1.0, 2.0]), ())
    array([1., 2.])
    """
    memory: Any = (ctypes.c_double * numbers.size)()
    memory.functions = functions
    out = np.ndarray(numbers.shape, np.float64, memory)
    out[:] = numbers
    return out


def _told(
    body: Callable[[FloatArray, FloatArray, float, FloatArray], None],
    first: FloatArray,
    second: FloatArray,
    number: float,
    out: FloatArray,
) -> int:
    """Run a body; keep what it raises, and say whether it did."""
    try:
        body(first, second, number, out)
    except BaseException as error:  # noqa: BLE001 - it is raised again: `KeptFailure`
        _kept.error = error
        return _RAISED
    return DONE


def _called(  # noqa: PLR0917 - the native signature
    body: Any,
    first: int,
    rows: int,
    columns: int,
    second: int,
    size: int,
    number: float,
    out: int,
    most: int,
) -> int:
    """Take addresses for arrays: copies of what is given, the place itself of what is wanted."""
    given = _array(first, rows * columns).copy().reshape(rows, columns)
    return _told(body, given, _array(second, size).copy(), number, _array(out, most))


def _array(address: int, size: int) -> FloatArray:
    """The numbers at an address, (size,), without a copy."""
    memory: Any = (ctypes.c_double * size).from_address(address)
    return np.ndarray((size,), np.float64, memory)
