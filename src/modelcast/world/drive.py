"""A generated drive: what `modelcast demo` runs on where no recording is at hand.

A script of manoeuvres is laid out (`modelcast.world.script`) and driven. The sender's input is GPS at the
rows' rate plus the last CAN message before each row.
"""

from dataclasses import KW_ONLY, dataclass, replace

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.trips.trajectory import Trajectory
from modelcast.world.script import FINE_S, FinePath, Manoeuvre, Script, at_rows, integrate
from modelcast.world.sensors import SensorModel, sense

__all__ = ["DRIVE_SENSOR", "MIN_DURATION_S", "CanBus", "Drive", "generate_drive"]

MIN_DURATION_S = 90.0
"""The first lap, which holds every manoeuvre once, fits into this."""

DRIVE_SENSOR = SensorModel(slow_position_noise_m=0.05, slow_correlation_s=300.0)
"""A receiver with carrier-phase corrections: white noise of 1 cm and a slow error of 5 cm an axis."""

_FIRST_SPEED_MPS = 8.0
_JERK_MPS3 = 2.0  # comfort: ISO 15622 lets adaptive cruise control use up to 5 m/s³
_HARD_JERK_MPS3 = 15.0  # an emergency brake builds its pressure up in about half a second
_HARD_BRAKE_MPS2 = 7.0
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
    sensor
        The errors of `input`: position and heading those of the GPS, the rest those of the bus, which also
        rounds and holds its values until its next message.
    """

    truth: Trajectory
    input: Trajectory
    manoeuvres: tuple[Manoeuvre, ...]
    sensor: SensorModel


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
    fine = integrate(script, speed_mps=_FIRST_SPEED_MPS, heading_rad=plan_rng.uniform(-np.pi, np.pi))
    count = round(duration_s * rate_hz)
    rows = np.round(np.arange(count) / rate_hz / FINE_S).astype(np.int64)
    truth = at_rows(fine, rows, f"generated/{seed}")
    seen = sense(truth, sensor, gps_rng)
    bus = CanBus() if can is None else can
    return Drive(
        truth,
        _with_can(seen, fine, rows, bus, can_rng),
        tuple(m for m in script.manoeuvres if m.start_s < duration_s),
        replace(
            sensor,
            speed_noise_mps=bus.speed_noise_mps,
            acceleration_noise_mps2=bus.acceleration_noise_mps2,
            yaw_rate_noise_radps=bus.yaw_rate_noise_radps,
        ),
    )


def _write_script(rng: np.random.Generator, duration_s: float) -> Script:
    """Lay out laps until the drive is long enough; the first lap's last brake is the hard one."""
    script = Script(_FIRST_SPEED_MPS)
    hard = True
    while script.steps * FINE_S < duration_s + 1.0:
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


def _with_can(
    seen: Trajectory, fine: FinePath, rows: IntArray, can: CanBus, rng: np.random.Generator
) -> Trajectory:
    """Return the GPS rows with speed, acceleration and yaw rate of the last CAN message before each."""
    period = 1.0 / can.rate_hz
    message = np.floor((rows * FINE_S - rng.uniform(0.0, period)) / period).astype(np.int64)
    message = np.maximum(message, 0)
    at = np.minimum(np.round(message * period / FINE_S).astype(np.int64), rows)
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
