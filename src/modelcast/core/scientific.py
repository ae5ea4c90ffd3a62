"""SciPy, taken in on first use: an evaluation of trips does without it, and so it comes with extras."""

import importlib
from typing import Any

from modelcast.core.exceptions import MissingExtraError

__all__ = ["scientific"]


def scientific(part: str, what: str, extra: str = "network") -> Any:
    """Return a module of SciPy.

    Parameters
    ----------
    part
        Its name without ``scipy.``.
    what
        What the user asked for, for the error.
    extra
        The extra that brings it to who asks for that.

    Raises
    ------
    MissingExtraError
        Where SciPy is not installed.

    Examples
    --------
    >>> float(scientific("special", "a radio").erfc(0.0))
    1.0
    """
    try:
        return importlib.import_module(f"scipy.{part}")
    except ImportError as error:
        raise MissingExtraError(what, extra) from error
