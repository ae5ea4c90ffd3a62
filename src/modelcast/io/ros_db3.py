"""ROS 2 bags as SQLite files (``*.db3``): trips of their topics with positions.

`modelcast.io.ros_bags` has the topics, the fields and what is skipped. Two tables are read:

============  ================================================  ==============================================
Table         Columns                                           Use
============  ================================================  ==============================================
``topics``    id, name, type, serialization_format              which messages are read
``messages``  id, topic_id, timestamp [ns], data                the messages, by id
============  ================================================  ==============================================

The file is opened for reading alone, and nothing that its schema could make run is run: both have to be plain
tables. A message may have `MOST_OCTETS`. A bag of several files is as many recordings; files that were packed
whole (``.db3.zstd``) have to be unpacked first. Messages that still stand in a journal beside the file
(``-wal``), as after a crash, are not read: that is told.

References
----------
github.com/ros2/rosbag2, rosbag2_storage_sqlite3.
"""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from modelcast.core.exceptions import DataFormatError
from modelcast.core.rules import shown
from modelcast.io.base import OnSkipped, ignore_skipped
from modelcast.io.holding import AbstractHoldingReader
from modelcast.io.ros_bags import AbstractBag, BagMessage, bag_trips
from modelcast.io.ros_messages import MESSAGES, message_name
from modelcast.trips.trajectory import Trajectory

__all__ = ["MOST_OCTETS", "RosDb3Reader"]

MOST_OCTETS = 64 << 20
"""Of one value in the file."""

_MAGIC = b"SQLite format 3\0"
_TABLES = {
    "topics": ("id", "name", "type", "serialization_format"),
    "messages": ("id", "topic_id", "timestamp", "data"),
}
_REMEDY = "It must be a bag that rosbag2 recorded with the storage sqlite3."
_ROWS_AT_ONCE = 1024
_MOST_TOPICS = 65_536
"""As many as an MCAP has channels."""


@dataclass(frozen=True, slots=True)
class RosDb3Reader(AbstractHoldingReader):
    """Reads SQLite files of rosbag2."""

    name: ClassVar[str] = "ros2-db3"

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether this is SQLite, with a bag's name or schema at its beginning."""
        return head.startswith(_MAGIC) and (path.suffix == ".db3" or b"serialization_format" in head)

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per topic."""
        yield from bag_trips(_SqliteBag(path), self.name, on_skipped, self.held_bytes)


@dataclass(slots=True)
class _SqliteBag(AbstractBag):
    path: str

    def messages(self) -> Iterator[BagMessage]:
        """Yield the messages of the topics that are read, and one of each other topic, without its octets."""
        with Path(self.path).open("rb") as file:
            if file.read(len(_MAGIC)) != _MAGIC:
                raise self._wrong("is no SQLite file")
        uri = f"{Path(self.path).resolve().as_uri()}?mode=ro&immutable=1"
        try:
            with closing(sqlite3.connect(uri, uri=True)) as base:
                base.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MOST_OCTETS)
                base.execute("PRAGMA trusted_schema = OFF")
                base.execute("PRAGMA cell_size_check = ON")
                base.text_factory = _text
                self._require_tables(base)
                yield from self._messages(base)
        except (sqlite3.Error, OverflowError) as error:
            raise self._wrong(f"cannot be read: {error}") from error

    def told(self) -> list[str]:
        """Whether there is a journal."""
        journal = Path(f"{self.path}-wal")
        try:
            size = journal.stat().st_size
        except OSError:
            return []
        return [f"{size} octets of a journal, {journal.name}, are not read"] if size else []

    def _require_tables(self, base: sqlite3.Connection) -> None:
        for table, columns in _TABLES.items():
            found = base.execute("SELECT type, sql FROM sqlite_master WHERE name = ?", (table,)).fetchall()
            if [kind for kind, _ in found] != ["table"] or "virtual" in str(found[0][1]).lower():
                raise self._wrong(f"has no plain table {table!r}")
            have = {str(row[1]) for row in base.execute(f"PRAGMA table_info({table})")}
            if lacks := [column for column in columns if column not in have]:
                raise self._wrong(f"its table {table!r} has no column {lacks[0]!r}")

    def _messages(self, base: sqlite3.Connection) -> Iterator[BagMessage]:
        topics: dict[int, tuple[str, str, str]] = {}
        for topic_id, *words in base.execute("SELECT id, name, type, serialization_format FROM topics"):
            if not isinstance(topic_id, int) or not all(isinstance(word, str) for word in words):
                raise self._wrong(f"its topic {shown(topic_id)} is {shown(words)}")
            topics[topic_id] = (words[0], words[1], words[2])
            if len(topics) > _MOST_TOPICS:
                raise self._wrong(f"has over {_MOST_TOPICS} topics")
        wanted = [one for one, (_, kind, _) in topics.items() if message_name(kind) in MESSAGES]
        for topic_id, (name, kind, encoding) in topics.items():
            if topic_id not in wanted:
                yield BagMessage(0, name, kind, encoding, 0, b"")
        marks = ", ".join("?" * len(wanted))
        query = f"SELECT id, topic_id, timestamp, data FROM messages WHERE topic_id IN ({marks}) ORDER BY id"  # noqa: S608 - marks alone
        rows = base.execute(query, wanted)
        while some := rows.fetchmany(_ROWS_AT_ONCE):
            for number, topic_id, t_ns, data in some:
                yield self._message(number, topics[topic_id], t_ns, data)

    def _message(self, number: Any, topic: tuple[str, str, str], t_ns: Any, data: Any) -> BagMessage:
        if not isinstance(number, int) or not isinstance(t_ns, int) or not isinstance(data, bytes):
            raise self._wrong(
                f"message {shown(number)} of {shown(topic[0])} is stored at {shown(t_ns)}, or no octets"
            )
        return BagMessage(number, *topic, t_ns, data)

    def _wrong(self, problem: str) -> DataFormatError:
        return DataFormatError(self.path, problem, remedy=_REMEDY)


def _text(octets: bytes) -> str:
    return octets.decode("utf-8", "replace")
