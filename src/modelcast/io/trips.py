"""`read_trips`: trips from files, folders and data frames, as a list that is read when it is asked for."""

from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, cast, overload

from modelcast.core.exceptions import ConfigError
from modelcast.io.base import OnSkipped, ignore_skipped
from modelcast.io.free_names import FreeNames, free_name
from modelcast.io.recordings import Recording, Recordings
from modelcast.trips.trajectory import Trajectory

if TYPE_CHECKING:
    import polars as pl

    from modelcast.io.frames import FrameRecording

__all__ = ["MOST_HELD_BYTES", "ArrowFrame", "TripSources", "Trips", "is_frame", "is_source", "read_trips"]


class ArrowFrame(Protocol):
    """A data frame that hands its columns over by the Arrow interface: Polars, pandas, pyarrow."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """Hand the columns over."""
        ...


TripSources: TypeAlias = str | Path | ArrowFrame | Iterable[Any]
"""A path, a data frame, or several of them."""

MOST_HELD_BYTES = 256 * 1024**2
"""Trips of more than this together are not kept, but read again when they are asked for."""

_MOST_SHOWN = 20


@dataclass(frozen=True, slots=True)
class _Entry:
    """Where a trip is found again: its recording, its place there, and what it is called in the list."""

    recording: "Recording | FrameRecording"
    place: int
    trip_id: str

    def read(self) -> Trajectory:
        found = next(islice(self.recording.trips(), self.place, None), None)
        if found is None:
            raise IndexError(f"{self.trip_id} is not in its file any more")
        return _named(found, self.trip_id)


@dataclass(frozen=True, slots=True)
class _Survey:
    """What a complete reading found; the trips themselves where they are few enough to keep."""

    entries: tuple[_Entry, ...]
    held: tuple[Trajectory, ...] | None


class Trips(Sequence[Trajectory]):
    """The trips of files, folders and data frames: a list that is read when it is asked for.

    Iterating reads one recording after another and yields a trip at a time; so does `len`, once. Trips of at
    most `MOST_HELD_BYTES` together are kept after the first complete reading; more are read again when they
    are asked for, so that a large folder needs no more memory than its largest recording. `list` asks for the
    length first and reads these twice; a ``for`` loop does not.

    Parameters
    ----------
    sources, format_name, columns, on_skipped
        As for `read_trips`.

    Raises
    ------
    ConfigError
        Where the format is unknown, has fixed columns but a map is given, or goes with a data frame.
    TypeError
        Where a source is neither a path nor a data frame.

    Examples
    --------
    >>> import polars as pl
    >>> frame = pl.DataFrame({"t": [0.0, 0.1, 0.2], "x": [0.0, 1.0, 2.0], "y": 0.0, "vehicle": "a"})
    >>> trips = Trips(frame)
    >>> trips
    Trips(1 source, not read yet)
    >>> len(trips), trips[0].trip_id, trips
    (1, 'frame/a', Trips(1 source, 1 trip))
    >>> trips.summary()["samples"].to_list()
    [3]
    """

    def __init__(
        self,
        sources: TripSources,
        format_name: str | None = None,
        *,
        columns: Mapping[str, str] | None = None,
        on_skipped: OnSkipped | None = None,
    ) -> None:
        if isinstance(sources, Mapping):
            raise TypeError(
                f"a source of trips is a path or a data frame, not {type(cast('object', sources)).__name__}: "
                f"make a data frame of it, as polars.DataFrame(columns)"
            )
        given: list[Any] = [sources] if is_source(sources) else list(cast("Iterable[Any]", sources))
        for source in given:
            if not is_source(source):
                raise TypeError(f"a source of trips is a path or a data frame, not {type(source).__name__}")
        frames = any(map(is_frame, given))
        if format_name is not None and frames:
            raise ConfigError(f"the format {format_name} is that of a file: leave it out for a data frame")
        Recordings([], format_name, columns=columns)  # refuses a format that is unknown
        self._sources = [_recording(one, columns) if is_frame(one) else str(one) for one in given]
        self._format = format_name
        self._columns = columns
        self._on_skipped = ignore_skipped if on_skipped is None else on_skipped
        self._skipped: dict[str, str] = {}
        self._skips_told = 0
        self._found: _Survey | None = None

    @property
    def skipped(self) -> Mapping[str, str]:
        """What gave no trip so far (a vehicle's identifier, a file in a folder), with the reason.

        Where two share a name, as the same vehicle in two files, the later gets ``#2``, ``#3``, ...
        """
        return MappingProxyType(self._skipped)

    def summary(self) -> "pl.DataFrame":
        """Return a row a trip, as `modelcast.io.frames.summary_frame` says."""
        return _summary(self)

    def __iter__(self) -> Iterator[Trajectory]:
        # Settled at the first trip, not here: `list` asks for the length once it has its iterator.
        held = None if self._found is None else self._found.held
        yield from self._read() if held is None else held

    def __len__(self) -> int:
        return len(self._surveyed().entries)

    @overload
    def __getitem__(self, index: int) -> Trajectory: ...
    @overload
    def __getitem__(self, index: slice) -> list[Trajectory]: ...
    def __getitem__(self, index: int | slice) -> Trajectory | list[Trajectory]:
        if isinstance(index, slice):
            places = range(*index.indices(len(self)))
            found = {place: trip for place, trip in enumerate(self) if place in places}
            return [found[place] for place in places]
        if self._found is None and index >= 0:
            trip = next(islice(self._read(), index, None), None)  # what comes behind it is not read
            if trip is not None:
                return trip
        survey = self._surveyed()
        count = len(survey.entries)
        if not -count <= index < count:
            raise IndexError(f"there is no trip {index} among {count}")
        return survey.entries[index].read() if survey.held is None else survey.held[index]

    def __repr__(self) -> str:
        found = self._found
        known = "not read yet" if found is None else _counted(len(found.entries), "trip")
        return f"Trips({_counted(len(self._sources), 'source')}, {known})"

    def _repr_html_(self) -> str:
        """Return a table of the trips; of sources not read yet that of the first."""
        from modelcast.io.frames import frame_html  # noqa: PLC0415 - reading files needs no data frames

        if self._found is None:
            first = list(islice(self._read(), _MOST_SHOWN + 1))
            if len(first) > _MOST_SHOWN:
                title = f"{self!r}; the first {_MOST_SHOWN}:"
                return frame_html(title, _summary(first[:_MOST_SHOWN]))
        summary = self.summary()
        return frame_html(repr(self), summary)

    def _surveyed(self) -> _Survey:
        """Return what a complete reading found; all is read once for it."""
        if self._found is None:
            deque(self._read(), maxlen=0)
        return cast("_Survey", self._found)

    def _recordings(self, on_skipped: OnSkipped) -> "Iterator[Recording | FrameRecording]":
        """Yield the recordings in order; paths that follow each other are read as one list."""
        paths: list[str] = []
        for source in (*self._sources, None):
            if isinstance(source, str):
                paths.append(source)
                continue
            yield from Recordings(paths, self._format, columns=self._columns, on_skipped=on_skipped)
            paths = []
            if source is not None:
                yield replace(source, on_skipped=on_skipped)

    def _read(self) -> Iterator[Trajectory]:
        """Yield every trip, and note at the end where they are."""
        skips = 0

        def note(what: str, reason: str) -> None:
            """Tell of what gave no trip, once however often it is read."""
            nonlocal skips
            skips += 1
            if skips > self._skips_told:
                self._skips_told = skips
                self._skipped[free_name(self._skipped, what)] = reason
                self._on_skipped(what, reason)

        names = FreeNames()
        entries: list[_Entry] = []
        held: list[Trajectory] = []
        left_bytes = MOST_HELD_BYTES
        for recording in self._recordings(note):
            again = replace(recording, on_skipped=ignore_skipped)
            for place, read in enumerate(recording.trips()):
                trip = _named(read, names.take(read.trip_id))
                entries.append(_Entry(again, place, trip.trip_id))
                left_bytes -= sum(column.nbytes for column in trip.columns().values())
                if left_bytes >= 0:
                    held.append(trip)
                else:
                    held.clear()
                yield trip
        kept = tuple(held) if left_bytes >= 0 else None
        self._found = _Survey(tuple(entries), kept)


def read_trips(
    sources: TripSources,
    format: str | None = None,  # noqa: A002 - the word a user would type
    *,
    columns: Mapping[str, str] | None = None,
    on_skipped: OnSkipped | None = None,
) -> Trips:
    """Return the trips of files, folders and data frames as a list that is read when it is asked for.

    A folder that a reader knows is one recording (comma2k19); of any other folder the files are read that
    some reader knows, in order of name, subfolders included, hidden ones and links to folders left out.
    Formats may differ from file to file. A file named twice is read once.

    Parameters
    ----------
    sources
        A file, a folder, a data frame (Polars, pandas, pyarrow), or several of them.
    format
        Name of the files' format (`modelcast.io.registry.reader_names`); found from the content where None.
    columns
        Column names for csv, parquet and data frames, by meaning, as in
        ``{"t": "time", "east": "x", "north": "y"}``.
    on_skipped
        Called once with what gave no trip (a vehicle's identifier, a file in a folder) and the reason;
        `Trips.skipped` has them too.

    Returns
    -------
    Trips
        A trip a vehicle, in the order given. Where two would share an identifier, the later gets ``#2``,
        ``#3``, ...

    Raises
    ------
    ConfigError
        Where the format is unknown, has fixed columns but a map is given, or goes with a data frame.
    TypeError
        Where a source is neither a path nor a data frame.

    Notes
    -----
    What is wrong with a file is raised where its trips are asked for: DataFormatError where a path does not
    exist or a file is not what its format says. To go on with the next file, use
    `modelcast.io.recordings.Recordings`.

    Examples
    --------
    >>> import polars as pl
    >>> frame = pl.DataFrame({"clock": [0.0, 0.1, 0.2], "px": [0.0, 1.0, 2.0], "py": 0.0})
    >>> trips = read_trips(frame, columns={"t": "clock", "east": "px", "north": "py"})
    >>> [trip.trip_id for trip in trips], [len(trip) for trip in trips]
    (['frame/vehicle'], [3])
    """
    return Trips(sources, format, columns=columns, on_skipped=on_skipped)


def is_frame(given: object) -> bool:
    """Return whether an object is a data frame: it hands its columns over by one of two interfaces.

    Parameters
    ----------
    given
        Anything.
    """
    return hasattr(given, "__arrow_c_stream__") or hasattr(given, "__dataframe__")


def is_source(given: object) -> bool:
    """Return whether an object is what trips are read from: a path or a data frame.

    Parameters
    ----------
    given
        Anything.
    """
    return isinstance(given, str | Path) or is_frame(given)


def _named(trip: Trajectory, trip_id: str) -> Trajectory:
    return trip if trip.trip_id == trip_id else replace(trip, trip_id=trip_id)


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _recording(frame: Any, columns: Mapping[str, str] | None) -> "FrameRecording":
    from modelcast.io.frames import frame_recording  # noqa: PLC0415 - reading files needs no data frames

    return frame_recording(frame, columns)


def _summary(trips: Iterable[Trajectory]) -> "pl.DataFrame":
    from modelcast.io.frames import summary_frame  # noqa: PLC0415 - reading files needs no data frames

    return summary_frame(trips)
