"""A generated drive: what `modelcast demo` runs on where no recording is at hand.

A script of manoeuvres is laid out as longitudinal and lateral acceleration over time, both continuous
with bounded jerk, so that speed is smooth and every bend is entered along a clothoid-like curve. The path is
its integral, by construction one a car can drive. The sender's input is GPS at the rows' rate plus the last
CAN message before each row.
"""

from dataclasses import KW_ONLY, dataclass, field, replace

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.sensors import SensorModel, sense

__all__ = ["DRIVE_SENSOR", "MIN_DURATION_S", "CanBus", "Drive", "Manoeuvre", "generate_drive"]

MIN_DURATION_S = 90.0
"""The first lap, which holds every manoeuvre once, fits into this."""

DRIVE_SENSOR = SensorModel(slow_position_noise_m=0.05, slow_correlation_s=300.0)
"""A receiver with carrier-phase corrections: white noise of 1 cm and a slow error of 5 cm an axis."""

_FINE_S = 0.01
_FIRST_SPEED_MPS = 8.0
_JERK_MPS3 = 2.0  # comfort: ISO 15622 lets adaptive cruise control use up to 5 m/s³
_HARD_JERK_MPS3 = 15.0  # an emergency brake builds its pressure up in about half a second
_HARD_BRAKE_MPS2 = 7.0
_LATERAL_JERK_MPS3 = 2.5
_LANE_M = 3.5
_MAX_LATERAL_MPS2 = 2.5


@dataclass(frozen=True, slots=True)
class CanBus:
    """How vehicle signals reach the sender.

    Parameters
    ----------
    rate_hz
        Messages a second [Hz].
    speed_step_mps, yaw_rate_step_radps, acceleration_step_mps2
        Resolution of the signals.
    speed_noise_mps, yaw_rate_noise_radps, acceleration_noise_mps2
        White noise before rounding, standard deviations.
    """

    rate_hz: float = 50.0
    speed_step_mps: float = 0.01
    _: KW_ONLY
    yaw_rate_step_radps: float = 0.01 * np.pi / 180.0
    acceleration_step_mps2: float = 0.01
    speed_noise_mps: float = 0.02
    yaw_rate_noise_radps: float = 0.1 * np.pi / 180.0
    acceleration_noise_mps2: float = 0.05

    def __post_init__(self) -> None:
        if not self.rate_hz > 0.0:
            raise ValueError(f"rate_hz must be positive, got {self.rate_hz}")


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


@dataclass(frozen=True, slots=True)
class Drive:
    """A generated drive: the path driven, what the sender saw of it, and its script.

    Parameters
    ----------
    truth
        Positions, speed, heading, acceleration and yaw rate without error.
    input
        The same rows from GPS (position, heading) and CAN (speed, acceleration, yaw rate).
    manoeuvres
        What happens when, without gaps, in order.
    """

    truth: Trajectory
    input: Trajectory
    manoeuvres: tuple[Manoeuvre, ...]


@dataclass(slots=True)
class _Script:
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
        self.manoeuvres.append(Manoeuvre(name, self.steps * _FINE_S, end * _FINE_S))
        self.steps = end
        self.speed_mps = max(0.0, self.speed_mps + float(along.sum()) * _FINE_S)

    def change_speed(self, name: str, to_mps: float, peak_mps2: float, jerk_mps3: float) -> None:
        """Accelerate or brake to a speed along a trapezoid."""
        change = to_mps - self.speed_mps
        shape = _trapezoid(abs(change), peak_mps2, jerk_mps3)
        self.add(name, np.sign(change) * shape, np.zeros(shape.size))

    def keep(self, name: str, duration_s: float, sway_mps2: float = 0.0) -> None:
        """Hold the speed; a sway is one smooth wave of acceleration that leaves the speed as it was."""
        count = round(duration_s / _FINE_S)
        phase = np.arange(count) / count
        wave = sway_mps2 * np.sin(2.0 * np.pi * phase) * np.sin(np.pi * phase) ** 2
        self.add(name, wave, np.zeros(count))

    def change_lane(self, side: float, duration_s: float) -> None:
        """Move one lane to the right (side = 1) or left (-1): one wave of lateral acceleration."""
        count = round(duration_s / _FINE_S)
        phase = (np.arange(count) + 0.5) / count
        across = side * 2.0 * np.pi * _LANE_M / duration_s**2 * np.sin(2.0 * np.pi * phase)
        self.add("lane change", np.zeros(count), across)

    def turn(self, angle_rad: float, lateral_mps2: float) -> None:
        """Turn right (positive) or left at the present speed, curvature growing and falling linearly."""
        shape = _trapezoid(abs(angle_rad) * self.speed_mps, lateral_mps2, _LATERAL_JERK_MPS3)
        self.add("turn", np.zeros(shape.size), np.sign(angle_rad) * shape)


