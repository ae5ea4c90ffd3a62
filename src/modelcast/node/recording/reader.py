"""Recordings read back, whoever wrote them: a chunk at a time, each bounded before it is unpacked.

What was cut off at the end, as by a crash, is left out and told; anything else that is no recording is an
error with its place.
"""

import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, Self, final

from modelcast.core.exceptions import DataFormatError, MissingExtraError
from modelcast.core.json_text import parse_json
from modelcast.core.rules import shown
from modelcast.node.recording.topics import TOPICS

try:
    import zstandard
    from mcap.data_stream import ReadDataStream
    from mcap.exceptions import McapError
    from mcap.opcode import Opcode
    from mcap.records import Channel, Chunk, Message
    from mcap.stream_reader import breakup_chunk
except ImportError as error:  # pragma: no cover - the extra is installed where tests run
    raise MissingExtraError("reading a recording", "node") from error

__all__ = ["MAGIC", "MOST_CHUNK_OCTETS", "Place", "RecordReader", "Recorded"]

MAGIC = b"\x89MCAP0\r\n"
"""Octets that an MCAP begins with."""

MOST_CHUNK_OCTETS = 64 << 20
"""Of one record of the file, and of a chunk when it is unpacked."""

_KNOWN = {one.name: one.schema for one in TOPICS}
_HEAD = struct.Struct("<BQ")
_REMEDY = "It must be an MCAP that modelcast node recorded (docs/recording.md)."
_BROKEN = (McapError, zstandard.ZstdError, struct.error, ValueError, OverflowError)


@dataclass(frozen=True, slots=True)
class Place:
    """Where a message is in the file.

    Parameters
    ----------
    chunk
        Octet at which its chunk begins.
    row
        Its number among the messages of the chunk.
    """

    chunk: int
    row: int


@dataclass(frozen=True, slots=True)
class Recorded:
    """A message of a recording.

    Parameters
    ----------
    topic
        A name of `modelcast.node.recording.topics.TOPICS`.
    t_ns
        Since 1970 [ns].
    data
        As it was written.
    place
        Where.
    """

    topic: str
    t_ns: int
    data: bytes
    place: Place


@final
class RecordReader:
    """One recording; a context manager.

    Parameters
    ----------
    path
        The MCAP.

    Raises
    ------
    DataFormatError
        Where it does not begin as one.
    OSError
        Where it cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.cut_off = False
        """Whether the end is missing, known after all was read."""
        self.skipped: Counter[str] = Counter()
        """Messages of topics that are none of a recording, by topic."""
        self._file: BinaryIO = path.open("rb")
        self._size = path.stat().st_size
        self._channels: dict[int, str] = {}
        if self._file.read(len(MAGIC)) != MAGIC:
            self._file.close()
            raise DataFormatError(str(path), "is no MCAP", remedy=_REMEDY)

    def __enter__(self) -> Self:
        """Read from the open file."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self._file.close()

    def messages(self) -> Iterator[Recorded]:
        """Yield all messages in the order in which they were written.

        Raises
        ------
        DataFormatError
            Where the file is none, or holds more than is read at once.
        """
        self.cut_off, at = False, len(MAGIC)
        self.skipped.clear()
        while True:
            found = self._record(at)
            if found is None:
                self.cut_off = True
                return
            kind, content = found
            if kind == Opcode.DATA_END:
                return
            if kind == Opcode.CHUNK:
                yield from self._unpacked(content, at)
            elif kind == Opcode.MESSAGE:
                raise self._wrong(f"a message outside a chunk at octet {at}")
            at += _HEAD.size + len(content)

    def at(self, place: Place) -> Recorded:
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
        found = self._record(place.chunk)
        if found is not None and found[0] == Opcode.CHUNK:
            for one in self._unpacked(found[1], place.chunk):
                if one.place == place:
                    return one
        raise self._wrong(f"no message {place.row} at octet {place.chunk}")

    def words(self, message: Recorded) -> Any:
        """What a message says, plain values of JSON.

        Parameters
        ----------
        message
            One of this file.

        Raises
        ------
        DataFormatError
            Where it is no JSON.
        """
        try:
            return parse_json(message.data.decode())
        except ValueError as error:
            raise self.wrong(message, error) from error

    def wrong(self, message: Recorded, error: ValueError) -> DataFormatError:
        """The error of a message that is not what its topic says.

        Parameters
        ----------
        message
            Which.
        error
            What is wrong with it.
        """
        place = message.place
        return self._wrong(
            f"{message.topic}, message {place.row} of the chunk at octet {place.chunk}: {error}"
        )

    def _record(self, at: int) -> tuple[int, bytes] | None:
        """Kind and content of the record at an octet; None where its end is missing."""
        self._file.seek(at)
        head = self._file.read(_HEAD.size)
        if len(head) < _HEAD.size:
            return None
        kind, length = _HEAD.unpack(head)
        if at + _HEAD.size + length > self._size:
            return None
        if length > MOST_CHUNK_OCTETS:
            raise self._wrong(
                f"a record of {length} octets at octet {at}; at most {MOST_CHUNK_OCTETS} are read"
            )
        return kind, self._file.read(length)

    def _unpacked(self, content: bytes, at: int) -> Iterator[Recorded]:
        try:
            chunk = Chunk.read(ReadDataStream(BytesIO(content)))
            size = chunk.uncompressed_size
            if size > MOST_CHUNK_OCTETS:
                raise ValueError(f"it unpacks to {size} octets, more than {MOST_CHUNK_OCTETS}")
            if chunk.compression not in {"", "zstd"}:
                raise ValueError(f"compression {shown(chunk.compression)}; zstd and none are read")
            if chunk.compression and zstandard.get_frame_parameters(chunk.data).content_size != size:
                raise ValueError(f"it does not unpack to its {size} octets")
            records = breakup_chunk(chunk, validate_crc=True)
        except _BROKEN as error:
            raise self._wrong(f"chunk at octet {at}: {str(error) or type(error).__name__}") from error
        row = 0
        for record in records:
            if isinstance(record, Channel):
                self._channels[record.id] = record.topic
            elif isinstance(record, Message):
                topic = self._channels.get(record.channel_id)
                if topic is None:
                    raise self._wrong(f"chunk at octet {at}: no channel {record.channel_id}")
                if topic in _KNOWN:
                    yield Recorded(topic, record.log_time, record.data, Place(at, row))
                else:
                    self.skipped[topic] += 1
                row += 1

    def _wrong(self, problem: str) -> DataFormatError:
        return DataFormatError(str(self.path), problem, remedy=_REMEDY)
