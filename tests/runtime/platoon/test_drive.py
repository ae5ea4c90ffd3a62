"""Platoons in a closed loop: against theory where they know all, and against that where they hear."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from modelcast.apps.cruise.acc import Acc
from modelcast.apps.cruise.base import AbstractCruiseLaw
from modelcast.apps.cruise.path import PathCacc
from modelcast.apps.cruise.ploeg import Ploeg
from modelcast.channel.dsrc import Dsrc
from modelcast.channel.erasure import Ideal, IndependentErasure
from modelcast.channel.erasure_radio import ErasureRadio
from modelcast.channel.radio import AbstractRadio
from modelcast.core.arrays import FloatArray
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.runtime.platoon.drive import DriveSettings, PlatoonTrace, drive_platoons, platoon_frames
from modelcast.runtime.platoon.knowledge import Heard, Perfect
from modelcast.study.cruise.senders import platoon_sender
from modelcast.world.platoon.leaders import BEGINS_S, AbstractLeader, Braking, RecordedSpeed, Sinusoid, Steady
from modelcast.world.platoon.platoons import Platoons

LAWS: tuple[AbstractCruiseLaw, ...] = (PathCacc(), Ploeg(), Acc())
every_law = pytest.mark.parametrize("law", LAWS, ids=[law.name for law in LAWS])

PLATOONS = Platoons(2, 4)

ROUNDING = 1e-6
"""Some thousand steps in double precision."""

STEPPING_RATIO = 0.01
"""A law asked every 10 ms acts 5 ms late on average: 0.6 % of a radian at 0.2 Hz, for a gain of about 1."""

SPEED_GRAIN_MPS, PLACE_GRAIN_M = 0.02, 0.03
"""Steps of a message's speed; its place's, 1.1 cm an axis, and half a step of speed over 0.1 s."""


def perfect(law: AbstractCruiseLaw, leader: AbstractLeader, **settings: float) -> PlatoonTrace:
    return drive_platoons(PLATOONS, leader, law, Perfect(PLATOONS), DriveSettings(**settings))  # pyright: ignore[reportArgumentType]


def heard(
    law: AbstractCruiseLaw,
    leader: AbstractLeader,
    settings: DriveSettings,
    *,
    name: str = "bsm-10hz",
    loss: float = 0.0,
    seed: int = 0,
    most_age_s: float = np.inf,
) -> PlatoonTrace:
    return drive_platoons(PLATOONS, leader, law, on_air(law, name, loss, seed, most_age_s), settings)


def on_air(
    law: AbstractCruiseLaw,
    name: str = "bsm-10hz",
    loss: float = 0.0,
    seed: int = 0,
    most_age_s: float = np.inf,
) -> Heard:
    radio = ErasureRadio(IndependentErasure(loss) if loss else Ideal())
    return Heard(PLATOONS, fleet(law, name, radio, seed), most_age_s=most_age_s)


def fleet(law: AbstractCruiseLaw, name: str, radio: AbstractRadio[Any], seed: int = 0) -> FleetLoop:
    speed = 100.0 / 3.6
    first = PLATOONS.frame(PLATOONS.init(law.gap_m(np.full((2, 3), speed)), speed))
    return FleetLoop(first, platoon_sender(name), radio, NetworkSettings(), seed=seed)


@every_law
def test_an_equilibrium_stays(law: AbstractCruiseLaw) -> None:
    trace = perfect(law, Steady(), duration_s=20.0)
    assert np.abs(trace.too_near_m).max() < ROUNDING
    assert np.ptp(trace.speed_mps) < ROUNDING
    assert not trace.fell_back.any()


@pytest.mark.slow
@every_law
def test_behind_a_leader_that_has_come_to_a_new_speed_spacing_errors_vanish(law: AbstractCruiseLaw) -> None:
    leader = RecordedSpeed("up", np.array([0.0, 4.0]), np.array([25.0, 28.0]))
    trace = perfect(law, leader, duration_s=80.0)
    during = np.abs(trace.too_near_m[trace.t_s < 20.0]).max()
    assert during > 0.05
    assert np.abs(trace.too_near_m[-1]).max() < 0.01 * during


@pytest.mark.parametrize(
    "law",
    [pytest.param(law, id=law.name, marks=pytest.mark.slow if law is not LAWS[0] else ()) for law in LAWS],
)
def test_swings_reach_every_follower_as_linear_theory_says(law: AbstractCruiseLaw) -> None:
    """Amplitudes over the leader's in the last four of 16 swings, law asked every 10 ms about the truth."""
    leader = Sinusoid()
    trace = perfect(law, leader, duration_s=85.0, frame_s=0.01, moments=1)
    late = trace.t_s >= 65.0 - 1e-9
    turn = np.exp(-2j * np.pi * leader.frequency_hz * trace.t_s[late])
    swings = 2.0 * np.abs((trace.speed_mps[late][:, 0] * turn[:, None]).mean(axis=0))
    s = np.array([2j * np.pi * leader.frequency_hz])
    theory = [np.ones(1, dtype=np.complex128)]
    for _ in range(PLATOONS.vehicles - 1):
        theory.append(law.response(s, theory[-1], theory[0], PLATOONS.drive.lag_s))
    expected = leader.amplitude_mps * np.array([abs(one[0]) for one in theory])
    for place in range(PLATOONS.vehicles):
        assert swings[place] == pytest.approx(expected[place], rel=STEPPING_RATIO * max(1, place)), place


