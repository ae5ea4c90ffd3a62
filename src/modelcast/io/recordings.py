"""`Recordings`: the files under several paths, one after another, each with the reader of its format."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from modelcast.core.exceptions import DataFormatError
from modelcast.core.printable import printable
from modelcast.io.base import AbstractTripReader, OnSkipped, ignore_skipped
from modelcast.io.manifest import MANIFEST
from modelcast.io.packed import archive_members, is_archive, member_of, recording_name
from modelcast.io.places import place_kind, readable_kind
from modelcast.io.registry import detect_format, get_reader, reader_names
from modelcast.io.unpacking import packed_trips
from modelcast.trips.trajectory import Trajectory

__all__ = ["Recording", "Recordings"]

_MOST_REASONS = 3
"""Files whose reasons the error names where none of a folder or archive is a recording."""


@dataclass(frozen=True, slots=True)
class Recording:
    """A file, or a folder that is one recording.

    Parameters
    ----------
    path
        As the user named it, or below a folder that the user named.
    reader
        The reader of its format.
    on_skipped
        Called with a vehicle that gave no trip, and the reason.
    """

    path: str
    reader: AbstractTripReader
    on_skipped: OnSkipped = ignore_skipped

    def trips(self) -> Iterator[Trajectory]:
        """Yield its trips.

        Raises
        ------
        DataFormatError
            Where it is not what its format says, or the operating system refuses it.
        """
        try:
            yield from packed_trips(self.reader, self.path, self.on_skipped)
        except OSError as error:
            raise _refused(self.path, error) from error
        except UnicodeDecodeError as error:
            octet = f"octet {error.object[error.start]:#04x} at {error.start}"
            problem = f"is not {error.encoding} text: {octet} of what was read is {error.reason}"
            raise DataFormatError(self.path, problem, remedy="Save it as UTF-8.") from error


@dataclass(frozen=True, slots=True)
class _Place:
    """Where to look next: a path a user named, what a folder or archive holds, the end of a named one."""

    path: str
    kind: Literal["named", "entry", "member", "end"]


class Recordings(Iterator[Recording]):
    """Iterates over the recordings at and under paths, in order; after an error it can be asked for the next.

    Parameters
    ----------
    paths, format_name, columns, on_skipped
        As for `modelcast.io.trips.read_trips`.

    Raises
    ------
    ConfigError
        Where the format is unknown, or has fixed columns but a map is given.

    Notes
    -----
    ``next`` raises DataFormatError for a path that is no readable file, OSError and whatever a reader's
    `matches` raises for one that cannot be told; `at` is then the path it was about.
    """

    def __init__(
        self,
        paths: str | Path | Iterable[str | Path],
        format_name: str | None = None,
        *,
        columns: Mapping[str, str] | None = None,
        on_skipped: OnSkipped | None = None,
    ) -> None:
        if format_name is not None:
            _with_columns(get_reader(format_name), columns)
        given = [paths] if isinstance(paths, str | Path) else list(paths)
        self._waiting = [_Place(str(path), "named") for path in reversed(given)]
        self._format = format_name
        self._columns = columns
        self._report = ignore_skipped if on_skipped is None else on_skipped
        self._root = Path()
        self._tried = False
        self._left: list[str] = []
        self._done: set[Path] = set()
        self.at = ""
        """The path looked at last."""

    def __next__(self) -> Recording:
        """Return the next recording."""
        while self._waiting:
            place = self._waiting.pop()
            self.at = place.path
            try:
                found = self._found(place)
            except (Exception, SystemExit) as error:
                self._tried = True
                if isinstance(error, OSError):
                    raise _refused(place.path, error) from error
                raise
            if found is not None:
                return found
        raise StopIteration

    def label(self, path: str) -> str:
        """Return a path from the last part of what the user named on: short, and the same on any machine.

        Parameters
        ----------
        path
            Of a recording, or of an entry of its folder.
        """
        return str(Path(path).relative_to(self._root.parent)) if self._holds(path) else Path(path).name

    def _holds(self, path: str) -> bool:
        return Path(path).is_relative_to(self._root)

    def _found(self, place: _Place) -> Recording | None:
        """Return the recording at a place; a folder's entries are put in line instead."""
        at = Path(place.path)
        if place.kind == "end":
            self._require_tried(place.path)
            return None
        if place.kind == "member":
            return self._known(place.path)
        if place.kind == "entry":
            kind = self._entry_kind(at)
        elif member_of(place.path) is not None:
            kind = "file"
            self._root, self._tried, self._left = at, False, []
        else:
            kind = readable_kind(at)
            self._root, self._tried, self._left = at, False, []
            if kind == "folder" or is_archive(at):
                self._waiting.append(_Place(place.path, "end"))
        if kind == "file" and is_archive(at):
            self._put_members(place.path)
            return None
        if kind == "file" and place.kind == "named":
            return self._opened(place.path, self._format or self._detected(place.path))
        if kind == "folder" and not any(get_reader(name).matches(at, b"") for name in reader_names()):
            self._waiting += [_Place(str(entry), "entry") for entry in sorted(at.iterdir(), reverse=True)]
            return None
        return None if kind is None else self._known(place.path)

    def _put_members(self, archive: str) -> None:
        """Put the members of an archive in line, each a recording; tell what is left out."""
        members, left = archive_members(archive)
        for path, reason in left.items():
            self._leave(path, reason)
        self._waiting += [_Place(member.path, "member") for member in reversed(members)]

    def _require_tried(self, folder: str) -> None:
        if not self._tried:
            raise DataFormatError(
                folder,
                f"no file in this {'folder' if Path(folder).is_dir() else 'archive'} is a trip that a reader "
                f"knows{' (' + '; '.join(self._left) + ')' if self._left else ''}",
                remedy="Name the files and their format.",
            )

    def _leave(self, path: str, reason: str) -> None:
        """Report what is left out, and keep the first reasons in case that nothing else is found."""
        if len(self._left) < _MOST_REASONS:
            self._left.append(printable(f"{self.label(path)}: {reason}"))
        self._report(path, reason)

    def _entry_kind(self, entry: Path) -> Literal["file", "folder"] | None:
        """Return what a folder's entry is, or None where it is left out, which is reported."""
        if entry.name.startswith("."):
            self._leave(str(entry), "hidden: name it to have it read")
            return None
        if entry.is_symlink() and entry.is_dir():
            self._leave(str(entry), "is a link to a folder: name it to have it read")
            return None
        kind = place_kind(entry) if entry.exists() else readable_kind(entry)
        if kind == "file":
            return "file"
        if kind == "folder":
            return "folder"
        self._leave(str(entry), f"is {kind}, not a file")
        return None

    def _known(self, path: str) -> Recording | None:
        """Return the recording at an entry of a folder; one that no reader knows is reported.

        The list of what modelcast wrote there is passed over.
        """
        if Path(path).name == MANIFEST:
            return None
        try:
            name = self._detected(path)
        except DataFormatError as error:
            self._leave(path, error.problem)
            return None
        if self._format not in {None, name}:
            self._leave(path, f"is {name}, not {self._format}")
            return None
        return self._opened(path, name)

    def _opened(self, path: str, name: str) -> Recording | None:
        """Return the recording with its reader, None where it is read already."""
        self._tried = True
        reader = _with_columns(get_reader(name), self._columns)
        stands_for = reader.stands_for(Path(path)).resolve()
        if stands_for in self._done:
            return None
        self._done.add(stands_for)
        return Recording(path, reader, self._report)

    def _detected(self, path: str) -> str:
        """Return a file's format; with a column map, text that no reader knows is taken for csv."""
        try:
            return detect_format(path)
        except DataFormatError:
            if self._columns is not None and Path(recording_name(path)).suffix.lower() in {".csv", ".txt"}:
                return "csv"
            raise


def _with_columns(reader: AbstractTripReader, columns: Mapping[str, str] | None) -> AbstractTripReader:
    return reader if columns is None else reader.with_columns(columns)


def _refused(path: str, error: OSError) -> DataFormatError:
    return DataFormatError(path, f"cannot be read: {error.strerror or error}")
