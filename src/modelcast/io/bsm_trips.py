"""Trips out of logged basic safety messages: what the readers share whose files are messages of many senders.

A log gives a row a message (`BsmRow`); here rows become blocks that can be gathered by sender, codes become
SI units, marks in the minute become instants, and what a sender said becomes a trip.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin, wrap_angle_rad
from modelcast.io.base import OnSkipped, Tally
from modelcast.io.bsm_values import CORE_COLUMNS, core_in_si, first_wrong_code, instants_ms
from modelcast.io.gathered_trips import TripRows, UsableRows, first_origin, placed_on_earth, trips_of
from modelcast.io.gathering import AbstractKeyedRows, KeyedBlock, gathered
from modelcast.io.rows import Rows
from modelcast.trips.trajectory import Trajectory
from modelcast.trips.understood import Understood

__all__ = ["AbstractBsmLog", "BsmRow", "bsm_trips"]

_BLOCK_ROWS = 16_384
_INSTANT = "t_ms"
_VALUES = {
    frozenset({True}): "codes of the standard, told by how they are written",
    frozenset({False}): "in the standard's units, told by how they are written",
    frozenset({True, False}): "codes of the standard in some messages, its units in others",
}
"""What the numbers of messages are in words, by whether they are codes."""


class BsmRow(NamedTuple):
    """A message as its log has it.

    Parameters
    ----------
    row
        Its number in the file, from 1.
    sender
        Its temporary id.
    stamp_ms
        When it was logged, NaN where that is not said [ms].
    mark_ms
        Its place in the minute, NaN where that is not said [ms].
    codes
        Whether `numbers` are codes of the standard.
    numbers
        For each of `CORE_COLUMNS`, NaN where not said; empty where they were not asked for.
    """

    row: int
    sender: str
    stamp_ms: float
    mark_ms: float
    codes: bool
    numbers: tuple[float, ...]


class AbstractBsmLog(ABC):
    """A file of messages that can be gone through again and again."""

    path: str
    """As the user named it."""

    @property
    @abstractmethod
    def cut(self) -> bool:
        """Whether a last message was cut off and passed over, known once all were read."""

    @property
    @abstractmethod
    def utc(self) -> bool:
        """Whether its stamps are of UTC, known once one was read."""

    @abstractmethod
    def messages(self, *, numbers: bool) -> Iterator[BsmRow]:
        """Yield its messages in order.

        Parameters
        ----------
        numbers
            Whether more is wanted than rows and senders.

        Raises
        ------
        DataFormatError
            Where it is not what its format says.
        """


def bsm_trips(
    log: AbstractBsmLog, source: str, on_skipped: OnSkipped, held_bytes: int
) -> Iterator[Trajectory]:
    """Yield a trip per sender.

    Parameters
    ----------
    log
        The file.
    source
        Name of the format.
    on_skipped
        As for readers.
    held_bytes
        Octets of numbers that may be gathered at a time.
    """
    rows = _Senders(log)

    def usable(raw: Rows, tally: Tally) -> UsableRows:
        clock = "UTC" if log.utc else "a clock without a zone"
        tally.understand(
            Understood(notes={"values": _VALUES[frozenset(rows.kinds)], "time": f"stamps of {clock}"})
        )
        raw = raw.without(np.isnan(raw.columns[_INSTANT]), "time missing", tally)
        raw = placed_on_earth(raw, tally)
        start_ms = float(raw.columns[_INSTANT].min()) if len(raw) else 0.0
        columns = {name: column for name, column in raw.columns.items() if name != _INSTANT}
        columns["t_s"] = (raw.columns[_INSTANT] - start_ms) / 1000.0
        columns["heading_rad"] = wrap_angle_rad(columns["heading_rad"])
        offset_s = start_ms / 1000.0
        return UsableRows(
            Rows(raw.line, columns), origin=rows.origin,
            unix_offset_s=offset_s if log.utc else None, clock_offset_s=None if log.utc else offset_s,
        )  # fmt: skip

    found = (TripRows(one.key, one.rows, one.partial) for one in gathered(rows, held_bytes))
    yield from trips_of(log.path, source, found, usable, on_skipped)


class _Senders(AbstractKeyedRows[str]):
    """The messages of a log by sender; `origin` is the first position once it was read."""

    def __init__(self, log: AbstractBsmLog) -> None:
        self.log = log
        self.path = log.path
        self.origin: Origin | None = None
        self.kinds: set[bool] = set()

    @property
    def columns(self) -> int:
        """Those of a trip, and the instant."""
        return len(CORE_COLUMNS) + 1

    def called(self, key: str) -> str:
        """The sender."""
        return key

    def blocks(self, *, rows: bool) -> Iterator[KeyedBlock[str]]:
        """Yield messages in blocks of a fixed number."""
        index = 0
        held: list[BsmRow] = []
        for message in self.log.messages(numbers=rows):
            if len(held) == _BLOCK_ROWS:
                yield self._block(index, held, rows=rows, partial=False)
                index, held = index + 1, []
            held.append(message)
        if not held:
            raise DataFormatError(
                self.path, "holds no basic safety message",
                remedy="Check that it is complete, and of messages with coreData.",
            )  # fmt: skip
        yield self._block(index, held, rows=rows, partial=self.log.cut)

    def _block(self, index: int, held: list[BsmRow], *, rows: bool, partial: bool) -> KeyedBlock[str]:
        place: dict[str, int] = {}
        number = np.array([place.setdefault(message.sender, len(place)) for message in held], np.int64)
        found = None
        if rows:
            found = self._rows(held)
            if self.origin is None:
                self.origin = first_origin(found)
        return KeyedBlock(index, list(place), number, found, partial)

    def _rows(self, held: list[BsmRow]) -> Rows:
        line = np.array([message.row for message in held], np.int64)
        table = np.array([message.numbers for message in held], np.float64)
        codes = np.array([message.codes for message in held], np.bool_)
        self.kinds |= {message.codes for message in held}
        raw = {name: table[:, at] for at, name in enumerate(CORE_COLUMNS)}
        wrong = first_wrong_code({name: np.where(codes, column, 0.0) for name, column in raw.items()})
        if wrong is not None:
            name, at = wrong
            raise DataFormatError(
                self.path, f"{name} is {raw[name][at]}, no whole number of the standard's steps",
                row=int(line[at]),
                remedy="Positions are whole numbers in this file, so all values have to be.",
            )  # fmt: skip
        stamps = np.array([message.stamp_ms for message in held], np.float64)
        marks = np.array([message.mark_ms for message in held], np.float64)
        return Rows(line, {_INSTANT: instants_ms(stamps, marks), **core_in_si(raw, codes=codes)})