@pytest.mark.parametrize("ranging", [True, False])
def test_who_hears_of_a_steady_leader_keeps_the_ideal_gap(ranging: bool) -> None:
    """With all that messages round, the loop on the air is the ideal one."""
    settings = DriveSettings(duration_s=20.0, ranging=ranging)
    trace = heard(PathCacc(), Steady(), settings)
    kept = trace.t_s >= BEGINS_S
    assert not trace.fell_back[kept].any()
    assert trace.age_s[kept] == pytest.approx(0.1)
    # The gap by the law's own balance: gain of speed over gain of place, of half a step of speed.
    slack_m = 0.5 * SPEED_GRAIN_MPS * sum(PathCacc().gains[:2]) / PathCacc().gains[2] + PLACE_GRAIN_M
    assert np.abs(trace.too_near_m[kept]).max() < slack_m
    assert np.ptp(trace.speed_mps[kept]) < 2 * SPEED_GRAIN_MPS


@pytest.mark.parametrize(("deceleration_mps2", "collides"), [(4.0, False), (5.0, True)])
def test_behind_a_harder_stop_5_m_are_too_few_even_for_perfect_knowledge(
    deceleration_mps2: float, collides: bool
) -> None:
    """What is told is what the brakes ahead do, and the own ones come a lag later."""
    trace = perfect(PathCacc(), Braking(deceleration_mps2=deceleration_mps2), duration_s=25.0)
    assert (trace.gap_m.min() <= 0.0) == collides


def test_any_radio_may_be_in_the_loop() -> None:
    """IEEE 802.11p with nobody else in reach: what it carries drives as what loses nothing does."""
    law, settings = PathCacc(), DriveSettings(duration_s=12.0)
    over = Heard(PLATOONS, fleet(law, "bsm-10hz", Dsrc()))
    trace = drive_platoons(PLATOONS, Sinusoid(), law, over, settings)
    other = heard(law, Sinusoid(), settings)
    kept = trace.t_s >= BEGINS_S
    assert not trace.fell_back[kept].any()
    assert np.abs(trace.gap_m - other.gap_m).max() < 2.0 * PLACE_GRAIN_M


