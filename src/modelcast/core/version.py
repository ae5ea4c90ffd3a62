"""Versions of the installed package and of what it stands on, for the files it writes."""

from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version

__all__ = ["installed_versions", "package_version"]


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


def installed_versions(names: Iterable[str]) -> dict[str, str]:
    """Return the versions of those packages that are installed, by name.

    Parameters
    ----------
    names
        As they are installed by.

    Examples
    --------
    >>> list(installed_versions(["numpy", "no-such-package"]))
    ['numpy']
    """
    found: dict[str, str] = {}
    for name in names:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found
