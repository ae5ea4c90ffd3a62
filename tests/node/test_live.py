"""Claims about a node put together from its configuration: sockets are real, time is not the wall's."""

import asyncio
import io
import json
import socket
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modelcast.core.exceptions import ConfigError
from modelcast.core.geodesy import Origin, geodetic_to_local
from modelcast.io.write_trips import write_csv
from modelcast.node.clock import SteeredClock
from modelcast.node.config import Air, Gnss, Metrics, NodeConfig, Page, Pseudonyms, Subscribe
from modelcast.node.inputs.base import AbstractSource
from modelcast.node.inputs.samples import GnssFix, Sample
from modelcast.node.journal import Journal
from modelcast.node.live import LiveNode, open_transport
from modelcast.station.sender.sender import named_sender
from modelcast.world.drive import generate_drive

from .virtual_time import run_in_virtual_time

SENDER = named_sender("mbc")


class VirtualClock(SteeredClock):
    """The running loop's time."""

    def __init__(self) -> None:
        super().__init__(1_764_000_000.0)

    def now_s(self) -> float:
        """Now."""
        return self.at(asyncio.get_running_loop().time())


@pytest.fixture(scope="module")
def trip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("trip") / "drive.csv"
    write_csv([generate_drive(3, 90.0).truth], path)
    return path


def free_port(kind: int) -> int:
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def config(trip: Path, **tables: Any) -> NodeConfig:
    air = Air(group="239.255.16.78", port=tables.pop("port"))
    return NodeConfig(air=air, gnss=Gnss(source=f"trip:{trip}"), **tables)


def a_node(asked: NodeConfig) -> tuple[LiveNode, io.StringIO]:
    lines = io.StringIO()
    return LiveNode(asked, SENDER, Journal(lines, lambda: 0.0), clock=VirtualClock()), lines


def events(lines: io.StringIO) -> list[dict[str, Any]]:
    return [json.loads(line) for line in lines.getvalue().splitlines()]


async def for_a_while(*nodes: LiveNode, seconds: float) -> None:
    stop = asyncio.Event()
    asyncio.get_running_loop().call_later(seconds, stop.set)
    await asyncio.gather(*(node.run(stop) for node in nodes))


def test_two_nodes_on_one_group_track_each_other(trip: Path) -> None:
    port = free_port(socket.SOCK_DGRAM)
    (one, lines), (other, _) = (a_node(config(trip, port=port)) for _ in range(2))
    run_in_virtual_time(for_a_while(one, other, seconds=10.0))
    assert one.node is not None
    assert other.node is not None
    for own, its in ((one, other), (other, one)):
        assert own.state is not None
        assert own.state.around.vehicle.tolist() == [its.node.station.temporary_id if its.node else -1]
        assert own.node is not None
        assert own.node.counts["receipt: accepted"] > 3
    # Both drive the same trip: the other is where this one is, up to the thresholds of what is sent.
    assert one.state is not None
    assert one.state.motion is not None
    (off_m,) = abs(one.state.around.position_m - one.state.motion.position_m).max(axis=1)
    assert off_m < 1.0
    assert one.late.count == pytest.approx(100, abs=3)
    told = events(lines)
    assert [told[0]["event"], told[-1]["event"]] == ["start", "stop"]
    assert {"event": "motion", "mode": "gnss+can", "before": None} in [
        {name: line[name] for name in ("event", "mode", "before") if name in line} for line in told
    ]
    assert told[-1]["sent"] == one.node.counts["sent"]


def test_names_change_while_it_runs_and_the_other_follows(trip: Path) -> None:
    port = free_port(socket.SOCK_DGRAM)
    shy, _ = a_node(config(trip, port=port, pseudonyms=Pseudonyms(least_s=3.0, most_s=3.0)))
    other, _ = a_node(config(trip, port=port))
    run_in_virtual_time(for_a_while(shy, other, seconds=11.0))
    assert shy.node is not None
    assert other.state is not None
    assert other.state.around.vehicle.tolist() == [shy.node.station.temporary_id]


async def get(port: int, path: str) -> bytes:
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n".encode())
    found = await reader.read()
    writer.close()
    return found


