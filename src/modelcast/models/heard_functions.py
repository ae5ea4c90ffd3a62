"""Point functions as receivers run them: on parameters that anybody may have sent.

A sub-model in Python may refuse what a message carries, or give a number that is none. To its own vehicle
that is an error of the model; to a host it is one message of a stranger's, which must not end the host.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import ModelcastWarning, SubModelError
from modelcast.models.base import PointFunctions
from modelcast.models.python_function import PythonFunction

__all__ = ["heard_functions", "tell_failure"]

_told: set[tuple[str, str]] = set()
"""Sub-models and their functions whose failure was told: strangers choose what is given."""


def heard_functions(functions: PointFunctions) -> PointFunctions:
    """Return point functions that give NaN where a Python function of theirs fails on what it is given.

    Compiled functions stay as they are: they give NaN by themselves.

    Parameters
    ----------
    functions
        Of a sub-model.

    Examples
    --------
    >>> from modelcast.models.base import made_functions
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> own = made_functions(ConstantVelocity(), 0.1)
    >>> heard_functions(own) is own
    True
    """
    if not any(isinstance(call.function, PythonFunction) for call in functions.calls):
        return functions
    calls = tuple(
        replace(call, function=PythonFunction(_Heard(call.function.body)))
        if isinstance(call.function, PythonFunction)
        else call
        for call in functions.calls
    )
    return replace(functions, calls=calls)


def tell_failure(error: SubModelError) -> None:
    """Warn that a sub-model failed on what a message carried, the first time for each of its functions.

    Parameters
    ----------
    error
        What it raised.
    """
    failed = (error.model, error.called)
    if failed not in _told:
        _told.add(failed)
        warnings.warn(
            f"{error} A message carried these parameters: it is refused, or the spread is that of constant "
            "velocity. This is told once.",
            ModelcastWarning,
            stacklevel=2,
        )


@dataclass(frozen=True, slots=True)
class _Heard:
    """The body of a `PythonFunction`; where it fails, no number."""

    body: Callable[[FloatArray, FloatArray, float, FloatArray], None]

    def __call__(self, first: FloatArray, second: FloatArray, number: float, out: FloatArray) -> None:
        """Call it."""
        try:
            self.body(first, second, number, out)
        except SubModelError as error:
            out[:] = np.nan
            tell_failure(error)
