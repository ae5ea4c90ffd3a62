"""What is shown while a command works: rows on a terminal, lines elsewhere, all on the standard error."""

import io
import os
import re
import sys
from collections.abc import Callable, Iterator

import pytest

from modelcast.cli.board import PROGRESS_VARIABLE, Board, attended, row_text, shown_as
from modelcast.cli.terminal import say
from modelcast.core.compiling import Compiling, hear, watch
from modelcast.core.exceptions import ConfigError

CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")


class Watched(io.StringIO):
    """A standard error that somebody watches."""

    def isatty(self) -> bool:
        """It is one."""
        return True


class Clock:
    """A clock that is set by hand."""

    now_s = 100.0

    def __call__(self) -> float:
        """The time [s]."""
        return self.now_s


@pytest.fixture(name="clock")
def _clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    monkeypatch.delenv(PROGRESS_VARIABLE)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "80")
    return Clock()


@pytest.fixture(name="piped")
def _piped(monkeypatch: pytest.MonkeyPatch) -> Callable[[], io.StringIO]:
    """Have the standard error be no terminal; called in the test, since pytest has one for each phase."""

    def put() -> io.StringIO:
        stream = io.StringIO()
        monkeypatch.setattr(sys, "stderr", stream)
        return stream

    return put


@pytest.fixture(name="seen")
def _seen(monkeypatch: pytest.MonkeyPatch) -> Callable[[], io.StringIO]:
    """Have the standard error be a terminal; as above."""

    def put() -> io.StringIO:
        stream = Watched()
        monkeypatch.setattr(sys, "stderr", stream)
        return stream

    return put


def last_rows(stream: io.StringIO) -> list[str]:
    """What a terminal shows after all that was written: the rows of the last time."""
    text = stream.getvalue().split("\x1b[2K")[-1]
    return [line.rstrip() for line in CONTROL.sub("", text).replace("\r", "\n").split("\n") if line.strip()]


def test_a_pipe_gets_a_plain_line_every_ten_seconds_and_nothing_before(
    clock: Clock, piped: Callable[[], io.StringIO]
) -> None:
    pipe = piped()
    board = Board(clock, ticking=False)
    with board.stage("runs", quiet=False) as stage:
        stage.update(0, 4, clock.now_s)
        for _ in range(41):
            clock.now_s += 0.5
            if clock.now_s == 110.0:
                stage.update(1, 4, clock.now_s)
            board.tick()
    assert pipe.getvalue().splitlines() == [
        "modelcast: runs 1/4, 0:10, about 0:30 left",
        "modelcast: runs 1/4, 0:20, about 1:00 left",
    ]


def test_a_terminal_gets_rows_that_are_gone_at_the_end(clock: Clock, seen: Callable[[], io.StringIO]) -> None:
    screen = seen()
    board = Board(clock, ticking=False)
    with board.stage("trips", quiet=False) as stage:
        stage.update(1, 3, clock.now_s)
        board.tick()
        assert screen.getvalue() == ""
        clock.now_s += 1.0
        stage.note = "a name\x1b[31m"
        board.tick()
        (row,) = last_rows(screen)
        assert all(part in row for part in ("trips", "1/3", r"a name\x1b[31m", "0:01"))
    assert last_rows(screen) == []


@pytest.mark.parametrize("width", [40, 60, 80, 200])
def test_a_row_is_one_line_and_cuts_nothing_but_the_note(
    clock: Clock, seen: Callable[[], io.StringIO], monkeypatch: pytest.MonkeyPatch, width: int
) -> None:
    screen = seen()
    monkeypatch.setenv("COLUMNS", str(width))
    board = Board(clock, ticking=False)
    with board.stage("trips", quiet=False) as stage:
        stage.update(0, 300, clock.now_s)
        stage.note = "a trip of a very long name that no terminal has room for in one line of its own " * 3
        clock.now_s += 60.0
        stage.update(10, 300, clock.now_s)
        board.tick()
        (row,) = last_rows(screen)
    assert len(row) < width
    assert "trips" in row
    assert "10/300" in row
    assert "1:00, about 29:00 left" in row


def test_a_terminal_of_letters_alone_gets_no_others(clock: Clock) -> None:
    with Board(clock, ticking=False).stage("trips", quiet=True) as stage:
        stage.update(3, 4, clock.now_s)
        stage.note = "this one"
        assert row_text(stage, clock.now_s, 80, plain=True) == "| trips ############.... 3/4  0:00  this one"


