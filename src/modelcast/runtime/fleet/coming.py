"""The frame that comes next, as far as vehicles may take it in while the one before it is on the air."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.world.scenario.base import FleetFrame

__all__ = ["Coming", "begins_of", "measured_of", "staying", "with_next"]


@dataclass(frozen=True, slots=True)
class Coming:
    """A frame of which measurements are taken in ahead of its step.

    Parameters
    ----------
    frame
        The truth.
    seen
        What the vehicles see of it.
    taken
        Slots whose measurement is taken in, (V,): those whose vehicle stays. Who is new begins with its step.
    """

    frame: FleetFrame
    seen: FleetFrame
    taken: BoolArray


def measured_of(seen: FleetFrame) -> FloatArray:
    """What vehicles see of themselves, a row each, (V, MEASURED) of `modelcast.station.arrays`."""
    columns = (seen.speed_mps, seen.heading_rad, seen.acceleration_mps2, seen.yaw_rate_radps)
    return np.column_stack((seen.position_m, *columns))


def begins_of(frame: FleetFrame) -> BoolArray:
    """Whose measurements begin anew, (V,)."""
    return np.zeros(len(frame), dtype=np.bool_) if frame.begins is None else frame.begins


def staying(vehicle: IntArray, coming: FleetFrame) -> BoolArray:
    """Slots whose vehicle is there in the next frame too, (V,).

    Parameters
    ----------
    vehicle
        Who is in which slot now, negative for nobody, (V,).
    coming
        The next frame.
    """
    found: BoolArray = coming.active & (vehicle == coming.vehicle_id)
    return found


def with_next(
    frames: Iterable[FleetFrame], *, are_told: bool
) -> Iterator[tuple[FleetFrame, FleetFrame | None]]:
    """Yield every frame with the one after it, None for the last.

    Parameters
    ----------
    frames
        Frames of one run.
    are_told
        Whether frames are taken one ahead; else each is taken when its step is due, and none is told of.
    """
    if not are_told:
        for frame in frames:
            yield frame, None
        return
    before: FleetFrame | None = None
    for frame in frames:
        if before is not None:
            yield before, frame
        before = frame
    if before is not None:
        yield before, None
