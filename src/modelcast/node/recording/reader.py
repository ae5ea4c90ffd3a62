"""Recordings read back, whoever wrote them: a chunk at a time, each bounded before it is unpacked.

What was cut off at the end, as by a crash, is left out and told; anything else that is no recording is an
error with its place.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self, final

from modelcast.core.exceptions import DataFormatError
from modelcast.core.json_text import parse_json
from modelcast.io.mcap_records import McapFile, McapMessage, Place
from modelcast.node.recording.topics import TOPICS

__all__ = ["RecordReader", "Recorded"]

_KNOWN = {one.name: one.schema for one in TOPICS}
_REMEDY = "It must be an MCAP that modelcast node recorded (docs/recording.md)."


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
        self.skipped: Counter[str] = Counter()
        """Messages of topics that are none of a recording, by topic."""
        self._file = McapFile(path, _REMEDY)

    @property
    def cut_off(self) -> bool:
        """Whether the end is missing, known after all was read."""
        return self._file.cut_off

    def __enter__(self) -> Self:
        """Read from the open file."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self._file.__exit__(kind, error, trace)

    def messages(self) -> Iterator[Recorded]:
        """Yield all messages in the order in which they were written.

        Raises
        ------
        DataFormatError
            Where the file is none, or holds more than is read at once.
        """
        self.skipped.clear()
        for message in self._file.messages():
            if message.topic in _KNOWN:
                yield _recorded(message)
            else:
                self.skipped[message.topic] += 1

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
        found = self._file.at(place)
        if found.topic not in _KNOWN:
            raise self._file.wrong(f"no message {place.row} of a recording at octet {place.chunk}")
        return _recorded(found)

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
        return self._file.wrong(
            f"{message.topic}, message {place.row} of the chunk at octet {place.chunk}: {error}"
        )


def _recorded(message: McapMessage) -> Recorded:
    return Recorded(message.topic, message.t_ns, message.data, message.place)
