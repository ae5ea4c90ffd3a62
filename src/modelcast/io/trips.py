"""`read_trips`: trips from files and folders of any known format."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from modelcast.io.base import OnSkipped
from modelcast.io.recordings import Recordings
from modelcast.trips.trajectory import Trajectory

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
    some reader knows, in order of name, subfolders included, hidden ones and links to folders left out.
    Formats may differ from file to file. A file named twice is read once.

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
        Where a path does not exist or a file is not what its format says. To go on with the next file, use
        `modelcast.io.recordings.Recordings`.
    ConfigError
        Where the format is unknown or has fixed columns but a map is given.
    """
    seen: dict[str, int] = {}
    for recording in Recordings(paths, format, columns=columns, on_skipped=on_skipped):
        for trip in recording.trips():
            copies = seen[trip.trip_id] = seen.get(trip.trip_id, 0) + 1
            yield trip if copies == 1 else replace(trip, trip_id=f"{trip.trip_id}#{copies}")
