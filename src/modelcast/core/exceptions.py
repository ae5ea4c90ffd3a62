"""The errors modelcast raises on purpose.

::

    ModelcastError
    ├── CodecError         bytes are not a message: reason, offset in bits
    ├── DataFormatError    a file is not what its format says: path, row, value, remedy
    ├── ConfigError        options that do not fit together, or that fit no trip
    ├── MissingExtraError  an optional part is not installed: the extra that brings it
    ├── PolicyError        a policy written in Python asks for what a station cannot do; a ValueError too
    └── SubModelError      a sub-model written in Python failed, or gave what is none: model, row, value

What works but is not what it seems is a `ModelcastWarning`.

Mistakes of a caller of the Python interface are plain ``ValueError``.
"""

from typing import Any

from modelcast.core.extras import EXTRAS, install_command
from modelcast.core.near_names import listed

__all__ = [
    "CodecError",
    "ConfigError",
    "DataFormatError",
    "MissingExtraError",
    "ModelcastError",
    "ModelcastWarning",
    "PolicyError",
    "SubModelError",
]


_MOST_NAMED = 3


class ModelcastError(Exception):
    """Base of every error modelcast raises on purpose; it comes out of a worker process as it was raised."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Keep the text and the fields: the arguments of a subclass are not its ``args``."""
        return _raised_elsewhere, (type(self), self.args), self.__dict__


def _raised_elsewhere(kind: type[ModelcastError], arguments: tuple[Any, ...]) -> ModelcastError:
    """Return an error as another process raised it."""
    error = kind.__new__(kind, *arguments)
    error.args = arguments
    return error


class CodecError(ModelcastError):
    """Bytes that are not a message.

    Parameters
    ----------
    reason
        What is wrong, with the offending value.
    offset_bits
        Where: bits from the start of the bytes given, the most significant bit of the first octet being 0.
    """

    def __init__(self, reason: str, offset_bits: int) -> None:
        self.reason = reason
        self.offset_bits = offset_bits
        super().__init__(f"bit {offset_bits}: {reason}")


class ConfigError(ModelcastError):
    """Options that do not fit together, or that no trip can satisfy."""


class PolicyError(ModelcastError, ValueError):
    """A policy written in Python decided what a station cannot do; the text names the policy."""


class SubModelError(ModelcastError):
    """A sub-model written in Python failed, or gave something else than it says; the cause is chained.

    Parameters
    ----------
    text
        What went wrong.
    model, called
        Name of the sub-model, and of its function; empty where no function of one was called.
    """

    def __init__(self, text: str, *, model: str = "", called: str = "") -> None:
        self.model = model
        self.called = called
        super().__init__(text)


class ModelcastWarning(UserWarning):
    """Something works, but other than one may take it to."""


class DataFormatError(ModelcastError):
    """A file is not what its format says.

    Parameters
    ----------
    path
        The file, as the user named it.
    problem
        What is wrong, with the offending value.
    row
        One-based line or record number, where one is to blame.
    remedy
        What the user can do about it.
    """

    def __init__(self, path: str, problem: str, *, row: int | None = None, remedy: str = "") -> None:
        self.path = path
        self.problem = problem
        self.row = row
        self.remedy = remedy
        place = path if row is None else f"{path}, row {row}"
        super().__init__(f"{place}: {problem}." + (f" {remedy}" if remedy else ""))


class MissingExtraError(ModelcastError):
    """An optional part of modelcast is not installed.

    Parameters
    ----------
    what
        What the user asked for.
    extra
        The extra that brings it, a name in `modelcast.core.extras.EXTRAS`.
    """

    def __init__(self, what: str, extra: str) -> None:
        own = tuple(EXTRAS[extra].packages)
        packages = listed(own, "and") if len(own) <= _MOST_NAMED else f"the packages of the extra {extra}"
        super().__init__(f"{what} needs {packages}: {install_command(own)}")
