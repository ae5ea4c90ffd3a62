"""Where compiled code is kept between runs."""

import os
from dataclasses import dataclass
from pathlib import Path

__all__ = ["KernelCache", "kernel_cache"]


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
    """Return where modelcast keeps its compiled code (`modelcast.core.kernel_cache`)."""
    from modelcast.core.kernel_cache import cache_folder

    place = cache_folder().absolute()
    files = list(place.rglob("*.kernel"))
    nearest = next(folder for folder in (place, *place.parents) if folder.exists())
    writable = nearest.is_dir() and os.access(nearest, os.W_OK)
    return KernelCache(place, sum(file.stat().st_size for file in files), writable)
