"""Claims about a node, a step at a time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pytest

from modelcast.apps.registry import get_application
from modelcast.apps.warnings import Level
from modelcast.channel.erasure import IndependentErasure
from modelcast.core.geodesy import Origin, local_to_geodetic
from modelcast.node.inputs.motion import Motion
from modelcast.node.node import Node, NodeState
from modelcast.node.pseudonyms import Pseudonyms
from modelcast.runtime.transport.base import AbstractTransport, Arrival
from modelcast.runtime.transport.virtual import VirtualMedium
from modelcast.station.station import Station

ORIGIN = Origin(48.0, 11.0, 500.0)


class Straight:
    """Drives north at constant speed, and brakes from a time on; knows nothing within the gaps."""

    def __init__(
        self,
        north_m: float,
        speed_mps: float,
        *,
        brakes_s: float = np.inf,
        gap_s: tuple[float, float] = (9e9, 9e9),
    ) -> None:
        self.north_m, self.speed_mps, self.brakes_s, self.gap_s = north_m, speed_mps, brakes_s, gap_s

    def at(self, now_s: float) -> Motion | None:
        """Where it is."""
        if self.gap_s[0] <= now_s < self.gap_s[1]:
            return None
        past_s = min(max(now_s - self.brakes_s, 0.0), self.speed_mps / 6.0)
        way_m = self.north_m + self.speed_mps * min(now_s, self.brakes_s)
        way_m += self.speed_mps * past_s - 3.0 * past_s**2
        braking = 0.0 < past_s < self.speed_mps / 6.0
        return moving(now_s, way_m, self.speed_mps - 6.0 * past_s, acceleration_mps2=-6.0 if braking else 0.0)


def moving(now_s: float, north_m: float, speed_mps: float, *, acceleration_mps2: float = 0.0) -> Motion:
    """On the way north."""
    latitude, longitude = local_to_geodetic(np.array([[0.0, north_m]]), ORIGIN)[0].tolist()
    return Motion(
        t_s=now_s,
        mode="gnss+can",
        place_deg=(latitude, longitude),
        position_m=(0.0, north_m),
        speed_mps=speed_mps,
        heading_rad=0.0,
        acceleration_mps2=acceleration_mps2,
        yaw_rate_radps=0.0,
        derived=frozenset(),
        covariance_m2=np.eye(2) * 1e-4,
        ellipse_known=True,
        age_s=0.0,
        begins=False,
    )


@dataclass
class Driven:
    """A node and the drive that it measures."""

    node: Node
    drive: Straight


class Tape(AbstractTransport):
    """Keeps what is sent, and gives what is put in."""

    def __init__(self) -> None:
        self.sent: list[tuple[bytes, float]] = []
        self.inbox: list[Arrival] = []

    def send(self, octets: bytes, *, sent_s: float) -> None:
        """Keep it."""
        self.sent.append((octets, sent_s))

    def receive(self, until_s: float) -> list[Arrival]:  # noqa: ARG002
        """Give what was put in."""
        found, self.inbox = self.inbox, []
        return found


def a_station(number: int, policy: str = "mbc") -> Station:
    return Station(policy, temporary_id=number, origin=ORIGIN, seed=number)


def drive(driven: Sequence[Driven], steps: int, first: int = 1) -> list[list[NodeState]]:
    """Steps of several nodes on one clock; frames leave when they are due, between steps."""
    states: list[list[NodeState]] = []
    for step in range(first, first + steps):
        now_s = 0.1 * step
        for one in driven:
            one.node.hear(now_s)
        states.append([one.node.step(now_s, one.drive.at(now_s)) for one in driven])
        for one in driven:
            one.node.send(now_s + 0.0999)
    return states


def test_a_node_sends_what_its_station_would() -> None:
    tape, source, alone = Tape(), Straight(0.0, 15.0), a_station(7)
    node = Node(a_station(7), tape)
    drive([Driven(node, source)], 60)
    wanted: list[bytes] = []
    for step in range(1, 61):
        motion = source.at(0.1 * step)
        assert motion is not None
        wanted += [
            one.octets
            for one in alone.sense(
                0.1 * step,
                motion.position_m,
                speed_mps=15.0,
                heading_rad=0.0,
                acceleration_mps2=0.0,
                yaw_rate_radps=0.0,
            )
        ]
    assert [octets for octets, _ in tape.sent] == wanted
    assert node.counts["sent"] == len(wanted) > 3
    assert node.counts["sent_octets"] == sum(map(len, wanted))


def test_the_same_inputs_give_the_same_frames_and_map() -> None:
    def once() -> tuple[list[list[float]], dict[str, int]]:
        medium = VirtualMedium(IndependentErasure(0.3), delay_s=0.01, seed=4)
        nodes = [
            Driven(Node(a_station(number), medium.join()), Straight(-30.0 * number, 15.0))
            for number in (1, 2)
        ]
        states = drive(nodes, 80)
        return [one.around.position_m.ravel().tolist() for _, one in states], dict(nodes[1].node.counts)

    assert once() == once()


def test_a_host_believes_the_remote_to_be_where_it_is() -> None:
    medium = VirtualMedium(delay_s=0.01)
    front = Driven(Node(a_station(1), medium.join()), Straight(0.0, 15.0))
    back = Driven(Node(a_station(2), medium.join()), Straight(-40.0, 15.0))
    states = drive([front, back], 60)
    last = states[-1][1]
    assert last.around.vehicle.tolist() == [1]
    assert np.allclose(last.around.position_m[0], (0.0, 15.0 * last.t_s), atol=0.3)
    assert back.node.counts["heard"] == front.node.counts["sent"] - len(front.node._waiting)
    assert back.node.counts["receipt: accepted"] > 0


def test_a_leader_that_brakes_is_warned_of_and_the_warning_is_told_once() -> None:
    events: list[tuple[str, Mapping[str, object]]] = []
    medium = VirtualMedium(delay_s=0.01)
    front = Driven(Node(a_station(1), medium.join()), Straight(0.0, 20.0, brakes_s=4.0))
    back = Driven(
        Node(
            a_station(2),
            medium.join(),
            applications={"fcw": get_application("fcw")},
            watch=lambda name, what: events.append((name, dict(what))),
        ),
        Straight(-25.0, 20.0),
    )
    states = drive([front, back], 55)
    warned = [one.warnings for _, one in states]
    first = next(at for at, found in enumerate(warned) if found and found[0].level == Level.WARNING)
    assert 4.0 < states[first][1].t_s < 5.0
    assert not any(found and found[0].level == Level.WARNING for found in warned[:first])
    one = warned[first][0]
    assert (one.application, one.vehicle) == ("fcw", 1)
    assert one.margin_m <= 0.0
    told = [what["level"] for name, what in events if name == "warning"]
    assert told.count("warning") == 1


def test_without_a_motion_it_is_silent_and_hears_on_and_says_so() -> None:
    events: list[tuple[str, Mapping[str, object]]] = []
    medium = VirtualMedium(delay_s=0.01)
    front = Driven(Node(a_station(1), medium.join()), Straight(0.0, 15.0))
    back = Driven(
        Node(
            a_station(2),
            medium.join(),
            applications={"fcw": get_application("fcw")},
            watch=lambda name, what: events.append((name, dict(what))),
        ),
        Straight(-40.0, 15.0, gap_s=(3.0, 5.0)),
    )
    before = drive([front, back], 29)
    sent = back.node.counts["sent"]
    silent = drive([front, back], 20, first=30)
    assert back.node.counts["sent"] == sent
    assert all(one.motion is None for _, one in silent)
    assert silent[-1][1].around.vehicle.tolist() == [1]
    drive([front, back], 30, first=50)
    assert back.node.counts["sent"] > sent
    assert [what["mode"] for name, what in events if name == "motion"] == ["gnss+can", "silent", "gnss+can"]
    assert len(before) == 29


def test_a_new_name_ends_the_old_track_and_nothing_of_the_old_name_follows() -> None:
    medium = VirtualMedium(delay_s=0.001)
    names = Pseudonyms(2.0, 2.0, np.random.default_rng(5))
    station = Station("bsm-10hz", temporary_id=names.temporary_id, origin=ORIGIN)
    front = Driven(Node(station, medium.join(), pseudonyms=names), Straight(0.0, 15.0))
    back = Driven(Node(a_station(2), medium.join()), Straight(-40.0, 15.0))
    seen = [tuple(one.around.vehicle.tolist()) for _, one in drive([front, back], 70)]
    assert names.changes == 3
    # Never two of one vehicle, and every name is one for two seconds.
    assert max(map(len, seen)) == 1
    assert len(dict.fromkeys(seen)) == 1 + 4


def test_what_is_no_message_is_counted_and_harms_nothing() -> None:
    tape = Tape()
    node = Node(a_station(1), tape)
    rng = np.random.default_rng(2)
    tape.inbox = [Arrival(rng.bytes(size), 0.05) for size in range(1, 300)]
    node.hear(0.05)
    assert node.counts["heard"] == 299
    assert node.counts["receipt: not a possible message"] == 299
    assert node.step(0.1, None).around.vehicle.size == 0


@pytest.mark.parametrize("span_s", [(0.0, 0.0), (5.0, 9.0)])
def test_names_change_within_their_span_or_never(span_s: tuple[float, float]) -> None:
    names = Pseudonyms(*span_s, np.random.default_rng(8))
    changed = [step * 0.1 for step in range(2000) if names.due(step * 0.1)]
    if span_s[1] == 0.0:
        assert changed == []
        return
    gaps = np.diff([0.0, *changed])
    assert names.changes == len(changed) > 20
    assert gaps.min() >= span_s[0] - 1e-9
    assert gaps.max() <= span_s[1] + 0.2
