"""Recorded tracks of people, laid over the crossings of a grid.

A track is turned and shifted as a whole, so that the line from its first place to its last lies along a
crossing and is halved by the middle of the street. Nothing else about it changes. Recorded people do not see
the vehicles of a grid, nor the vehicles them: they may pass through one another.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import atan2, cos, sin

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.core.kinds import Kind
from modelcast.trips.trajectory import Trajectory
from modelcast.world.scenario.footways import make_footways
from modelcast.world.scenario.grid import Grid
from modelcast.world.scenario.recorded import Replay, make_replay

__all__ = ["crossings_of", "laid_tracks"]


def crossings_of(grid: Grid) -> FloatArray:
    """Every way over an arm of a junction: its middle and its end, (N, 4), east and north each [m].

    Parameters
    ----------
    grid
        The streets.
    """
    ways = make_footways(grid.streets, columns=grid.columns, rows=grid.rows, block_m=grid.block_m)
    corner, direction = np.nonzero(ways.lanes[:, :, 1] >= 0)
    begins, ends = ways.corner_m[corner], ways.corner_m[ways.onto[corner, direction]]
    return np.concatenate([0.5 * (begins + ends), ends], axis=1)


def laid_tracks(
    trips: Sequence[Trajectory],
    kinds: Sequence[Kind],
    crossings_m: FloatArray,
    *,
    rng: np.random.Generator,
    duration_s: float,
) -> Replay:
    """Tracks over random crossings, each once, begun at random times, early enough to end if they can.

    Parameters
    ----------
    trips, kinds
        The tracks, and what kind of people they are of.
    crossings_m
        As `crossings_of` gives them.
    rng
        Of the draws.
    duration_s
        Length of the run [s].

    Raises
    ------
    ValueError
        Where there is no track, or one is coarser than the clock of frames.
    """
    chosen = crossings_m[rng.integers(len(crossings_m), size=len(trips))]
    laid = [_laid(trip, place) for trip, place in zip(trips, chosen, strict=True)]
    spare_s = np.array([max(duration_s - float(trip.t_s[-1]), 0.0) for trip in trips])
    # The clock of frames counts from the first track: one at zero keeps it where the run begins.
    starts_s = rng.random(len(trips)) * spare_s
    if len(trips):
        starts_s[int(np.argmin(starts_s))] = 0.0
    return make_replay(laid, starts_s.tolist(), kinds=kinds)


def _laid(trip: Trajectory, crossing_m: FloatArray) -> Trajectory:
    """A track turned and shifted onto a crossing."""
    chord = trip.position_m[-1] - trip.position_m[0]
    along = crossing_m[2:] - crossing_m[:2]
    turn = atan2(along[0], along[1]) - atan2(chord[0], chord[1])  # clockwise
    rotation = np.array([[cos(turn), sin(turn)], [-sin(turn), cos(turn)]])
    middle = 0.5 * (trip.position_m[0] + trip.position_m[-1])
    heading = trip.heading_rad
    return replace(
        trip,
        position_m=(trip.position_m - middle) @ rotation.T + crossing_m[:2],
        heading_rad=None if heading is None else wrap_angle_rad(heading + turn),
        origin=None,
    )
