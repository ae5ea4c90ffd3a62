"""`read_trips`: trips from files and folders of any known format."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from modelcast.core.exceptions import DataFormatError
from modelcast.core.trajectory import Trajectory
from modelcast.io.base import AbstractTripReader, OnSkipped, ignore_skipped
from modelcast.io.registry import detect_format, get_reader, reader_names

__all__ = ["read_trips"]


def read_trips(
    paths: str | Path | Iterable[str | Path],
    format: str | None = None,  # noqa: A002 - the word a user would type
    *,
    columns: Mapping[str, str] | None = None,
    on_skipped: OnSkipped | None = None,
) -> Iterator[Trajectory]:
    """Yield the trips of files and folders, one at a time, in the order given.

    A folder that a reader knows is one recording (comma2k19); of any other folder the files are read that
    some reader knows, in order of name, subfolders included. Formats may differ from file to file.

    Parameters
    ----------
    paths
        A file, a folder, or several of them.
    format
        Name of the format (`modelcast.io.registry.reader_names`); found from the content where None.
    columns
        Column names for csv and parquet, by meaning, as in ``{"t": "time", "east": "x", "north": "y"}``.
    on_skipped
        Called with what gave no trip (a vehicle's identifier, a file in a folder) and the reason.

    Yields
    ------
    Trajectory
        One vehicle's trip. Where two would share an identifier, the later gets ``#2``, ``#3``, ...

    Raises
    ------
    DataFormatError
        Where a path does not exist or a file is not what its format says.
    ConfigError
        Where the format is unknown or has fixed columns but a map is given.
    """
    report = ignore_skipped if on_skipped is None else on_skipped
    seen: dict[str, int] = {}
    for path, reader in _recordings(paths, format, report, mapped=columns is not None):
        chosen = reader if columns is None else reader.with_columns(columns)
        for trip in _read(chosen, path, report):
            copies = seen[trip.trip_id] = seen.get(trip.trip_id, 0) + 1
            yield trip if copies == 1 else replace(trip, trip_id=f"{trip.trip_id}#{copies}")


def _read(reader: AbstractTripReader, path: str, report: OnSkipped) -> Iterator[Trajectory]:
    """Yield a recording's trips; what the operating system refuses is an error of the file."""
    try:
        yield from reader.read(path, report)
    except OSError as error:
        raise DataFormatError(path, f"cannot be read: {error.strerror or error}") from error


def _recordings(
    paths: str | Path | Iterable[str | Path], format_name: str | None, report: OnSkipped, *, mapped: bool
) -> Iterator[tuple[str, AbstractTripReader]]:
    """Yield every recording once, with its reader."""
    given = [paths] if isinstance(paths, str | Path) else list(paths)
    done: set[Path] = set()
    for path in given:
        if not Path(path).exists():
            raise DataFormatError(str(path), "does not exist", remedy="Check the path.")
        for found, reader in _expanded(path, format_name, report, mapped=mapped):
            stands_for = reader.stands_for(Path(found)).resolve()
            if stands_for not in done:
                done.add(stands_for)
                yield found, reader


def _expanded(
    path: str | Path, format_name: str | None, report: OnSkipped, *, mapped: bool
) -> Iterator[tuple[str, AbstractTripReader]]:
    """Yield the recordings under one path."""
    at = Path(path)
    if at.is_file():
        yield str(path), get_reader(format_name or _detected(path, mapped=mapped))
        return
    if format_name is not None:
        get_reader(format_name)
    found = False
    for entry in _entries(at):
        try:
            name = _detected(entry, mapped=mapped)
        except DataFormatError as error:
            report(str(entry), error.problem)
            continue
        if format_name in {None, name}:
            found = True
            yield str(entry), get_reader(name)
        else:
            report(str(entry), f"is {name}, not {format_name}")
    if not found:
        raise DataFormatError(
            str(path),
            "no file in this folder is a trip that a reader knows",
            remedy="Name the files and their format.",
        )


def _entries(folder: Path) -> Iterator[Path]:
    """Yield the folder itself where it is one recording, else the files and recordings in it."""
    if any(get_reader(name).matches(folder, b"") for name in reader_names()):
        yield folder
        return
    for entry in sorted(folder.iterdir()):
        if entry.is_file():
            yield entry
        elif entry.is_dir() and not entry.is_symlink():
            yield from _entries(entry)


def _detected(path: str | Path, *, mapped: bool) -> str:
    """Return a file's format; with a column map, text that no reader knows is taken for csv."""
    try:
        return detect_format(path)
    except DataFormatError:
        if mapped and Path(path).suffix.lower() in {".csv", ".txt"}:
            return "csv"
        raise
