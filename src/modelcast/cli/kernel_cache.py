"""Where compiled code is kept between runs."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import cast

__all__ = ["KernelCache", "kernel_cache"]

_SUFFIXES = frozenset({".nbi", ".nbc"})


@dataclass(frozen=True, slots=True)
class KernelCache:
    """The cache of compiled code.

    Parameters
    ----------
    place
        Its folder, which may not exist yet.
    size_bytes
        Size of all compiled code in it [byte].
    writable
        Whether compiled code can be added.
    """

    place: Path
    size_bytes: int
    writable: bool


def kernel_cache() -> KernelCache:
    """Return where numba keeps modelcast's compiled code.

    The folder that NUMBA_CACHE_DIR names; else beside the source, where that can be written to; else the
    user's cache folder.
    """
    named = os.environ.get("NUMBA_CACHE_DIR")
    package = Path(__file__).resolve().parent.parent
    if named:
        place = Path(named).absolute()
    elif os.access(package, os.W_OK):
        place = package
    else:
        from numba.misc.appdirs import AppDirs

        place = Path(cast("str", AppDirs(appname="numba", appauthor=False).user_cache_dir))
    files = [file for file in place.rglob("*") if file.suffix in _SUFFIXES]
    nearest = next(folder for folder in (place, *place.parents) if folder.exists())
    writable = nearest.is_dir() and os.access(nearest, os.W_OK)
    return KernelCache(place, sum(file.stat().st_size for file in files), writable)
