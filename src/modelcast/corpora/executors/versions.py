"""What must be the same on every machine that works on one job: the versions that its figures depend on."""

import hashlib
import platform
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from modelcast.core.version import installed_versions

__all__ = ["PACKAGES", "difference", "own_versions", "source_digest", "worker_versions"]

PACKAGES = ("modelcast", "numpy", "numba", "llvmlite", "scipy", "polars", "pyarrow")
"""Packages whose version changes figures, or the files they are written into."""

_MISSING = "none"
_SHOWN = 12


@cache
def own_versions() -> Mapping[str, str]:
    """Versions of Python and `PACKAGES` in this process, by name; ``none`` where one is not installed."""
    python = ".".join(platform.python_version_tuple()[:2])
    return {"python": python, **dict.fromkeys(PACKAGES, _MISSING), **installed_versions(PACKAGES)}


@cache
def source_digest() -> str:
    """Return the SHA-256 of all sources of modelcast: two of one version may differ while it is worked on."""
    folder = Path(__file__).parents[2]
    found = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        found.update(path.relative_to(folder).as_posix().encode() + b"\0")
        found.update(hashlib.sha256(path.read_bytes()).digest())
    return found.hexdigest()


def worker_versions() -> dict[str, str]:
    """Versions in this process, and its sources': what a worker says of itself."""
    return {**own_versions(), "modelcast's sources": source_digest()[:_SHOWN]}


def difference(worker: str, theirs: Mapping[str, str], ours: Mapping[str, str]) -> str | None:
    """In what a worker differs, as one line; None where it does not.

    Parameters
    ----------
    worker
        Its address.
    theirs, ours
        Versions by name.

    Examples
    --------
    >>> difference("tcp://10.0.0.7:4001", {"numpy": "2.2.0"}, {"numpy": "2.4.1"})
    'worker tcp://10.0.0.7:4001 has numpy 2.2.0, this machine 2.4.1'
    """
    differ = [
        f"{name} {theirs.get(name, _MISSING)}, this machine {version}"
        for name, version in ours.items()
        if theirs.get(name) != version
    ]
    return f"worker {worker} has {'; '.join(differ)}" if differ else None
