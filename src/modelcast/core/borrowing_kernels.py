"""A way to compile inner functions: they borrow their arrays and do not count references to them.

Numba counts references to every array that a compiled function is given, atomically. In a function called for
every pair of vehicles that is most of the time. A function decorated with `borrowing` must not create or keep
an array; it reads and writes those it is given.
"""

from collections.abc import Callable
from typing import Any

import numba

__all__ = ["borrowing"]

_OPTIONS: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "_nrt": False,
    "forceinline": True,
    "error_model": "numpy",
}


def borrowing(function: Callable[..., Any]) -> Any:
    """Compile a function that creates no array."""
    return numba.njit(**_OPTIONS)(function)
