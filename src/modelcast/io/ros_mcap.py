"""ROS 2 bags as MCAP files (``*.mcap``): trips of their topics with positions.

`modelcast.io.ros_bags` has the topics, the fields and what is skipped, `modelcast.io.mcap_records` the
records of a file. Chunks packed by zstd or lz4 need the extra ``mcap``. A bag of several files is as many
recordings.
What ``modelcast node`` records is an MCAP too, but no bag: it is for ``modelcast replay``.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from modelcast.io.base import OnSkipped, ignore_skipped
from modelcast.io.holding import AbstractHoldingReader
from modelcast.io.mcap_records import MAGIC, McapFile
from modelcast.io.ros_bags import AbstractBag, BagMessage, bag_trips
from modelcast.trips.trajectory import Trajectory

__all__ = ["RosMcapReader"]


@dataclass(frozen=True, slots=True)
class RosMcapReader(AbstractHoldingReader):
    """Reads MCAP files of ROS 2."""

    name: ClassVar[str] = "ros2-mcap"

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether it begins as an MCAP."""
        del path
        return head.startswith(MAGIC)

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per topic."""
        yield from bag_trips(_McapBag(path), self.name, on_skipped, self.held_bytes)


@dataclass(slots=True)
class _McapBag(AbstractBag):
    path: str
    cut_off: bool = False

    def messages(self) -> Iterator[BagMessage]:
        """Yield the messages of the file."""
        with McapFile(Path(self.path), "A bag of ROS 2 is read, as rosbag2 records it.") as file:
            for number, one in enumerate(file.messages(), start=1):
                yield BagMessage(number, one.topic, one.schema, one.encoding, one.t_ns, one.data)
            self.cut_off = file.cut_off

    def told(self) -> list[str]:
        """Whether the end is missing."""
        return ["the end of the file is missing: it was read as far as it goes"] if self.cut_off else []
