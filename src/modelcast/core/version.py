"""The version of the installed package, for the files it writes."""

from functools import cache
from importlib.metadata import PackageNotFoundError, version

__all__ = ["package_version"]


@cache
def package_version() -> str:
    """Return the version of the installed package, or ``unknown`` where it runs uninstalled.

    Examples
    --------
    >>> package_version() == package_version()
    True
    """
    try:
        return version("modelcast")
    except PackageNotFoundError:
        return "unknown"
