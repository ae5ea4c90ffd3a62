"""Who sits in which slot, for sources that name their vehicles: files and SUMO."""

from collections.abc import Sequence

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.kinds import SIZES_M, Kind
from modelcast.world.scenario.base import NOBODY, FleetFrame

__all__ = ["RAW_COLUMNS", "FleetSlots"]

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
        self, t_s: float, labels: Sequence[str], rows: FloatArray, kinds: Sequence[Kind] | None = None
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
            width[at] = [SIZES_M[one][1] for one in kinds]
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
