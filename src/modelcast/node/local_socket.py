"""Sockets in the file system that only this user may open."""

import asyncio
import os
import stat
from collections.abc import Callable
from pathlib import Path

__all__ = ["serve_locally"]


async def serve_locally(
    meet: Callable[[asyncio.StreamReader, asyncio.StreamWriter], None], path: str, *, limit: int = 2**16
) -> asyncio.Server:
    """Listen at a local socket that only this user may open.

    Parameters
    ----------
    meet
        Called for each that comes.
    path
        Of the socket; one that was left there before is replaced.
    limit
        Octets that are read ahead.

    Raises
    ------
    OSError
        Where it cannot be made, or something else is there.
    """
    _remove_socket(Path(path))
    before = os.umask(0o177)
    try:
        return await asyncio.start_unix_server(meet, path, limit=limit)
    finally:
        os.umask(before)


def _remove_socket(place: Path) -> None:
    """Remove what was left there; anything that is no socket stays."""
    if place.exists() and stat.S_ISSOCK(place.stat().st_mode):
        place.unlink()
