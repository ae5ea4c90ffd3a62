"""When a node changes all that names it: temporary id, message count, certificate and update numbers."""

import math
from typing import final

import numpy as np

__all__ = ["Pseudonyms"]

_IDS = 2**32


@final
class Pseudonyms:
    """A schedule of changes.

    Parameters
    ----------
    least_s, most_s
        Between two changes, evenly drawn; 0 and 0 for never [s].
    rng
        Draws times and temporary ids; on the road one that nobody can guess.

    Examples
    --------
    >>> names = Pseudonyms(300.0, 900.0, np.random.default_rng(1))
    >>> first = names.temporary_id
    >>> names.due(0.0), names.due(299.0), names.due(900.0), names.temporary_id != first
    (False, False, True, True)
    """

    def __init__(self, least_s: float, most_s: float, rng: np.random.Generator) -> None:
        self._span_s, self._rng = (least_s, most_s), rng
        self.temporary_id = self._drawn()
        """The name in use."""
        self.changes = 0
        """How often it changed."""
        self._next_s = math.nan

    def due(self, now_s: float) -> bool:
        """Whether the name changes now; `temporary_id` is the new one then.

        Parameters
        ----------
        now_s
            Now; the first call begins the first span [s].
        """
        if self._span_s[1] == 0.0:
            return False
        if math.isnan(self._next_s):
            self._next_s = now_s + self._rng.uniform(*self._span_s)
        if now_s < self._next_s:
            return False
        before = self.temporary_id
        while self.temporary_id == before:
            self.temporary_id = self._drawn()
        self._next_s = now_s + self._rng.uniform(*self._span_s)
        self.changes += 1
        return True

    def _drawn(self) -> int:
        return int(self._rng.integers(_IDS))
