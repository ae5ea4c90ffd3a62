"""Claims about a node that a person carries: what it speaks, hears, warns of, and shows."""

import json
from dataclasses import replace

import numpy as np
import pytest

from modelcast.cli.node import sender_of_config
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.core.kinds import SIZES_M, Kind
from modelcast.dashboard.document import read_snapshot, snapshot_text
from modelcast.messages.ieee1609 import encode_unsecured
from modelcast.messages.psids import PEOPLE_PSID, SAFETY_PSID
from modelcast.messages.wsmp import decode_wsm, encode_wsm
from modelcast.models.profile import default_profile
from modelcast.node.building import applications_of, envelope_of, node_of
from modelcast.node.config import NodeConfig, Roadside, Sending, Station
from modelcast.node.envelope import Opened, Unsecured
from modelcast.node.inputs.motion import Motion
from modelcast.node.node import Node, NodeState
from modelcast.node.plane import place_in
from modelcast.node.relaying import Relaying
from modelcast.node.run import Lateness
from modelcast.node.showing import Showing, figures_of
from modelcast.node.toml_file import tables_of
from modelcast.runtime.transport.virtual import VirtualMedium
from modelcast.station.relay import RelayRule

ORIGIN = Origin(48.0, 11.0)
KINDS = {
    "vehicle": Kind.VEHICLE,
    "pedestrian": Kind.PEDESTRIAN,
    "cyclist": Kind.CYCLIST,
    "roadworker": Kind.ROAD_WORKER,
}


def made(medium: VirtualMedium, kind: str, seed: int) -> Node:
    config = NodeConfig(station=Station(kind=kind), sending=Sending(policy="mbc"))
    return node_of(
        config,
        sender_of_config(config),
        medium.join(),
        envelope_of(None, config.security, utc_at_zero_s=0.0, names_seed=seed, kind=config.station.speaks),
        origin=ORIGIN,
        names_seed=seed,
        station_seed=seed,
    )


def at(t_s: float, place_m: tuple[float, float], speed_mps: float, heading_rad: float) -> Motion:
    return Motion(
        t_s=t_s,
        position_m=place_m,
        place_deg=(48.0, 11.0),
        speed_mps=speed_mps,
        heading_rad=heading_rad,
        acceleration_mps2=0.0,
        yaw_rate_radps=0.0,
        derived=frozenset(),
        covariance_m2=np.eye(2) * 1e-4,
        ellipse_known=True,
        age_s=0.0,
        begins=False,
        mode="gnss",
    )


def met(kind: str, steps: int = 30) -> tuple[list[tuple[Node, NodeState]], list[bytes]]:
    """A car drives north at 14 m/s; somebody steps onto its path before it is there."""
    medium = VirtualMedium(instant_s=0.1)
    car, person, ear = made(medium, "vehicle", 1), made(medium, kind, 2), medium.join()
    states = [(car, car.step(0.0, None)), (person, person.step(0.0, None))]
    frames: list[bytes] = []
    for step in range(1, steps + 1):
        t_s = 0.1 * step
        drives, walks = (0.0, -70.0 + 14.0 * t_s), (6.0 - 1.4 * t_s, 0.0)
        motions = (at(t_s, drives, 14.0, 0.0), at(t_s, walks, 1.4, 1.5 * np.pi))
        states = []
        for node, motion in zip((car, person), motions, strict=True):
            node.hear(t_s)
            states.append((node, node.step(t_s, motion)))
            node.send(t_s + 0.05)
        frames += [one.octets for one in ear.receive(t_s + 0.09)]
    return states, frames


@pytest.mark.parametrize("kind", ["pedestrian", "cyclist", "roadworker"])
def test_car_and_person_know_and_warn_of_each_other(kind: str) -> None:
    ((car, driving), (person, walking)), _ = met(kind)
    assert driving.around.kind.tolist() == [KINDS[kind]]
    assert walking.around.kind.tolist() == [Kind.VEHICLE]
    assert np.hypot(*(driving.around.position_m[0] - (6.0 - 1.4 * 3.0, 0.0))) < 0.5
    assert np.hypot(*(walking.around.position_m[0] - (0.0, -70.0 + 14.0 * 3.0))) < 0.5
    for node, state in ((car, driving), (person, walking)):
        assert {one.application for one in state.warnings} == {"vru"}
        (remote,) = Showing(node).snapshot(state).remotes.kind
        assert remote == state.around.kind[0]


def test_a_persons_device_understands_the_models_of_vehicles() -> None:
    person = made(VirtualMedium(), "cyclist", 4)
    vehicles = default_profile().bank.carried().complete()
    assert person.station.model_names[1] == tuple(member.name for member in vehicles.members)


