"""What maps said while a soak ran, and what follows from it over a stretch of time."""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray

__all__ = ["Maps", "Stretch"]

OFF_M = 2.0
"""A remote farther than this from where it truly is counts as not recovered."""

LASTS_S = 1.0
"""Recovered is what has been right for so long."""

_UTC, _HOST, _REMOTE, _ERROR = range(4)


@dataclass(frozen=True, slots=True)
class Stretch:
    """Maps over some time.

    Parameters
    ----------
    tracked_ratio
        Share of the remotes that should be in maps and were; not a number where no map was seen.
    error_p95_m
        Of those, how far from the truth [m].
    strangers
        Most remotes in one map that nobody is.
    """

    tracked_ratio: float
    error_p95_m: float
    strangers: int


class Maps:
    """Rows of who believed whom where; NaN for a remote that is not in a map."""

    def __init__(self) -> None:
        self._rows: list[tuple[float, int, int, float]] = []
        self._strangers: list[tuple[float, int, int]] = []

    def add(self, utc_s: float, host: int, errors_m: dict[int, float], *, strangers: int) -> None:
        """Take in what a host's map said.

        Parameters
        ----------
        utc_s
            When [s].
        host
            Whose it is.
        errors_m
            By remote; NaN where it is not there [m].
        strangers
            Remotes in it that nobody is.
        """
        self._rows += [(utc_s, host, remote, error_m) for remote, error_m in errors_m.items()]
        self._strangers.append((utc_s, host, strangers))

    def stretch(self, from_s: float, to_s: float, pairs: frozenset[tuple[int, int]]) -> Stretch:
        """Figures of a time.

        Parameters
        ----------
        from_s, to_s
            Its begin and end, UTC [s].
        pairs
            Hosts and remotes that count.
        """
        rows = self._of(from_s, to_s, pairs)
        errors_m = rows[:, _ERROR]
        known = np.isfinite(errors_m)
        hosts = {host for host, _ in pairs}
        return Stretch(
            float(known.mean()) if known.size else np.nan,
            float(np.quantile(errors_m[known], 0.95)) if known.any() else np.nan,
            max(
                (many for at_s, host, many in self._strangers if from_s <= at_s < to_s and host in hosts),
                default=0,
            ),
        )

    def recovery_s(self, from_s: float, to_s: float, pairs: frozenset[tuple[int, int]]) -> float:
        """How long after a time every pair is right and stays so; infinite where it is not by the end [s].

        Parameters
        ----------
        from_s, to_s
            When a fault ended, and how long is looked on, UTC [s].
        pairs
            Hosts and remotes that count.
        """
        rows = self._of(from_s, to_s, pairs)
        found_s = 0.0
        for host, remote in pairs:
            own = rows[(rows[:, _HOST] == host) & (rows[:, _REMOTE] == remote)]
            right = own[:, _ERROR] <= OFF_M
            wrong_s: FloatArray = own[~right, _UTC]
            last_s = float(wrong_s.max()) if wrong_s.size else from_s
            after_s = own[right & (own[:, _UTC] > last_s), _UTC]
            if not after_s.size or after_s[-1] - after_s[0] < LASTS_S - 0.2:
                return np.inf
            # Where a map was not to be seen at first, as of a node that starts, it counts from when it was.
            found_s = max(
                found_s, float(after_s[0]) - from_s if wrong_s.size or after_s[0] - from_s > 0.3 else 0.0
            )
        return found_s

    def _of(self, from_s: float, to_s: float, pairs: frozenset[tuple[int, int]]) -> FloatArray:
        rows = [row for row in self._rows if from_s <= row[0] < to_s and (row[1], row[2]) in pairs]
        return np.array(rows, dtype=np.float64).reshape(-1, 4)
