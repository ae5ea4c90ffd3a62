"""Claims about the four nodes to try."""

import asyncio
import io
import random
import socket

import numpy as np
import pytest

from modelcast.core.geodesy import geodetic_to_local
from modelcast.node.clock import SteeredClock
from modelcast.node.config import Air, NodeConfig
from modelcast.node.demo import demo_trips
from modelcast.node.inputs.replay import TripReplay
from modelcast.node.journal import Journal
from modelcast.node.live import LiveNode
from modelcast.node.lossy import LossyTransport
from modelcast.node.showing import Showing
from modelcast.runtime.transport.virtual import VirtualMedium
from modelcast.station.sender.sender import named_sender

from .virtual_time import run_in_virtual_time


class VirtualClock(SteeredClock):
    """The running loop's time."""

    def __init__(self) -> None:
        super().__init__(1_764_000_000.0)

    def now_s(self) -> float:
        """Now."""
        return self.at(asyncio.get_running_loop().time())


def test_the_drives_are_what_their_columns_say_and_nobody_touches() -> None:
    trips = demo_trips()
    leader, second, third, crossing = (trips[name] for name in ("leader", "second", "third", "crossing"))
    for trip in (leader, second, third):
        assert trip.speed_mps is not None
        moved = np.diff(trip.position_m[:, 1]) / trip.dt_s
        mean = 0.5 * (trip.speed_mps[1:] + trip.speed_mps[:-1])
        assert np.abs(moved - mean).max() < 0.1
        assert trip.speed_mps.min() > 2.5
    for ahead, behind in ((leader, second), (second, third)):
        gap_m = ahead.position_m[:, 1] - behind.position_m[:, 1]
        assert gap_m.min() > 9.0
    # It crosses their road every half minute, ahead of the leader, and moves as its columns say.
    east_m, north_m = crossing.position_m.T
    crosses = np.flatnonzero(np.diff(np.signbit(east_m)))
    assert np.diff(crossing.t_s[crosses]) == pytest.approx(np.full(crosses.size - 1, 30.0), abs=0.11)
    assert 15.0 < (north_m - leader.position_m[:, 1])[crosses].min() < 40.0
    assert crossing.speed_mps is not None
    assert crossing.heading_rad is not None
    moved = np.diff(crossing.position_m, axis=0) / crossing.dt_s
    middle = 0.5 * (crossing.speed_mps[1:] + crossing.speed_mps[:-1])
    assert np.abs(np.hypot(*moved.T) - middle).max() < 0.05
    course = np.arctan2(*moved.T)
    assert np.abs(np.sin(course - crossing.heading_rad[:-1])).max() < 0.02


@pytest.mark.slow
def test_every_node_knows_the_others_in_spite_of_losses(monkeypatch: pytest.MonkeyPatch) -> None:
    # Nodes draw names and losses from what nobody can guess; here all runs draw the same.
    monkeypatch.setattr("secrets.randbits", random.Random(7).getrandbits)  # noqa: S311 - not for secrets
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = int(probe.getsockname()[1])

    async def main() -> dict[str, LiveNode]:
        clock, stop = VirtualClock(), asyncio.Event()
        air = Air(group="239.255.16.80", port=port, loss_ratio=0.3)
        nodes = {
            name: LiveNode(
                NodeConfig(air=air),
                named_sender("mbc"),
                Journal(io.StringIO(), lambda: 0.0),
                clock=clock,
                gnss=TripReplay(trip),
            )
            for name, trip in demo_trips().items()
        }
        asyncio.get_running_loop().call_later(24.0, stop.set)
        await asyncio.gather(*(node.run(stop) for node in nodes.values()))
        return nodes

    nodes = run_in_virtual_time(main())
    where = {
        node.node.station.temporary_id: node.state.motion.place_deg
        for node in nodes.values()
        if node.node is not None and node.state is not None and node.state.motion is not None
    }
    assert len(where) == 4
    off_m: list[float] = []
    received, lost = 0.0, 0.0
    for node in nodes.values():
        assert node.state is not None
        assert node.node is not None
        assert node.origin is not None
        around = node.state.around
        assert set(around.vehicle.tolist()) == set(where) - {node.state.temporary_id}
        true_m = geodetic_to_local(np.array([where[one] for one in around.vehicle.tolist()]), node.origin)
        off_m += np.hypot(*(around.position_m - true_m).T).tolist()
        # What the page shows of each: its error, and what came and was lost in the last five seconds.
        places = dict(zip(around.vehicle.tolist(), map(tuple, true_m.tolist()), strict=True))
        shown = Showing(node.node, lambda _, places=places: places).snapshot(node.state).remotes
        assert shown.error_m.tolist() == off_m[-3:]
        known = shown.messages > 1
        assert np.isnan(shown.loss_ratio[~known]).all()
        received += shown.messages[known].sum()
        lost += (shown.messages[known] * shown.loss_ratio[known] / (1.0 - shown.loss_ratio[known])).sum()
    # Several losses in a row leave one or another behind for a while.
    assert np.median(off_m) < 2.0
    assert max(off_m) < 20.0
    assert received > 12.0
    assert 0.05 < lost / (received + lost) < 0.65


def test_a_share_of_what_arrives_is_thrown_away() -> None:
    medium = VirtualMedium()
    one, other = medium.join(), LossyTransport(medium.join(), 0.3, seed=1)
    for step in range(2000):
        one.send(step.to_bytes(2, "big"), sent_s=0.1 * step)
    heard = [arrival.octets for arrival in other.receive(300.0)]
    assert len(heard) + other.lost == 2000
    assert 0.25 < other.lost / 2000 < 0.35
    assert heard == sorted(heard)
    other.send(b"mine", sent_s=300.0)
    assert [arrival.octets for arrival in one.receive(301.0)] == [b"mine"]
    with pytest.raises(ValueError, match="must lie in"):
        LossyTransport(one, 1.5, seed=1)
