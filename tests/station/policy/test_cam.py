"""Claims about the triggering of cooperative awareness messages."""

import numpy as np
import pytest

from modelcast.station.policy.base import Air, Motion, TransmitInputs
from modelcast.station.policy.cam import CamTriggering, CooperativeAwareness
from modelcast.station.policy.dcc import AdaptiveDcc, ReactiveDcc
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive

TEN_HZ_S = 0.1 * np.arange(1200)


def plain(t_s: np.ndarray, position_m: np.ndarray, speed_mps: np.ndarray, heading_deg: np.ndarray) -> list:
    """Clause 6.1.3 word by word, in units of a tenth of a second."""
    sent, last, t_gen_cam, n_gen_cam = [0], 0, 1.0, 0
    for now in range(1, len(t_s)):
        elapsed = round(float(t_s[now] - t_s[last]), 6)
        turned = abs((heading_deg[now] - heading_deg[last] + 180.0) % 360.0 - 180.0)
        moved = np.linalg.norm(position_m[now] - position_m[last])
        faster = abs(speed_mps[now] - speed_mps[last])
        if elapsed >= 0.1 and (turned > 4.0 or moved > 4.0 or faster > 0.5):
            t_gen_cam, n_gen_cam = min(elapsed, 1.0), 0
        elif elapsed >= t_gen_cam:
            n_gen_cam += 1
            if n_gen_cam == 3:
                t_gen_cam, n_gen_cam = 1.0, 0
        else:
            continue
        sent.append(now)
        last = now
    return sent


def sent_at(speed_mps: np.ndarray, heading_deg: np.ndarray | float = 0.0) -> np.ndarray:
    heading = np.broadcast_to(np.deg2rad(heading_deg), TEN_HZ_S.shape)
    moved = 0.1 * np.concatenate([[0.0], np.cumsum(speed_mps[:-1])])
    position = np.stack([moved, 0 * moved], axis=1)
    return CamTriggering().transmit_indices(TEN_HZ_S, position, speed_mps=speed_mps, heading_rad=heading)


@pytest.mark.parametrize(
    ("speed_mps", "steps"),
    [(0.0, 10), (3.9, 10), (6.1, 7), (9.9, 5), (13.5, 3), (21.0, 2), (41.0, 1), (70.0, 1)],
)
def test_at_constant_speed_messages_come_after_the_first_sample_beyond_4_m(
    speed_mps: float, steps: int
) -> None:
    sent = sent_at(np.full(TEN_HZ_S.size, speed_mps))
    assert set(np.diff(sent)) == {steps}


def test_after_a_change_three_messages_keep_the_pace_then_one_a_second() -> None:
    """One jump of speed after 0.3 s: T_GenCam is 0.3 s for three messages by time-out."""
    speed = np.where(TEN_HZ_S < 1.25, 0.0, 0.6)
    heading = np.zeros(TEN_HZ_S.size)
    cam = CamTriggering().transmit_indices(
        TEN_HZ_S, np.zeros((TEN_HZ_S.size, 2)), speed_mps=speed, heading_rad=heading
    )
    assert cam[:7].tolist() == [0, 10, 13, 16, 19, 22, 32]


def test_a_turn_across_north_counts_the_short_way() -> None:
    assert set(np.diff(sent_at(np.zeros(TEN_HZ_S.size), 358.0 + 3.0 * (TEN_HZ_S % 2 > 1)))) == {10}
    assert len(sent_at(np.zeros(TEN_HZ_S.size), 358.0 + 5.0 * (TEN_HZ_S % 2 > 1))) > 121


@pytest.mark.parametrize("seed", range(6))
def test_random_drives_agree_with_the_clause_word_by_word(seed: int) -> None:
    rng = np.random.default_rng(seed)
    speed = np.abs(np.cumsum(rng.normal(0.0, 0.12, TEN_HZ_S.size)))
    heading = np.cumsum(rng.normal(0.0, 0.6, TEN_HZ_S.size))
    position = np.cumsum(
        0.1 * speed[:, None] * np.stack([np.sin(np.deg2rad(heading)), np.cos(np.deg2rad(heading))], axis=1),
        axis=0,
    )
    sent = CamTriggering().transmit_indices(
        TEN_HZ_S, position, speed_mps=speed, heading_rad=np.deg2rad(heading)
    )
    assert sent.tolist() == plain(TEN_HZ_S, position, speed, heading)


def test_rates_lie_between_1_and_10_hz_and_parts_start_anew(gapped: Trajectory) -> None:
    assert gapped.speed_mps is not None
    assert gapped.heading_rad is not None
    sent = CamTriggering().transmit_indices(
        gapped.t_s,
        gapped.position_m,
        speed_mps=gapped.speed_mps,
        heading_rad=gapped.heading_rad,
        segments=gapped.segments,
    )
    assert set(gapped.segments[:-1]) <= set(sent)
    for first, end in zip(gapped.segments[:-1], gapped.segments[1:], strict=True):
        steps_s = np.diff(gapped.t_s[sent[(sent >= first) & (sent < end)]])
        assert ((steps_s > 0.1 - 1e-6) & (steps_s < 1.0 + 1e-6)).all()


