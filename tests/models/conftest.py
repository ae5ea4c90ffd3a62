"""Trips that the tests of the models share."""

import pytest

from modelcast.trips.trajectory import Trajectory
from modelcast.world.drive import generate_drive


@pytest.fixture(scope="session")
def drive() -> Trajectory:
    """A generated drive of 100 s without errors, with speed and heading."""
    return generate_drive(seed=3, duration_s=100.0).truth
