"""Claims about what stations on the air know of the road and of each other."""

import numpy as np
import pytest

from modelcast.models.context_columns import (
    LEADER_ACCELERATION,
    LEADER_GAP,
    LEADER_KNOWN,
    LEADER_RELATIVE_SPEED,
    ROAD_KNOWN,
    ROAD_TURN,
)
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.station.arrays import sensed
from modelcast.station.context.knowledge import Knowledge
from modelcast.station.receiver.heard import Heard, HeardKind
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap


def plain(t_s: float, north_m: float, speed_mps: float) -> Heard:
    """A plain message of remote 9 that drives north."""
    one, whole = np.full(1, np.nan), np.zeros(1, dtype=np.int64)
    return Heard(
        np.full(1, int(HeardKind.PLAIN)),
        whole + 9,
        np.array([round(10.0 * t_s)]),
        t_s=np.array([t_s]),
        received_s=np.array([t_s]),
        position_m=np.array([[0.0, north_m]]),
        speed_mps=np.array([speed_mps]),
        heading_rad=np.zeros(1),
        acceleration_mps2=np.zeros(1),
        yaw_rate_radps=np.zeros(1),
        profile=whole - 1,
        in_use=whole,
        parameters=np.zeros((1, 0)),
        length_m=one,
        width_m=one,
        user=whole - 1,
    )


def test_a_station_follows_who_its_own_map_holds_ahead() -> None:
    around = LocalDynamicMap()
    _, state = around.hear(around.init(), plain(0.0, 40.0, 12.0))
    knowledge, sample = Knowledge(2), np.array([0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 0.0])
    row = np.zeros(13)
    who, motion = around.motions(state, 1.0)
    knowledge.follow(1.0, 1, sample, who=who, motion=motion, row=row)
    assert row[LEADER_KNOWN] == 1.0
    assert row[[LEADER_GAP, LEADER_RELATIVE_SPEED, LEADER_ACCELERATION]] == pytest.approx([52.0, 2.0, 0.0])
    who, motion = around.motions(state, 9.0)
    knowledge.follow(9.0, 1, sample, who=who, motion=motion, row=row)
    assert not row[: LEADER_KNOWN + 1].any()


def test_each_station_remembers_its_own_drive_until_another_takes_its_place() -> None:
    knowledge = Knowledge(2)
    who = np.array([1, 0], dtype=np.int64)
    for step in range(1400):
        angle = 0.01 * step
        one = [100.0 * np.sin(angle), 100.0 * np.cos(angle), 10.0 * np.cos(angle), -10.0 * np.sin(angle)]
        samples = np.array([[*one, 0.0, 0.1, 0.0], [0.0, 10.0 * 0.1 * step, 0.0, 10.0, 0.0, 0.0, 0.0]])
        rows = knowledge.drive(0.1 * step, who, samples)
        if step == 800:
            assert rows[0, ROAD_KNOWN] == 1.0
            assert rows[0, ROAD_TURN] == pytest.approx(0.1, abs=0.01)
            assert not rows[1].any()
            knowledge.forget(np.array([False, True]))
        elif step > 800:
            assert not rows[0].any()


def test_context_stands_behind_the_newest_sample_in_both_its_places() -> None:
    held = sensed(3, 4, SAMPLE_COLUMNS + 13)
    held.taken[:] = 6, 0, 1
    Knowledge(3).lay(held, np.array([0, 2]), np.array([np.arange(13.0), np.full(13, 5.0)]))
    for at in (1, 5):
        assert held.samples[0, at, SAMPLE_COLUMNS:].tolist() == list(range(13))
    for at in (0, 4):
        assert (held.samples[2, at, SAMPLE_COLUMNS:] == 5.0).all()
    assert held.samples[..., SAMPLE_COLUMNS:].any(axis=2).sum() == 4
