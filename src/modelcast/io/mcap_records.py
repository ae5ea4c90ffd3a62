"""The messages of MCAP files, whoever wrote them: a record at a time, each bounded before it is unpacked.

A file is its magic, then records: an octet for the kind, eight for the length, the content; all numbers have
the low octet first. Read are

=====  ==========  =================================================================================
0x03   schema      id (2), name, encoding, data
0x04   channel     id (2), schema's id (2), topic, encoding of its messages, metadata
0x05   message     channel's id (2), sequence (4), log time (8), publish time (8), the message
0x06   chunk       first and last time (8 each), size unpacked (8), CRC-32 or 0 (4), compression,
                   the three kinds above, packed
0x0F   end of the data; what follows is an index
=====  ==========  =================================================================================

Texts are their length (4) and UTF-8. All other kinds are passed over. Chunks may be plain, zstd or lz4; the
last two need the extra ``mcap``. A file cut off at its end, as by a crash, is read as far as it goes, and
`McapFile.cut_off` is true; anything else that is no MCAP is an error with its place.

References
----------
mcap.dev: MCAP format specification, version 0.
"""

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, Self, final

from modelcast.core.exceptions import DataFormatError, MissingExtraError
from modelcast.core.rules import shown

__all__ = ["MAGIC", "MOST_CHUNK_OCTETS", "McapFile", "McapMessage", "Place"]

MAGIC = b"\x89MCAP0\r\n"
"""Octets that an MCAP begins with."""

MOST_CHUNK_OCTETS = 64 << 20
"""Of one record of the file, and of a chunk when it is unpacked."""

_LONGEST_TEXT = 1024
"""Octets of a name; names of topics in ROS have at most 255."""

_HEAD = struct.Struct("<BQ")
_MESSAGE_HEAD = struct.Struct("<HIQQ")
_CHUNK_HEAD = struct.Struct("<QQQI")
_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _DATA_END = 0x03, 0x04, 0x05, 0x06, 0x0F


@dataclass(frozen=True, slots=True)
class Place:
    """Where a message is in the file.

    Parameters
    ----------
    chunk
        Octet at which its chunk begins, or the message itself where it is in none.
    row
        Its number among the messages of the chunk, from 0.
    """

    chunk: int
    row: int


@dataclass(frozen=True, slots=True)
class McapMessage:
    """A message of a file.

    Parameters
    ----------
    topic
        Of its channel.
    schema
        Name of its channel's schema; empty where it has none.
    encoding
        Of the message, as ``cdr`` or ``json``.
    t_ns
        When it was logged [ns].
    data
        As it was written.
    place
        Where.
    """

    topic: str
    schema: str
    encoding: str
    t_ns: int
    data: bytes
    place: Place


@dataclass(frozen=True, slots=True)
class _Channel:
    topic: str
    schema_id: int
    encoding: str


