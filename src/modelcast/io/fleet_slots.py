"""Who sits in which slot, for sources that name their vehicles: files and SUMO."""

from collections.abc import Sequence

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.kinds import SIZES_M, Kind
from modelcast.world.scenario.base import NOBODY, FleetFrame
from modelcast.world.scenario.motion import is_jump

__all__ = ["RAW_COLUMNS", "FleetSlots", "Jumps"]

RAW_COLUMNS = (
    "east_m",
    "north_m",
    "speed_mps",
    "heading_rad",
    "acceleration_mps2",
    "yaw_rate_radps",
    "length_m",
)
"""Columns of the rows that `FleetSlots.frame` takes."""

_SPEED = RAW_COLUMNS.index("speed_mps")


class Jumps:
    """Gives who jumps as no vehicle does another name from there on.

    Examples
    --------
    >>> jumps = Jumps()
    >>> here, far = (np.array([[east_m, 0.0, 10.0, 0.0, 0.0, 0.0, 4.5]]) for east_m in (0.0, 500.0))
    >>> jumps.labels(["a"], here, 0.1), jumps.labels(["a"], here, 0.1), jumps.count
    (['a'], ['a'], 0)
    >>> jumps.labels(["a"], far, 0.1) == ["a"], jumps.count
    (False, 1)
    """

    def __init__(self) -> None:
        self._before: dict[str, FloatArray] = {}
        self._jumps: dict[str, int] = {}

    @property
    def count(self) -> int:
        """Jumps so far."""
        return sum(self._jumps.values())

    def forget(self) -> None:
        """Compare nobody's next place with the last: there is a gap in time."""
        self._before.clear()

    def labels(self, names: Sequence[str], rows: FloatArray, elapsed_s: float) -> list[str]:
        """Return names under which a vehicle that jumped is another one.

        Parameters
        ----------
        names
            Of the vehicles that are there, each once.
        rows
            Their numbers, (len(names), 7), in the order of `RAW_COLUMNS`.
        elapsed_s
            Time since the last call [s].
        """
        known = [(at, self._before[name]) for at, name in enumerate(names) if name in self._before]
        if known:
            at = np.array([place for place, _ in known])
            old, new = np.array([row for _, row in known]), rows[at]
            moved = np.hypot(*(new[:, :2] - old[:, :2]).T)
            for place in at[is_jump(moved, np.maximum(old[:, _SPEED], new[:, _SPEED]), elapsed_s)]:
                name = names[int(place)]
                self._jumps[name] = self._jumps.get(name, 0) + 1
        self._before = dict(zip(names, rows, strict=True))
        return [f"{name}\0{self._jumps[name]}" if name in self._jumps else name for name in names]


class FleetSlots:
    """Gives vehicles slots: the lowest free one to who comes, until it is missing from a frame.

    Parameters
    ----------
    slots
        Number of slots V.
    """

    def __init__(self, slots: int) -> None:
        self._slot: dict[str, int] = {}
        self._identity: dict[str, int] = {}
        self._free = list(range(slots - 1, -1, -1))
        self._slots = slots
        self._next = 0

    def frame(
        self,
        t_s: float,
        labels: Sequence[str],
        rows: FloatArray,
        kinds: Sequence[Kind] | None = None,
        widths_m: Sequence[float] | None = None,
    ) -> FleetFrame | None:
        """Return the frame of the vehicles that are there, or None where they are more than the slots.

        Parameters
        ----------
        t_s
            Time [s].
        labels
            Names of the vehicles, each once.
        rows
            Their numbers, (len(labels), 7), in the order of `RAW_COLUMNS`; NaN where not known.
        kinds
            Of each; None where all traffic is vehicles.
        widths_m
            Of each [m], where kinds are given; None for those of `SIZES_M`.
        """
        here = set(labels)
        gone = sorted(self._slot[label] for label in self._slot if label not in here)
        for slot in reversed(gone):
            self._free.append(slot)
        for label in [label for label in self._slot if label not in here]:
            del self._slot[label], self._identity[label]
        self._free.sort(reverse=True)
        for label in labels:
            if label not in self._slot:
                if not self._free:
                    return None
                self._slot[label] = self._free.pop()
                self._identity[label] = self._next
                self._next += 1
        at = np.array([self._slot[label] for label in labels], dtype=np.int64)
        table = np.zeros((len(RAW_COLUMNS), self._slots))
        table[:, at] = rows.reshape(-1, len(RAW_COLUMNS)).T
        kind: IntArray | None = None
        width: FloatArray | None = None
        if kinds is not None:
            kind, width = np.zeros(self._slots, dtype=np.int64), np.zeros(self._slots)
            kind[at] = [int(one) for one in kinds]
            width[at] = [SIZES_M[one][1] for one in kinds] if widths_m is None else widths_m
        identity = np.full(self._slots, NOBODY, dtype=np.int64)
        identity[at] = [self._identity[label] for label in labels]
        return FleetFrame(
            t_s,
            np.ascontiguousarray(table[:2].T),
            speed_mps=table[2],
            heading_rad=table[3],
            acceleration_mps2=table[4],
            yaw_rate_radps=table[5],
            length_m=table[6],
            vehicle_id=identity,
            active=identity != NOBODY,
            kind=kind,
            width_m=width,
        )