def generate_drive(
    seed: int = 0,
    duration_s: float = 240.0,
    rate_hz: float = 10.0,
    *,
    sensor: SensorModel = DRIVE_SENSOR,
    can: CanBus | None = None,
) -> Drive:
    """Drive of cruising, lane changes, turns, braking (once hard), stops and starts.

    Parameters
    ----------
    seed
        Same seed, same bytes.
    duration_s
        Length of the drive [s], at least `MIN_DURATION_S`.
    rate_hz
        Rows a second [Hz], at most 50.
    sensor
        Errors of the GPS; its speed, acceleration and yaw-rate noises are replaced by those of `can`.
    can
        The vehicle bus.

    Raises
    ------
    ValueError
        Where the drive is too short for its manoeuvres or the rate is not in (0, 50].

    Examples
    --------
    >>> drive = generate_drive(seed=1, duration_s=100.0)
    >>> len(drive.truth), round(drive.truth.dt_s, 6), drive.manoeuvres[0].name
    (1000, 0.1, 'accelerate')
    """
    if not duration_s >= MIN_DURATION_S:
        raise ValueError(
            f"duration_s must be at least {MIN_DURATION_S} to hold every manoeuvre: {duration_s}"
        )
    if not 0.0 < rate_hz <= 50.0:
        raise ValueError(f"rate_hz must lie in (0, 50], got {rate_hz}")
    plan_rng, gps_rng, can_rng = np.random.default_rng(seed).spawn(3)
    script = _write_script(plan_rng, duration_s)
    fine = _integrate(script, speed_mps=_FIRST_SPEED_MPS, heading_rad=plan_rng.uniform(-np.pi, np.pi))
    count = round(duration_s * rate_hz)
    rows = np.round(np.arange(count) / rate_hz / _FINE_S).astype(np.int64)
    truth = _at_rows(fine, rows, f"generated/{seed}")
    seen = sense(truth, sensor, gps_rng)
    return Drive(
        truth,
        _with_can(seen, fine, rows, CanBus() if can is None else can, can_rng),
        tuple(m for m in script.manoeuvres if m.start_s < duration_s),
    )


@dataclass(frozen=True, slots=True)
class _Fine:
    """The path at fine steps, (N,) each but the position, (N, 2)."""

    position_m: FloatArray
    speed_mps: FloatArray
    heading_rad: FloatArray
    acceleration_mps2: FloatArray
    yaw_rate_radps: FloatArray


def _trapezoid(area: float, peak: float, slope: float) -> FloatArray:
    """Non-negative pulse of a given integral, rising and falling at a slope, at most a peak high."""
    peak = min(peak, np.sqrt(area * slope))
    ramp = peak / slope
    flat = max(area / peak - ramp, 0.0)
    count = max(round((2.0 * ramp + flat) / _FINE_S), 2)
    t = (np.arange(count) + 0.5) / count * (2.0 * ramp + flat)
    pulse = np.minimum(np.minimum(t, 2.0 * ramp + flat - t) * slope, peak)
    return pulse * (area / (float(pulse.sum()) * _FINE_S))


