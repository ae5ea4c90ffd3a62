"""What the vehicles of a table say of one unit: one that is at odds with it does not decide for the others.

A vehicle may reverse, stand and drift, or have a bad receiver, and then move as if a column held something
else. A column that does hold something else does so for most vehicles.
"""

from collections import Counter
from collections.abc import Callable

from modelcast.core.exceptions import DataFormatError

__all__ = ["UnitVotes"]


class UnitVotes:
    """Votes of vehicles, by question.

    Examples
    --------
    >>> votes = UnitVotes()
    >>> def against() -> bool:
    ...     raise DataFormatError("a.csv", "x is in feet")
    >>> votes.ask("feet", against)
    >>> str(votes.objection)
    'a.csv: x is in feet.'
    >>> votes.ask("feet", lambda: False)
    >>> votes.objection is None
    False
    >>> votes.ask("feet", lambda: True)
    >>> votes.ask("feet", lambda: True)
    >>> votes.objection is None
    True
    """

    def __init__(self) -> None:
        self._fit: Counter[str] = Counter()
        self._objected: Counter[str] = Counter()
        self._first: dict[str, DataFormatError] = {}

    def ask(self, question: str, check: Callable[[], bool]) -> None:
        """Count what a vehicle says.

        Parameters
        ----------
        question
            What is asked of every vehicle.
        check
            Returns whether the vehicle fits what is stated, False where it cannot be told, and raises
            `DataFormatError` where it fits something else.
        """
        try:
            self._fit[question] += check()
        except DataFormatError as error:
            self._objected[question] += 1
            self._first.setdefault(question, error)

    @property
    def objection(self) -> DataFormatError | None:
        """The first objection to what at least half of the vehicles that could be told object to, if any."""
        return next(
            (first for asked, first in self._first.items() if self._objected[asked] >= self._fit[asked]), None
        )
