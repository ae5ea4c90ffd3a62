"""Frames from files and other simulators, completed: columns that are missing, from the frames around.

Truth may look ahead: speed and heading come from positions one frame to either side, acceleration and yaw
rate from speeds and headings in the same way. What is missing is NaN. A vehicle that has not moved yet has no
heading that could be taken from its motion: `with_course` leaves it NaN.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.world.scenario.base import FleetFrame
from modelcast.world.sensors import HEADING_HOLD_MPS

__all__ = ["completed", "with_course", "with_rates"]

_LEAST_MOTION_M = 0.1
"""Positions are written to centimetres or decimetres: less than this has no direction [m]."""


def completed(frames: Iterable[FleetFrame]) -> Iterator[FleetFrame]:
    """Yield frames with every column known, at most two frames late.

    At a vehicle's first and last frame the difference is on one side; a vehicle seen once has zeros. Below
    `HEADING_HOLD_MPS` a heading taken from positions keeps its last value; before there is one it is zero.

    Parameters
    ----------
    frames
        Frames in order of time; speeds, headings, accelerations and yaw rates that are not known are NaN.
    """
    return with_rates(
        replace(frame, heading_rad=np.nan_to_num(frame.heading_rad)) for frame in with_course(frames)
    )


def with_course(frames: Iterable[FleetFrame]) -> Iterator[FleetFrame]:
    """Yield frames with speed, and with heading where the file or the motion says it, at most one frame late.

    Parameters
    ----------
    frames
        As for `completed`.
    """
    done: FleetFrame | None = None
    for before, now, after in _triples(frames):
        if not (np.isnan(now.speed_mps).any() or np.isnan(now.heading_rad).any()):
            done = now
            yield now
            continue
        earlier, had = _beside(now, before)
        later, has = _beside(now, after)
        span = _span(now, earlier, had, later, has)
        moved = (
            np.where(has[:, None], later.position_m, now.position_m)
            - np.where(had[:, None], earlier.position_m, now.position_m)
        ) / span[:, None]
        speed = _filled(now.speed_mps, np.hypot(moved[:, 0], moved[:, 1]))
        held = np.full(len(now), np.nan) if done is None else np.where(had, done.heading_rad, np.nan)
        course = np.where(
            np.hypot(moved[:, 0], moved[:, 1]) * np.where(np.isinf(span), 0.0, span) >= _LEAST_MOTION_M,
            np.arctan2(moved[:, 0], moved[:, 1]),
            np.nan,
        )
        course = np.where((speed < HEADING_HOLD_MPS) & ~np.isnan(held), held, course)
        heading = wrap_angle_rad(_filled(now.heading_rad, course))
        done = replace(now, speed_mps=speed * now.active, heading_rad=np.where(now.active, heading, 0.0))
        yield done


def with_rates(frames: Iterable[FleetFrame]) -> Iterator[FleetFrame]:
    """Yield frames with acceleration and yaw rate, at most one frame late.

    Parameters
    ----------
    frames
        Frames that have speed and heading.
    """
    for before, now, after in _triples(frames):
        earlier, had = _beside(now, before)
        later, has = _beside(now, after)
        span = _span(now, earlier, had, later, has)
        gained = np.where(has, later.speed_mps, now.speed_mps) - np.where(
            had, earlier.speed_mps, now.speed_mps
        )
        turned = np.where(has, later.heading_rad, now.heading_rad) - np.where(
            had, earlier.heading_rad, now.heading_rad
        )
        yield replace(
            now,
            acceleration_mps2=_filled(now.acceleration_mps2, gained / span) * now.active,
            yaw_rate_radps=_filled(now.yaw_rate_radps, wrap_angle_rad(turned) / span) * now.active,
        )


def _triples(
    frames: Iterable[FleetFrame],
) -> Iterator[tuple[FleetFrame | None, FleetFrame, FleetFrame | None]]:
    """Yield every frame between those before and after it."""
    before: FleetFrame | None = None
    now: FleetFrame | None = None
    for after in frames:
        if now is not None:
            yield before, now, after
        before, now = now, after
    if now is not None:
        yield before, now, None


def _beside(now: FleetFrame, other: FleetFrame | None) -> tuple[FleetFrame, BoolArray]:
    """Return a frame beside this one, and in which slots it holds the same vehicle."""
    if other is None:
        return now, np.zeros(len(now), dtype=np.bool_)
    return other, now.active & (now.vehicle_id == other.vehicle_id)


def _span(
    now: FleetFrame, earlier: FleetFrame, had: BoolArray, later: FleetFrame, has: BoolArray
) -> FloatArray:
    """Return the time between a vehicle's neighbouring frames, infinite where it has none, (V,) [s]."""
    span = np.where(has, later.t_s - now.t_s, 0.0) + np.where(had, now.t_s - earlier.t_s, 0.0)
    return np.where(span > 0.0, span, np.inf)


def _filled(column: FloatArray, with_what: FloatArray) -> FloatArray:
    return np.where(np.isnan(column), with_what, column)
