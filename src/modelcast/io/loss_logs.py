"""Logs of what was heard on the road, as losses to replay.

==============  =============================================================================
Format          What tells losses
==============  =============================================================================
``spmd-bsm``    ``GenTime``, ``MsgCount``, ``TxRandom`` of rows whose RxDevice is not TxDevice
``nyc-cvpd``    ``T_s``, ``msgCnt`` of the vehicles that the event's host heard
``pcap``        ``secMark``, ``msgCnt`` of the messages in a capture, pcap or pcapng
==============  =============================================================================
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from modelcast.channel.link_record import SHORTEST_PART, LinkRecord
from modelcast.channel.recorded import RecordedLosses
from modelcast.core.exceptions import DataFormatError
from modelcast.core.printable import printable
from modelcast.io.free_names import FreeNames
from modelcast.io.heard_links import HeardLinks
from modelcast.io.nyc_losses import read_event_links
from modelcast.io.pcap_losses import read_capture_links
from modelcast.io.registry import get_reader
from modelcast.io.regular import sha256_of
from modelcast.io.spmd_losses import UNCOUNTED_COLUMNS, read_bsm_links
from modelcast.io.text_head import file_head, first_lines, split_fields

__all__ = ["LOSS_FORMATS", "LossLog", "read_loss_logs"]

LOSS_FORMATS: Mapping[str, Callable[[str], HeardLinks]] = MappingProxyType(
    {"spmd-bsm": read_bsm_links, "nyc-cvpd": read_event_links, "pcap": read_capture_links}
)
"""Formats that tell what was lost, and what reads their links."""

_REMEDY = (
    "Name a log of what one vehicle heard of others, with counts of messages: BsmP1 of Safety Pilot with "
    "rows whose RxDevice is not TxDevice, an event of New York, or a capture (pcap) of what a radio heard."
)


@dataclass(frozen=True, slots=True)
class LossLog:
    """A log as losses to replay.

    Parameters
    ----------
    name
        Of its file; unlike all others of a command.
    sha256
        Of its content.
    channel
        The links that can be replayed.
    heard
        All that the log holds.
    """

    name: str
    sha256: str
    channel: RecordedLosses
    heard: HeardLinks

    def as_text(self) -> str:
        """Say what the log holds and what of it is not replayed, in one line."""
        channel, links = self.channel, self.heard.links
        bursts_s = channel.bursts_s
        text = (
            f"{self.name}: {_several(len(channel.links), 'link')}, {_several(channel.messages, 'message')}, "
            f"{100 * channel.packet_error_ratio:.3g} % lost"
        )
        if bursts_s.size:
            text += f" in bursts of {bursts_s.mean():.2g} s on average, {bursts_s.max():.3g} s at most"
        left = [
            (sum(link.unknown for link in links), "span", _unknown_s(links)),
            (sum(link.short for link in links), "part", f" under {SHORTEST_PART} messages"),
            (len(links) - len(channel.links), "link", " without a longer part"),
            (self.heard.uncounted, "message", " without time or count"),
            (self.heard.own, "log", " of own messages"),
        ]
        shown = [f"{_several(count, word)}{more}" for count, word, more in left if count]
        text += f"; not replayed: {', '.join(shown)}" if shown else ""
        return text + (f"; met: {', '.join(self.heard.skipped)}" if self.heard.skipped else "")


def _several(count: int, word: str) -> str:
    return f"{count} {word}" + ("" if count == 1 else "s")


def _unknown_s(links: Sequence[LinkRecord]) -> str:
    return f" ({sum(link.unknown_s for link in links):.3g} s) in which counts and times do not agree"


def read_loss_logs(paths: Sequence[Path]) -> list[LossLog]:
    """Read logs, each once; of two files of one name the second is called ``NAME#2``.

    Parameters
    ----------
    paths
        Files.

    Raises
    ------
    ConfigError
        Where one is missing or no ordinary file.
    DataFormatError
        Where a file cannot be read, or tells no losses.
    """
    found: dict[str, LossLog] = {}
    names = FreeNames()
    for path in paths:
        sha256 = sha256_of(path)
        if sha256 in found:
            continue
        found[sha256] = _loss_log(path, names.take(printable(path.name)), sha256)
    return list(found.values())


def _loss_log(path: Path, name: str, sha256: str) -> LossLog:
    place = str(path)
    head = file_head(place)
    if not head.strip():
        raise DataFormatError(place, "the file is empty", remedy=_REMEDY)
    columns = set(split_fields((first_lines(head) or [""])[0]))
    for column, why in UNCOUNTED_COLUMNS.items():
        if column in columns:
            raise DataFormatError(place, f"{why}, so what was lost is not told", remedy=_REMEDY)
    form = next((form for form in LOSS_FORMATS if get_reader(form).matches(path, head)), None)
    if form is None:
        raise DataFormatError(place, "does not tell which messages were lost", remedy=_REMEDY)
    heard = LOSS_FORMATS[form](place)
    usable = tuple(link for link in heard.links if link.lost.size)
    if not heard.links:
        own = (
            "holds a vehicle's own messages alone, of which none is lost" if heard.own else "holds no message"
        )
        raise DataFormatError(place, own, remedy=_REMEDY)
    if not usable:
        raise DataFormatError(
            place,
            f"no link has {SHORTEST_PART} messages in a row whose counts go on with their times",
            remedy=_REMEDY,
        )
    return LossLog(name, sha256, RecordedLosses(usable), heard)