@final
class McapFile:
    """One file; a context manager.

    Parameters
    ----------
    path
        The file.
    remedy
        What errors say last.

    Raises
    ------
    DataFormatError
        Where it does not begin as an MCAP.
    OSError
        Where it cannot be read.
    """

    def __init__(self, path: Path, remedy: str) -> None:
        self.path, self._remedy = path, remedy
        self.cut_off = False
        """Whether the end is missing, known after all was read."""
        self._file: BinaryIO = path.open("rb")
        self._size = path.stat().st_size
        self._channels: dict[int, _Channel] = {}
        self._schemas: dict[int, str] = {}
        if self._file.read(len(MAGIC)) != MAGIC:
            self._file.close()
            raise self.wrong("is no MCAP")

    def __enter__(self) -> Self:
        """Read from the open file."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self._file.close()

    def messages(self) -> Iterator[McapMessage]:
        """Yield all messages in the order in which they were written.

        Raises
        ------
        DataFormatError
            Where the file is none, or holds more than is read at once.
        MissingExtraError
            Where a chunk is packed in a way whose package is missing.
        """
        self.cut_off, at = False, len(MAGIC)
        while True:
            head = self._head(at)
            if head is None:
                self.cut_off = True
                return
            kind, length = head
            if kind == _DATA_END:
                return
            if kind in {_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK}:
                yield from self._of_record(kind, self._content(at, length), at)
            at += _HEAD.size + length

    def at(self, place: Place) -> McapMessage:
        """The message at a place.

        Parameters
        ----------
        place
            Of one that `messages` gave.

        Raises
        ------
        DataFormatError
            Where the file has changed since.
        """
        head = self._head(place.chunk)
        if head is not None and head[0] in {_MESSAGE, _CHUNK}:
            for one in self._of_record(head[0], self._content(place.chunk, head[1]), place.chunk):
                if one.place == place:
                    return one
        raise self.wrong(f"no message {place.row} at octet {place.chunk}")

    def wrong(self, problem: str) -> DataFormatError:
        """The error of a file with a problem.

        Parameters
        ----------
        problem
            What is wrong with it.
        """
        return DataFormatError(str(self.path), problem, remedy=self._remedy)

    def _head(self, at: int) -> tuple[int, int] | None:
        """Kind and length of the record at an octet; None where its end is missing."""
        self._file.seek(at)
        head = self._file.read(_HEAD.size)
        if len(head) < _HEAD.size:
            return None
        kind, length = _HEAD.unpack(head)
        return None if at + _HEAD.size + length > self._size else (kind, length)

    def _content(self, at: int, length: int) -> bytes:
        if length > MOST_CHUNK_OCTETS:
            raise self.wrong(
                f"a record of {length} octets at octet {at}; at most {MOST_CHUNK_OCTETS} are read"
            )
        self._file.seek(at + _HEAD.size)
        return self._file.read(length)

    def _of_record(self, kind: int, content: bytes, at: int) -> Iterator[McapMessage]:
        """Yield the messages of a record of the file, and take note of its channels."""
        if kind != _CHUNK:
            yield from self._parsed(iter([(kind, memoryview(content))]), at, f"record at octet {at}")
            return
        try:
            records = list(_split(memoryview(_unpacked(content))))
        except (ValueError, struct.error) as error:
            raise self.wrong(f"chunk at octet {at}: {error}") from error
        yield from self._parsed(iter(records), at, f"chunk at octet {at}")

    def _parsed(
        self, records: Iterator[tuple[int, memoryview]], at: int, where: str
    ) -> Iterator[McapMessage]:
        row = 0
        for kind, content in records:
            try:
                found = self._one(kind, content, Place(at, row))
            except (ValueError, struct.error) as error:
                raise self.wrong(f"{where}: {error}") from error
            if found is not None:
                row += 1
                yield found

    def _one(self, kind: int, content: memoryview, place: Place) -> McapMessage | None:
        if kind == _MESSAGE:
            channel_id, _, t_ns, _ = _MESSAGE_HEAD.unpack_from(content)
            channel = self._channels.get(channel_id)
            if channel is None:
                raise ValueError(f"no channel {channel_id}")
            schema = self._schemas.get(channel.schema_id, "")
            data = bytes(content[_MESSAGE_HEAD.size :])
            return McapMessage(channel.topic, schema, channel.encoding, t_ns, data, place)
        if kind == _CHANNEL:
            channel_id, schema_id = struct.unpack_from("<HH", content)
            topic, at = _text(content, 4)
            encoding, _ = _text(content, at)
            self._channels[channel_id] = _Channel(topic, schema_id, encoding)
        elif kind == _SCHEMA:
            self._schemas[struct.unpack_from("<H", content)[0]] = _text(content, 2)[0]
        return None


def _text(content: memoryview, at: int) -> tuple[str, int]:
    """A text, and the octet behind it."""
    (length,) = struct.unpack_from("<I", content, at)
    end = at + 4 + length
    if length > _LONGEST_TEXT or end > len(content):
        raise ValueError(
            f"a name of {length} octets in a record of {len(content)}; at most {_LONGEST_TEXT} are read"
        )
    return bytes(content[at + 4 : end]).decode(), end


def _split(content: memoryview) -> Iterator[tuple[int, memoryview]]:
    """Yield the records inside a chunk."""
    at = 0
    while at < len(content):
        kind, length = _HEAD.unpack_from(content, at)
        at += _HEAD.size
        if at + length > len(content):
            raise ValueError(f"a record of {length} octets where {len(content) - at} are left")
        yield kind, content[at : at + length]
        at += length


def _unpacked(content: bytes) -> bytes:
    """The records of a chunk, not more of them than it says, and those that it was made of."""
    _, _, size, crc = _CHUNK_HEAD.unpack_from(content)
    compression, at = _text(memoryview(content), _CHUNK_HEAD.size)
    (length,) = struct.unpack_from("<Q", content, at)
    packed = content[at + 8 : at + 8 + length]
    if len(packed) < length:
        raise ValueError(f"ends {length - len(packed)} octets early")
    if size > MOST_CHUNK_OCTETS:
        raise ValueError(f"it unpacks to {size} octets, more than {MOST_CHUNK_OCTETS}")
    if compression == "zstd":
        data = _from_zstd(packed, size)
    elif compression == "lz4":
        data = _from_lz4(packed, size)
    elif not compression:
        data = packed
    else:
        raise ValueError(f"compression {shown(compression)}; zstd, lz4 and none are read")
    if len(data) != size:
        raise ValueError(f"it does not unpack to its {size} octets")
    if crc and zlib.crc32(data) != crc:
        raise ValueError("its CRC-32 is another one: it is damaged")
    return data


def _from_zstd(packed: bytes, size: int) -> bytes:
    try:
        import zstandard  # noqa: PLC0415 - of an extra; plain files need it not
    except ImportError as error:  # pragma: no cover - the extra is installed where tests run
        raise MissingExtraError("reading an MCAP with chunks packed by zstd", "mcap") from error
    try:
        stated = zstandard.get_frame_parameters(packed).content_size
        if stated not in {size, zstandard.CONTENTSIZE_UNKNOWN}:
            raise ValueError(f"it does not unpack to its {size} octets")
        return zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
    except zstandard.ZstdError as error:
        raise ValueError(str(error)) from error


def _from_lz4(packed: bytes, size: int) -> bytes:
    try:
        import lz4.frame  # type: ignore[import-untyped]  # noqa: PLC0415 - as above
    except ImportError as error:  # pragma: no cover - the extra is installed where tests run
        raise MissingExtraError("reading an MCAP with chunks packed by lz4", "mcap") from error
    unpacker: Any = lz4.frame.LZ4FrameDecompressor()  # pyright: ignore[reportUnknownMemberType]
    try:
        data: bytes = unpacker.decompress(packed, max_length=size + 1)
    except RuntimeError as error:
        raise ValueError(str(error)) from error
    return data
