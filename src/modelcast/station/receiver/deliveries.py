"""How many of its remotes' messages a host has heard of late, by their counts.

The rule is the packet error ratio of SAE J2945/1, a remote at a time: messages carry counts modulo 128, so
the first and the last that were heard in five seconds tell how many were sent between.
"""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.station.policy.neighbours_kernels import NeighbourTables, delivered_each

__all__ = ["SHORT_ID", "SUB_INTERVAL_S", "Deliveries", "deliveries_of"]

SUB_INTERVAL_S = 1.0
"""Length of the parts that time is cut into; five that are over count [s]."""

SHORT_ID = 2**31 - 1
"""Bits of temporary ids by which remotes are told apart in the tables."""


@dataclass(frozen=True, slots=True, eq=False)
class Deliveries:
    """Messages of N remotes in the seconds that count.

    Parameters
    ----------
    received
        Basic safety messages heard and believed, (N,).
    sent
        By their counts, never fewer, (N,); 0 where none was heard.
    """

    received: IntArray
    sent: IntArray

    @property
    def loss_ratio(self) -> FloatArray:
        """Share that was lost, NaN where fewer than two were heard, (N,)."""
        known = self.received > 1
        return np.where(known, (self.sent - self.received) / np.where(known, self.sent, 1), np.nan)

    @property
    def total_loss_ratio(self) -> float:
        """Share of the messages of all remotes of whom two or more were heard; NaN where there are none."""
        known = self.received > 1
        sent = int(self.sent[known].sum())
        return (sent - int(self.received[known].sum())) / sent if sent else float("nan")


def deliveries_of(tables: NeighbourTables, host: int, vehicle: IntArray, t_s: float) -> Deliveries:
    """What a host heard of its remotes.

    Parameters
    ----------
    tables, host
        Into which messages were entered, and whose row is the host's.
    vehicle
        Temporary ids of the remotes, (N,).
    t_s
        Now [s].
    """
    out = np.zeros((vehicle.size, 2), dtype=np.int64)
    short = np.ascontiguousarray(vehicle, dtype=np.int64) & SHORT_ID
    delivered_each(tables.hosts, tables.slots, tables.lookup, host, short, t_s, SUB_INTERVAL_S, out)
    return Deliveries(out[:, 0], out[:, 1])
