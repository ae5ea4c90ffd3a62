"""Cruise control for another simulator: where that moves vehicles as ours does, it drives as ours."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.apps.cruise.base import AbstractCruiseLaw
from modelcast.apps.cruise.path import PathCacc
from modelcast.apps.cruise.ploeg import Ploeg
from modelcast.channel.erasure import IndependentErasure
from modelcast.channel.erasure_radio import ErasureRadio
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.runtime.platoon.control import CruiseControl
from modelcast.runtime.platoon.drive import DriveSettings, drive_platoons
from modelcast.runtime.platoon.knowledge import Heard
from modelcast.station.sender.message_arrays import MESSAGES
from modelcast.study.cruise.senders import platoon_sender
from modelcast.world.platoon.dynamics import PlatoonState, driven
from modelcast.world.platoon.leaders import Sinusoid
from modelcast.world.platoon.platoons import Platoons
from modelcast.world.scenario.base import STEP_S

PLATOONS, SECONDS = Platoons(2, 3), 12.0
RADIO = ErasureRadio(IndependentErasure(0.3))


def begun(law: AbstractCruiseLaw) -> PlatoonState:
    """Platoons at the leader's first speed and the law's gap."""
    first_mps = float(Sinusoid().speed_mps(np.zeros(1))[0])
    return PLATOONS.init(law.gap_m(np.full((2, 2), first_mps)), first_mps)


@pytest.mark.parametrize("law", [PathCacc(), Ploeg()])
@pytest.mark.parametrize("name", ["bsm-10hz", "mbc"])
def test_it_drives_as_the_closed_loop_of_ours(law: AbstractCruiseLaw, name: str) -> None:
    sender = platoon_sender(name, threshold_m=0.05)
    settings = NetworkSettings(reach_m=1000.0)
    loop = FleetLoop(PLATOONS.frame(begun(law)), sender, RADIO, settings, seed=3)
    plan = DriveSettings(duration_s=SECONDS, moments=1, ranging=False, settle_s=0.0)
    ours = drive_platoons(PLATOONS, Sinusoid(), law, Heard(PLATOONS, loop, most_age_s=5.0), plan)

    control = CruiseControl(PLATOONS, law, sender, RADIO, seed=3)
    state = begun(law)
    speeds = Sinusoid().speed_mps(np.arange(ours.t_s.size + 1) * STEP_S)
    gaps, ages, lost = [], [], []
    for step in range(ours.t_s.size):
        state = replace(state, t_s=round(step * STEP_S, 9))
        asked = control.step(PLATOONS.frame(state))
        gaps.append(PLATOONS.gap_m(state))
        ages.append(asked.age_s.reshape(2, 2))
        lost.append(asked.fell_back.reshape(2, 2))
        acceleration = asked.acceleration_mps2.reshape(2, 2)
        state = driven(state, acceleration, float(speeds[step + 1]), STEP_S, PLATOONS.drive)
    np.testing.assert_array_equal(np.array(gaps), ours.gap_m)
    np.testing.assert_array_equal(np.array(ages), ours.age_s)
    np.testing.assert_array_equal(np.array(lost), ours.fell_back)
    assert control.messages == loop.sent.total[MESSAGES] > 0


def test_what_is_asked_for_stays_within_the_limits() -> None:
    control = CruiseControl(PLATOONS, PathCacc(), platoon_sender("bsm-10hz"), ErasureRadio(), seed=1)
    state = PLATOONS.init(np.array([[-3.0, 200.0], [-3.0, 200.0]]), 20.0)
    for step in range(4):
        asked = control.step(PLATOONS.frame(replace(state, t_s=round(step * STEP_S, 9))))
    limits = PLATOONS.drive
    assert asked.acceleration_mps2.max() == limits.most_mps2
    assert asked.acceleration_mps2.min() >= -limits.hardest_mps2


def test_what_does_not_fit_is_told() -> None:
    sender = platoon_sender("bsm-10hz")
    with pytest.raises(ValueError, match="step_s must be positive"):
        CruiseControl(PLATOONS, PathCacc(), sender, RADIO, seed=1, step_s=0.0)
    control = CruiseControl(PLATOONS, PathCacc(), sender, RADIO, seed=1)
    assert (control.loop, control.messages) == (None, 0)
    other = Platoons(1, 4)
    with pytest.raises(ValueError, match="6 slots, got a frame of 4"):
        control.step(other.frame(other.init(np.full((1, 3), 5.0), 20.0)))
