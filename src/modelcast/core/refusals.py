"""What the operating system refuses, as a reason and what to do about it."""

import errno
import os
import re

__all__ = ["is_full", "refusal"]

_ROOM = "Make room there, or name another place"
_REMEDIES = {
    errno.ENOENT: "Check the path",
    errno.EACCES: "Name a place that you may read and write",
    errno.ENOSPC: _ROOM,
    errno.EDQUOT: _ROOM,
    errno.EFBIG: f"{_ROOM}; ulimit -f says how large a file may be",
    errno.EROFS: "Name another place",
    errno.EADDRINUSE: "Another program listens there: end it, or name another port",
}
"""What to do, by what is refused."""

_FULL = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
_NUMBER = re.compile(r"\b(?:errno|os error) (\d{1,4})\b", re.IGNORECASE)
"""Where libraries that open files themselves write it: Polars and pyarrow."""


def refusal(error: OSError) -> str:
    """Return why something was refused, and the remedy as a sentence where there is one.

    Parameters
    ----------
    error
        What was raised.

    Examples
    --------
    >>> refusal(OSError(28, "No space left on device"))
    'No space left on device. Make room there, or name another place.'
    >>> refusal(OSError("Error writing bytes to file. Detail: [errno 28] No space left on device"))
    'No space left on device. Make room there, or name another place.'
    """
    number = _number(error)
    reason = os.strerror(number) if number > 0 else error.strerror or str(error)
    remedy = _REMEDIES.get(number)
    return f"{reason}. {remedy}." if remedy else reason


def is_full(error: OSError) -> bool:
    """Whether there is no room where something is written.

    Parameters
    ----------
    error
        What was raised.
    """
    return _number(error) in _FULL


def _number(error: OSError) -> int:
    """The system's number; 0 where it is not known."""
    found = _NUMBER.search(str(error))
    return error.errno or (int(found[1]) if found else 0)
