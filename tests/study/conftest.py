"""Trips and settings that the tests of the evaluation share."""

import numpy as np
import pytest

from modelcast.study.case import TripCase, make_case
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive


@pytest.fixture(scope="session")
def drive() -> Trajectory:
    """A generated drive of 100 s without errors, with speed and heading."""
    return generate_drive(seed=3, duration_s=100.0).truth


@pytest.fixture(scope="session")
def gapped_drive(drive: Trajectory) -> Trajectory:
    """The drive with a gap of 5 s and one of 1 s, and between them a part shorter than a window."""
    keep = (drive.t_s < 40.0) | ((drive.t_s >= 45.0) & (drive.t_s < 45.55)) | (drive.t_s >= 46.5)
    columns = {
        name: column[keep] for name, column in drive.columns().items() if name not in ("t_s", "position_m")
    }
    return build_trajectory("made/gaps", drive.t_s[keep], drive.position_m[keep], **columns)


@pytest.fixture(scope="session")
def gapped_case(gapped_drive: Trajectory) -> TripCase:
    """That drive in the recorded protocol."""
    return make_case(gapped_drive, EvaluationSettings(protocol="recorded"))


@pytest.fixture(scope="session")
def accelerating() -> Trajectory:
    """A straight drive at a constant 2 m/s², its velocity exactly known."""
    t = np.arange(400) * 0.1
    speed = 5.0 + 2.0 * t
    position = np.stack([5.0 * t + t**2, np.zeros(t.size)], axis=1)
    return build_trajectory(
        "made/accelerating", t, position, speed_mps=speed, heading_rad=np.full(t.size, np.pi / 2)
    )
