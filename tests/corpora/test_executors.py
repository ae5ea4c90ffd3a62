"""The contract of every executor, and what processes and clusters add to it."""

import errno
import os
import signal
import sys
from collections.abc import Callable, Generator
from contextlib import ExitStack
from functools import partial
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext, SpawnProcess
from pathlib import Path

import pytest

from modelcast.core.compiling import Compiling, watch
from modelcast.core.exceptions import ConfigError
from modelcast.corpora.executors.base import TRIES, AbstractCrew, AbstractExecutor, Failed, LostWorkerError
from modelcast.corpora.executors.here import HereExecutor
from modelcast.corpora.executors.memory import LEAST_WORKER_BYTES
from modelcast.corpora.executors.processes import ProcessCrew, ProcessExecutor
from worker_tasks import (
    arrow_bytes,
    compile_and_die,
    die_at,
    doubled,
    fail_at,
    pid,
    raise_unpicklable,
    threads,
)

NUMBERS = range(7)


def _cluster() -> AbstractExecutor:
    pytest.importorskip("distributed")
    from modelcast.corpora.executors.cluster import ClusterExecutor  # noqa: PLC0415 - of an extra

    return ClusterExecutor("local:2")


EXECUTORS: dict[str, Callable[[], AbstractExecutor]] = {
    "here": HereExecutor,
    "one process": lambda: ProcessExecutor(1),
    "two processes": lambda: ProcessExecutor(2),
    "cluster": _cluster,
}


@pytest.fixture(scope="module")
def crews() -> Generator[Callable[[str], AbstractCrew]]:
    """Every executor's workers, started when first asked for."""
    started: dict[str, AbstractCrew] = {}
    with ExitStack() as stack:

        def ask(name: str) -> AbstractCrew:
            if name not in started:
                started[name] = stack.enter_context(EXECUTORS[name]().start())
            return started[name]

        yield ask


OF_CLUSTER = pytest.param("cluster", marks=pytest.mark.slow)


@pytest.fixture(params=[*(name for name in EXECUTORS if name != "cluster"), OF_CLUSTER])
def crew(request: pytest.FixtureRequest, crews: Callable[[str], AbstractCrew]) -> AbstractCrew:
    """Workers of every executor."""
    return crews(request.param)


@pytest.fixture(params=["two processes", OF_CLUSTER])
def other_processes(request: pytest.FixtureRequest, crews: Callable[[str], AbstractCrew]) -> AbstractCrew:
    """Workers that are other processes."""
    return crews(request.param)


def test_each_piece_of_work_is_answered_once(crew: AbstractCrew) -> None:
    assert sorted(crew.as_done(doubled, NUMBERS)) == [(number, 2 * number) for number in NUMBERS]
    assert list(crew.as_done(doubled, ())) == []


def test_a_task_that_raises_stops_no_other(crew: AbstractCrew) -> None:
    answers = dict(crew.as_done(fail_at, NUMBERS))
    failed = answers.pop(3)
    assert answers == {number: 2 * number for number in NUMBERS if number != 3}
    assert isinstance(failed, Failed)
    assert (type(failed.error), str(failed.error)) == (ValueError, "no 3")


def test_an_error_that_cannot_be_sent_is_told_by_its_text(crew: AbstractCrew) -> None:
    ((_, failed),) = crew.as_done(raise_unpicklable, [1])
    assert isinstance(failed, Failed)
    assert "no 1" in str(failed.error)


def test_work_may_go_on_after_an_iterator_was_left(crew: AbstractCrew) -> None:
    begun = crew.as_done(doubled, NUMBERS)
    next(begun)
    begun.close()
    assert sorted(crew.as_done(doubled, [8])) == [(8, 16)]


def test_folders_of_this_machine_are_seen(crew: AbstractCrew, tmp_path: Path) -> None:
    crew.require_shared([tmp_path])
    assert list(tmp_path.iterdir()) == []


def test_a_worker_uses_one_thread(other_processes: AbstractCrew) -> None:
    assert dict(other_processes.as_done(threads, range(2))) == {0: (1, 1), 1: (1, 1)}


@pytest.mark.skipif(sys.platform != "linux", reason="bounded on Linux alone")
def test_a_bounded_process_reserves_no_memory_that_it_does_not_use() -> None:
    """Else work that takes far less than the bound is refused."""
    with ProcessExecutor(1, 2**30).start() as crew:
        ((_, taken_bytes),) = crew.as_done(arrow_bytes, [1000])
    assert isinstance(taken_bytes, int)
    assert 0 <= taken_bytes < 32 * 2**20


