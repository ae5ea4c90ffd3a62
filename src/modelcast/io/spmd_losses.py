"""Lost messages of Safety Pilot logs (``BsmP1``), one-day and two-month releases.

A link is one transmitter heard by one receiver in one file of it: (RxDevice, FileId, TxDevice). ``GenTime``
and ``MsgCount`` of what was heard tell what was not; where ``TxRandom`` changes, after 3,000 messages, the
count jumps. Rows in which RxDevice is TxDevice are a vehicle's own messages, heard over no radio.

The release's other files of received messages do not tell what was lost: ``DataRv`` repeats messages over
rows and has no counts, ``RV_RX`` has neither counts nor the messages' own times, and the times of ``RSE_BSM``
are those within a minute.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from modelcast.channel.link_record import COUNTS, counted_link
from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.io.heard_links import HeardLinks
from modelcast.io.spmd import Key, open_spmd
from modelcast.io.spmd_bsm import BSM_LAYOUT
from modelcast.io.text_blocks import number_column

__all__ = ["UNCOUNTED_COLUMNS", "read_bsm_links"]

UNCOUNTED_COLUMNS: Mapping[str, str] = MappingProxyType(
    {
        "RvDevice": "DataRv has no counts of messages",
        "RV_ID": "RV_RX has no counts of messages",
        "BSMID": "RSE_BSM has times within a minute alone",
    }
)
"""Why the release's other files of received messages tell no losses, by a column that each alone has."""

_NUMBERS = ("GenTime", "TxRandom", "MsgCount")
_NO_EPOCH = -(2**31)
"""Stands for a TxRandom that is not there: it is a number of 16 bits."""


@dataclass(slots=True)
class _Heard:
    """Messages of one link, block by block."""

    time: list[FloatArray] = field(default_factory=list[FloatArray])
    epoch: list[IntArray] = field(default_factory=list[IntArray])
    count: list[IntArray] = field(default_factory=list[IntArray])


def read_bsm_links(path: str) -> HeardLinks:
    """The links of a ``BsmP1`` file, in order of appearance; it is read once, 24 octets a message are held.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    DataFormatError
        Where the file is no BsmP1, or a count is no whole number of 0 to 127.
    """
    file = open_spmd(path, replace(BSM_LAYOUT, numbers=_NUMBERS))
    heard: dict[Key, _Heard] = {}
    own: set[Key] = set()
    uncounted = 0
    for block in file.blocks((*file.layout.keys, *_NUMBERS)):
        keys, number = file.block_keys(block)
        time, epoch, count = (number_column(path, block, file.at[name], name) for name in _NUMBERS)
        mine = np.array([receiver == sender for receiver, _, sender in keys], dtype=np.bool_)
        others: BoolArray = ~mine[number]
        _check_counts(path, count[others], block.line[others])
        usable: BoolArray = np.isfinite(count) & (time > 0.0)
        uncounted += int((others & ~usable).sum())
        # Rows by their keys, those of no use behind all.
        place = np.where(usable, number, len(keys))
        order = np.argsort(place, kind="stable")
        bounds = np.searchsorted(place[order], np.arange(len(keys) + 1))
        for at, key in enumerate(keys):
            if mine[at]:
                own.add(key)
                continue
            rows = order[bounds[at] : bounds[at + 1]]
            link = heard.setdefault(key, _Heard())
            link.time.append(time[rows])
            link.epoch.append(np.where(np.isfinite(epoch[rows]), epoch[rows], _NO_EPOCH).astype(np.int64))
            link.count.append(count[rows].astype(np.int64))
    links = [
        counted_link(
            f"{receiver} hears {sender}, file {file_id}",
            # Since the first message: 100 ns of a time since 2004 in seconds would be lost.
            _since_first(np.concatenate(link.time)) * BSM_LAYOUT.time_unit_s,
            np.concatenate(link.count),
            epoch=np.concatenate(link.epoch),
        )
        for (receiver, file_id, sender), link in heard.items()
    ]
    return HeardLinks(links, len(own), uncounted)


def _since_first(time: FloatArray) -> FloatArray:
    return time - time[0] if time.size else time


def _check_counts(path: str, count: FloatArray, line: IntArray) -> None:
    bad = np.isfinite(count) & ~((count >= 0) & (count < COUNTS) & (count == np.floor(count)))
    if bad.any():
        at = int(np.argmax(bad))
        raise DataFormatError(
            path,
            f"MsgCount is {count[at]:g}, not a whole number of 0 to {COUNTS - 1}",
            row=int(line[at]),
            remedy="Correct the value, or leave the cell blank where it is not known.",
        )