def test_figures_page_and_map_are_served_while_it_runs_and_closed_after(trip: Path, tmp_path: Path) -> None:
    ports = [free_port(socket.SOCK_STREAM) for _ in range(2)]
    place = tmp_path / "map.sock"
    asked = config(
        trip,
        port=free_port(socket.SOCK_DGRAM),
        metrics=Metrics(port=ports[0]),
        page=Page(on=True, port=ports[1]),
        subscribe=Subscribe(path=str(place)),
    )
    node, _ = a_node(asked)

    async def look() -> tuple[bytes, bytes, list[bytes]]:
        stop = asyncio.Event()
        running = asyncio.create_task(node.run(stop))
        while node.state is None:  # noqa: ASYNC110 - time is virtual
            await asyncio.sleep(0.1)
        figures, page = await get(ports[0], "/metrics"), await get(ports[1], "/")
        reader, writer = await asyncio.open_unix_connection(str(place))
        lines = [await reader.readline() for _ in range(3)]
        writer.close()
        stop.set()
        await running
        return figures, page, lines

    figures, page, lines = run_in_virtual_time(look())
    assert b"\nmodelcast_silent 0\n" in figures
    assert page.startswith(b"HTTP/1.1 200")
    times = [json.loads(line)["t_s"] for line in lines]
    assert times == sorted(times)
    assert place.stat().st_mode & 0o077 == 0 if place.exists() else True
    for port in ports:
        with socket.socket() as probe, pytest.raises(ConnectionRefusedError):
            probe.connect(("127.0.0.1", port))


def test_a_page_for_others_needs_a_token(trip: Path) -> None:
    asked = config(trip, port=free_port(socket.SOCK_DGRAM), page=Page(on=True, host="0.0.0.0", port=0))  # noqa: S104
    node, _ = a_node(asked)
    with pytest.raises(ConfigError, match="give a token"):
        run_in_virtual_time(for_a_while(node, seconds=5.0))


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"gnss": Gnss(source="cow:moo")}, "is no source of fixes"),
        ({"air": Air(transport="pigeon")}, "'pigeon'. Known: multicast"),
        ({"metrics": Metrics(host="203.0.113.9", port=9)}, r"\[metrics\] cannot listen on 203.0.113.9:9"),
        (
            {"subscribe": Subscribe(path="/nowhere/at/all/map.sock")},
            r"\[subscribe\] cannot listen at /nowhere",
        ),
    ],
)
def test_what_cannot_be_opened_is_told(changed: dict[str, Any], told: str, trip: Path) -> None:
    node, _ = a_node(replace(config(trip, port=free_port(socket.SOCK_DGRAM)), **changed))
    with pytest.raises(ConfigError, match=told):
        run_in_virtual_time(for_a_while(node, seconds=5.0))


def test_a_transport_that_is_multicast_is_made_as_the_table_says() -> None:
    with pytest.raises(ConfigError, match="cannot join"):
        open_transport(Air(interface="203.0.113.9"), VirtualClock())


def test_who_listens_to_the_map_is_sent_away_at_the_end_and_nothing_is_left_unmet(
    trip: Path, tmp_path: Path
) -> None:
    path, unmet = tmp_path / "map.sock", list[object]()
    asked = config(trip, port=free_port(socket.SOCK_DGRAM), subscribe=Subscribe(path=str(path)))
    node, _ = a_node(asked)

    async def main() -> bytes:
        asyncio.get_running_loop().set_exception_handler(lambda _loop, what: unmet.append(what))
        stop = asyncio.Event()
        running = asyncio.create_task(node.run(stop))
        while not path.exists():  # noqa: ASYNC110 - a file tells nobody
            await asyncio.sleep(0.1)
        reader, writer = await asyncio.open_unix_connection(str(path), limit=2**20)
        await reader.readline()
        stop.set()
        await running
        left = await reader.read()
        writer.close()
        return left

    assert run_in_virtual_time(main()).count(b"\n") <= 1
    assert unmet == []


class Waiting(AbstractSource):
    """A receiver that has no fix before a time, and then stands at one place."""

    def __init__(self, place_deg: tuple[float, float], from_s: float) -> None:
        self._place_deg, self._next_s = place_deg, from_s

    async def start(self) -> None:
        """Nothing to open."""

    async def stop(self) -> None:
        """Nothing to close."""

    def take(self, now_s: float) -> list[Sample]:
        """A fix every tenth of a second."""
        found: list[Sample] = []
        while self._next_s <= now_s:
            at_s = self._next_s
            latitude_deg, longitude_deg = self._place_deg
            found.append(
                GnssFix(
                    received_s=at_s,
                    measured_s=at_s,
                    latitude_deg=latitude_deg + 1e-5 * at_s,
                    longitude_deg=longitude_deg,
                    speed_mps=11.0,
                    heading_rad=0.0,
                )
            )
            self._next_s += 0.1
        return found

    def counts(self) -> dict[str, int]:
        """None."""
        return {}