def test_what_followers_know_at_a_frame_was_said_of_the_frame_before() -> None:
    """Place and speed of 0.1 s ago, coasted: nobody hears what is said only now."""
    law, knowledge = PathCacc(), on_air(PathCacc())
    _, ahead, leader = PLATOONS.pairs
    frames = list(platoon_frames(PLATOONS, Sinusoid(), law, Perfect(PLATOONS), DriveSettings(duration_s=9.0)))
    for before, frame in pairwise(frames):
        knowledge.listen(before)
        if frame.t_s < BEGINS_S + 1.0:
            continue
        told = knowledge.told(frame)
        for motions, slots in ((told.ahead, ahead), (told.leader, leader)):
            coasted = before.position_m[slots, 0] + 0.1 * before.speed_mps[slots]
            assert motions.position_m[:, 0] == pytest.approx(coasted, abs=PLACE_GRAIN_M)
            assert motions.speed_mps == pytest.approx(before.speed_mps[slots], abs=SPEED_GRAIN_MPS)
            assert motions.acceleration_mps2 == pytest.approx(before.acceleration_mps2[slots], abs=0.01)
        assert told.age_s == pytest.approx(0.1)


def test_who_is_told_nothing_keeps_its_speed_for_a_while_and_then_the_headway_of_the_fallback() -> None:
    """It goes there as exp(-t/10 s): 0.9 m of 30 are left after 35 s."""
    trace = heard(PathCacc(), Steady(), DriveSettings(duration_s=40.0), loss=1.0)
    waiting = trace.t_s < BEGINS_S
    assert trace.fell_back.all()
    assert np.isnan(trace.age_s).all()
    assert np.ptp(trace.speed_mps[waiting]) < ROUNDING
    assert trace.gap_m[-1, 0, 0] == pytest.approx(Acc().gap_m(trace.speed_mps[-1, 0, 1]), rel=0.03)


def test_what_is_too_old_is_not_known() -> None:
    settings = DriveSettings(duration_s=12.0)
    trace = heard(PathCacc(), Steady(), settings, name="bsm-1hz", most_age_s=0.55)
    kept = trace.t_s >= BEGINS_S
    assert np.nanmax(trace.age_s[kept]) <= 0.55
    assert 0.4 < np.isnan(trace.age_s[kept]).mean() < 0.6
    assert np.all(trace.fell_back[np.isnan(trace.age_s)])


def test_one_seed_is_one_drive_and_another_is_another() -> None:
    settings = DriveSettings(duration_s=10.0)
    one, again, other = (
        heard(PathCacc(), Sinusoid(), settings, name="mbc", loss=0.5, seed=seed) for seed in (1, 1, 2)
    )
    assert np.array_equal(one.gap_m, again.gap_m)
    assert not np.array_equal(one.gap_m, other.gap_m)


def test_a_follower_without_a_sensor_is_driven_by_what_it_believes() -> None:
    """A swing that the radio tells: the sensor's gap and the believed one differ by what coasting misses."""
    settings = DriveSettings(duration_s=20.0)
    seeing = heard(PathCacc(), Sinusoid(), settings)
    blind = heard(PathCacc(), Sinusoid(), replace(settings, ranging=False))
    apart_m = np.abs(seeing.gap_m - blind.gap_m).max()
    assert 0.001 < apart_m < 0.5


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"duration_s": 0.0}, "duration_s"),
        ({"frame_s": -0.1}, "frame_s"),
        ({"moments": 0}, "moments"),
        ({"settle_s": -1.0}, "settle_s"),
    ],
)
def test_impossible_drives_are_refused(change: dict[str, float], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        replace(DriveSettings(), **change)


def test_frames_are_those_of_the_drive() -> None:
    settings = DriveSettings(duration_s=8.0)
    trace = perfect(PathCacc(), Sinusoid(), duration_s=8.0)
    frames = list(platoon_frames(PLATOONS, Sinusoid(), PathCacc(), Perfect(PLATOONS), settings))
    assert [frame.t_s for frame in frames] == trace.t_s.tolist()
    speeds: FloatArray = np.array([frame.speed_mps.reshape(2, 4) for frame in frames])
    assert np.array_equal(speeds, trace.speed_mps)
