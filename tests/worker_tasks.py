"""Tasks that workers of other processes know by name."""

import os
import signal
from pathlib import Path

from modelcast.core.compiling import Compiling, hear

__all__ = [
    "arrow_bytes",
    "compile_and_die",
    "die_at",
    "doubled",
    "fail_at",
    "pid",
    "raise_unpicklable",
    "threads",
]


def arrow_bytes(rows: int) -> int:
    """Octets by which the process grows, where it makes an Arrow array of so many rows."""
    import pyarrow as pa  # noqa: PLC0415 - as late as a worker does

    before = _data_bytes()
    held = pa.nulls(rows, pa.float64())
    return _data_bytes() - before + 0 * held.nbytes


def _data_bytes() -> int:
    """Of what RLIMIT_DATA bounds."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmData"))


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


def compile_and_die(_number: int) -> None:
    """Die while functions are being compiled."""
    hear(Compiling("a.b", 3, os.getpid()))
    os.kill(os.getpid(), signal.SIGKILL)


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
