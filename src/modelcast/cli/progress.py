"""What a command says it is doing: a stage each, shown on the board (`modelcast.cli.board`)."""

import math
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager

from modelcast.cli.board import board
from modelcast.cli.reading import TripSource
from modelcast.core.doing import heard
from modelcast.core.printable import printable
from modelcast.trips.trajectory import Trajectory

__all__ = ["busy", "counted", "rated", "staged", "watched", "watching"]


@contextmanager
def busy(label: str, *, quiet: bool) -> Generator[None]:
    """Show that something is being done, for how long, and what of it is at hand (`modelcast.core.doing`).

    Parameters
    ----------
    label
        What is being done.
    quiet
        Show nothing.
    """
    with board.stage(label, quiet=quiet, counts=False) as stage:

        def note(what: str) -> None:
            stage.note = what

        with heard(note):
            yield


@contextmanager
def watched(source: TripSource, *, quiet: bool) -> Generator[Iterator[Trajectory]]:
    """Yield the source's trips, with files begun and trips taken shown meanwhile.

    Parameters
    ----------
    source
        The files.
    quiet
        Show nothing.
    """
    with board.stage("files", quiet=quiet) as stage:
        stage.total = source.files

        def shown() -> Iterator[Trajectory]:
            for trip in source:
                stage.update(source.started - 1, source.files, board.clock_s())
                stage.note = f"trip {source.trips}: {printable(trip.trip_id)}"
                yield trip

        yield shown()


@contextmanager
def counted(label: str, *, quiet: bool) -> Generator[Callable[[int, int | None], None]]:
    """Yield a function that takes steps done and steps to do, None where nobody knows, shown meanwhile.

    Parameters
    ----------
    label
        What the steps are.
    quiet
        Show nothing.
    """
    with board.stage(label, quiet=quiet) as stage:

        def show(done: int, steps: int | None) -> None:
            stage.update(done, steps, board.clock_s())

        yield show


@contextmanager
def watching(label: str, *, quiet: bool = False) -> Generator[Callable[[str], None]]:
    """Yield a function that takes names of what is being done, whose number nobody knows beforehand.

    Parameters
    ----------
    label
        What is being done.
    quiet
        Show nothing.
    """
    done = 0
    with board.stage(label, quiet=quiet, counts=False) as stage:

        def show(name: str) -> None:
            nonlocal done
            done += 1
            stage.note = f"{done}: {printable(name)}"

        yield show


@contextmanager
def staged(*, quiet: bool) -> Generator[Callable[[str, int, int], None]]:
    """Yield a function that takes a part's name, steps done and steps to do; each part is timed by itself.

    Parameters
    ----------
    quiet
        Show nothing.
    """
    with rated(quiet=quiet, shows_rows=False) as show:
        yield lambda name, done, steps: show(name, done, steps, 0)


@contextmanager
def rated(
    *, quiet: bool, under_way: Callable[[], int] = lambda: 0, shows_rows: bool = True
) -> Generator[Callable[[str, int, int, int], None]]:
    """Yield a function that takes a part's name, steps done, steps to do, and rows done by them.

    Shown are the rows, the rate, and the time left if what is left goes as what was done.

    Parameters
    ----------
    quiet
        Show nothing.
    under_way
        Rows that steps not yet done have done; asked for twice a second at most.
    shows_rows
        Whether rows and rate are shown.
    """
    with board.stage("starting", quiet=quiet, counts=False) as stage:

        def show(name: str, done: int, steps: int, rows: int) -> None:
            now_s = board.clock_s()
            if stage.label != name or not stage.counts:
                stage.begin(name, now_s)
                stage.more = _Rows(under_way, rows, now_s) if shows_rows else None
            if isinstance(stage.more, _Rows):
                stage.more.rows = rows
            stage.update(done, steps, now_s)

        yield show


_LOOK_S = 0.5


class _Rows:
    """Rows so far, and rows a second.

    Parameters
    ----------
    under_way
        Rows that are not counted yet.
    rows, begun_s
        Rows that were there before, and since when others are counted [s].
    """

    def __init__(self, under_way: Callable[[], int], rows: int, begun_s: float) -> None:
        self._under_way = under_way
        self._before, self._begun_s = rows, begun_s
        self._looked_s, self._seen = -math.inf, 0
        self.rows = rows

    def __call__(self, now_s: float) -> str:
        """Text for a row."""
        if now_s > self._looked_s + _LOOK_S:
            self._seen, self._looked_s = self._under_way(), now_s
        rows = self.rows + self._seen
        return f"{rows:,} rows, {(rows - self._before) / max(now_s - self._begun_s, 1e-3):,.0f}/s"
