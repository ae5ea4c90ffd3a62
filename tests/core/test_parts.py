"""Claims: work in parts is done once each, in order, and what was put off is done before the end."""

from collections.abc import Generator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
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


def test_what_is_handed_over_is_done_meanwhile(shared: Parts) -> None:
    """The other thread waits for nothing more, and comes back for it."""
    first, second = Event(), Event()

    def work() -> bool:
        shared.hand_over(first.set)
        found = first.wait(LONG_S)
        shared.hand_over(second.set)
        # The other may have been about to leave: who hands more over calls it back.
        while found and not second.is_set():
            shared.hand_over(lambda: None)
        return found

    assert shared.beside(work)


@pytest.mark.parametrize("is_beside", [False, True])
def test_works_on_a_part_are_done_in_their_order(shared: Parts, *, is_beside: bool) -> None:
    """Whether one thread does them beside or several at the end, and whoever puts them off."""
    done: list[tuple[int, int]] = []
    happened = Event()

    def put_off(number: int) -> None:
        shared.put_off(lambda part: done.append((part, number)))

    def work() -> None:
        for number in range(20):
            shared.hand_over(partial(put_off, number))
        shared.hand_over(happened.set)
        if is_beside:
            happened.wait(LONG_S)
        for number in range(20, 40):
            shared.hand_over(partial(put_off, number))

    if is_beside:
        shared.beside(work)
    else:
        work()
    shared.finish()
    for part in range(4):
        assert [number for one, number in done if one == part] == list(range(40))


def test_what_is_handed_over_finds_all_before_it_done(shared: Parts) -> None:
    done, found = list[int](), list[int]()
    shared.put_off(done.append)
    shared.hand_over(lambda: found.append(len(done)))
    shared.put_off(done.append)
    shared.hand_over(lambda: found.append(len(done)))
    shared.finish()
    assert found == [4, 8]
    WHOLE.hand_over(lambda: found.append(0))
    assert found == [4, 8, 0]


def test_a_failure_beside_is_told_at_its_end(shared: Parts) -> None:
    """Of the first part by the other thread, of the rest as all is finished."""
    begun = Event()

    def fails(part: int) -> None:
        begun.set()
        raise ZeroDivisionError(part)

    shared.put_off(fails)
    with pytest.raises(ZeroDivisionError):
        shared.beside(lambda: begun.wait(LONG_S))
    with pytest.raises(ZeroDivisionError):
        shared.finish()
