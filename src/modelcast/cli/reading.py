"""Reading trips for a command: progress on the terminal, files that fail kept apart."""

import fnmatch
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    SpinnerColumn,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
)

from modelcast.cli.terminal import complain, error_console
from modelcast.core.exceptions import DataFormatError
from modelcast.core.printable import printable
from modelcast.core.trajectory import Trajectory
from modelcast.io.trips import read_trips

__all__ = ["PARTLY_FAILED", "TripSource", "counted", "staged", "watched"]

PARTLY_FAILED = 3
"""Exit code where some trips failed and the rest is complete."""


class TripSource:
    """The trips of several files, in order; a file that cannot be read becomes a failure, not an end.

    Parameters
    ----------
    paths
        Files or folders.
    format_name
        Format, or None to detect it.
    columns
        Column map for csv and parquet.
    pattern
        Trips whose identifier matches this shell pattern are taken.
    """

    def __init__(
        self,
        paths: Sequence[Path],
        *,
        format_name: str | None = None,
        columns: Mapping[str, str] | None = None,
        pattern: str = "*",
    ) -> None:
        self._paths = paths
        self._format = format_name
        self._columns = columns
        self._pattern = pattern
        self.failures: dict[str, str] = {}
        self.skipped: dict[str, str] = {}
        self.started = 0
        self.trips = 0

    def __len__(self) -> int:
        return len(self._paths)

    def _skip(self, name: str, reason: str) -> None:
        self.skipped[Path(name).name if Path(name).exists() else name] = reason

    @property
    def exit_code(self) -> int:
        """Exit code of a command that took every trip."""
        return PARTLY_FAILED if self.failures else 0

    def __iter__(self) -> Iterator[Trajectory]:
        # One reader over all paths would end at the first bad one; identifiers stay unique all the same.
        seen: dict[str, int] = {}
        for path in self._paths:
            self.started += 1
            try:
                for trip in read_trips(path, self._format, columns=self._columns, on_skipped=self._skip):
                    if fnmatch.fnmatch(trip.trip_id, self._pattern):
                        seen[trip.trip_id] = seen.get(trip.trip_id, 0) + 1
                        self.trips += 1
                        yield _renamed(trip, seen[trip.trip_id])
            except DataFormatError as error:
                place = "" if error.row is None else f"row {error.row}: "
                copies = sum(name.partition("#")[0] == path.name for name in self.failures)
                name = f"{path.name}#{copies + 1}" if copies else path.name
                self.failures[name] = f"{place}{error.problem}. {error.remedy}".strip()
                complain(error)


def _renamed(trip: Trajectory, copy: int) -> Trajectory:
    return trip if copy == 1 else replace(trip, trip_id=f"{trip.trip_id}#{copy}")


@contextmanager
def watched(source: TripSource, *, quiet: bool) -> Generator[Iterator[Trajectory]]:
    """Yield the source's trips, with files begun and trips taken shown on the terminal meanwhile.

    Parameters
    ----------
    source
        Its length is the number of files.
    quiet
        Show nothing.
    """
    bar = _bar("files", quiet=quiet)
    task = bar.add_task("files", total=len(source), note="")

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


def _bar(label: str, *, quiet: bool) -> Progress:
    """A progress bar on stderr that leaves nothing behind, and is silent where that is no terminal."""
    console = error_console()
    return Progress(
        SpinnerColumn(),
        TextColumn(label),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[note]}", markup=False),
        TimeElapsedColumn(),
        console=console,
        transient=True,
        disable=quiet or not console.is_terminal,
    )