def _write_script(rng: np.random.Generator, duration_s: float) -> _Script:
    """Lay out laps until the drive is long enough; the first lap's last brake is the hard one."""
    script = _Script(_FIRST_SPEED_MPS)
    hard = True
    while script.steps * _FINE_S < duration_s + 1.0:
        side = float(rng.choice([-1.0, 1.0]))
        script.change_speed("accelerate", rng.uniform(13.0, 18.0), rng.uniform(1.5, 2.5), _JERK_MPS3)
        script.keep("cruise", rng.uniform(3.0, 6.0), rng.uniform(0.1, 0.4))
        script.change_lane(side, rng.uniform(4.5, 6.0))
        script.keep("cruise", rng.uniform(2.0, 5.0), rng.uniform(0.1, 0.4))
        script.change_speed("brake", rng.uniform(6.5, 8.5), rng.uniform(1.5, 2.5), _JERK_MPS3)
        script.turn(side * np.deg2rad(rng.uniform(75.0, 105.0)), rng.uniform(1.8, _MAX_LATERAL_MPS2))
        script.change_speed("accelerate", rng.uniform(13.0, 18.0), rng.uniform(1.5, 2.5), _JERK_MPS3)
        script.keep("cruise", rng.uniform(3.0, 8.0), rng.uniform(0.1, 0.4))
        if hard:
            script.change_speed("hard brake", 0.0, _HARD_BRAKE_MPS2, _HARD_JERK_MPS3)
        else:
            script.change_speed("brake", 0.0, rng.uniform(2.0, 3.0), _JERK_MPS3)
        script.keep("stop", rng.uniform(3.0, 6.0))
        hard = False
    return script


def _integrate(script: _Script, *, speed_mps: float, heading_rad: float) -> _Fine:
    """Speed, heading and path of the script's accelerations, which are means over the fine steps."""
    along, across = np.concatenate(script.along), np.concatenate(script.across)
    speed = np.concatenate([[speed_mps], speed_mps + np.cumsum(along) * _FINE_S])
    speed = np.where(speed < 1e-6, 0.0, speed)  # rounding must not creep through a stop
    middle = 0.5 * (speed[1:] + speed[:-1])
    yaw_rate = np.where(across != 0.0, across / np.where(middle > 0.0, middle, 1.0), 0.0)
    heading = np.concatenate([[heading_rad], heading_rad + np.cumsum(yaw_rate) * _FINE_S])
    half = 0.5 * (heading[1:] + heading[:-1])
    steps = middle[:, None] * _FINE_S * np.stack([np.sin(half), np.cos(half)], axis=1)
    position = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    return _Fine(position, speed, heading, _at_steps(along), _at_steps(yaw_rate))


def _at_steps(means: FloatArray) -> FloatArray:
    """Values at the ends of steps, from their means over the steps."""
    padded = np.concatenate([means[:1], means, means[-1:]])
    return 0.5 * (padded[1:] + padded[:-1])


def _at_rows(fine: _Fine, rows: IntArray, trip_id: str) -> Trajectory:
    return build_trajectory(
        trip_id,
        np.asarray(rows * _FINE_S, dtype=np.float64),
        fine.position_m[rows],
        speed_mps=fine.speed_mps[rows],
        heading_rad=wrap_angle_rad(fine.heading_rad[rows]),
        acceleration_mps2=fine.acceleration_mps2[rows],
        yaw_rate_radps=fine.yaw_rate_radps[rows],
        source="generated",
    )


def _with_can(
    seen: Trajectory, fine: _Fine, rows: IntArray, can: CanBus, rng: np.random.Generator
) -> Trajectory:
    """Return the GPS rows with speed, acceleration and yaw rate of the last CAN message before each."""
    period = 1.0 / can.rate_hz
    message = np.floor((rows * _FINE_S - rng.uniform(0.0, period)) / period).astype(np.int64)
    message = np.maximum(message, 0)
    at = np.minimum(np.round(message * period / _FINE_S).astype(np.int64), rows)
    noise = rng.standard_normal((3, int(message.max()) + 1))[:, message]

    def signal(column: FloatArray, std: float, step: float, draw: FloatArray) -> FloatArray:
        return np.round((column[at] + std * draw) / step) * step

    speed = signal(fine.speed_mps, can.speed_noise_mps, can.speed_step_mps, noise[0])
    return replace(
        seen,
        speed_mps=np.where(fine.speed_mps[at] > 0.0, np.maximum(speed, 0.0), 0.0),
        acceleration_mps2=signal(
            fine.acceleration_mps2, can.acceleration_noise_mps2, can.acceleration_step_mps2, noise[1]
        ),
        yaw_rate_radps=signal(
            fine.yaw_rate_radps, can.yaw_rate_noise_radps, can.yaw_rate_step_radps, noise[2]
        ),
    )
