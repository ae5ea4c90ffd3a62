"""A drive laid out by hand: accelerations along and across over time, and the path that follows from them.

Both accelerations are continuous with bounded jerk, so that speed is smooth and every bend is entered along a
clothoid-like curve. The path is their integral, by construction one a car can drive.
"""

from dataclasses import dataclass, field

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.trips.trajectory import Trajectory, build_trajectory

__all__ = [
    "FINE_S",
    "LANE_M",
    "FinePath",
    "Manoeuvre",
    "Script",
    "at_rows",
    "integrate",
    "lateral_wave",
    "trapezoid",
]

FINE_S = 0.01
"""Step at which drives are laid out [s]."""

_LATERAL_JERK_MPS3 = 2.5
LANE_M = 3.5
"""Width of a lane [m]."""


@dataclass(frozen=True, slots=True)
class Manoeuvre:
    """One named part of a drive.

    Parameters
    ----------
    name
        ``accelerate``, ``cruise``, ``lane change``, ``brake``, ``turn``, ``hard brake`` or ``stop``.
    start_s, end_s
        When it begins and ends [s].
    """

    name: str
    start_s: float
    end_s: float


@dataclass(slots=True)
class Script:
    """A drive being laid out at fine steps: acceleration along, acceleration across (right), and names."""

    speed_mps: float
    along: list[FloatArray] = field(default_factory=list[FloatArray])
    across: list[FloatArray] = field(default_factory=list[FloatArray])
    manoeuvres: list[Manoeuvre] = field(default_factory=list[Manoeuvre])
    steps: int = 0

    def add(self, name: str, along: FloatArray, across: FloatArray) -> None:
        """Append a manoeuvre of two accelerations, (N,) [m/s²] each."""
        self.along.append(along)
        self.across.append(across)
        end = self.steps + along.size
        self.manoeuvres.append(Manoeuvre(name, self.steps * FINE_S, end * FINE_S))
        self.steps = end
        self.speed_mps = max(0.0, self.speed_mps + float(along.sum()) * FINE_S)

    def change_speed(self, name: str, to_mps: float, peak_mps2: float, jerk_mps3: float) -> None:
        """Accelerate or brake to a speed along a trapezoid."""
        change = to_mps - self.speed_mps
        shape = trapezoid(abs(change), peak_mps2, jerk_mps3)
        self.add(name, np.sign(change) * shape, np.zeros(shape.size))

    def keep(self, name: str, duration_s: float, sway_mps2: float = 0.0) -> None:
        """Hold the speed; a sway is one smooth wave of acceleration that leaves the speed as it was."""
        count = round(duration_s / FINE_S)
        phase = np.arange(count) / count
        wave = sway_mps2 * np.sin(2.0 * np.pi * phase) * np.sin(np.pi * phase) ** 2
        self.add(name, wave, np.zeros(count))

    def change_lane(
        self, side: float, duration_s: float, shift_m: float = LANE_M, skew_ratio: float = 0.5
    ) -> None:
        """Move to the right (side = 1) or left (-1): one wave of lateral acceleration.

        ``skew_ratio`` is the share of the time in which the vehicle leaves its course.
        """
        self.add("lane change", *lateral_wave(side * shift_m, duration_s, skew_ratio))

    def turn(self, angle_rad: float, lateral_mps2: float) -> None:
        """Turn right (positive) or left at the present speed, curvature growing and falling linearly."""
        shape = trapezoid(abs(angle_rad) * self.speed_mps, lateral_mps2, _LATERAL_JERK_MPS3)
        self.add("turn", np.zeros(shape.size), np.sign(angle_rad) * shape)


@dataclass(frozen=True, slots=True)
class FinePath:
    """The path at fine steps, (N,) each but the position, (N, 2)."""

    position_m: FloatArray
    speed_mps: FloatArray
    heading_rad: FloatArray
    acceleration_mps2: FloatArray
    yaw_rate_radps: FloatArray


def lateral_wave(shift_m: float, duration_s: float, skew_ratio: float = 0.5) -> tuple[FloatArray, FloatArray]:
    """Accelerations along (none) and across, (N,) [m/s²], that shift a path to the right."""
    count = round(duration_s / FINE_S)
    phase = (np.arange(count) + 0.5) / count
    leaving = phase < skew_ratio
    stretch = 0.5 / np.where(leaving, skew_ratio, 1.0 - skew_ratio)
    warped = np.where(leaving, stretch * phase, 0.5 + stretch * (phase - skew_ratio))
    peak = 2.0 * np.pi * shift_m / duration_s**2
    return np.zeros(count), peak * stretch * np.sin(2.0 * np.pi * warped)


def trapezoid(area: float, peak: float, slope: float) -> FloatArray:
    """Non-negative pulse of a given integral, rising and falling at a slope, at most a peak high."""
    peak = min(peak, np.sqrt(area * slope))
    ramp = peak / slope
    flat = max(area / peak - ramp, 0.0)
    count = max(round((2.0 * ramp + flat) / FINE_S), 2)
    t = (np.arange(count) + 0.5) / count * (2.0 * ramp + flat)
    pulse = np.minimum(np.minimum(t, 2.0 * ramp + flat - t) * slope, peak)
    return pulse * (area / (float(pulse.sum()) * FINE_S))


def integrate(script: Script, *, speed_mps: float, heading_rad: float) -> FinePath:
    """Speed, heading and path of the script's accelerations, which are means over the fine steps."""
    along, across = np.concatenate(script.along), np.concatenate(script.across)
    speed = np.concatenate([[speed_mps], speed_mps + np.cumsum(along) * FINE_S])
    speed = np.where(speed < 1e-6, 0.0, speed)  # rounding must not creep through a stop
    middle = 0.5 * (speed[1:] + speed[:-1])
    yaw_rate = np.where(across != 0.0, across / np.where(middle > 0.0, middle, 1.0), 0.0)
    heading = np.concatenate([[heading_rad], heading_rad + np.cumsum(yaw_rate) * FINE_S])
    half = 0.5 * (heading[1:] + heading[:-1])
    steps = middle[:, None] * FINE_S * np.stack([np.sin(half), np.cos(half)], axis=1)
    position = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    return FinePath(position, speed, heading, _at_steps(along), _at_steps(yaw_rate))


def _at_steps(means: FloatArray) -> FloatArray:
    """Values at the ends of steps, from their means over the steps."""
    padded = np.concatenate([means[:1], means, means[-1:]])
    return 0.5 * (padded[1:] + padded[:-1])


def at_rows(fine: FinePath, rows: IntArray, trip_id: str) -> Trajectory:
    """Return the path at some of its fine steps, (T,), as a trip without errors."""
    return build_trajectory(
        trip_id,
        np.asarray(rows * FINE_S, dtype=np.float64),
        fine.position_m[rows],
        speed_mps=fine.speed_mps[rows],
        heading_rad=wrap_angle_rad(fine.heading_rad[rows]),
        acceleration_mps2=fine.acceleration_mps2[rows],
        yaw_rate_radps=fine.yaw_rate_radps[rows],
        source="generated",
    )
