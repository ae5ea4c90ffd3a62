"""Claims about what the vehicles of a fleet know of the road and of the vehicle ahead."""

import numpy as np
import pytest

from modelcast.channel.tabulated import ReceptionTable, TabulatedRadio
from modelcast.core.arrays import FloatArray
from modelcast.models.bank import Bank
from modelcast.models.context_columns import (
    LEADER_ACCELERATION,
    LEADER_GAP,
    LEADER_KNOWN,
    LEADER_RELATIVE_SPEED,
    ROAD_KNOWN,
    ROAD_TURN,
)
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sender.sender import Sender
from modelcast.world.scenario.base import FleetFrame

RADIUS_M, SPEED_MPS, BEHIND_RAD = 100.0, 15.0, 0.25


def circling(step: int) -> FleetFrame:
    """Two cars that circle clockwise, the second 25 m of arc behind the first."""
    angle = SPEED_MPS * 0.1 * step / RADIUS_M - np.array([0.0, BEHIND_RAD])
    return FleetFrame(
        round(0.1 * step, 6),
        RADIUS_M * np.stack([np.sin(angle), np.cos(angle)], axis=1),
        speed_mps=np.full(2, SPEED_MPS),
        heading_rad=(angle + np.pi / 2.0 + np.pi) % (2.0 * np.pi) - np.pi,
        acceleration_mps2=np.zeros(2),
        yaw_rate_radps=np.full(2, SPEED_MPS / RADIUS_M),
        length_m=np.full(2, 4.5),
        vehicle_id=np.array([11, 12]),
        active=np.ones(2, dtype=np.bool_),
    )


def known(reader: Bank, received_ratio: float, steps: int, threads: int = 1) -> FloatArray:
    """Context of both cars at every step, (T, 2, 13)."""
    radio = TabulatedRadio(
        ReceptionTable(np.array([0.0, 1e6]), np.full((2, 20), received_ratio), bin_m=500.0)
    )
    sender = Sender("reader", ErrorDriven(0.5, identify="never", max_inter_transmit_time_s=1.0), reader)
    settings = NetworkSettings(warm_up_s=0.0, start_spread_s=0.0)
    loop = FleetLoop(circling(0), sender, radio, settings, seed=1, threads=threads)
    found: list[FloatArray] = []
    for step in range(steps):
        loop.step(circling(step))
        sensed = loop.stations.sensed
        place = (sensed.taken - 1) % sensed.stated_m.shape[1]
        found.append(sensed.samples[np.arange(2), place, SAMPLE_COLUMNS:].copy())
    return np.array(found)


def test_a_car_knows_who_is_ahead_on_its_arc_and_on_the_second_lap_the_road(reader: Bank) -> None:
    found = known(reader, 1.0, 700)
    first, second = found[:, 0], found[:, 1]
    assert not first[:400, LEADER_KNOWN].any()  # the second car is 600 m ahead of it along the circle
    assert second[10:, LEADER_KNOWN].all()
    chord_m = 2.0 * RADIUS_M * np.sin(BEHIND_RAD / 2.0)
    np.testing.assert_allclose(second[10:, LEADER_GAP], chord_m, atol=0.6)
    np.testing.assert_allclose(second[10:, LEADER_RELATIVE_SPEED], 0.0, atol=0.3)
    np.testing.assert_allclose(second[10:, LEADER_ACCELERATION], 0.0, atol=0.3)
    assert not found[:400, :, ROAD_KNOWN].any()
    for one in (first, second):
        assert one[450:, ROAD_KNOWN].all()
        assert one[500, ROAD_TURN] == pytest.approx(SPEED_MPS / RADIUS_M, abs=0.01)


def test_who_hears_nothing_follows_nobody(reader: Bank) -> None:
    assert not known(reader, 0.0, 30)[..., : LEADER_KNOWN + 1].any()


def test_threads_change_nothing(reader: Bank) -> None:
    np.testing.assert_array_equal(known(reader, 0.7, 60), known(reader, 0.7, 60, threads=2))
