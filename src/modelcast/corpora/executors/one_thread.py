"""One thread a worker process, so that N workers are N processors and no more.

The libraries look at these variables when they are imported: a process must have them from its first moment.
"""

import os
from collections.abc import Generator
from contextlib import contextmanager

__all__ = ["ONE_THREAD", "one_thread_processes"]

ONE_THREAD = {
    "NUMBA_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "POLARS_MAX_THREADS": "1",
    "RAYON_NUM_THREADS": "1",
    "_RJEM_MALLOC_CONF": "background_thread:false",
}
"""Environment of a worker; pyarrow looks at OMP_NUM_THREADS too. The last is for the allocator of Polars:
where memory is bounded it may get no thread, and would try for ever."""


@contextmanager
def one_thread_processes() -> Generator[None]:
    """Processes that are started in the block use one thread each."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
