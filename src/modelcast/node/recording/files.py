"""The two files of a recording: an MCAP and a capture, each readable after whatever was written last.

Both are written without a buffer of their own, a whole record or chunk at a time. Where the disk refuses in
the midst of one, the file is cut back to the last that is whole.
"""

import struct
import time
from collections.abc import Sequence
from pathlib import Path
from typing import final

from modelcast.core.exceptions import MissingExtraError
from modelcast.io.pcap import pcap_octets
from modelcast.node.recording.topics import TOPICS, Topic

try:
    from mcap.writer import CompressionType, Writer
except ImportError as error:  # pragma: no cover - the extra is installed where tests run
    raise MissingExtraError("recording", "node") from error

__all__ = ["RecordingFiles", "recorded_octets"]

_SUFFIXES = (".mcap", ".pcap")
_END = struct.pack("<BQI", 0x0F, 4, 0) + struct.pack("<BQQQI", 0x02, 20, 0, 0, 0) + b"\x89MCAP0\r\n"
"""An MCAP's records DataEnd and Footer for a file without a summary, and the magic behind them."""
_SUMMARY_OCTETS = 8192
_INDEX_OCTETS = 400
"""Room that the summary takes at the end: schemas and channels, and for every chunk its index."""
_CHUNK_OCTETS = 1 << 20


def recorded_octets(folder: Path) -> int:
    """How much recordings take in a folder.

    Parameters
    ----------
    folder
        Where recordings are written.
    """
    return sum(one.stat().st_size for one in folder.iterdir() if one.suffix in _SUFFIXES)


@final
class _File:
    """A new file that knows how much of it is whole."""

    def __init__(self, path: Path) -> None:
        self._raw = path.open("xb", buffering=0)
        self._at = self.whole = 0

    def write(self, data: bytes) -> int:
        """Write all of it, or raise `OSError`."""
        left = memoryview(data)
        while left:
            count = self._raw.write(left)
            self._at += count
            left = left[count:]
        return len(data)

    def tell(self) -> int:
        """Octets written so far."""
        return self._at

    def flush(self) -> None:
        """Nothing waits: all is written; what is there is whole now."""
        self.whole = self._at

    def cut_back(self) -> None:
        """Leave only what is whole."""
        self._raw.truncate(self.whole)
        self._raw.seek(self.whole)
        self._at = self.whole

    def close(self) -> None:
        """Let go."""
        self._raw.close()


@final
class RecordingFiles:
    """Writes one recording.

    Parameters
    ----------
    folder
        Where; it must exist.
    utc_s
        When it begins, since 1970 [s]: the files are named by it.
    most_octets
        Of both files together.

    Raises
    ------
    OSError
        Where they cannot be made.
    """

    def __init__(self, folder: Path, utc_s: float, *, most_octets: float) -> None:
        stem = folder / time.strftime("modelcast-%Y%m%dT%H%M%SZ", time.gmtime(utc_s))
        number = 1
        while True:
            self.path = stem.with_name(stem.name + (f"-{number}" if number > 1 else "") + ".mcap")
            try:
                self._mcap = _File(self.path)
                break
            except FileExistsError:
                number += 1
        self._most, self._waiting, self._chunks = most_octets, 0, 0
        self._frames: list[tuple[int, bytes]] = []
        self._channels: dict[str, int] = {}
        try:
            self._pcap = _File(self.path.with_suffix(".pcap"))
        except OSError:
            self._mcap.close()
            raise
        self._writer = Writer(self._mcap, chunk_size=_CHUNK_OCTETS, compression=CompressionType.ZSTD)  # type: ignore[arg-type]
        self._begun = False

    @property
    def octets(self) -> int:
        """Written so far."""
        return self._mcap.tell() + self._pcap.tell()

    def has_room(self, octets: int) -> bool:
        """Whether so much more may come before the quota is reached.

        Parameters
        ----------
        octets
            Of messages and frames to add.
        """
        end = _SUMMARY_OCTETS + _INDEX_OCTETS * (self._chunks + 2)
        return self.octets + self._waiting + octets + end <= self._most

    def add(self, topic: Topic, t_ns: int, text: str) -> None:
        """Add a message; it is in the file after the next `flush`.

        Parameters
        ----------
        topic
            Of it.
        t_ns
            Since 1970 [ns].
        text
            What it says, JSON.

        Raises
        ------
        OSError
            Where the disk is full.
        """
        self._begin()
        data = text.encode()
        self._waiting += len(data) + 64
        self._writer.add_message(self._channels[topic.name], max(t_ns, 0), data, max(t_ns, 0))

    def add_frames(self, frames: Sequence[tuple[int, bytes]]) -> None:
        """Add frames to the capture.

        Parameters
        ----------
        frames
            Since 1970 [ns], and octets.
        """
        self._frames += frames
        self._waiting += sum(len(octets) + 30 for _, octets in frames)

    def flush(self) -> None:
        """Bring everything into the files.

        Raises
        ------
        OSError
            Where the disk is full.
        """
        self._begin()
        self._writer.flush()
        pieces = pcap_octets(self._frames)
        head = next(pieces)
        if self._pcap.tell() == 0:
            self._pcap.write(head)
        self._pcap.write(b"".join(pieces))
        self._pcap.flush()
        self._frames, self._waiting = [], 0
        self._chunks += 1

    def finish(self) -> None:
        """End both files with all that was added, the MCAP with its summary, and close them.

        Raises
        ------
        OSError
            Where the disk is full; call `give_up` then.
        """
        self.flush()
        self._writer.finish()
        self._close()

    def give_up(self) -> None:
        """After an `OSError`: leave in the files what is whole, and close them; raises nothing."""
        for file, end in ((self._mcap, _END), (self._pcap, b"")):
            try:
                file.cut_back()
                file.write(end if file.tell() else b"")
                file.flush()
            except OSError:
                pass
        self._close()

    def _begin(self) -> None:
        if self._begun:
            return
        self._begun = True
        self._writer.start(profile="", library="modelcast")
        for topic in TOPICS:
            schema = self._writer.register_schema(topic.schema, "jsonschema", topic.document.encode())
            self._channels[topic.name] = self._writer.register_channel(topic.name, "json", schema)

    def _close(self) -> None:
        self._mcap.close()
        self._pcap.close()
