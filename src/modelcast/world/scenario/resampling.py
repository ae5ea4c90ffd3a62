"""Frames at another step: what makes 10 Hz of a file at 1 Hz."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from modelcast.core.geodesy import heading_to_velocity
from modelcast.world.scenario.base import NOBODY, STEP_S, FleetFrame

__all__ = ["resampled"]


def resampled(frames: Iterable[FleetFrame], step_s: float = STEP_S) -> Iterator[FleetFrame]:
    """Yield frames at multiples of a step, along cubic curves through positions and velocities.

    Speed, heading, acceleration and yaw rate are those of the curve; acceleration jumps where given frames
    meet. A vehicle is there between two given frames if it is in both.

    Parameters
    ----------
    frames
        Complete frames, the first at t = 0.
    step_s
        The step [s].

    Raises
    ------
    ValueError
        Where the step is not positive.
    """
    if not step_s > 0.0:
        raise ValueError(f"step_s must be positive, got {step_s}")
    number = 0
    before: FleetFrame | None = None
    for after in frames:
        if before is not None:
            while number * step_s < after.t_s - 1e-9:
                yield _between(before, after, number * step_s)
                number += 1
        before = after
    if before is not None and abs(number * step_s - before.t_s) < 1e-9:
        yield before


def _between(before: FleetFrame, after: FleetFrame, t_s: float) -> FleetFrame:
    """Return the fleet at a time between two frames."""
    if t_s - before.t_s < 1e-9:
        return before
    span = after.t_s - before.t_s
    u = (t_s - before.t_s) / span
    here = before.active & (before.vehicle_id == after.vehicle_id)
    p, q = before.position_m, after.position_m
    v = heading_to_velocity(before.speed_mps, before.heading_rad) * span
    w = heading_to_velocity(after.speed_mps, after.heading_rad) * span
    # p + u v + u² (3 (q - p) - 2 v - w) + u³ (v + w - 2 (q - p))
    second, third = 3.0 * (q - p) - 2.0 * v - w, v + w - 2.0 * (q - p)
    position = p + u * (v + u * (second + u * third))
    velocity = (v + u * (2.0 * second + 3.0 * u * third)) / span
    change = (2.0 * second + 6.0 * u * third) / span**2
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    moving = speed > 0.1
    safe = np.where(moving, speed, 1.0)
    along = (velocity * change).sum(axis=1) / safe
    turning = (change[:, 0] * velocity[:, 1] - change[:, 1] * velocity[:, 0]) / safe**2
    heading = np.where(moving, np.arctan2(velocity[:, 0], velocity[:, 1]), before.heading_rad)
    return replace(
        before,
        t_s=round(t_s, 6),
        position_m=position * here[:, None],
        speed_mps=speed * here,
        heading_rad=heading * here,
        acceleration_mps2=np.where(moving & here, along, 0.0),
        yaw_rate_radps=np.where(moving & here, turning, 0.0),
        length_m=before.length_m * here,
        vehicle_id=np.where(here, before.vehicle_id, NOBODY),
        active=here,
    )