def test_two_vehicles_are_not_warned_of_as_people() -> None:
    ((_, driving), (_, other)), _ = met("vehicle")
    assert "vru" not in {one.application for one in (*driving.warnings, *other.warnings)}


def test_what_a_person_sends_goes_in_its_own_application() -> None:
    _, frames = met("cyclist")
    psids = {(message.psid, message.payload[3:5]) for message in map(decode_wsm, frames)}
    assert psids >= {(SAFETY_PSID, b"\x00\x14"), (PEOPLE_PSID, b"\x00\x20")}
    assert (SAFETY_PSID, b"\x00\x20") not in psids
    assert (PEOPLE_PSID, b"\x00\x14") not in psids


def test_a_message_in_the_application_of_others_is_refused() -> None:
    for octets, psid in ((b"\x00\x14abc", PEOPLE_PSID), (b"\x00\x20abc", SAFETY_PSID)):
        frame = encode_wsm(encode_unsecured(octets), psid)
        assert Unsecured().open(frame, received_s=0.0) == Opened(None, "another application")
    for octets, psid in ((b"\x00\x20abc", PEOPLE_PSID), (b"\x00\xf0abc", SAFETY_PSID)):  # a relay's
        assert decode_wsm(Unsecured().wrap(octets, sent_s=0.0)).psid == psid
    named = encode_wsm(encode_unsecured(b"\x00\xf0abc"), PEOPLE_PSID)
    assert Unsecured().open(named, received_s=0.0) == Opened(b"\x00\xf0abc", "accepted")


def test_the_kind_is_in_lines_for_other_programs_and_in_the_figures() -> None:
    ((car, driving), _), _ = met("pedestrian")
    text = snapshot_text(Showing(car).snapshot(driving))
    assert json.loads(text)["remotes"]["kind"] == [Kind.PEDESTRIAN]
    read = read_snapshot(text).remotes
    assert read.kind is not None
    assert read.kind.tolist() == [Kind.PEDESTRIAN]
    figures = {one.name: one.values for one in figures_of(car, driving, Lateness())}
    assert figures["modelcast_remotes_by_kind"] == {
        "vehicle": 0.0, "pedestrian": 1.0, "cyclist": 0.0, "road_worker": 0.0,
    }  # fmt: skip


def test_a_persons_message_tells_a_place_to_begin_at_and_is_repeated_by_a_relay() -> None:
    _, frames = met("pedestrian")
    said = [one for one in frames if decode_wsm(one).psid == PEOPLE_PSID]
    place = place_in(said[0])
    assert place is not None
    assert (place.latitude_deg, place.longitude_deg) == pytest.approx((48.0, 11.0), abs=1e-3)
    unit = made(VirtualMedium(), "vehicle", 3)
    relaying = Relaying(RelayRule(rate_hz=100.0, within_m=500.0, max_age_s=1.0), 0.1)
    octets = [Unsecured().open(one, received_s=0.0).octets or b"" for one in said[:1]]
    receipts = unit.station.hear(octets, received_s=[0.2])
    relaying.hear(octets, [0.2], receipts)
    repeated = [
        one for now_s in (0.2, 0.3, 0.4) for _, one in relaying.turn(now_s, unit.station.believe(now_s))
    ]
    assert repeated == octets


def test_what_a_kind_is_asked_to_be() -> None:
    walker = NodeConfig(station=Station(kind="pedestrian"))
    assert list(applications_of(walker)) == ["vru"]
    assert list(applications_of(NodeConfig())) == ["fcw", "eebl", "ima", "vru"]
    sender = sender_of_config(walker)
    assert sender.kind == Kind.PEDESTRIAN
    assert [member.name for member in sender.bank.members] == ["stop-and-go"]
    own = sender_of_config(replace(walker, sending=Sending(bank="cv+ctra")))
    assert [member.name for member in own.bank.members] == ["cv", "ctra"]
    free = sender_of_config(replace(walker, sending=Sending(policy="free")))
    assert [member.name for member in free.bank.members] == ["stop-and-go"]
    named = sender_of_config(replace(walker, sending=Sending(profile="default")))
    assert named.bank.name == default_profile().bank.name
    assert sender_of_config(NodeConfig()).kind == Kind.VEHICLE
    assert SIZES_M[Kind.PEDESTRIAN] < SIZES_M[Kind.VEHICLE]


def test_a_roadside_unit_is_nobody_who_walks() -> None:
    with pytest.raises(ValueError, match="nobody carries"):
        NodeConfig(station=Station(kind="cyclist"), roadside=Roadside(on=True))
    with pytest.raises(DataFormatError, match=r"nobody carries.*cyclist"):
        tables_of('[station]\nkind = "cyclist"\n[roadside]\non = true\n', NodeConfig)
    with pytest.raises(DataFormatError, match="kind"):
        tables_of('[station]\nkind = "horse"\n', NodeConfig)
