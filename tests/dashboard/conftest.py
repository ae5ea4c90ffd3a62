"""Fixtures of the page's tests: small snapshots laid out by hand."""

import re
from collections.abc import Callable
from importlib.resources import files

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.dashboard.snapshot import AHEAD_S, Counters, Host, Remotes, Snapshot, WarningShown

MakeSnapshot = Callable[..., Snapshot]


def remotes(count: int, t_s: float) -> Remotes:
    """Remotes that drive east at 10 m/s, each in a lane of its own; every third has fallen silent."""
    vehicle = np.arange(1, count + 1)
    position_m = np.stack([10.0 * t_s + 20.0 * vehicle, 5.0 * vehicle], axis=1)
    path_m = position_m[:, None] + AHEAD_S[None, :, None] * np.array([10.0, 0.0])
    unknown: FloatArray = np.where(vehicle % 2, 0.25, np.nan)
    return Remotes(
        vehicle,
        position_m,
        heading_rad=np.full(count, np.pi / 2),
        speed_mps=np.full(count, 10.0),
        semi_axes_m=np.tile([1.5, 0.5], (count, 1)),
        angle_rad=np.zeros(count),
        ahead_s=AHEAD_S,
        path_m=path_m,
        names=("Part I", "ctra", "cv"),
        model=vehicle % 3,
        age_s=np.full(count, 0.4),
        silent_s=np.where(vehicle % 3, 0.2, 3.5),
        messages=vehicle.astype(np.float64),
        loss_ratio=unknown,
        error_m=unknown,
    )


@pytest.fixture
def make_snapshot() -> MakeSnapshot:
    """A snapshot of some remotes at a time; the second of them is warned of."""

    def make(t_s: float = 1.0, count: int = 3, *, warned: bool = True) -> Snapshot:
        said = (WarningShown(2, "fcw", 2, round(t_s - 0.5, 3)),) if warned and count > 1 else ()
        return Snapshot(
            t_s,
            Host(9_000, (10.0 * t_s, 0.0), heading_rad=np.pi / 2, speed_mps=10.0, inputs="GNSS and CAN"),
            remotes=remotes(count, t_s),
            warnings=said,
            counters=Counters(
                2.0,
                30.0,
                sent_bytes_per_s=400.0,
                received_bytes_per_s=6000.0,
                loss_ratio=0.25,
                channel_busy_ratio=0.1,
                rejected={"not a possible message": 4},
            ),
        )

    return make


@pytest.fixture(scope="session")
def themes() -> dict[str, dict[str, str]]:
    """The page's colours by name, by day and at night."""
    text = (files("modelcast.dashboard") / "static" / "page.css").read_text()
    day, night = re.findall(r":root(?:\[[^\]]*\])? \{(.*?)\}", text, re.DOTALL)[:2]
    return {
        name: dict(re.findall(r"--([a-z0-9-]+): (#[0-9a-f]{6})", part))
        for name, part in (("day", day), ("night", night))
    }