def test_what_is_printed_does_not_meet_the_rows(
    clock: Clock, seen: Callable[[], io.StringIO], capsys: pytest.CaptureFixture[str]
) -> None:
    """The rows are taken away first: on a terminal both streams are one."""
    screen = seen()
    board = Board(clock, ticking=False)
    with board.stage("trips", quiet=False):
        clock.now_s += 1.0
        board.tick()
        assert last_rows(screen)
        say("a result")
        assert last_rows(screen) == []
        assert capsys.readouterr().out == "a result\n"
        board.tick()
        assert last_rows(screen)


def test_a_time_left_counts_from_the_first_news_so_that_kept_work_is_no_work(clock: Clock) -> None:
    with Board(clock, ticking=False).stage("runs", quiet=True) as stage:
        clock.now_s += 100.0
        stage.update(10, 20, clock.now_s)
        assert stage.left_s(clock.now_s) is None
        clock.now_s += 6.0
        stage.update(13, 20, clock.now_s)
        assert stage.left_s(clock.now_s) == pytest.approx(14.0)
        stage.update(20, 20, clock.now_s)
        assert stage.left_s(clock.now_s) is None


def test_compilation_is_counted_over_this_process_and_its_workers(clock: Clock) -> None:
    board = Board(clock, ticking=False)

    def steps() -> list[str]:
        return [one.steps for one in board.shown()]

    board.hear(Compiling("a.outer", 3, 1))
    assert steps() == ["0/3"]
    board.hear(Compiling("a.part", 2, 1))
    board.hear(Compiling("b.other", 5, 2))
    assert steps() == ["2/8"]
    board.hear(Compiling("", 0, 2))
    board.hear(Compiling("a.last", 1, 1))
    assert board.shown()[0].note == "last"
    board.hear(Compiling("", 0, 1))
    assert steps() == []


def test_what_a_process_that_is_gone_had_to_compile_is_counted_no_more(clock: Clock) -> None:
    board = Board(clock, ticking=False)
    board.hear(Compiling("", 0, 3))
    board.hear(Compiling("a.outer", 3, 1))
    board.hear(Compiling("b.other", 5, 2))
    board.hear(Compiling("", 0, 2))
    assert [one.steps for one in board.shown()] == ["1/4"]


def test_a_command_hears_of_compilation_while_it_is_attended(piped: Callable[[], io.StringIO]) -> None:
    pipe = piped()
    told: list[Compiling] = []
    before = watch(told.append)
    try:
        with attended(quiet=False):
            hear(Compiling("a.b", 1, 7))
        hear(Compiling("a.c", 1, 7))
    finally:
        watch(before)
    assert [one.label for one in told] == ["a.c"]
    assert pipe.getvalue() == ""


def environments() -> Iterator[tuple[dict[str, str], bool, bool, str]]:
    yield {"TERM": "xterm"}, True, False, "bars"
    yield {"TERM": "xterm", "NO_COLOR": "1"}, True, False, "bars"
    yield {"TERM": "dumb"}, True, False, "lines"
    yield {"TERM": "xterm", "FORCE_COLOR": "1"}, False, False, "lines"
    yield {"TERM": "xterm"}, True, True, "none"
    yield {"TERM": "xterm", PROGRESS_VARIABLE: "bars"}, True, True, "none"
    yield {"TERM": "xterm", PROGRESS_VARIABLE: "lines"}, True, False, "lines"
    yield {"TERM": "dumb", PROGRESS_VARIABLE: "bars"}, False, False, "bars"


@pytest.mark.parametrize(("known", "watched", "quiet", "how"), list(environments()))
def test_how_it_is_shown(
    monkeypatch: pytest.MonkeyPatch, known: dict[str, str], watched: bool, quiet: bool, how: str
) -> None:
    for name in (PROGRESS_VARIABLE, "NO_COLOR", "FORCE_COLOR"):
        monkeypatch.delenv(name, raising=False)
    for name, value in known.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, "stderr", Watched() if watched else io.StringIO())
    assert shown_as(quiet=quiet) == how


def test_no_colour_is_written_where_none_is_wanted(
    clock: Clock, seen: Callable[[], io.StringIO], monkeypatch: pytest.MonkeyPatch
) -> None:
    screen = seen()
    monkeypatch.setenv("NO_COLOR", "1")
    board = Board(clock, ticking=False)
    with board.stage("trips", quiet=False) as stage:
        stage.update(1, 3, clock.now_s)
        clock.now_s += 1.0
        board.tick()
    assert not re.search(r"\x1b\[[0-9;]*[34][0-9](;[0-9]+)*m", screen.getvalue())


def test_another_word_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(os.environ, PROGRESS_VARIABLE, "loud")
    with pytest.raises(ConfigError, match="bars, lines or none, got 'loud'"):
        shown_as(quiet=False)
