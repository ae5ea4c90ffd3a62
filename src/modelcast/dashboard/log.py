"""Snapshots in a file, one JSON document a line: written as they come, read at any time.

A line is a text of `modelcast.dashboard.document`: a snapshot, or the road that was driven. Times rise. What
was cut off in the last line, as by a crash, is left out and counted.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self

import numpy as np

from modelcast.core.exceptions import DataFormatError
from modelcast.core.rules import shown
from modelcast.dashboard.document import read_road, read_snapshot, road_text, snapshot_text
from modelcast.dashboard.feed import AbstractLogFeed
from modelcast.dashboard.seen_paths import SeenPaths
from modelcast.dashboard.snapshot import Snapshot

__all__ = ["LONGEST_LINE_BYTES", "MOST_LINES", "SnapshotLog", "SnapshotLogWriter"]

LONGEST_LINE_BYTES = 4 << 20
"""Octets of one line: about 25,000 remotes."""

MOST_LINES = 2_000_000
"""Lines of a log: two days at 10 Hz."""

_SNAPSHOT = re.compile(rb'\{"kind":"snapshot","t_s":(-?\d{1,10}(?:\.\d{1,9})?),')
_ROAD = b'{"kind":"road",'
_REMEDY = "It must be a log that modelcast wrote: lines of JSON as docs/node-page.md has them"


class SnapshotLogWriter:
    """Writes a log; a context manager.

    Parameters
    ----------
    path
        The file; one that is there is replaced.

    Raises
    ------
    OSError
        Where it cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("wb")
        self._seen = SeenPaths()
        self._last_s = -np.inf

    def __enter__(self) -> Self:
        """Write into the open file."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Write the road behind the snapshots, and close."""
        with self._file:
            self._file.write(road_text(self._seen.lines_m()).encode() + b"\n")

    def write(self, snapshot: Snapshot) -> None:
        """Add one.

        Parameters
        ----------
        snapshot
            Later than the last.

        Raises
        ------
        ValueError
            Where it is not later.
        OSError
            Where the disk is full.
        """
        if not snapshot.t_s > self._last_s:
            raise ValueError(f"t_s must increase, got {snapshot.t_s} after {self._last_s}")
        self._last_s = snapshot.t_s
        remotes = snapshot.remotes
        self._seen.add(zip(remotes.vehicle.tolist(), *remotes.position_m.T.tolist(), strict=True))
        self._file.write(snapshot_text(snapshot).encode() + b"\n")


class SnapshotLog(AbstractLogFeed):
    """A log that can be wound to any time; a context manager.

    Opening reads the beginnings of all lines; a line is judged when it is shown.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    DataFormatError
        Where it is no log.
    OSError
        Where it cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        super().__init__()
        self._places: list[tuple[int, int, int]] = []
        self.cut_off = 0
        """Lines left out since their end is missing: 0 or 1."""
        self._file = path.open("rb")
        try:
            self._scan()
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> Self:
        """Read from the open file."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self._file.close()

    @property
    def name(self) -> str:
        """The file's own name."""
        return self._path.name

    def text_at(self, t_s: float) -> str:
        """The newest snapshot that is no later than a time, or the first, as its line has it.

        Parameters
        ----------
        t_s
            The time [s].

        Raises
        ------
        DataFormatError
            Where the line is no snapshot.
        """
        row, start, length = self._places[self.place_at(t_s)]
        self._file.seek(start)
        return self._judged(row, self._file.read(length))

    def _scan(self) -> None:
        start = 0
        for row, line in enumerate(_lines(self._file), start=1):
            if row > MOST_LINES or len(line) > LONGEST_LINE_BYTES:
                raise self._wrong(
                    row, f"more than {MOST_LINES} lines, or a line over {LONGEST_LINE_BYTES} octets"
                )
            found = _SNAPSHOT.match(line)
            if not line.endswith(b"\n"):
                self.cut_off = 1
            elif found is not None:
                t_s = float(found[1])
                if self._times_s and t_s <= self._times_s[-1]:
                    raise self._wrong(row, f"time {t_s} s after {self._times_s[-1]} s")
                self._times_s.append(t_s)
                self._places.append((row, start, len(line)))
            elif line.startswith(_ROAD):
                self._road = self._judged(row, line)
            else:
                raise self._wrong(row, f"no snapshot and no road, but {shown(line[:40])}")
            start += len(line)
        if not self._times_s:
            raise self._wrong(None, "no snapshot")
        self.text_at(-np.inf)

    def _judged(self, row: int, line: bytes) -> str:
        """The line as text, if it is what it says."""
        try:
            text = line.decode().rstrip("\n")
            read_road(text) if line.startswith(_ROAD) else read_snapshot(text)
        except ValueError as error:
            raise self._wrong(row, str(error)) from error
        return text

    def _wrong(self, row: int | None, problem: str) -> DataFormatError:
        return DataFormatError(str(self._path), problem, row=row, remedy=_REMEDY)


def _lines(file: BinaryIO) -> Iterator[bytes]:
    """Lines with their ends; one that is too long comes cut, one octet over the bound."""
    while line := file.readline(LONGEST_LINE_BYTES + 1):
        yield line
