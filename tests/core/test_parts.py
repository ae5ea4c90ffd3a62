"""Claims: work in parts is done once each, in order, and what was put off is done before the end."""

from collections.abc import Generator
from concurrent.futures import ThreadPoolExecutor
from threading import Event

import pytest

from modelcast.core.parts import WHOLE, Parts

LONG_S = 30.0
"""Nobody waits so long unless something is wrong."""


@pytest.fixture(name="shared")
def _shared() -> Generator[Parts]:
    with ThreadPoolExecutor(2) as pool:
        yield Parts(4, pool)


def test_what_parts_return_is_in_order(shared: Parts) -> None:
    assert shared.each(lambda part: part * part) == [0, 1, 4, 9]
    assert WHOLE.each(lambda part: part) == [0]


def test_without_threads_nothing_is_put_off() -> None:
    done: list[int] = []
    Parts(3).put_off(done.append)
    assert done == [0, 1, 2]


def test_what_was_put_off_is_done_once_before_the_end(shared: Parts) -> None:
    done: list[int] = []
    shared.put_off(done.append)
    assert done == []
    shared.finish()
    assert sorted(done) == [0, 1, 2, 3]
    shared.finish()
    assert len(done) == 4


def test_another_thread_does_it_beside(shared: Parts) -> None:
    """The work waits for what was put off, which only another thread can have done."""
    happened = Event()
    shared.put_off(lambda part: happened.set() if part == 3 else None)
    assert shared.beside(lambda: happened.wait(LONG_S))


def test_work_beside_nothing_is_just_done(shared: Parts) -> None:
    assert shared.beside(lambda: "done") == "done"
    assert WHOLE.beside(lambda: "done") == "done"


def test_a_failure_of_what_was_put_off_is_told(shared: Parts) -> None:
    def fails(part: int) -> None:
        raise ZeroDivisionError(part)

    shared.put_off(fails)
    with pytest.raises(ZeroDivisionError):
        shared.finish()
