"""Tasks in processes of this machine.

Each process has a pipe of its own and one task at a time. So the death of a process is known to be of the
task it had, costs no other, and is mended by a new process. (`concurrent.futures` breaks the whole pool, with
everything that waits in it.)
"""

import multiprocessing
import os
import pickle
import signal
import traceback
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any, TypeVar, cast

from modelcast.core.compiling import Compiling, hear, watch
from modelcast.core.exceptions import ConfigError, ModelcastError
from modelcast.corpora.executors.base import TRIES, AbstractCrew, AbstractExecutor, Failed, LostWorkerError
from modelcast.corpora.executors.memory import LIMITED, limit_memory, processes_within
from modelcast.corpora.executors.one_thread import one_thread_processes
from modelcast.corpora.executors.undisturbed import end_with_parent, undisturbed

__all__ = ["ProcessCrew", "ProcessExecutor"]

Work = TypeVar("Work")
Found = TypeVar("Found")

_SPAWN = multiprocessing.get_context("spawn")  # a fork would share threads and locks of Numba and Polars


@dataclass(frozen=True, slots=True)
class ProcessExecutor(AbstractExecutor):
    """Processes of this machine, one thread each.

    Parameters
    ----------
    jobs
        How many; 0 for one a processor, or fewer where the memory is for fewer.
    memory_bytes
        What all of them together may take, shared out evenly; None for no bound.

    Raises
    ------
    ConfigError
        Where the number is negative, or the memory is not enough for that many.
    """

    jobs: int = 0
    memory_bytes: int | None = None

    def __post_init__(self) -> None:
        if self.jobs < 0:
            raise ConfigError(f"--jobs must be 0 (one a processor) or more, got {self.jobs}")
        if self.memory_bytes is not None:
            processes_within(self.memory_bytes, self.jobs)

    @property
    def count(self) -> int:
        """How many processes are meant."""
        open_to = os.cpu_count() or 1
        if self.memory_bytes is not None:
            open_to = min(open_to, processes_within(self.memory_bytes, self.jobs))
        return self.jobs or open_to

    @property
    def worker_bytes(self) -> int | None:
        """An even share."""
        return None if self.memory_bytes is None else self.memory_bytes // self.count

    @contextmanager
    def start(self) -> Generator[AbstractCrew]:
        """Processes are started as there is work for them."""
        crew = ProcessCrew(self.count, memory_bytes=self.worker_bytes)
        try:
            yield crew
        finally:
            crew.end()


class ProcessCrew(AbstractCrew):
    """Processes of this machine, each started when there is work for it.

    Parameters
    ----------
    count
        The most there are at a time.
    memory_bytes
        What one of them may take; None for no bound.
    """

    def __init__(self, count: int, *, memory_bytes: int | None = None) -> None:
        self._count = count
        self._memory_bytes = memory_bytes
        self._idle: list[_Worker] = []

    def as_done(
        self, function: Callable[[Work], Found], work: Iterable[Work]
    ) -> Iterator[tuple[Work, Found | Failed]]:
        """A task whose process dies is begun again behind the others, `TRIES` times in all."""
        left, again = iter(work), deque[tuple[Work, int]]()
        busy: dict[_Worker, tuple[Work, int]] = {}

        def following() -> tuple[Work, int] | None:
            for one in left:
                return one, 1
            return again.popleft() if again else None

        try:
            while True:
                while len(busy) < self._count and (task := following()) is not None:
                    busy[self._given(function, task[0])] = task
                if not busy:
                    return
                for worker, said in _answers(busy):
                    (one, tries), answer = busy.pop(worker), said
                    if not isinstance(answer, _Lost):
                        self._idle.append(worker)
                    elif tries < TRIES:
                        again.append((one, tries + 1))
                        continue
                    else:
                        answer = Failed(LostWorkerError(tries, answer.how))
                    yield one, cast("Found | Failed", answer)
        finally:
            for worker in busy:
                worker.end()

    def require_shared(self, folders: Sequence[Path]) -> None:
        """It is one machine."""

    def end(self) -> None:
        """End all processes, at once."""
        while self._idle:
            self._idle.pop().end()

    def _given(self, function: Callable[[Any], Any], one: object) -> "_Worker":
        """A worker that has been given a piece of work; one that died while it had none is forgotten."""
        while self._idle:
            worker = self._idle.pop()
            with suppress(OSError):
                worker.give(function, one)
                return worker
            worker.end()
        worker = _Worker(self._memory_bytes)
        with suppress(OSError):  # where it is dead already, its answer says so
            worker.give(function, one)
        return worker


