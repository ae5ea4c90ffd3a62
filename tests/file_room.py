"""As where a disk is full: the system takes no file that is larger than so much."""

from collections.abc import Generator
from contextlib import contextmanager

__all__ = ["room"]


@contextmanager
def room(most_bytes: int | None) -> Generator[None]:
    """Refuse larger files for as long as the block lasts; None for any."""
    if most_bytes is None:
        yield
        return
    import resource  # noqa: PLC0415 - not on every platform

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
