"""Claims about the figures of a node's inputs."""

import io

import pytest

from modelcast.node.inputs.base import AbstractSource
from modelcast.node.inputs.motion_source import MotionSource
from modelcast.node.inputs.replay import TripReplay
from modelcast.node.inputs.samples import Sample
from modelcast.node.journal import Journal
from modelcast.node.measuring import Measuring
from modelcast.node.metrics import exposition
from modelcast.world.drive import generate_drive


class Quiet(AbstractSource):
    """Gives nothing, after so many connections."""

    def __init__(self, connections: int = 0) -> None:
        self._connections = connections

    async def start(self) -> None:
        """Nothing to open."""

    async def stop(self) -> None:
        """Nothing to close."""

    def take(self, now_s: float) -> list[Sample]:
        """Nothing."""
        del now_s
        return []

    def counts(self) -> dict[str, int]:
        """Its connections."""
        return {"connections": self._connections}


def figures(measuring: Measuring) -> dict[str, float]:
    lines = exposition(measuring.figures()).splitlines()
    return {
        name: float(value)
        for name, value in (line.rsplit(" ", 1) for line in lines if not line.startswith("#"))
    }


def test_outages_changes_and_ages_are_counted() -> None:
    """A trip with a bus is driven for 5 s, then nothing comes for 3 s, then it goes on."""
    replay = TripReplay(generate_drive(1, 90.0).truth)
    measuring = Measuring(
        {"gnss": replay, "can": Quiet()}, MotionSource(replay.origin), Journal(io.StringIO(), lambda: 0.0)
    )
    for tick in range(51):
        measuring.at(tick / 10)
    driven = figures(measuring)
    assert driven['modelcast_mode{mode="gnss+can"}'] == 1.0
    assert driven["modelcast_fix_age_seconds"] == pytest.approx(0.0, abs=1e-9)
    assert driven["modelcast_fix_stale_seconds"] == pytest.approx(0.3)
    assert driven['modelcast_outages_total{source="gnss"}'] == 0.0
    assert driven['modelcast_gnss_total{what="samples"}'] == driven['modelcast_aligned_total{what="samples"}']
    silent = Measuring({"gnss": Quiet(3)}, measuring.motion, Journal(io.StringIO(), lambda: 0.0))
    for tick in range(51, 81):
        silent.at(tick / 10)
    lost = figures(silent)
    assert lost['modelcast_mode{mode="silent"}'] == 1.0
    assert lost['modelcast_mode_changes_total{mode="silent"}'] == 1.0
    assert lost['modelcast_outages_total{source="gnss"}'] == 1.0
    assert lost["modelcast_fix_age_seconds"] == pytest.approx(3.0)
    assert lost['modelcast_bus_age_seconds{quantity="speed_mps"}'] == pytest.approx(3.0)
    assert lost['modelcast_reconnects_total{source="gnss"}'] == 2.0
    replay.take(8.0)
    for tick in range(81, 90):
        measuring.at(tick / 10)
    again = figures(measuring)
    assert again['modelcast_mode_changes_total{mode="gnss+can"}'] == 2.0
