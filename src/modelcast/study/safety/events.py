"""True warnings as events, and what became of each: warned in time, late, or missed."""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray

__all__ = ["TrueWarnings", "delays_s", "false_warnings", "true_warnings"]


@dataclass(frozen=True, slots=True, eq=False)
class TrueWarnings:
    """E warnings that perfect knowledge gives over N instants.

    Parameters
    ----------
    first, last
        First and last instant of each, (E,).
    event
        Which of them an instant belongs to, -1 for none, (N,).
    """

    first: IntArray
    last: IntArray
    event: IntArray

    def instants(self, which: BoolArray) -> IntArray:
        """How many of some instants belong to each warning, (E,).

        Parameters
        ----------
        which
            The instants, (N,).
        """
        of = self.event[which]
        return np.bincount(of[of >= 0], minlength=self.first.size).astype(np.int64)


def _runs(warned: BoolArray, t_s: FloatArray, merge_s: float) -> tuple[IntArray, IntArray]:
    """First and last instants of warnings that stop for ``merge_s`` at least, (E,) each."""
    at = np.flatnonzero(warned)
    if at.size == 0:
        return at, at
    apart = np.diff(t_s[at]) > merge_s
    return at[np.concatenate([[True], apart])], at[np.concatenate([apart, [True]])]


def true_warnings(warned: BoolArray, counted: BoolArray, t_s: FloatArray, *, merge_s: float) -> TrueWarnings:
    """Events among true warnings; those without a counted instant are none.

    Parameters
    ----------
    warned
        Whether perfect knowledge warns, (N,).
    counted
        Which instants count, (N,).
    t_s
        (N,) rising [s].
    merge_s
        Warnings that stop for less are one [s].

    Examples
    --------
    >>> import numpy as np
    >>> warned = np.array([0, 1, 1, 0, 1, 0, 0, 1], dtype=bool)
    >>> found = true_warnings(warned, np.ones(8, dtype=bool), np.arange(8) * 0.1, merge_s=0.25)
    >>> found.first.tolist(), found.last.tolist(), found.event.tolist()
    ([1, 7], [4, 7], [-1, 0, 0, 0, 0, -1, -1, 1])
    """
    first, last = _runs(warned, t_s, merge_s)
    kept = np.array([counted[a : b + 1][warned[a : b + 1]].any() for a, b in zip(first, last, strict=True)])
    first, last = (first[kept], last[kept]) if first.size else (first, last)
    event: IntArray = np.full(warned.size, -1, dtype=np.int64)
    for number, (a, b) in enumerate(zip(first.tolist(), last.tolist(), strict=True)):
        event[a : b + 1] = number
    return TrueWarnings(first, last, event)


def delays_s(true: TrueWarnings, warned: BoolArray, t_s: FloatArray, *, grace_s: float) -> FloatArray:
    """How late each true warning came in each run, infinite where it did not, (E, R) [s].

    Parameters
    ----------
    true
        The events.
    warned
        Whether the host warned, (R, N).
    t_s
        (N,) rising [s].
    grace_s
        Time after an event's end at which a warning still counts as late [s].
    """
    found = np.full((true.first.size, warned.shape[0]), np.inf)
    until = np.searchsorted(t_s, t_s[true.last] + grace_s, side="right") if true.first.size else true.last
    for event, (begin, end) in enumerate(zip(true.first.tolist(), until.tolist(), strict=True)):
        part = warned[:, begin:end]
        late = t_s[begin + np.argmax(part, axis=1)] - t_s[begin]
        found[event] = np.where(part.any(axis=1), late, np.inf)
    return found


def false_warnings(
    warned: BoolArray, truly: BoolArray, counted: BoolArray, t_s: FloatArray, *, merge_s: float
) -> IntArray:
    """Warnings of each run with no true one within ``merge_s`` before, during or after, (R,).

    Parameters
    ----------
    warned
        Whether the host warned, (R, N).
    truly
        Whether perfect knowledge warns, (N,).
    counted
        Which instants count, (N,).
    t_s
        (N,) rising [s].
    merge_s
        As in `true_warnings` [s].
    """
    true_s = t_s[truly]
    found: list[int] = []
    for run in range(warned.shape[0]):
        first, last = _runs(warned[run] & counted, t_s, merge_s)
        near = np.searchsorted(true_s, t_s[last] + merge_s, side="right") > np.searchsorted(
            true_s, t_s[first] - merge_s, side="left"
        )
        found.append(int(np.count_nonzero(~near)))
    return np.array(found, dtype=np.int64)
