"""What the leaders of platoons drive: speed as a function of time.

`Sinusoid` asks whether a disturbance grows along the string, `Braking` whether there is room, `RecordedSpeed`
what people do; `Steady` does nothing. Disturbances begin at `BEGINS_S`, when all have settled on the air.
"""

import abc
from dataclasses import dataclass, field
from math import pi

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.trips.trajectory import Trajectory
from modelcast.world.sensors import with_motion

__all__ = ["BEGINS_S", "AbstractLeader", "Braking", "RecordedSpeed", "Sinusoid", "Steady", "recorded_leader"]

BEGINS_S = 5.0
"""When disturbances begin, as in Plexe's example [s]."""

_CRUISE_MPS = 100.0 / 3.6
"""100 km/h, as in Plexe's example."""


class AbstractLeader(abc.ABC):
    """A profile of speed."""

    @property
    @abc.abstractmethod
    def name(self) -> str:
        """Short name, as in tables."""

    @abc.abstractmethod
    def speed_mps(self, t_s: FloatArray) -> FloatArray:
        """Speed at times, never negative, (T,) [m/s].

        Parameters
        ----------
        t_s
            Not negative, (T,) [s].
        """


def _check(**positive: float) -> None:
    for name, value in positive.items():
        if not (np.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} must be positive and finite, got {value}")


@dataclass(frozen=True, slots=True)
class Steady(AbstractLeader):
    """One speed.

    Parameters
    ----------
    mean_mps
        The speed [m/s].
    """

    mean_mps: float = _CRUISE_MPS

    def __post_init__(self) -> None:
        _check(mean_mps=self.mean_mps)

    @property
    def name(self) -> str:
        """Short name."""
        return "steady"

    def speed_mps(self, t_s: FloatArray) -> FloatArray:
        """The speed, (T,)."""
        return np.full_like(t_s, self.mean_mps)


@dataclass(frozen=True, slots=True)
class Sinusoid(AbstractLeader):
    """A speed that swings about its mean.

    Parameters
    ----------
    mean_mps, amplitude_mps
        Mean and amplitude [m/s].
    frequency_hz
        Swings a second [Hz].

    Raises
    ------
    ValueError
        Where a value is not positive, or the speed would turn.

    Notes
    -----
    Plexe's example swings 0.2 times a second by 10 km/h, but its leader is held to 1.5 m/s² and never gets
    there. Half that amplitude asks for 1.75 m/s², within the limits of every vehicle here, so that what is
    seen is the law and not the limit.
    """

    mean_mps: float = _CRUISE_MPS
    amplitude_mps: float = 5.0 / 3.6
    frequency_hz: float = 0.2

    def __post_init__(self) -> None:
        _check(mean_mps=self.mean_mps, amplitude_mps=self.amplitude_mps, frequency_hz=self.frequency_hz)
        if self.amplitude_mps > self.mean_mps:
            raise ValueError(f"amplitude_mps must not exceed mean_mps, got {self.amplitude_mps}")

    @property
    def name(self) -> str:
        """Short name."""
        return "sinusoid"

    def speed_mps(self, t_s: FloatArray) -> FloatArray:
        """Mean, then a sine from `BEGINS_S` on, (T,)."""
        since_s = np.maximum(t_s - BEGINS_S, 0.0)
        return self.mean_mps + self.amplitude_mps * np.sin(2.0 * pi * self.frequency_hz * since_s)


@dataclass(frozen=True, slots=True)
class Braking(AbstractLeader):
    """A hard stop.

    Parameters
    ----------
    mean_mps
        Speed before [m/s].
    deceleration_mps2
        At which the leader brakes, from `BEGINS_S` on [m/s²].
    lag_s
        First-order lag of its brakes [s].

    Notes
    -----
    Plexe's example brakes at 8 m/s², and its followers are told what the vehicle ahead asks for. Told what it
    does, later by the lag of its brakes, the first follower of a PATH platoon, 5 m behind, runs into it at
    5 m/s² and not at 4 m/s², with perfect knowledge.
    """

    mean_mps: float = _CRUISE_MPS
    deceleration_mps2: float = 3.0
    lag_s: float = 0.5

    def __post_init__(self) -> None:
        _check(mean_mps=self.mean_mps, deceleration_mps2=self.deceleration_mps2, lag_s=self.lag_s)

    @property
    def name(self) -> str:
        """Short name."""
        return "braking"

    def speed_mps(self, t_s: FloatArray) -> FloatArray:
        """Falling at the deceleration, which the lag lets in, down to 0, (T,)."""
        since_s = np.maximum(t_s - BEGINS_S, 0.0)
        braked_s = since_s + self.lag_s * np.expm1(-since_s / self.lag_s)
        return np.maximum(self.mean_mps - self.deceleration_mps2 * braked_s, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class RecordedSpeed(AbstractLeader):
    """A recorded speed; its first value holds until `BEGINS_S`, its last at the end.

    Parameters
    ----------
    label
        Short name.
    t_s, recorded_mps
        Times from the recording's start, increasing, and speeds, (T,) [s], [m/s].

    Raises
    ------
    ValueError
        Where there are fewer than two samples, shapes differ, or times do not increase.
    """

    label: str
    t_s: FloatArray = field(repr=False)
    recorded_mps: FloatArray = field(repr=False)

    def __post_init__(self) -> None:
        if self.t_s.size < 2 or self.t_s.shape != self.recorded_mps.shape or self.t_s.ndim != 1:
            raise ValueError(
                "t_s and recorded_mps must be (T,) with T >= 2, "
                f"got {self.t_s.shape} and {self.recorded_mps.shape}"
            )
        if not np.all(np.diff(self.t_s) > 0.0):
            raise ValueError("t_s must increase")

    @property
    def name(self) -> str:
        """The label."""
        return self.label

    @property
    def lasts_s(self) -> float:
        """Time that there is something to drive, the wait before included [s]."""
        return BEGINS_S + float(self.t_s[-1] - self.t_s[0])

    def speed_mps(self, t_s: FloatArray) -> FloatArray:
        """Recorded speed, linear between samples, (T,)."""
        return np.maximum(np.interp(t_s - BEGINS_S, self.t_s - self.t_s[0], self.recorded_mps), 0.0)


def recorded_leader(trip: Trajectory) -> RecordedSpeed:
    """The leader that drives a recorded trip's speed, over its longest part without a gap.

    Parameters
    ----------
    trip
        Any trip; where it has no speed, that of its places is taken.

    Raises
    ------
    ValueError
        Where no part has two samples.

    Examples
    --------
    >>> from modelcast.trips.trajectory import build_trajectory
    >>> t_s = np.arange(20) * 0.1
    >>> trip = build_trajectory("a/1", t_s, np.column_stack([20.0 * t_s, 0.0 * t_s]))
    >>> recorded_leader(trip).speed_mps(np.array([0.0, 6.0])).round(6).tolist()
    [20.0, 20.0]
    """
    longest = int(np.argmax(np.diff(trip.segments)))
    part = slice(int(trip.segments[longest]), int(trip.segments[longest + 1]))
    speed = with_motion(trip).speed_mps
    if speed is None or part.stop - part.start < 2:
        raise ValueError(f"{trip.trip_id} has no part of two samples or more")
    return RecordedSpeed(trip.trip_id, trip.t_s[part].copy(), speed[part].copy())
