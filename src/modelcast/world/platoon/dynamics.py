"""How vehicles of a platoon move: what they are asked for reaches the road late, and only so far."""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray

__all__ = ["Drive", "PlatoonState", "driven"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """Drive and brakes of a vehicle.

    Parameters
    ----------
    lag_s
        First-order lag from what is asked for to what is done; 0 for none [s].
    most_mps2, hardest_mps2
        Limits of acceleration and of braking, both positive [m/s²].

    Raises
    ------
    ValueError
        Where the lag is negative or a limit is not positive.

    References
    ----------
    Defaults: Plexe, ``examples/platooning`` (engineTau 0.5 s; vehicle type: accel 2.5, decel 9.0).
    """

    lag_s: float = 0.5
    most_mps2: float = 2.5
    hardest_mps2: float = 9.0

    def __post_init__(self) -> None:
        if not self.lag_s >= 0.0:
            raise ValueError(f"lag_s must not be negative, got {self.lag_s}")
        for name in ("most_mps2", "hardest_mps2"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")


@dataclass(frozen=True, slots=True)
class PlatoonState:
    """B platoons of N vehicles, the leader first.

    Parameters
    ----------
    t_s
        Now [s].
    along_m
        Where the vehicles' middles are on their road, (B, N) [m].
    speed_mps, acceleration_mps2
        (B, N) [m/s], [m/s²].
    commanded_mps2
        The acceleration asked for last, within the limits, (B, N) [m/s²].

    Raises
    ------
    ValueError
        Where shapes differ.
    """

    t_s: float
    along_m: FloatArray
    _: KW_ONLY
    speed_mps: FloatArray
    acceleration_mps2: FloatArray
    commanded_mps2: FloatArray

    def __post_init__(self) -> None:
        shape = self.along_m.shape
        if len(shape) != 2:
            raise ValueError(f"along_m must be (B, N), got {shape}")
        for name in ("speed_mps", "acceleration_mps2", "commanded_mps2"):
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} must have shape {shape}, got {getattr(self, name).shape}")


def driven(
    state: PlatoonState, asked_mps2: FloatArray, leader_mps: float, dt_s: float, drive: Drive
) -> PlatoonState:
    """Return the platoons a moment later.

    Followers do what they are asked for, which is exact for a command that holds over the moment; leaders
    have the speed they are given. Nobody reverses.

    Parameters
    ----------
    state
        The platoons now.
    asked_mps2
        Acceleration asked of the followers, (B, N - 1) [m/s²].
    leader_mps
        Speed of the leaders at the end of the moment [m/s].
    dt_s
        The moment [s].
    drive
        Of the followers.

    Notes
    -----
    With tau da/dt = u - a and E = 1 - exp(-dt/tau)::

        a' = a + (u - a) E
        v' = v + u dt + (a - u) tau E
        x' = x + v dt + u dt² / 2 + (a - u) tau (dt - tau E)
    """
    commanded = np.empty_like(state.along_m)
    commanded[:, 1:] = np.clip(asked_mps2, -drive.hardest_mps2, drive.most_mps2)
    commanded[:, 0] = (leader_mps - state.speed_mps[:, 0]) / dt_s
    lag_s = drive.lag_s
    share = -np.expm1(-dt_s / lag_s) if lag_s > 0.0 else 1.0
    short = state.acceleration_mps2 - commanded
    acceleration = commanded + short * (1.0 - share)
    speed = state.speed_mps + commanded * dt_s + short * (lag_s * share)
    way = state.speed_mps * dt_s + 0.5 * commanded * dt_s**2 + short * (lag_s * (dt_s - lag_s * share))
    stopped = speed <= 0.0
    along = state.along_m + np.where(stopped, np.maximum(way, 0.0), way)
    along[:, 0] = state.along_m[:, 0] + 0.5 * (state.speed_mps[:, 0] + leader_mps) * dt_s
    speed, acceleration = np.where(stopped, 0.0, speed), np.where(stopped, 0.0, acceleration)
    speed[:, 0], acceleration[:, 0] = leader_mps, commanded[:, 0]
    return PlatoonState(
        state.t_s + dt_s,
        along,
        speed_mps=speed,
        acceleration_mps2=acceleration,
        commanded_mps2=commanded,
    )