@pytest.fixture
def gapped() -> Trajectory:
    """A generated drive with a gap of 5 s."""
    drive = generate_drive(seed=3, duration_s=100.0).truth
    keep = (drive.t_s < 40.0) | (drive.t_s >= 45.0)
    assert drive.speed_mps is not None
    assert drive.heading_rad is not None
    return build_trajectory(
        "made/gap",
        drive.t_s[keep],
        drive.position_m[keep],
        speed_mps=drive.speed_mps[keep],
        heading_rad=drive.heading_rad[keep],
    )


@pytest.mark.parametrize(
    "wrong",
    [{"min_inter_transmit_time_s": 2.0}, {"distance_m": 0.0}, {"timeouts": 0}, {"heading_change_rad": -1.0}],
)
def test_what_is_out_of_range_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must be"):
        CamTriggering(**wrong)


def asked(
    policy: CooperativeAwareness, drive: Trajectory, *, busy: float = 0.0, airtime_s: float = 4e-4
) -> list[int]:
    """Samples at which one vehicle sends when asked sample by sample."""
    assert drive.speed_mps is not None
    assert drive.heading_rad is not None
    state = policy.init(1, 1)
    sent = []
    one, none = np.ones(1), np.zeros(1)
    for i, now in enumerate(drive.t_s):
        inputs = TransmitInputs(
            np.full(1, now),
            none,
            silence_s=none,
            tracking_error_m=np.zeros((1, 1)),
            available=np.ones((1, 1), dtype=np.bool_),
            motion=Motion(
                drive.position_m[i : i + 1],
                drive.speed_mps[i : i + 1],
                heading_rad=drive.heading_rad[i : i + 1],
                critical=np.zeros(1, dtype=np.bool_),
            ),
            air=Air(busy * one, none, packet_error_ratio=none, airtime_s=airtime_s * one),
        )
        decisions, state = policy.decide(state, inputs, np.random.default_rng(0))
        if decisions.kind[0]:
            sent.append(i)
    return sent


@pytest.mark.parametrize("shortest_s", [0.1, 0.3])
def test_asked_sample_by_sample_it_sends_what_the_replay_does(shortest_s: float) -> None:
    drive = generate_drive(seed=5, duration_s=100.0).truth
    assert drive.speed_mps is not None
    assert drive.heading_rad is not None
    triggering = CamTriggering(shortest_s)
    replayed = triggering.transmit_indices(
        drive.t_s, drive.position_m, speed_mps=drive.speed_mps, heading_rad=drive.heading_rad
    )
    assert asked(CooperativeAwareness(triggering, control=None), drive) == replayed.tolist()


def test_a_busy_channel_stretches_the_time_between_messages() -> None:
    """Fast on a motorway every 0.1-0.2 s; a share of 0.001 and 400 us airtime allow one in 0.4 s."""
    t_s = 0.1 * np.arange(300)
    drive = build_trajectory(
        "made/fast",
        t_s,
        np.stack([35.0 * t_s, 0.0 * t_s], axis=1),
        speed_mps=np.full(300, 35.0),
        heading_rad=np.full(300, 0.5 * np.pi),
    )
    free = np.diff(asked(CooperativeAwareness(), drive, busy=0.1))
    held = AdaptiveDcc(min_share=0.001, max_share=0.001)
    assert set(free.tolist()) == {2}
    assert set(np.diff(asked(CooperativeAwareness(control=held), drive)).tolist()) == {4}
    table = CooperativeAwareness(control=ReactiveDcc())
    assert set(np.diff(asked(table, drive, busy=0.55)).tolist()) == {5}
    # T_GenCam_Dcc stays within T_GenCamMin and T_GenCamMax however long the airtime.
    slow = np.diff(asked(CooperativeAwareness(control=held), drive, airtime_s=0.1))
    assert set(slow.tolist()) == {10}


def test_congestion_control_never_allows_less_than_100_ms() -> None:
    """Asked every 50 ms and moving 5 m in them: a share of 0.03 alone would allow a message every 25 ms."""
    t_s = 0.05 * np.arange(100)
    drive = build_trajectory(
        "made/faster",
        t_s,
        np.stack([100.0 * t_s, 0.0 * t_s], axis=1),
        speed_mps=np.full(100, 100.0),
        heading_rad=np.full(100, 0.5 * np.pi),
    )
    assert set(np.diff(asked(CooperativeAwareness(), drive)).tolist()) == {2}
