"""What a trip reader is: a name, a test of whether a file is its own, and an iterator of trips.

A reader is a small value. It opens nothing until `read` is iterated, and it yields one vehicle at a time.
Rows it cannot use are counted, by reason, in the trip's `Reading`; a vehicle without any usable row is
reported to `on_skipped`, so that nothing disappears unseen.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import ClassVar, Self, TypeAlias

from modelcast.core.exceptions import ConfigError
from modelcast.trips.trajectory import Reading, Trajectory
from modelcast.trips.understood import Understood

__all__ = ["AbstractTripReader", "NoUsableRow", "OnSkipped", "Tally", "ignore_skipped"]

OnSkipped: TypeAlias = Callable[[str, str], None]
"""Called with a vehicle (or file) that gave no trip, and the reason."""


def ignore_skipped(what: str, reason: str) -> None:
    """Take note of nothing: what `read` uses where the caller does not ask.

    Parameters
    ----------
    what
        The file, or what in it gave no trip.
    reason
        Why.
    """
    del what, reason


class NoUsableRow(str):
    """The reason where all rows of a vehicle were left out; it knows how many these are.

    Parameters
    ----------
    text
        The reason.
    rows
        How many rows the vehicle had.
    """

    __slots__ = ("rows",)

    rows: int

    def __new__(cls, text: str, rows: int = 0) -> Self:
        """Make one of its text and its number of rows; copies give the latter later."""
        reason = super().__new__(cls, text)
        reason.rows = rows
        return reason


class Tally:
    """Counts of one vehicle's rows while it is read.

    Examples
    --------
    >>> tally = Tally()
    >>> tally.skip("no fix", 2)
    >>> tally.repair("out of order", 0)
    >>> tally.reading(rows=5, samples=3)
    Reading(rows=5, skipped={'no fix': 2}, repaired={})
    """

    def __init__(self) -> None:
        self._skipped: dict[str, int] = {}
        self._repaired: dict[str, int] = {}
        self._understood: Understood | None = None

    def understand(self, found: Understood) -> None:
        """Note what the file was taken for.

        Parameters
        ----------
        found
            The same value for all trips of a file.
        """
        self._understood = found

    def skip(self, reason: str, count: int) -> None:
        """Count rows left out.

        Parameters
        ----------
        reason
            Why, in words that a summary shows.
        count
            How many; none leaves no trace of the reason.
        """
        if count:
            self._skipped[reason] = self._skipped.get(reason, 0) + int(count)

    def repair(self, reason: str, count: int) -> None:
        """Count rows put right.

        Parameters
        ----------
        reason
            What was done, in words that a summary shows.
        count
            How many; none leaves no trace of the reason.
        """
        if count:
            self._repaired[reason] = self._repaired.get(reason, 0) + int(count)

    @property
    def left_out(self) -> int:
        """Rows left out so far."""
        return sum(self._skipped.values())

    def reading(self, rows: int, samples: int) -> Reading:
        """Return the counts as a frozen value.

        Parameters
        ----------
        rows
            Rows that the file held for the vehicle.
        samples
            Rows that became samples.

        Raises
        ------
        ValueError
            Where a row is neither a sample nor counted as skipped, or is counted twice: the reader is wrong.
        """
        found = Reading(
            rows=rows,
            skipped=dict(self._skipped),
            repaired=dict(self._repaired),
            understood=self._understood,
        )
        if found.samples != samples:
            raise ValueError(
                f"{rows} rows read are not {samples} samples and {rows - found.samples} skipped: "
                f"{dict(self._skipped)}"
            )
        return found

    def why_empty(self) -> NoUsableRow:
        """Return the reasons in words, for a vehicle of which nothing is left."""
        parts = [f"{count} {reason}" for reason, count in self._skipped.items()]
        return NoUsableRow("no usable row: " + (", ".join(parts) or "no rows"), self.left_out)


class AbstractTripReader(ABC):
    """One file format.

    The docstring of a reader holds the table of its columns and the list of what it repairs or skips;
    anything else that is wrong with a file is a `DataFormatError` with the file, the row, the value and a
    remedy.
    """

    name: ClassVar[str]
    """The name the reader is registered under."""

    streams: ClassVar[bool] = False
    """Whether `read` takes packed files and members of archives as they are, by `io.packed.open_octets`; else
    it gets temporary copies."""

    @abstractmethod
    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether this is a file (or folder) of the format.

        Parameters
        ----------
        path
            The file or folder.
        head
            Its first bytes; empty for a folder.
        """

    @abstractmethod
    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield the trips of a file, each complete, with identifiers unique in it.

        Parameters
        ----------
        path
            The file, as the user named it: errors repeat it, and its stem begins the identifiers.
        on_skipped
            Called with the identifier of a vehicle that gave no trip, and the reason.

        Raises
        ------
        DataFormatError
            Where the file breaks a rule that the reader does not list as repaired or skipped.
        """

    def with_columns(self, columns: Mapping[str, str]) -> "AbstractTripReader":
        """Return the reader with the user's column names, for formats that leave them open.

        Parameters
        ----------
        columns
            The user's name of a column by the reader's own.

        Raises
        ------
        ConfigError
            Where the format fixes its own columns.
        """
        raise ConfigError(
            f"The format {self.name} has fixed columns: the column map {dict(columns)} does not apply to it. "
            "Leave it out, or choose csv or parquet."
        )

    def within(self, held_bytes: int) -> "AbstractTripReader":
        """Return the reader that holds at most so many octets of numbers at a time; by default itself.

        Parameters
        ----------
        held_bytes
            The limit; a single trip over it is an error.
        """
        del held_bytes
        return self

    def stands_for(self, path: Path) -> Path:
        """Return the one file that stands for a recording of several; the file itself by default.

        Parameters
        ----------
        path
            Any file of the recording.
        """
        return path
