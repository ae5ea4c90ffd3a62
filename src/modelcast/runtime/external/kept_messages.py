"""The messages that a session has sent of late, by number, so that receptions need only name them."""

from collections import deque
from collections.abc import Iterable, Sequence
from typing import final

import numpy as np

from modelcast.core.arrays import IntArray
from modelcast.runtime.external.exchange import FOREIGN, MOST_KEPT
from modelcast.runtime.external.refusal import FieldError

__all__ = ["KeptMessages"]


@final
class KeptMessages:
    """Octets by number, from 0 in the order of sending.

    Parameters
    ----------
    kept_s
        For how long a message can be named [s].
    most
        Messages that are kept; the steps of more push out the oldest ones.

    Examples
    --------
    >>> kept = KeptMessages(10.0)
    >>> kept.add(0.0, [b"one", b"two"]), kept.add(0.1, [b"three"])
    (0, 2)
    >>> kept.octets(np.array([2, -1, 0]), np.array([0, 2, 1]), [b"other"])
    [b'three', b'one', b'other']
    """

    def __init__(self, kept_s: float, most: int = MOST_KEPT) -> None:
        self._kept_s, self._most = kept_s, most
        self._octets: list[bytes] = []
        self._first = 0
        self._steps: deque[tuple[float, int]] = deque()

    def add(self, t_s: float, octets: Iterable[bytes]) -> int:
        """Keep the messages of a step, forget what is too old, and return the number of the first.

        Parameters
        ----------
        t_s
            Of the step, later than the last [s].
        octets
            In order of their numbers.
        """
        first = self._first + len(self._octets)
        self._octets.extend(octets)
        end = self._first + len(self._octets)
        if end > first:
            self._steps.append((t_s, end))
        forgotten = self._first
        while self._steps and (self._steps[0][0] < t_s - self._kept_s or end - forgotten > self._most):
            _, forgotten = self._steps.popleft()
        del self._octets[: forgotten - self._first]
        self._first = forgotten
        return first

    def octets(self, numbers: IntArray, order: IntArray, foreign: Sequence[bytes] = ()) -> list[bytes]:
        """Octets of some messages, all of them kept or foreign.

        Parameters
        ----------
        numbers
            Which, (K,); each `FOREIGN` stands for the next foreign one.
        order
            In which order to give them, (K,).
        foreign
            Octets of the foreign ones.
        """
        index, table = numbers - self._first, self._octets
        if foreign:
            index[numbers == FOREIGN] = len(table) + np.arange(len(foreign))
            table = [*table, *foreign]
        return list(map(table.__getitem__, index[order].tolist()))

    def check(self, numbers: IntArray) -> None:
        """Refuse numbers that nothing is kept of.

        Parameters
        ----------
        numbers
            Which, (K,).

        Raises
        ------
        FieldError
            Where one is of no message, or of one too long ago.
        """
        last = self._first + len(self._octets) - 1
        wrong = numbers[(numbers < self._first) | (numbers > last)]
        if wrong.size:
            held = f"one from {self._first} to {last}" if self._octets else "none yet"
            raise FieldError(
                "message",
                int(wrong[0]),
                f"-1 or the number of one of the last {self._most} messages of the last {self._kept_s:g} s: "
                f"{held}",
            )
