"""Frames from files and other simulators, completed: rates that are missing, from the frames around.

Truth may look ahead, so a frame is completed when the next is known. What is missing is NaN.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.core.sensor import HEADING_HOLD_MPS
from modelcast.simulation.scenario.base import FleetFrame

__all__ = ["complete", "completed"]


def completed(frames: Iterable[FleetFrame]) -> Iterator[FleetFrame]:
    """Yield frames with every column known, one frame late.

    Parameters
    ----------
    frames
        Frames in order of time; speeds, headings, accelerations and yaw rates that are not known are NaN.
    """
    before: FleetFrame | None = None
    now: FleetFrame | None = None
    for after in frames:
        if now is not None:
            before = complete(before, now, after)
            yield before
        now = after
    if now is not None:
        yield complete(before, now, None)


def complete(before: FleetFrame | None, now: FleetFrame, after: FleetFrame | None) -> FleetFrame:
    """Return a frame without NaN: differences on both sides, on one side at a vehicle's first and last frame.

    Speed comes from positions, heading from positions where the vehicle is faster than `HEADING_HOLD_MPS`
    (else the frame before), acceleration from speeds, yaw rate from headings. A vehicle seen once has zeros.

    Parameters
    ----------
    before
        The frame before, complete.
    now
        The frame.
    after
        The frame after.
    """
    earlier, has_earlier = _neighbour(now, before)
    later, has_later = _neighbour(now, after)
    span = np.where(has_later, later.t_s, now.t_s) - np.where(has_earlier, earlier.t_s, now.t_s)
    span = np.where(span > 0.0, span, np.inf)
    moved = np.where(has_later[:, None], later.position_m, now.position_m) - np.where(
        has_earlier[:, None], earlier.position_m, now.position_m
    )
    speed = _filled(now.speed_mps, np.hypot(moved[:, 0], moved[:, 1]) / span)
    course = np.arctan2(moved[:, 0], moved[:, 1])
    held = np.where(has_earlier & (speed < HEADING_HOLD_MPS), earlier.heading_rad, course)
    heading = wrap_angle_rad(_filled(now.heading_rad, held))
    gained = _difference(earlier.speed_mps, has_earlier, speed, later.speed_mps, has_later)
    turned = wrap_angle_rad(
        _difference(earlier.heading_rad, has_earlier, heading, later.heading_rad, has_later)
    )
    here = now.active
    return replace(
        now,
        speed_mps=speed * here,
        heading_rad=heading * here,
        acceleration_mps2=_filled(now.acceleration_mps2, _over(gained, has_earlier, has_later, now, later, earlier))
        * here,
        yaw_rate_radps=_filled(now.yaw_rate_radps, _over(turned, has_earlier, has_later, now, later, earlier))
        * here,
    )


def _neighbour(now: FleetFrame, other: FleetFrame | None) -> tuple[FleetFrame, BoolArray]:
    """Return a frame beside this one, and in which slots it holds the same vehicle."""
    if other is None:
        return now, np.zeros(len(now), dtype=np.bool_)
    return other, now.active & other.active & (now.vehicle_id == other.vehicle_id)


def _filled(column: FloatArray, with_what: FloatArray) -> FloatArray:
    return np.where(np.isnan(column), with_what, column)


def _difference(
    earlier: FloatArray, has_earlier: BoolArray, now: FloatArray, later: FloatArray, has_later: BoolArray
) -> FloatArray:
    """Return the change over the known neighbours; a later value that is not known counts as no neighbour."""
    after = np.where(has_later & ~np.isnan(later), later, now)
    return after - np.where(has_earlier, earlier, now)


def _over(
    change: FloatArray,
    has_earlier: BoolArray,
    has_later: BoolArray,
    now: FleetFrame,
    later: FleetFrame,
    earlier: FleetFrame,
) -> FloatArray:
    """Return a change over the time it took."""
    span = np.where(has_later, later.t_s - now.t_s, 0.0) + np.where(has_earlier, now.t_s - earlier.t_s, 0.0)
    return change / np.where(span > 0.0, span, np.inf)
