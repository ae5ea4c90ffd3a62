"""What a corpus is made from: the recordings under several paths, each with a short name of its own."""

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from modelcast.core.printable import printable
from modelcast.io.base import AbstractTripReader
from modelcast.io.failure import failure_reason
from modelcast.io.free_names import free_name
from modelcast.io.packed import member_of
from modelcast.io.reading_rate import require_rate
from modelcast.io.recordings import Recordings

__all__ = ["FoundSources", "Source", "find_sources"]

_LIBRARIES_BYTES, _HELD_SHARE, _LEAST_HELD_BYTES = 350 * 2**20, 8, 8 * 2**20
"""What a process takes before it reads; share of the rest that rows being gathered may take. Text, and what
is made of a trip's rows, take the other shares."""


@dataclass(frozen=True, slots=True)
class Source:
    """A recording that is to go into a corpus.

    Parameters
    ----------
    number
        Its place among the sources, from 0.
    label
        From what the user named on; no other source has it.
    path
        Where it is.
    reader
        The reader of its format.
    pattern
        Trips whose identifier matches this shell pattern are taken.
    rate_hz
        Rate at which they are read; None for as recorded.
    memory_bytes
        What the process that reads it may take; None where only the machine bounds it.
    """

    number: int
    label: str
    path: str
    reader: AbstractTripReader
    pattern: str
    rate_hz: float | None = None
    memory_bytes: int | None = None

    @property
    def place(self) -> Path:
        """The file or folder on disk; of a member its archive."""
        member = member_of(self.path)
        return Path(self.path if member is None else member.archive)

    @property
    def state(self) -> list[int]:
        """Number of its files, their octets together, and when the last was changed [ns]."""
        at = self.place
        files = [file for file in at.rglob("*") if file.is_file()] if at.is_dir() else [at]
        found = [file.stat() for file in files]
        return [
            len(found),
            sum(one.st_size for one in found),
            max((one.st_mtime_ns for one in found), default=0),
        ]


@dataclass(frozen=True, slots=True)
class FoundSources:
    """What lies under the paths a user named.

    Parameters
    ----------
    sources
        The recordings, in order.
    failures
        Paths that are none, with the reason.
    skipped
        Files that no reader knows, and the like, with the reason.
    settings
        How they are to be read: format, columns, pattern and rate, as the user said.
    """

    sources: tuple[Source, ...]
    failures: Mapping[str, str]
    skipped: Mapping[str, str]
    settings: Mapping[str, Any]


def find_sources(
    paths: Iterable[str | Path],
    format_name: str | None = None,
    *,
    columns: Mapping[str, str] | None = None,
    pattern: str = "*",
    rate_hz: float | None = None,
    memory_bytes: int | None = None,
) -> FoundSources:
    """Return the recordings at and under paths; a path that cannot be told is a failure, not an end.

    Parameters
    ----------
    paths, format_name, columns
        As for `modelcast.io.trips.read_trips`.
    pattern, rate_hz
        As in `Source`.
    memory_bytes
        What the process that reads one may take; None for the readers' own bounds.

    Raises
    ------
    ConfigError
        Where the format is unknown, or has fixed columns but a map is given; where the rate is none.
    """
    require_rate(rate_hz)
    skipped: dict[str, str] = {}
    failures: dict[str, str] = {}
    labels: dict[str, str] = {}

    def note(what: str, reason: str) -> None:
        label = recordings.label(what) if os.path.lexists(what) or member_of(what) else what
        skipped[free_name(skipped, printable(label))] = printable(reason)

    recordings = Recordings(paths, format_name, columns=columns, on_skipped=note)
    sources: list[Source] = []
    while True:
        try:
            recording = next(recordings, None)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever it is, it costs this path alone
            label = printable(recordings.label(recordings.at))
            failures[free_name(failures, label)] = printable(failure_reason(error))
            continue
        if recording is None:
            settings = {
                "format": format_name,
                "columns": None if columns is None else dict(columns),
                "trip": pattern,
                "rate": rate_hz,
            }
            return FoundSources(tuple(sources), failures, skipped, settings)
        label = free_name(labels, printable(recordings.label(recording.path)))
        labels[label] = recording.path
        reader = recording.reader
        if memory_bytes is not None:
            reader = reader.within(max((memory_bytes - _LIBRARIES_BYTES) // _HELD_SHARE, _LEAST_HELD_BYTES))
        sources.append(Source(len(sources), label, recording.path, reader, pattern, rate_hz, memory_bytes))
