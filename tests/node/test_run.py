"""Claims about a node in real time, in a loop whose time is not the wall's."""

import asyncio
import socket

import numpy as np
import pytest

from modelcast.core.geodesy import Origin
from modelcast.node.inputs.motion import Motion
from modelcast.node.node import Node, NodeState
from modelcast.node.run import Lateness, run_node
from modelcast.runtime.transport.base import AbstractTransport, Arrival
from modelcast.station.station import Station

from .virtual_time import LoopClock, run_in_virtual_time

ORIGIN = Origin(48.0, 11.0, 500.0)
TICK_S = 0.1


def parked(now_s: float) -> Motion:
    """A vehicle that stands."""
    return Motion(
        t_s=now_s,
        mode="gnss",
        place_deg=(48.0, 11.0),
        position_m=(0.0, 0.0),
        speed_mps=0.0,
        heading_rad=0.0,
        acceleration_mps2=0.0,
        yaw_rate_radps=0.0,
        derived=frozenset(),
        covariance_m2=np.eye(2),
        ellipse_known=True,
        age_s=0.0,
        begins=False,
    )


class Paired(AbstractTransport):
    """One end of a pair of sockets; knows when frames left and were taken up."""

    def __init__(self, clock: LoopClock, end: socket.socket) -> None:
        self.clock, self.end = clock, end
        self.left_s: list[float] = []
        self.taken_s: list[float] = []
        end.setblocking(False)

    def send(self, octets: bytes, *, sent_s: float) -> None:
        """Put it into the socket."""
        self.left_s.append(sent_s)
        self.end.send(octets)

    def receive(self, until_s: float) -> list[Arrival]:
        """Take what is in the socket."""
        found: list[Arrival] = []
        while True:
            try:
                found.append(Arrival(self.end.recv(4096), until_s))
            except BlockingIOError:
                self.taken_s += [until_s] * len(found)
                return found


def a_node(transport: AbstractTransport, number: int = 1) -> Node:
    station = Station("bsm-10hz", temporary_id=number, origin=ORIGIN)
    return Node(station, transport)


def test_steps_are_at_whole_ticks_and_frames_leave_when_they_are_due() -> None:
    late, states, near, far = Lateness(), list[NodeState](), *socket.socketpair(type=socket.SOCK_DGRAM)

    async def main() -> list[float]:
        clock, stop = LoopClock(), asyncio.Event()
        transport = Paired(clock, near)
        node = a_node(transport)
        asyncio.get_running_loop().call_later(2.05, stop.set)
        await run_node(node, clock, parked, tick_s=TICK_S, stop=stop, publish=states.append, lateness=late)
        return transport.left_s

    with near, far:
        left_s = run_in_virtual_time(main())
    assert [one.t_s for one in states] == pytest.approx(TICK_S * np.arange(1, 21))
    assert late.count == 20
    assert late.skipped == 0
    assert late.quantile_s(1.0) < 1e-6
    assert len(left_s) == 20
    # Each leaves at a time of its own within its step, some milliseconds later as its policy draws it.
    assert (np.array(left_s) >= TICK_S * np.arange(1, 21)).all()
    assert np.diff(left_s) == pytest.approx(np.full(19, TICK_S), abs=0.01)


def test_a_frame_is_heard_as_it_comes_not_at_the_next_step() -> None:
    near, far = socket.socketpair(type=socket.SOCK_DGRAM)

    async def main() -> list[float]:
        clock, stop, loop = LoopClock(), asyncio.Event(), asyncio.get_running_loop()
        transport = Paired(clock, near)
        loop.call_later(0.53, far.send, b"frame")
        loop.call_later(0.57, far.send, b"frame")
        loop.call_later(0.95, stop.set)
        await run_node(a_node(transport), clock, parked, tick_s=TICK_S, stop=stop, fileno=near.fileno())
        return transport.taken_s

    with near, far:
        assert run_in_virtual_time(main()) == pytest.approx([0.53, 0.57])


@pytest.mark.parametrize(("costs_s", "waits_s"), [(0.0005, 0.0035), (0.001, 0.007), (0.02, 0.01)])
def test_what_comes_while_frames_have_just_been_heard_waits_in_proportion_to_what_that_took(
    costs_s: float, waits_s: float
) -> None:
    near, far = socket.socketpair(type=socket.SOCK_DGRAM)
    at_s = 0.51 + 0.0001 * np.arange(300)

    class Slow(Paired):
        """Takes its time, and notes when by the loop's."""

        def __init__(self, clock: LoopClock, end: socket.socket) -> None:
            super().__init__(clock, end)
            self.heard_s: list[float] = []

        def receive(self, until_s: float) -> list[Arrival]:
            found = super().receive(until_s)
            if found:
                self.heard_s.append(asyncio.get_running_loop().time())
                self.clock.spend(costs_s)
            return found

    async def main() -> list[float]:
        clock, stop, loop = LoopClock(), asyncio.Event(), asyncio.get_running_loop()
        for one_s in at_s.tolist():
            loop.call_at(loop.time() + one_s, far.send, b"frame")
        loop.call_later(0.59, stop.set)
        transport = Slow(clock, near)
        await run_node(a_node(transport), clock, parked, tick_s=TICK_S, stop=stop, fileno=near.fileno())
        assert len(transport.taken_s) == at_s.size
        return transport.heard_s

    with near, far:
        heard_s = run_in_virtual_time(main())
    assert heard_s[0] == pytest.approx(0.51)
    assert np.diff(heard_s[:-1]) == pytest.approx(waits_s, abs=2e-4)


def test_a_step_that_takes_too_long_costs_those_that_it_covers_and_no_more() -> None:
    late, states, near, far = Lateness(), list[NodeState](), *socket.socketpair(type=socket.SOCK_DGRAM)

    async def main() -> None:
        clock, stop = LoopClock(), asyncio.Event()

        def publish(state: NodeState) -> None:
            states.append(state)
            if len(states) == 5:
                clock.spend(0.35)

        asyncio.get_running_loop().call_later(1.5, stop.set)
        await run_node(
            a_node(Paired(clock, near)),
            clock,
            parked,
            tick_s=TICK_S,
            stop=stop,
            publish=publish,
            lateness=late,
        )

    with near, far:
        run_in_virtual_time(main())
    times = [round(one.t_s, 6) for one in states]
    # The fifth step, at 0.5 s, ends at 0.85 s: 0.6 and 0.7 are left out, and 0.8 begins 0.05 s late.
    assert times[:7] == [0.1, 0.2, 0.3, 0.4, 0.5, 0.8, 0.9]
    assert late.skipped == 2
    assert late.quantile_s(1.0) == pytest.approx(0.05)


def test_it_stops_at_once_and_leaves_the_socket() -> None:
    near, far = socket.socketpair(type=socket.SOCK_DGRAM)

    async def main() -> float:
        clock, stop, loop = LoopClock(), asyncio.Event(), asyncio.get_running_loop()
        loop.call_later(0.31, stop.set)
        node = a_node(Paired(clock, near))
        await run_node(node, clock, parked, tick_s=TICK_S, stop=stop, fileno=near.fileno())
        assert not loop.remove_reader(near.fileno())
        return clock.now_s()

    with near, far:
        assert run_in_virtual_time(main()) == pytest.approx(0.31)


def test_lateness_keeps_the_newest() -> None:
    late = Lateness()
    assert np.isnan(late.quantile_s(0.5))
    for value in [1.0] * 5000 + [0.25] * 4096:
        late.add(value)
    assert (late.quantile_s(0.0), late.quantile_s(1.0), late.count) == (0.25, 0.25, 9096)
