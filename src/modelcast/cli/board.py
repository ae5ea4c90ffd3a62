"""What a command shows while it works: rows on a terminal that go at the end, a line now and then elsewhere.

Everything is on the standard error; what a command finds is alone on the standard output. How it is shown is
found once, when something begins:

========  ===========================================================================================
shown as  where
========  ===========================================================================================
bars      on a terminal that can move its cursor
lines     elsewhere, as in a pipe, a log or ``TERM=dumb``: one every ten seconds
none      where the command is told to be quiet
========  ===========================================================================================

The environment variable ``MODELCAST_PROGRESS`` names another of the three.
"""

import os
import sys
import threading
import time
from collections.abc import Callable, Generator, Iterable
from contextlib import ExitStack, contextmanager
from dataclasses import KW_ONLY, dataclass, field
from typing import TYPE_CHECKING

from modelcast.cli import terminal
from modelcast.core import compiling
from modelcast.core.exceptions import ConfigError
from modelcast.core.printable import printable

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.live import Live

__all__ = ["PROGRESS_VARIABLE", "Board", "Stage", "attended", "board", "clock_text", "row_text", "shown_as"]

PROGRESS_VARIABLE = "MODELCAST_PROGRESS"
"""Environment variable that says how progress is shown."""

_LINE_S = 10.0
_ROW_S = 0.5
"""Age from which on a row is shown: what is done by then needs none."""
_TICK_S = 0.125


@dataclass(slots=True, eq=False)
class Stage:
    """Something that takes its time.

    Parameters
    ----------
    label
        What is done.
    begun_s
        When it began, by the board's clock [s].
    counts
        Whether its steps can be counted.
    done, total
        Steps done, and to do in all; None where that is not known.
    note
        What it is at.
    more
        Says how fast it goes, given the time [s]; None where there is nothing to say.
    """

    label: str
    begun_s: float
    _: KW_ONLY
    counts: bool = True
    done: float = 0.0
    total: float | None = None
    note: str = ""
    more: Callable[[float], str] | None = None
    _first: tuple[float, float] | None = field(default=None, init=False)

    def begin(self, label: str, now_s: float) -> None:
        """Turn to another thing that is counted.

        Parameters
        ----------
        label
            What it is.
        now_s
            The time, by the board's clock [s].
        """
        self.label, self.begun_s, self.counts = printable(label), now_s, True
        self.note, self._first = "", None

    def update(self, done: float, total: float | None, now_s: float) -> None:
        """Note how far it is.

        Parameters
        ----------
        done, total
            Steps.
        now_s
            The time, by the board's clock [s].
        """
        if self._first is None:
            self._first = (done, now_s)
        self.done, self.total = done, total

    @property
    def steps(self) -> str:
        """Steps done and to do, as text; empty where they are not counted."""
        if not self.counts:
            return ""
        return f"{self.done:,.0f}/{'?' if self.total is None else format(self.total, ',.0f')}"

    def left_s(self, now_s: float) -> float | None:
        """Time left, if what is left goes as what was done since the first news [s]; None where unknown.

        Parameters
        ----------
        now_s
            The time, by the board's clock [s].
        """
        if self._first is None or self.total is None:
            return None
        first, since_s = self._first
        if not first < self.done < self.total:
            return None
        return (now_s - since_s) * (self.total - self.done) / (self.done - first)

    def times(self, now_s: float) -> str:
        """Rate where there is one, time gone, and time left where it is known.

        Parameters
        ----------
        now_s
            The time, by the board's clock [s].
        """
        left_s = self.left_s(now_s)
        parts = [] if self.more is None else [self.more(now_s)]
        parts.append(clock_text(now_s - self.begun_s))
        if left_s is not None:
            parts.append(f"about {clock_text(left_s)} left")
        return ", ".join(part for part in parts if part)

    def line(self, now_s: float) -> str:
        """Everything in one line.

        Parameters
        ----------
        now_s
            The time, by the board's clock [s].
        """
        head = f"{self.label} {self.steps}".rstrip()
        return ", ".join(part for part in (head, printable(self.note), self.times(now_s)) if part)


