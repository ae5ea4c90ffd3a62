"""Temporary copies of packed recordings, for readers that need a file they can open and move about in.

Readers that go through a file from its beginning to its end read packed ones as they are unpacked
(`AbstractTripReader.streams`). For the others a recording is unpacked into a temporary folder, alone or with
the files beside it that share its name up to the last underscore (``drive_GT.txt``, ``drive_Input.txt``), and
removed as soon as its trips have been read.
"""

import shutil
import tempfile
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path

from modelcast.core.exceptions import DataFormatError
from modelcast.io.base import AbstractTripReader, OnSkipped
from modelcast.io.packed import archive_members, is_packed, member_of, open_octets, recording_name
from modelcast.trips.trajectory import Trajectory

__all__ = ["MOST_COPIED_BYTES", "packed_trips"]

MOST_COPIED_BYTES = 8 * 2**30
"""Octets that a temporary copy may take."""

_PIECE_BYTES = 2**20


def packed_trips(reader: AbstractTripReader, path: str, on_skipped: OnSkipped) -> Iterator[Trajectory]:
    """Yield the trips of a recording that may be packed.

    Parameters
    ----------
    reader
        The reader of its format.
    path
        A file or folder, or a member of an archive.
    on_skipped
        As for readers.

    Raises
    ------
    DataFormatError
        Where it is not what its format says, cannot be unpacked, or takes too much room.
    """
    if Path(path).is_dir() or not is_packed(path) or reader.streams:
        yield from reader.read(path, on_skipped)
        return
    with _copied(path) as copy:
        folder, place = str(copy.parent), str(Path(path).parent)
        try:
            yield from reader.read(str(copy), lambda what, why: on_skipped(what.replace(folder, place), why))
        except DataFormatError as error:
            named = path if error.path == str(copy) else error.path.replace(folder, place)
            raise DataFormatError(
                named, error.problem.replace(folder, place), row=error.row, remedy=error.remedy
            ) from error


@contextmanager
def _copied(path: str) -> Generator[Path]:
    """Unpack a recording, and what belongs to it, as long as it is needed."""
    with tempfile.TemporaryDirectory(prefix="modelcast-") as folder:
        left = MOST_COPIED_BYTES
        for part in (path, *_companions(path)):
            left = _unpack(part, Path(folder) / recording_name(part), left)
        yield Path(folder) / recording_name(path)


def _companions(path: str) -> list[str]:
    """Return the members beside one that share its name up to the last underscore."""
    member = member_of(path)
    shared, mark, _ = recording_name(path).rpartition("_")
    if member is None or not mark:
        return []
    folder = member.name.rpartition("/")[0]
    return [
        other.path
        for other in archive_members(member.archive)[0]
        if other != member
        and other.name.rpartition("/")[0] == folder
        and recording_name(other.name).rpartition("_")[0] == shared
    ]


def _unpack(path: str, to: Path, left: int) -> int:
    """Unpack one file, and return how many octets are left for others."""
    room = min(left, shutil.disk_usage(to.parent).free)
    with open_octets(path) as packed, to.open("wb") as out:
        while piece := packed.read(_PIECE_BYTES):
            left, room = left - len(piece), room - len(piece)
            if room < 0:
                raise DataFormatError(
                    path,
                    f"takes over {MOST_COPIED_BYTES / 2**30:,.0f} GiB unpacked, or more than is free for it",
                    remedy="Unpack it yourself and name what it holds.",
                )
            out.write(piece)
    return left
