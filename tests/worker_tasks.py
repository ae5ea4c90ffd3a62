"""Tasks that workers of other processes know by name."""

import os
import signal
from pathlib import Path

__all__ = ["die_at", "doubled", "fail_at", "pid", "raise_unpicklable", "threads"]


def doubled(number: int) -> int:
    return 2 * number


def fail_at(number: int) -> int:
    """Three is no number to double."""
    if number == 3:
        raise ValueError(f"no {number}")
    return doubled(number)


def die_at(folder: Path, numbers: dict[int, int], number: int) -> int:
    """Double a number, once the process has died as often as said; deaths are counted in a folder."""
    died = len(list(folder.glob(f"{number}-*")))
    if died < numbers.get(number, 0):
        (folder / f"{number}-{died}").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return doubled(number)


def raise_unpicklable(number: int) -> int:
    """Raise what no other process can be told."""

    class LocalError(Exception):
        pass

    raise LocalError(f"no {number}")


def pid(_number: int) -> int:
    return os.getpid()


def threads(_number: int) -> tuple[int, int]:
    """Threads of Numba and Polars in a worker."""
    import numba  # noqa: PLC0415 - the other tasks need no second to begin
    import polars as pl  # noqa: PLC0415

    return numba.get_num_threads(), pl.thread_pool_size()
