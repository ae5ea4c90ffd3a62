"""A bound on what a worker process may allocate, where the operating system has one (Linux)."""

import sys

from modelcast.core.exceptions import ConfigError

__all__ = ["LEAST_WORKER_BYTES", "limit_memory", "processes_within"]

LEAST_WORKER_BYTES = 600 * 2**20
"""A worker needs as much for the libraries alone; with less they fail where nobody can say why."""


def processes_within(memory_bytes: int, asked: int) -> int:
    """How many workers an amount of memory is enough for.

    Parameters
    ----------
    memory_bytes
        For all of them together.
    asked
        How many the user named; 0 where it is left open.

    Raises
    ------
    ConfigError
        Where it is not enough for those, or for one.

    Examples
    --------
    >>> processes_within(2 * 2**30, asked=0)
    3
    """
    enough_for = memory_bytes // LEAST_WORKER_BYTES
    needed = max(asked, 1)
    if enough_for < needed:
        fewer = f", or take fewer processes: {enough_for}" if enough_for else ""
        raise ConfigError(
            f"--memory of {memory_bytes / 2**20:.4g} MiB is too little: a process needs "
            f"{LEAST_WORKER_BYTES // 2**20} MiB; give {needed * LEAST_WORKER_BYTES // 2**20} MiB{fewer}"
        )
    return enough_for


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
