"""What stations know beside their own motion, written into their newest samples."""

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.models.context_columns import CONTEXT_COLUMNS
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.station.arrays import Sensed
from modelcast.station.context import ahead_kernels, drive_kernels, road_kernels
from modelcast.station.context.ahead_numbers import followers
from modelcast.station.context.road import NO_ROADS, drives, roads
from modelcast.station.context.road_kernels import Roads

__all__ = ["FLEET_CELLS", "Knowledge"]

FLEET_CELLS = 4_000
"""Cells of each station's memory of its own drives: 20 km."""


class Knowledge:
    """Roads that V stations remember, and whom they follow; it owns its arrays.

    Parameters
    ----------
    vehicles
        V.
    shared
        Memory of roads that all of them hold.
    cells
        Cells of each station's own memory.
    """

    def __init__(self, vehicles: int, *, shared: Roads = NO_ROADS, cells: int = FLEET_CELLS) -> None:
        self._drives, self.followers = drives(vehicles), followers(vehicles)
        self._own, self._shared = roads(vehicles, cells), shared

    def forget(self, whose: BoolArray) -> None:
        """Let some stations know nothing, (V,): others have taken their places.

        Parameters
        ----------
        whose
            Which.
        """
        count = int(whose.sum())
        for held, empty in (
            (self._drives, drives(count)),
            (self.followers, followers(count)),
        ):
            for column, new in zip(held, empty, strict=True):
                column[whose] = new
        self._own.heads[whose] = road_kernels.NOWHERE
        self._own.filled[whose] = 0

    def newest(self, sensed: Sensed, vehicle: IntArray) -> FloatArray:
        """Newest samples of some stations, (K, 9).

        Parameters
        ----------
        sensed
            What all hold.
        vehicle
            Whose, (K,).
        """
        place = (sensed.taken[vehicle] - 1) % sensed.stated_m.shape[1]
        return np.ascontiguousarray(sensed.samples[vehicle, place, :SAMPLE_COLUMNS])

    def drive(self, t_s: float, vehicle: IntArray, samples: FloatArray) -> FloatArray:
        """Take in stations' newest samples; returns their context with the road's columns, (K, 13).

        Parameters
        ----------
        t_s
            Now [s].
        vehicle, samples
            Whose, (K,), and the samples, (K, 9).
        """
        rows = np.zeros((vehicle.size, CONTEXT_COLUMNS))
        drive_kernels.drive_each(self._drives, self._own, self._shared, vehicle, t_s, samples, rows)
        return rows

    def follow(
        self, t_s: float, host: int, sample: FloatArray, *, who: IntArray, motion: FloatArray, row: FloatArray
    ) -> None:
        """Write the leader's columns of one station's context from its local dynamic map.

        Parameters
        ----------
        t_s
            Now [s].
        host, sample
            Whose, and its newest sample, (7,).
        who, motion
            As `LocalDynamicMap.motions` returns them.
        row
            Its context, (13,), which is written.
        """
        ahead_kernels.follow(self.followers, host, t_s, sample, np.ascontiguousarray(who), motion, row)

    def lay(self, sensed: Sensed, vehicle: IntArray, rows: FloatArray) -> None:
        """Write the context behind what some stations measured last, in both places of the sample.

        Parameters
        ----------
        sensed
            What all hold, with room for it.
        vehicle, rows
            Whose, (K,), and the context, (K, 13).
        """
        ring = sensed.stated_m.shape[1]
        place = (sensed.taken[vehicle] - 1) % ring
        for at in (place, place + ring):
            sensed.samples[vehicle, at, SAMPLE_COLUMNS : SAMPLE_COLUMNS + CONTEXT_COLUMNS] = rows
