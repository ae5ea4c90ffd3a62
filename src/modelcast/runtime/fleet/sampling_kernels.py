"""Compiled windows of the closed loop's senders: what every vehicle sees of itself comes in."""

from math import cos, hypot, sin, sqrt

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatMatrix, FloatVector, IntVector
from modelcast.models.point_kernels import (
    ACCELERATION,
    EAST,
    NORTH,
    POSITION_NOISE,
    VELOCITY_EAST,
    VELOCITY_NORTH,
    YAW_RATE,
)
from modelcast.runtime.fleet.arrays import SenderArrays
from modelcast.station.sensing.noise_kernels import difference_variance, settled
from modelcast.station.sensing.rates import NO_RATES_BELOW_MPS

__all__ = ["take_samples"]


@kernel
def take_samples(
    t_s: float,
    at: int,
    seen_m: FloatMatrix,
    speed_mps: FloatVector,
    heading_rad: FloatVector,
    acceleration_mps2: FloatVector,
    yaw_rate_radps: FloatVector,
    vehicle_id: IntVector,
    active: BoolVector,
    s: SenderArrays,
    order: int,
    noise: tuple[float, float, float, float, float, float],
    out_started: BoolVector,
) -> None:
    """Take what V vehicles see at one instant into their windows, at place ``at`` of the rings.

    The row is that of `modelcast.station.sensing.velocity.sample_matrix` for a log that reports speed,
    heading, acceleration and yaw rate. ``noise`` holds the constants of `noise_kernels.settled`, after the
    mean at the start. ``out_started`` (V,) tells whose slot has a new vehicle.
    """
    first_mean, samples, clip, share, prior_samples, free = noise
    length = s.times.size // 2
    s.times[at] = s.times[at + length] = t_s
    for v in range(vehicle_id.size):
        out_started[v] = False
        if not active[v]:
            s.vehicle[v], s.history[v] = -1, 0
            continue
        if s.vehicle[v] != vehicle_id[v]:
            out_started[v] = True
            s.vehicle[v], s.history[v] = vehicle_id[v], 0
            s.noise[v, 0], s.noise[v, 1] = first_mean, 0.0
        own = s.samples[v]
        row = own[at + length]
        row[EAST], row[NORTH] = seen_m[v, 0], seen_m[v, 1]
        row[VELOCITY_EAST] = speed_mps[v] * sin(heading_rad[v])
        row[VELOCITY_NORTH] = speed_mps[v] * cos(heading_rad[v])
        moving = hypot(row[VELOCITY_EAST], row[VELOCITY_NORTH]) >= NO_RATES_BELOW_MPS
        row[ACCELERATION] = acceleration_mps2[v] if moving else 0.0
        row[YAW_RATE] = yaw_rate_radps[v] if moving else 0.0
        s.history[v] += 1
        if s.history[v] > order:
            square = difference_variance(s.times, own, at + length, order)
            s.noise[v, 0], s.noise[v, 1] = settled(
                square, s.noise[v, 0], s.noise[v, 1], samples, clip, share, prior_samples, free
            )
        row[POSITION_NOISE] = sqrt(s.noise[v, 0] / share)
        own[at] = row