def clock_text(time_s: float) -> str:
    """Return a time as minutes and seconds, with hours where there are any.

    Parameters
    ----------
    time_s
        The time [s].

    Examples
    --------
    >>> clock_text(83.4), clock_text(7322.0)
    ('1:23', '2:02:02')
    """
    minutes, seconds = divmod(max(int(time_s), 0), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"


def shown_as(*, quiet: bool) -> str:
    """Return how progress is shown: bars, lines or none.

    Parameters
    ----------
    quiet
        The command is told to be quiet.

    Raises
    ------
    ConfigError
        Where the environment variable names nothing of these.
    """
    asked = os.environ.get(PROGRESS_VARIABLE, "")
    if asked not in {"", "bars", "lines", "none"}:
        raise ConfigError(f"{PROGRESS_VARIABLE} must be bars, lines or none, got {asked!r}")
    if quiet or sys.stderr is None:
        return "none"
    able = sys.stderr.isatty() and os.environ.get("TERM") not in {"dumb", "unknown"}
    return asked or ("bars" if able else "lines")


class Board:
    """All that is going on in this process, and where it is shown.

    Parameters
    ----------
    clock_s
        A clock that never goes back [s].
    ticking
        Have a thread call `tick`; else whoever made it does.

    Attributes
    ----------
    hushed
        Whether the command is told to be quiet: then nothing is shown, whatever begins.
    """

    def __init__(self, clock_s: Callable[[], float] = time.monotonic, *, ticking: bool = True) -> None:
        self.clock_s, self._ticking = clock_s, ticking
        self._stages: list[Stage] = []
        self._fallback: Stage | None = None
        self._compiling = _Compilations(self)
        self._how = "none"
        self.hushed = False
        self._live: Live | None = None
        self._told_s = 0.0
        self._lock = threading.RLock()
        self._end: threading.Event | None = None
        self._beside = ExitStack()

    @contextmanager
    def stage(
        self,
        label: str,
        *,
        quiet: bool,
        counts: bool = True,
        more: Callable[[float], str] | None = None,
        fallback: bool = False,
    ) -> Generator[Stage]:
        """Yield a stage that is shown for as long as the block lasts.

        Parameters
        ----------
        label, counts, more
            As for `Stage`.
        quiet
            It is not shown.
        fallback
            It is shown only where nothing else is.
        """
        one = Stage(printable(label), self.clock_s(), counts=counts, more=more)
        if quiet or self.hushed:
            yield one
            return
        self._begin(one, fallback=fallback)
        try:
            yield one
        finally:
            self._finish(one)

    def hear(self, one: compiling.Compiling) -> None:
        """Take in what is being compiled; shown where anything is.

        Parameters
        ----------
        one
            As `modelcast.core.compiling.watch` gives it.
        """
        with self._lock:
            self._compiling.hear(one)

    def shown(self) -> list[Stage]:
        """Return what is going on, the outermost first."""
        with self._lock:
            found = [*self._stages, *self._compiling.stages]
            return found or ([] if self._fallback is None else [self._fallback])

    def tick(self) -> None:
        """Show how things stand: at once on a terminal, elsewhere where the last line is old enough."""
        with self._lock:
            now_s = self.clock_s()
            if self._how == "lines":
                stages = self.shown()
                if stages and now_s >= self._told_s + _LINE_S:
                    self._told_s = now_s
                    terminal.complain("; ".join(one.line(now_s) for one in stages))
            elif self._how == "bars":
                rows = [one for one in self.shown() if now_s >= one.begun_s + _ROW_S]
                if rows:
                    self._draw(rows, now_s)

    @contextmanager
    def aside(self) -> Generator[None]:
        """Take the rows away for as long as something else is printed."""
        with self._lock:
            self._wipe()
            yield

    def abandon(self) -> None:
        """Give the cursor back, in a process that is about to end without another word."""
        if self._live is not None:
            sys.stderr.write("\x1b[?25h\n")
            sys.stderr.flush()

    def _begin(self, one: Stage, *, fallback: bool) -> None:
        with self._lock:
            if self._end is None:
                self._how = shown_as(quiet=False)
                self._told_s = self.clock_s()
                self._start()
            if fallback:
                self._fallback = one
            else:
                self._stages.append(one)

    def _finish(self, one: Stage) -> None:
        with self._lock:
            if one is self._fallback:
                self._fallback = None
            else:
                self._stages.remove(one)
            if not self._stages and self._fallback is None:
                self._compiling = _Compilations(self)
                self._wipe()
                self._beside.close()
                if self._end is not None:
                    self._end.set()
                    self._end = None

    def _start(self) -> None:
        """Have `tick` called by a thread of its own until the last stage ends."""
        end = self._end = threading.Event()
        if self._how == "none":
            return
        self._beside.enter_context(terminal.beside(self.aside))

        def ticking() -> None:
            while not end.wait(_TICK_S):
                self.tick()

        if self._ticking:
            threading.Thread(target=ticking, name="progress", daemon=True).start()

    def _draw(self, rows: Iterable[Stage], now_s: float) -> None:
        from rich.live import Live

        if self._live is None:
            self._live = Live(
                console=terminal.error_console(),
                auto_refresh=False,
                transient=True,
                redirect_stdout=False,
                redirect_stderr=False,
            )
            self._live.start()
        self._live.update(_rows(rows, now_s, self._live.console), refresh=True)

    def _wipe(self) -> None:
        if self._live is not None:
            live, self._live = self._live, None
            live.stop()


class _Compilations:
    """What is being compiled by which process, as one stage."""

    def __init__(self, owner: Board) -> None:
        self._owner = owner
        self._stage: Stage | None = None
        self._done: dict[int, int] = {}
        self._left: dict[int, int] = {}

    @property
    def stages(self) -> tuple[Stage, ...]:
        """The stage; none where nothing is being compiled."""
        return (self._stage,) if self._stage is not None and self._left else ()

    def hear(self, one: compiling.Compiling) -> None:
        """Count a function that is begun, or one whose process is ready or gone."""
        if not one.label and one.process not in self._left:
            return
        now_s = self._owner.clock_s()
        if self._stage is None:
            self._stage = Stage("compiling, once for this machine", now_s)
        if one.label:
            self._done[one.process] = self._done.get(one.process, 0) + 1
            self._left[one.process] = one.left
            self._stage.note = one.label.rpartition(".")[2]
        else:  # what a process that is gone had left is not to be done by it
            del self._left[one.process]
        # The one that is begun is not done yet.
        begun = sum(self._done.values())
        self._stage.update(begun - 1, begun - len(self._left) + sum(self._left.values()), now_s)


def _rows(stages: Iterable[Stage], now_s: float, console: "Console") -> "RenderableType":
    """Stages as a terminal shows them, a line each."""
    from rich.console import Group
    from rich.text import Text

    plain = not console.encoding.startswith("utf")
    texts = (row_text(one, now_s, console.width - 1, plain=plain) for one in stages)
    return Group(*(Text(text, no_wrap=True, overflow="crop") for text in texts))


def row_text(stage: Stage, now_s: float, width: int, *, plain: bool = False) -> str:
    """Return a stage as one line: what is at hand gives way first, then the bar, then the label.

    Parameters
    ----------
    stage
        The stage.
    now_s
        The time, by the board's clock [s].
    width
        Columns there are.
    plain
        Use ASCII alone.
    """
    from rich.cells import cell_len, set_cell_size

    spinner, full, empty = (_SPINNERS[0], "#", ".") if plain else (_SPINNERS[1], "\u2501", "\u254c")
    tail = "  ".join(part for part in (stage.steps, stage.times(now_s)) if part)
    turn = spinner[int((now_s - stage.begun_s) / _TICK_S) % len(spinner)]
    room = width - len(tail) - 4
    label = stage.label if cell_len(stage.label) <= room else set_cell_size(stage.label, max(room, 1))
    parts, room = [turn, label], room - cell_len(label)
    if stage.counts and stage.total is not None and room >= _BAR + 1:
        done = round(_BAR * min(stage.done / stage.total, 1.0)) if stage.total else _BAR
        parts.append(full * done + empty * (_BAR - done))
        room -= _BAR + 1
    parts.append(tail)
    note = printable(stage.note)
    if note and room >= _LEAST_NOTE:
        short = note if cell_len(note) <= room - 2 else set_cell_size(note, room - 5) + "..."
        parts.append(f" {short}")
    return " ".join(parts)


_SPINNERS = ("|/-\\", "\u280b\u2819\u2839\u2838\u283c\u2834\u2826\u2827\u2807\u280f")
_BAR = 16
_LEAST_NOTE = 12

board = Board()
"""The one of this process."""


@contextmanager
def attended(*, quiet: bool) -> Generator[None]:
    """Show a command's progress, compilation too, for as long as the block lasts.

    Parameters
    ----------
    quiet
        Show nothing.

    Raises
    ------
    ConfigError
        Where the environment variable names no way to show it.
    """
    board.hushed = shown_as(quiet=quiet) == "none"
    before = compiling.watch(board.hear)
    try:
        with board.stage("working", quiet=False, counts=False, fallback=True):
            yield
    finally:
        compiling.watch(before)
        board.hushed = False