def waiting_node(asked: NodeConfig, gnss: AbstractSource) -> tuple[LiveNode, io.StringIO]:
    lines = io.StringIO()
    return LiveNode(asked, SENDER, Journal(lines, lambda: 0.0), clock=VirtualClock(), gnss=gnss), lines


def planes(lines: io.StringIO) -> list[str]:
    return [line["found"] for line in events(lines) if line["event"] == "plane"]


def test_a_node_without_a_place_hears_and_keeps_the_map(trip: Path) -> None:
    """The plane begins at the first place heard; where others are is the same on the Earth."""
    port = free_port(socket.SOCK_DGRAM)
    speaks, told = a_node(config(trip, port=port))
    blind, lines = waiting_node(config(trip, port=port), Waiting((0.0, 0.0), 9e9))
    run_in_virtual_time(for_a_while(speaks, blind, seconds=8.0))
    assert (planes(told), planes(lines)) == (["trip"], ["heard"])
    assert blind.node is not None
    assert blind.state is not None
    assert speaks.state is not None
    assert speaks.state.motion is not None
    assert blind.origin is not None
    assert blind.state.motion is None
    assert blind.node.counts["sent"] == 0
    assert blind.state.around.vehicle.tolist() == [speaks.state.temporary_id]
    true_m = geodetic_to_local(np.array([speaks.state.motion.place_deg]), blind.origin)
    assert np.hypot(*(blind.state.around.position_m - true_m).T)[0] < 1.0
    # The frame that told the place is heard like any other.
    assert blind.node.counts["heard"] == speaks.node.counts["sent"] if speaks.node else False


def test_the_plane_begins_at_the_configured_place_or_at_the_own(trip: Path) -> None:
    port = free_port(socket.SOCK_DGRAM)
    asked = config(trip, port=port)
    there = replace(asked, gnss=replace(asked.gnss, latitude_deg=48.0, longitude_deg=11.0))
    named, first = waiting_node(there, Waiting((48.01, 11.0), 3.0))
    own, second = waiting_node(asked, Waiting((48.01, 11.0), 3.0))
    run_in_virtual_time(for_a_while(named, own, seconds=6.0))
    assert named.origin == Origin(48.0, 11.0)
    assert (planes(first), planes(second)) == (["configured"], ["own"])
    for node in (named, own):
        assert node.state is not None
        assert node.state.motion is not None
    assert own.origin is not None
    assert own.origin.latitude_deg == pytest.approx(48.01, abs=1e-3)


def test_a_plane_begun_far_from_the_own_place_is_left(trip: Path) -> None:
    """Whoever forges a first message, or moves a vehicle by ship, silences nobody."""
    asked = config(trip, port=free_port(socket.SOCK_DGRAM))
    there = replace(asked, gnss=replace(asked.gnss, latitude_deg=-33.0, longitude_deg=151.0))
    node, lines = waiting_node(there, Waiting((48.0, 11.0), 3.0))
    run_in_virtual_time(for_a_while(node, seconds=8.0))
    assert planes(lines) == ["configured", "own"]
    assert node.node is not None
    assert node.state is not None
    assert node.state.motion is not None
    assert abs(np.array(node.state.motion.position_m)).max() < 100.0
    assert node.node.counts["sent"] > 0


def test_figures_page_and_map_answer_before_any_place_is_known(trip: Path, tmp_path: Path) -> None:
    ports = [free_port(socket.SOCK_STREAM) for _ in range(2)]
    place = tmp_path / "map.sock"
    asked = config(
        trip,
        port=free_port(socket.SOCK_DGRAM),
        metrics=Metrics(port=ports[0]),
        page=Page(on=True, port=ports[1]),
        subscribe=Subscribe(path=str(place)),
    )
    node, _ = waiting_node(asked, Waiting((48.0, 11.0), 9e9))

    async def look() -> tuple[bytes, bytes, bytes]:
        stop = asyncio.Event()
        running = asyncio.create_task(node.run(stop))
        await asyncio.sleep(1.0)
        figures, page = await get(ports[0], "/metrics"), await get(ports[1], "/")
        reader, writer = await asyncio.open_unix_connection(str(place))
        line = await reader.readline()
        writer.close()
        stop.set()
        await running
        return figures, page, line

    figures, page, line = run_in_virtual_time(look())
    assert node.node is None
    for told in ("modelcast_silent 1", 'modelcast_mode{mode="silent"} 1', "modelcast_fix_age_seconds +Inf"):
        assert f"\n{told}\n" in figures.decode()
    assert page.startswith(b"HTTP/1.1 200")
    shown = json.loads(line)
    assert (shown["host"], shown["remotes"]["id"]) == (None, [])
