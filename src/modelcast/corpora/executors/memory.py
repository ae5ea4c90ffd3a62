"""A bound on what a worker process may allocate, where the operating system has one (Linux)."""

import sys

__all__ = ["LIMITED", "limit_memory"]

LIMITED = {"ARROW_DEFAULT_MEMORY_POOL": "system"}
"""Environment of a process that is to be bound: pyarrow's own allocator reserves a GiB before it needs any,
and what is reserved counts."""


def limit_memory(most_bytes: int | None) -> None:
    """Let the kernel refuse this process memory beyond a bound.

    What is refused raises `MemoryError` in Python, and ends the process in libraries that cannot go on: both
    cost a task and not the machine.

    Parameters
    ----------
    most_bytes
        Of private writable memory (RLIMIT_DATA); None for no bound. No effect where there is no such limit.
    """
    if most_bytes is None or sys.platform != "linux":
        return
    import resource  # noqa: PLC0415 - not on every platform

    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    most = most_bytes if hard == resource.RLIM_INFINITY else min(most_bytes, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (most, hard))
