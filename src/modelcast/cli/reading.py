"""Reading trips for a command: a file that fails costs that file alone."""

import fnmatch
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from modelcast.cli.terminal import complain, say
from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.core.printable import printable
from modelcast.io.failure import failure_reason
from modelcast.io.free_names import FreeNames, free_name
from modelcast.io.packed import is_archive, member_of
from modelcast.io.reading_rate import read_at, require_rate
from modelcast.io.recordings import Recording, Recordings
from modelcast.trips.trajectory import Trajectory

__all__ = ["PARTLY_FAILED", "TripSource", "require_paths"]

_MOST_NAMED = 5
"""Trips that are named where a pattern takes none."""

PARTLY_FAILED = 3
"""Exit code where some trips failed and the rest is complete."""


def require_paths(paths: Sequence[Path], command: str) -> None:
    """Refuse a command that names no trips.

    Parameters
    ----------
    paths
        What it names.
    command
        Its name, and its study where it has one.

    Raises
    ------
    ConfigError
        Where there is none.
    """
    if not paths:
        raise ConfigError(f"name at least one trip file or folder (modelcast {command} --help)")


class TripSource:
    """The trips of several files, in order, once; a file that cannot be read becomes a failure, not an end.

    Names and reasons come from files: control characters in them are written out.

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
    rate_hz
        Rate at which they are read (`modelcast.trips.rate`); None for as recorded. A trip recorded more
        slowly is skipped.

    Raises
    ------
    ConfigError
        Where the format is unknown, or has fixed columns but a map is given; where the rate is none.
    """

    def __init__(
        self,
        paths: Sequence[Path],
        *,
        format_name: str | None = None,
        columns: Mapping[str, str] | None = None,
        pattern: str = "*",
        rate_hz: float | None = None,
    ) -> None:
        require_rate(rate_hz)
        self._rate_hz = rate_hz
        self._paths = paths
        self._pattern = pattern
        self._recordings = Recordings(paths, format_name, columns=columns, on_skipped=self._skip)
        self.failures: dict[str, str] = {}
        self.skipped: dict[str, str] = {}
        self.started = 0
        self.trips = 0
        self._others: list[str] = []

    @property
    def files(self) -> int | None:
        """Number of files, None where folders or archives are among the paths."""
        many = any(path.is_dir() or is_archive(path) for path in self._paths)
        return None if many else len(self._paths)

    @property
    def exit_code(self) -> int:
        """Exit code of a command that took every trip."""
        return PARTLY_FAILED if self.failures else 0

    def skipped_lines(self) -> list[str]:
        """Say what gave no trip, a line each; the first few."""
        from modelcast.report.console import skipped_lines

        return skipped_lines(self.skipped, rest="modelcast trips names all")

    def tell_skipped(self) -> None:
        """Print what gave no trip, in a command whose files have no place for it."""
        for line in self.skipped_lines():
            say(line)

    def __iter__(self) -> Iterator[Trajectory]:
        names = FreeNames()
        while (recording := self._next_recording()) is not None:
            self.started += 1
            try:
                for read in recording.trips():
                    trip = read_at(_named(read, printable(read.trip_id)), self._rate_hz, self._skip)
                    if trip is None:
                        continue
                    if fnmatch.fnmatch(trip.trip_id, self._pattern):
                        self.trips += 1
                        yield _named(trip, names.take(trip.trip_id))
                    elif len(self._others) < _MOST_NAMED:
                        self._others.append(trip.trip_id)
            except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever it is, it costs this file alone
                self._fail(recording.path, error)
        if not self.trips:
            self._tell_why()

    def _tell_why(self) -> None:
        """Say why there is no trip at all, where files are not to blame."""
        if self._others:
            complain(f"--trip {self._pattern}: no trip is named so; there are {', '.join(self._others)}")
        for line in self.skipped_lines():
            complain(line)

    def _next_recording(self) -> Recording | None:
        while True:
            try:
                return next(self._recordings, None)
            except (Exception, SystemExit) as error:  # noqa: BLE001 - as above
                self.started += 1
                self._fail(self._recordings.at, error)

    def _fail(self, path: str, error: BaseException) -> None:
        """Note a file that could not be read, and say so."""
        label = printable(self._recordings.label(path))
        self.failures[free_name(self.failures, label)] = printable(failure_reason(error))
        complain(str(error) if isinstance(error, DataFormatError) else f"{path}: {failure_reason(error)}")

    def _skip(self, name: str, reason: str) -> None:
        label = self._recordings.label(name) if os.path.lexists(name) or member_of(name) else name
        self.skipped[free_name(self.skipped, printable(label))] = printable(reason)


def _named(trip: Trajectory, name: str) -> Trajectory:
    return trip if trip.trip_id == name else replace(trip, trip_id=name)
