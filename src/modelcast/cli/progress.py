"""What a command shows while it works: on the standard error, where that is a terminal; gone at the end."""

import math
import os
import sys
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager

from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    Task,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
)
from rich.text import Text

from modelcast.cli.reading import TripSource
from modelcast.cli.terminal import error_console
from modelcast.core.printable import printable
from modelcast.trips.trajectory import Trajectory

__all__ = ["busy", "counted", "rated", "staged", "watched", "watching"]


@contextmanager
def busy(label: str, *, quiet: bool) -> Generator[None]:
    """Show that something is being done, and for how long, where its steps cannot be counted.

    Parameters
    ----------
    label
        What is being done.
    quiet
        Show nothing.
    """
    bar = _bar(label, quiet=quiet, steps=False)
    bar.add_task(label, total=None, note="")
    with bar:
        yield


@contextmanager
def watched(source: TripSource, *, quiet: bool) -> Generator[Iterator[Trajectory]]:
    """Yield the source's trips, with files begun and trips taken shown on the terminal meanwhile.

    Parameters
    ----------
    source
        The files.
    quiet
        Show nothing.
    """
    bar = _bar("files", quiet=quiet)
    task = bar.add_task("files", total=source.files, note="")

    def shown() -> Iterator[Trajectory]:
        for trip in source:
            note = f"trip {source.trips}: {printable(trip.trip_id)}"
            bar.update(task, completed=source.started - 1, note=note)
            yield trip

    with bar:
        yield shown()


@contextmanager
def counted(label: str, *, quiet: bool) -> Generator[Callable[[int, int], None]]:
    """Yield a function that takes steps done and steps to do, shown on the terminal meanwhile.

    Parameters
    ----------
    label
        What the steps are.
    quiet
        Show nothing.
    """
    bar = _bar(label, quiet=quiet)
    task = bar.add_task(label, total=None, note="")

    def show(done: int, steps: int) -> None:
        bar.update(task, completed=done, total=steps)

    with bar:
        yield show


@contextmanager
def watching(label: str) -> Generator[Callable[[str], None]]:
    """Yield a function that takes names of what is being done, whose number nobody knows beforehand.

    Parameters
    ----------
    label
        What is being done.
    """
    bar = _bar(label, quiet=False, steps=False)
    task = bar.add_task(label, total=None, note="")
    done = 0

    def show(name: str) -> None:
        nonlocal done
        done += 1
        bar.update(task, note=f"{done}: {printable(name)}")

    with bar:
        yield show


@contextmanager
def staged(*, quiet: bool) -> Generator[Callable[[str, int, int], None]]:
    """Yield a function that takes a stage's name, steps done and steps to do; each stage has its bar.

    Parameters
    ----------
    quiet
        Show nothing.
    """
    bar = _bar("", quiet=quiet)
    tasks: dict[str, TaskID] = {}

    def show(stage: str, done: int, steps: int) -> None:
        if stage not in tasks:
            tasks[stage] = bar.add_task(stage, total=steps, note=stage)
        bar.update(tasks[stage], completed=done, total=steps)

    with bar:
        yield show


@contextmanager
def rated(
    *, quiet: bool, under_way: Callable[[], int] = lambda: 0
) -> Generator[Callable[[str, int, int, int], None]]:
    """Yield a function that takes a stage's name, steps done, steps to do, and rows done by them.

    Shown are the rows, the rate, and the time left if what is left goes as what was done.

    Parameters
    ----------
    quiet
        Show nothing.
    under_way
        Rows that steps not yet done have done; asked for twice a second.
    """
    bar = _bar("", quiet=quiet, steps=False, more=_Rate(under_way))
    tasks: dict[str, TaskID] = {}

    def show(stage: str, done: int, steps: int, rows: int) -> None:
        if stage not in tasks:
            for before in tasks.values():
                bar.remove_task(before)
            tasks[stage] = bar.add_task(
                stage, total=steps, note=stage, rows=rows,
                begun_s=time.monotonic(), done_before=done, rows_before=rows,
            )  # fmt: skip
        bar.update(tasks[stage], completed=done, total=steps, rows=rows)

    with bar:
        yield show


_LOOK_S = 0.5


class _Rate(ProgressColumn):
    """Rows so far, rows a second, and the time left."""

    def __init__(self, under_way: Callable[[], int]) -> None:
        self._under_way = under_way
        self._looked_s, self._seen = -math.inf, 0
        super().__init__()

    def render(self, task: Task) -> Text:
        """Text for one stage."""
        told = task.fields
        now_s = time.monotonic()
        if now_s > self._looked_s + _LOOK_S:
            self._seen, self._looked_s = self._under_way(), now_s
        rows = int(told["rows"]) + self._seen
        elapsed_s = max(now_s - float(told["begun_s"]), 1e-3)
        text = f"{rows:,} rows, {(rows - int(told['rows_before'])) / elapsed_s:,.0f}/s"
        done, total = task.completed - float(told["done_before"]), task.total
        if done > 0.0 and total is not None:
            text += f", {elapsed_s * (total - task.completed) / done:,.0f} s left"
        return Text(text)


def _bar(label: str, *, quiet: bool, steps: bool = True, more: ProgressColumn | None = None) -> Progress:
    """A progress bar on stderr that leaves nothing behind, and is silent where that is no terminal."""
    # rich takes FORCE_COLOR for a terminal: what counts here is whether somebody watches.
    watched = sys.stderr.isatty() and os.environ.get("TERM") not in {"dumb", "unknown"}
    counts = (BarColumn(), MofNCompleteColumn()) if steps else ()
    return Progress(
        SpinnerColumn(),
        TextColumn(label, markup=False),
        *counts,
        TextColumn("{task.fields[note]}", markup=False),
        *(() if more is None else (more,)),
        TimeElapsedColumn(),
        console=error_console(),
        transient=True,
        disable=quiet or not watched,
    )
