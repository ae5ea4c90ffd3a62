"""Claims about the senders of ``modelcast serve``: those of ``modelcast network``, of people too."""

import dataclasses

import numpy as np
import pytest

from modelcast.cli.banks import bank_in_use, profile_in_use
from modelcast.cli.network_plan import NetworkPlan
from modelcast.cli.network_senders import sender_of as network_sender
from modelcast.cli.options import SensorOptions
from modelcast.core.kinds import Kind
from modelcast.runtime.external.exchange import SessionSettings
from modelcast.runtime.external.senders import sender_of
from modelcast.runtime.external.session import Session
from modelcast.station.fleet import Fleet
from modelcast.station.sender.names import sends_models
from modelcast.station.sender.sender import Sender
from modelcast.station.sensing.motion_filter import MotionFilter

from ..convoy import Convoy  # noqa: TID252 - tests are no package

PLAN = NetworkPlan(
    "highway",
    duration_s=6.0,
    warm_up_s=2.0,
    length_m=400.0,
    lanes=0,
    blocks=5,
    seed=0,
    certificates="gap",
    banks=("default",),
    profile=None,
    start=None,
    identify=None,
    cost="bytes",
    threads=1,
    thresholds_m=(0.2,),
    keep_alive_s=1.0,
    believe=None,
    budget=4.0 / 3.0,
    legacy_threshold_m=0.0,
    approach_m=20.0,
    relaxed_error_m=None,
    sensor=SensorOptions(),
)


def of_network(policy: str, kind: Kind, profile: str | None) -> Sender:
    """As a network run makes it with what it does of itself."""
    bank = "default" if kind == Kind.VEHICLE else "people"
    named = bank_in_use(bank, profile=profile_in_use(profile)) if sends_models(policy) else None
    return network_sender(
        dataclasses.replace(PLAN, profile=profile),
        policy,
        bank,
        threshold_m=0.2,
        named=named,
        motion=MotionFilter(),
        kind=kind,
    )


@pytest.mark.parametrize("profile", [None, "people"])
@pytest.mark.parametrize("kind", [Kind.VEHICLE, Kind.PEDESTRIAN, Kind.CYCLIST])
@pytest.mark.parametrize("policy", ["mbc", "free", "baseline", "cam", "j2945-free", "j2945-mbc"])
def test_a_session_sends_what_a_network_sends(policy: str, kind: Kind, profile: str | None) -> None:
    """The same bank and rules, and so the same octets, of vehicles and of people."""
    wanted = of_network(policy, kind, profile)
    settings = SessionSettings(1, sender=policy, people_slots=1, seed=4)
    found = sender_of(settings, kind, profile_in_use(profile))
    assert found.bank == wanted.bank
    assert (found.lanes.start, found.lanes.identify) == (wanted.lanes.start, wanted.lanes.identify)
    assert found.plain == wanted.plain
    session = Session(settings, lambda asked, own: sender_of(asked, own, profile_in_use(profile)))
    fleet = Fleet(wanted, slots=1, seed=settings.seed + int(kind))
    convoy, octets = Convoy(1), 0
    for number in range(40):
        step = convoy.step(number, kind=np.array([kind]))
        own = fleet.sense(
            step.t_s,
            step.vehicle,
            step.position_m,
            speed_mps=step.speed_mps,
            heading_rad=step.heading_rad,
            acceleration_mps2=step.acceleration_mps2,
            yaw_rate_radps=step.yaw_rate_radps,
        )
        sent = session.step(step).frames()
        assert sent == [one.octets for one in own]
        octets += sum(map(len, sent))
    assert octets


def test_hosts_of_every_kind_understand_the_models_of_the_others() -> None:
    """Who heard the same messages of a vehicle believes the same of it, a person as a vehicle."""
    session, convoy = Session(SessionSettings(2, people_slots=1, seed=4)), Convoy(3)
    kind = np.array([Kind.VEHICLE, Kind.PEDESTRIAN, Kind.VEHICLE])
    for number in range(40):
        convoy.carry(session.step(convoy.step(number, kind=kind)))
    person, vehicle = (session.believe(np.array([host]), 4.0) for host in (10, 17))
    at = [int(np.flatnonzero(one.vehicle == 3)[0]) for one in (person, vehicle)]
    for name in ("position_m", "velocity_mps", "covariance_m2", "yaw_rate_radps"):
        np.testing.assert_array_equal(getattr(person, name)[at[0]], getattr(vehicle, name)[at[1]])