def test_a_lost_worker_costs_nothing(other_processes: AbstractCrew, tmp_path: Path) -> None:
    """The third and the fifth kill the process they are in, the fifth twice."""
    answers = dict(other_processes.as_done(partial(die_at, tmp_path, {3: 1, 5: 2}), NUMBERS))
    assert answers == {number: 2 * number for number in NUMBERS}
    assert sorted(one.name for one in tmp_path.iterdir()) == ["3-0", "5-0", "5-1"]


def test_a_task_that_loses_every_worker_is_given_up_and_stops_no_other(
    other_processes: AbstractCrew, tmp_path: Path
) -> None:
    answers = dict(other_processes.as_done(partial(die_at, tmp_path, {3: 99}), NUMBERS))
    failed = answers.pop(3)
    assert answers == {number: 2 * number for number in NUMBERS if number != 3}
    assert isinstance(failed, Failed)
    assert isinstance(failed.error, LostWorkerError)
    assert f"its worker was lost {TRIES} times" in str(failed.error)
    assert len(list(tmp_path.iterdir())) == TRIES
    if isinstance(other_processes, ProcessCrew):
        assert "the last one by SIGKILL" in str(failed.error)


def test_a_worker_that_dies_while_it_compiles_is_known_to_compile_no_more() -> None:
    told: list[Compiling] = []
    before = watch(told.append)
    try:
        with ProcessExecutor(1).start() as crew:
            list(crew.as_done(compile_and_die, [1]))
    finally:
        watch(before)
    begun = [one.process for one in told if one.label]
    assert len(begun) == TRIES
    assert [one.process for one in told if not one.label] == begun


@pytest.mark.skipif(os.name == "nt", reason="a console's Ctrl-C is another thing there")
def test_a_worker_whose_start_is_interrupted_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C while it starts is held back until it has started, and then nobody else knows it."""
    started: list[int | None] = []
    start = SpawnProcess.start

    def press(process: SpawnProcess) -> None:
        start(process)
        started.append(process.pid)
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(SpawnProcess, "start", press)
    with ProcessExecutor(1).start() as crew, pytest.raises(KeyboardInterrupt):
        list(crew.as_done(pid, [1]))
    (one,) = started
    assert one is not None
    with pytest.raises(ProcessLookupError):
        os.kill(one, 0)


def test_a_worker_that_cannot_be_started_leaves_nothing_open(monkeypatch: pytest.MonkeyPatch) -> None:
    pipes: list[Connection] = []
    pipe = SpawnContext.Pipe

    def refuse(_: SpawnProcess) -> None:
        raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN))

    def noted(context: SpawnContext, *, duplex: bool = True) -> tuple[Connection, Connection]:
        pipes.extend(pipe(context, duplex))
        return pipes[0], pipes[1]

    monkeypatch.setattr(SpawnProcess, "start", refuse)
    monkeypatch.setattr(SpawnContext, "Pipe", noted)
    with ProcessExecutor(1).start() as crew, pytest.raises(BlockingIOError):
        list(crew.as_done(pid, [1]))
    assert [one.closed for one in pipes] == [True, True]


def test_processes_are_other_processes_and_end_with_the_block() -> None:
    with ProcessExecutor(2).start() as crew:
        seen = {found for _, found in crew.as_done(pid, range(4)) if isinstance(found, int)}
    assert os.getpid() not in seen
    assert 1 <= len(seen) <= 2
    for one in seen:
        with pytest.raises(ProcessLookupError):
            os.kill(one, 0)


@pytest.mark.parametrize(
    ("jobs", "memory_bytes"),
    [(-1, None), (1, 0), (0, LEAST_WORKER_BYTES - 1), (2, 2 * LEAST_WORKER_BYTES - 1)],
)
def test_no_processes_and_no_memory_are_refused(jobs: int, memory_bytes: int | None) -> None:
    with pytest.raises(ConfigError, match=r"--jobs|--memory"):
        ProcessExecutor(jobs, memory_bytes)


def test_where_jobs_are_left_open_they_are_no_more_than_the_memory_is_for() -> None:
    assert ProcessExecutor(0, LEAST_WORKER_BYTES).count == 1
    assert ProcessExecutor(2, 2 * LEAST_WORKER_BYTES).worker_bytes == LEAST_WORKER_BYTES
