"""Packed recordings: ``.gz`` files, and the members of ``.zip`` archives, read as what they hold.

A member of an archive has the archive's path with its own behind it, ``drives.zip/day 1/a.csv``; anything
that opens a recording takes such a path. gzip is told by its first octets, an archive by its suffix and its
first octets, and a member may be packed by gzip again.

What is unpacked is counted while it is: more than `MOST_RATIO` octets for each packed one (behind the first
`FREE_BYTES`) is an error, whatever the file says of itself. Encrypted members, methods other than deflate,
damage and an early end are errors too.
"""

import gzip
import io
import zipfile
import zlib
from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, cast

from modelcast.core.exceptions import DataFormatError

__all__ = [
    "FREE_BYTES",
    "MOST_MEMBERS",
    "MOST_RATIO",
    "Member",
    "archive_members",
    "is_archive",
    "is_packed",
    "is_there",
    "member_of",
    "open_octets",
    "recording_name",
    "recording_stem",
]

MOST_RATIO = 250
"""Octets that a packed one may stand for; drives recorded as text reach 20."""

FREE_BYTES = 64 * 2**20
"""So many may come whatever the ratio."""

MOST_MEMBERS = 10_000
"""Members of one archive."""

_GZIP = b"\x1f\x8b"
_ZIP = b"PK"
_SUFFIX = ".zip"
_DAMAGED = (EOFError, zlib.error, zipfile.BadZipFile, gzip.BadGzipFile)
_REMEDY = "Pack it by deflate, or unpack it first."
_END, _END_BYTES, _COMMENT_BYTES = b"PK\x05\x06", 22, 65535
_LISTED_BYTES = 2**16
"""The longest entry of an archive's list that is thought of, to bound the list before it is read."""


@dataclass(frozen=True, slots=True)
class Member:
    """A place in an archive.

    Parameters
    ----------
    archive
        The archive's path.
    name
        The member's name in it.
    """

    archive: str
    name: str

    @property
    def path(self) -> str:
        """How it is called."""
        return f"{self.archive}/{self.name}"


def is_archive(path: str | Path) -> bool:
    """Return whether a path leads to a zip archive.

    Parameters
    ----------
    path
        As the user named it.
    """
    at = Path(path)
    if at.suffix.lower() != _SUFFIX or not at.is_file():
        return False
    with at.open("rb") as file:
        return file.read(2) == _ZIP


def member_of(path: str | Path) -> Member | None:
    """Return the member that a path names, None where it names none; it need not be there.

    Parameters
    ----------
    path
        Any path.
    """
    text = path.as_posix() if isinstance(path, Path) else path
    at = text.lower().find(_SUFFIX + "/")
    while at >= 0:
        archive = text[: at + len(_SUFFIX)]
        if is_archive(archive):
            return Member(archive, text[at + len(_SUFFIX) + 1 :])
        at = text.lower().find(_SUFFIX + "/", at + 1)
    return None


def is_there(path: str | Path) -> bool:
    """Return whether a path leads to something: on disk, or in an archive.

    Parameters
    ----------
    path
        Any path.
    """
    member = member_of(path)
    if member is None:
        return Path(path).exists()
    with _archive(member.archive) as archive:
        return member.name in archive.namelist()


def is_packed(path: str | Path) -> bool:
    """Return whether a recording has to be unpacked: a member of an archive, or a file that begins as gzip.

    Parameters
    ----------
    path
        A file, or a member of an archive.
    """
    if member_of(path) is not None:
        return True
    with Path(path).open("rb") as file:
        return file.read(2) == _GZIP


def recording_name(path: str | Path) -> str:
    """Return the name of a recording's file without its folders and without ``.gz``.

    Parameters
    ----------
    path
        A file, or a member of an archive.
    """
    name = Path(path).name
    return name[:-3] if name.lower().endswith(".gz") else name


def recording_stem(path: str | Path) -> str:
    """Return what the identifiers of a recording's trips begin with.

    Parameters
    ----------
    path
        A file, or a member of an archive.

    Examples
    --------
    >>> recording_stem("drives.zip/day 1/a.csv.gz"), recording_stem("a.csv")
    ('a', 'a')
    """
    return Path(recording_name(path)).stem


def archive_members(path: str | Path) -> tuple[list[Member], dict[str, str]]:
    """Return the members of an archive that may be recordings, by name, and why others are none, by path.

    Parameters
    ----------
    path
        The archive.

    Raises
    ------
    DataFormatError
        Where it cannot be read, holds too many members, or all are encrypted.
    """
    found: list[Member] = []
    left: dict[str, str] = {}
    encrypted = 0
    with _archive(str(path)) as archive:
        for info in sorted(archive.infolist(), key=lambda info: info.filename):
            member = Member(str(path), info.filename)
            parts = info.filename.split("/")
            if info.is_dir():
                continue
            if info is not archive.getinfo(info.filename):
                left[member.path] = "several members have this name: only the last of them is read"
            elif info.flag_bits & 1:
                encrypted += 1
                left[member.path] = "is encrypted: unpack it with its password"
            elif any(part.startswith(".") for part in parts) or parts[0] == "__MACOSX":
                left[member.path] = "hidden: unpack it to have it read"
            elif parts[-1].lower().endswith(_SUFFIX):
                left[member.path] = "is an archive in an archive: unpack the outer one"
            else:
                found.append(member)
    if encrypted and not found:
        raise DataFormatError(str(path), "is encrypted", remedy="Unpack it with its password.")
    return found, left