@dataclass(frozen=True, slots=True)
class _Lost:
    """What a process answers that has died.

    Parameters
    ----------
    how
        In words.
    """

    how: str


class _Worker:
    """One process, at the other end of a pipe.

    Parameters
    ----------
    memory_bytes
        What it may take; None for no bound.
    """

    def __init__(self, memory_bytes: int | None) -> None:
        self.pipe, theirs = _SPAWN.Pipe()
        self._process = _SPAWN.Process(target=_serve, args=(theirs, memory_bytes), daemon=True)
        try:
            with one_thread_processes({} if memory_bytes is None else LIMITED), undisturbed():
                self._process.start()
        except BaseException:
            if self._process.pid is None:
                self.pipe.close()
            else:  # nobody else knows it
                self.end()
            raise
        finally:
            theirs.close()

    def give(self, function: Callable[[Any], Any], one: object) -> None:
        """Send a piece of work."""
        self.pipe.send_bytes(pickle.dumps((function, one)))

    def answer(self) -> object:
        """What it answers; `_Lost` where it has died, `Compiling` where it has only begun to."""
        try:
            return pickle.loads(self.pipe.recv_bytes())  # noqa: S301 - our own process
        except (EOFError, OSError):
            self._process.join()
            code = self._process.exitcode
            self.end()
            return _Lost(_ended(code))

    def end(self) -> None:
        """End it, whatever it is doing; what it was compiling it compiles no more."""
        if self._process.pid is not None:
            hear(Compiling("", 0, self._process.pid))
        self.pipe.close()
        self._process.kill()
        self._process.join()
        self._process.close()


def _answers(workers: Iterable[_Worker]) -> Iterator[tuple[_Worker, object]]:
    """Workers that have answered or died, and how; waits for the first to say anything."""
    by_pipe = {worker.pipe: worker for worker in workers}
    for pipe in wait(list(by_pipe)):
        worker = by_pipe[cast("Connection[Any, Any]", pipe)]
        answer = worker.answer()
        if isinstance(answer, Compiling):
            hear(answer)
        else:
            yield worker, answer


def _ended(code: int | None) -> str:
    """How a process ended."""
    if code is not None and code < 0:
        with suppress(ValueError):
            return f"by {signal.Signals(-code).name}"
    return f"with exit code {code}"


def _serve(pipe: "Connection[Any, Any]", memory_bytes: int | None) -> None:
    """Answer one piece of work after another, until the other end is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # also where the parent could not block it
    end_with_parent()
    limit_memory(memory_bytes)
    watch(lambda one: pipe.send_bytes(pickle.dumps(one)))
    with suppress(EOFError, OSError):
        while True:
            pipe.send_bytes(_answered(pipe.recv_bytes()))


def _answered(message: bytes) -> bytes:
    """What a piece of work gives, or what it raises, as octets."""
    try:
        function, one = pickle.loads(message)  # noqa: S301 - of our own process
        return pickle.dumps(function(one))
    except Exception as error:  # noqa: BLE001 - whatever it is, it costs this task alone
        return _told(error)


def _told(error: Exception) -> bytes:
    """An error as octets, with the lines where it was raised; by its text where it cannot be sent itself."""
    error.add_note("".join(traceback.format_exception(error)))
    try:
        message = pickle.dumps(Failed(error))
        pickle.loads(message)  # noqa: S301 - written a line above
    except Exception:  # noqa: BLE001 - of whatever class the error is
        plain = ModelcastError(f"{type(error).__name__}: {error}")
        return pickle.dumps(Failed(plain))
    return message
