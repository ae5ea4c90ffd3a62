"""What messages say about a vehicle's motion, whatever kind of message it was."""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.trips.trajectory import Trajectory

__all__ = ["Statements", "statements_of"]


@dataclass(frozen=True, slots=True)
class Statements:
    """What B messages say, in order of arrival; several of one remote may be among them.

    Parameters
    ----------
    vehicle
        Temporary ids, (B,).
    t_s
        When each is dated, (B,) [s].
    position_m
        East and north, (B, 2) [m].
    velocity_mps
        East and north, (B, 2) [m/s]; not a number where not stated.
    received_s
        When each arrived, (B,) [s].

    Raises
    ------
    ValueError
        Where shapes do not agree, or a time or position is not finite.
    """

    vehicle: IntArray
    t_s: FloatArray
    _: KW_ONLY
    position_m: FloatArray
    velocity_mps: FloatArray
    received_s: FloatArray

    def __post_init__(self) -> None:
        count = self.vehicle.size
        for name, shape in (
            ("vehicle", (count,)),
            ("t_s", (count,)),
            ("position_m", (count, 2)),
            ("velocity_mps", (count, 2)),
            ("received_s", (count,)),
        ):
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} must have shape {shape}, got {getattr(self, name).shape}")
        for name in ("t_s", "position_m", "received_s"):
            if not np.isfinite(getattr(self, name)).all():
                raise ValueError(f"{name} must be finite")
        if np.isinf(self.velocity_mps).any():
            raise ValueError("velocity_mps must be finite, or not a number where not stated")


def statements_of(trip: Trajectory) -> Statements | None:
    """What a vehicle would say that sent every sample of its trip at once; None without speed or heading.

    Parameters
    ----------
    trip
        A recorded trip.
    """
    if trip.speed_mps is None or trip.heading_rad is None:
        return None
    heading = np.stack([np.sin(trip.heading_rad), np.cos(trip.heading_rad)], axis=1)
    return Statements(
        np.zeros(len(trip), dtype=np.int64),
        trip.t_s,
        position_m=trip.position_m,
        velocity_mps=trip.speed_mps[:, None] * heading,
        received_s=trip.t_s,
    )
