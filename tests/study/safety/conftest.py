"""Platoons whose order and headways are known."""

import numpy as np
import pytest

from modelcast.trips.trajectory import Trajectory, build_trajectory

HEADWAY_S = 1.5


def follower_of(
    name: str, late_s: float, *, duration_s: float = 60.0, clock_s: float = 100.0, brake_at_s: float = 30.0
) -> Trajectory:
    """A car on an S-shaped road that is somewhere as much later than the first car, and brakes with it."""
    t_s = np.arange(round(duration_s * 10)) * 0.1
    along = _way(t_s - late_s, brake_at_s)
    east, north = along, 30.0 * np.sin(along / 120.0)
    speed = np.gradient(np.concatenate([[0.0], np.hypot(np.diff(east), np.diff(north)).cumsum()]), t_s)
    heading = np.arctan2(np.gradient(east), np.gradient(north))
    return build_trajectory(
        name, t_s, np.column_stack((east, north)), speed_mps=speed, heading_rad=heading, clock_s=clock_s
    )


def _way(t_s: np.ndarray, brake_at_s: float) -> np.ndarray:
    """Way of a car at 15 m/s that brakes at 4 m/s² for 2.5 s and then keeps 5 m/s."""
    braking = np.clip(t_s - brake_at_s, 0.0, 2.5)
    return 15.0 * t_s - 2.0 * braking**2 - 10.0 * np.maximum(t_s - brake_at_s - 2.5, 0.0)


@pytest.fixture(scope="session")
def platoon() -> list[Trajectory]:
    """Three cars, 1.5 s behind each other, the names not in their order."""
    return [follower_of(f"made/{name}", HEADWAY_S * place) for place, name in enumerate("bca")]