@contextmanager
def open_octets(path: str | Path) -> Generator[BinaryIO]:
    """Open a recording for reading octets, unpacked where it is packed.

    What cannot be unpacked is a DataFormatError while it is read.

    Parameters
    ----------
    path
        A file, or a member of an archive.
    """
    name = str(path)
    member = member_of(name)
    with ExitStack() as stack:
        if member is None:
            file: Any = stack.enter_context(Path(path).open("rb"))
            if file.peek(2)[:2] != _GZIP:
                yield file
                return
            packed = Path(path).stat().st_size
        else:
            file, packed = _opened_member(stack, member)
            if file.peek(2)[:2] != _GZIP:
                yield file
                return
        unzipped = stack.enter_context(gzip.GzipFile(fileobj=file, mode="rb"))
        yield cast("BinaryIO", stack.enter_context(_buffered(_Unpacked(name, unzipped, packed))))


def _opened_member(stack: ExitStack, member: Member) -> "tuple[io.BufferedReader, int]":
    """Return a member open for reading, and its packed octets."""
    archive = stack.enter_context(_archive(member.archive))
    try:
        info = archive.getinfo(member.name)
        if info.flag_bits & 1:
            raise DataFormatError(member.path, "is encrypted", remedy="Unpack it with its password.")
        if info.compress_type not in {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}:
            raise DataFormatError(
                member.path, f"is packed by method {info.compress_type}, not deflate", remedy=_REMEDY
            )
        opened = stack.enter_context(archive.open(info))
    except KeyError as error:
        raise DataFormatError(member.path, "is not in the archive", remedy="Check the path.") from error
    except (*_DAMAGED, NotImplementedError, RuntimeError) as error:
        raise DataFormatError(member.path, f"cannot be unpacked: {error}", remedy=_REMEDY) from error
    packed = info.compress_size
    return stack.enter_context(_buffered(_Unpacked(member.path, opened, packed))), packed


def _buffered(raw: "_Unpacked") -> io.BufferedReader:
    return io.BufferedReader(raw, 2**17)


class _Unpacked(io.RawIOBase):
    """What comes out of a packed stream, counted; damage and excess are errors of a reader."""

    def __init__(self, path: str, stream: Any, packed: int) -> None:
        self._path, self._stream, self._packed = path, stream, packed
        self._come = 0

    def readable(self) -> bool:
        """Return true."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Read some octets."""
        view = memoryview(buffer)
        try:
            octets: bytes = self._stream.read(len(view))
        except _DAMAGED as error:
            raise DataFormatError(
                self._path, f"cannot be unpacked: {error}", remedy="It is damaged or cut short: get it again."
            ) from error
        self._come += len(octets)
        if self._come > max(FREE_BYTES, MOST_RATIO * self._packed):
            raise DataFormatError(
                self._path,
                f"unpacks to over {self._come:,} octets from {self._packed:,}, {MOST_RATIO} times as many",
                remedy="No recorded drive does that; unpack it yourself where it is one.",
            )
        view[: len(octets)] = octets
        return len(octets)


@contextmanager
def _archive(path: str) -> Generator[zipfile.ZipFile]:
    """Open an archive whose list of members is of a size that archives of recordings have."""
    try:
        with Path(path).open("rb") as file:
            listed = _listed(file)
            if listed > MOST_MEMBERS:
                raise DataFormatError(
                    path, f"holds {listed:,} members or a list as long, more than {MOST_MEMBERS:,}",
                    remedy="Unpack it into a folder.",
                )  # fmt: skip
            archive = zipfile.ZipFile(file)
            if len(archive.infolist()) > MOST_MEMBERS:
                raise DataFormatError(
                    path, f"holds over {MOST_MEMBERS:,} members", remedy="Unpack it into a folder."
                )
            with archive:
                yield archive
    except (*_DAMAGED, NotImplementedError) as error:
        raise DataFormatError(
            path, f"is no archive that can be read: {error}", remedy="Check that it is complete."
        ) from error


def _listed(file: BinaryIO) -> int:
    """Return how many members an archive says it has; nothing of its list is read."""
    size = file.seek(0, 2)
    file.seek(max(size - _END_BYTES - _COMMENT_BYTES, 0))
    tail = file.read()
    file.seek(0)
    at = tail.rfind(_END)
    if at < 0 or len(tail) - at < _END_BYTES:
        return 0  # no archive, as reading it will say
    members = int.from_bytes(tail[at + 10 : at + 12], "little")
    octets = int.from_bytes(tail[at + 12 : at + 16], "little")
    return max(members, octets // _LISTED_BYTES)
