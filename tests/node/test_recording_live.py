"""Claims about a node on the road that is recorded, and about its frames on the air again."""

import asyncio
import io
import json
import socket
from pathlib import Path

import pytest

from modelcast.cli.node import sender_of_config
from modelcast.core.exceptions import ConfigError
from modelcast.io.write_trips import write_csv
from modelcast.node.clock import SteeredClock
from modelcast.node.config import Air, Gnss, NodeConfig, Pseudonyms, Record
from modelcast.node.journal import Journal
from modelcast.node.live import LiveNode
from modelcast.node.multicast import MulticastTransport
from modelcast.node.recording.frames import read_heard, read_sent
from modelcast.node.recording.on_air import emit_recording
from modelcast.node.recording.reader import RecordReader
from modelcast.node.recording.replay import replay_recording
from modelcast.runtime.transport.base import AbstractTransport, Arrival
from modelcast.station.sender.sender import named_sender
from modelcast.world.drive import generate_drive

from .virtual_time import LoopClock, run_in_virtual_time

SENDER = named_sender("mbc")


class VirtualClock(SteeredClock):
    """The running loop's time."""

    def __init__(self) -> None:
        super().__init__(1_764_000_000.0)

    def now_s(self) -> float:
        """Now."""
        return self.at(asyncio.get_running_loop().time())


def config(folder: Path, port: int, *, most_mb: float = 100.0, record: str = "") -> NodeConfig:
    trip = folder / "drive.csv"
    write_csv([generate_drive(3, 90.0).truth], trip)
    return NodeConfig(
        air=Air(group="239.255.16.91", port=port),
        gnss=Gnss(source=f"trip:{trip}"),
        pseudonyms=Pseudonyms(least_s=3.0, most_s=4.0),
        record=Record(folder=record or str(folder / "recordings"), most_mb=most_mb),
    )


@pytest.fixture
def port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


async def for_a_while(*nodes: LiveNode, seconds: float) -> None:
    stop = asyncio.Event()
    asyncio.get_running_loop().call_later(seconds, stop.set)
    await asyncio.gather(*(node.run(stop) for node in nodes))


def a_node(asked: NodeConfig) -> tuple[LiveNode, io.StringIO]:
    lines = io.StringIO()
    return LiveNode(asked, SENDER, Journal(lines, lambda: 0.0), clock=VirtualClock()), lines


def test_two_recorded_nodes_are_gone_through_again(tmp_path: Path, port: int) -> None:
    asked = config(tmp_path, port)
    (one, lines), (other, _) = a_node(asked), a_node(asked)
    run_in_virtual_time(for_a_while(one, other, seconds=12.0))
    logs = sorted((tmp_path / "recordings").glob("*.mcap"))
    assert len(logs) == 2  # of one second: each has a name of its own
    named = [event["file"] for event in map(json.loads, lines.getvalue().splitlines()) if "file" in event]
    assert named[0] in map(str, logs)
    for log in logs:
        found = replay_recording(log, sender_of_config)
        assert (found.difference, found.cut_off) == ("", False)
        assert found.steps > 110
        assert found.heard > 10
        with RecordReader(log) as reader:
            names = {reader.words(m)["temporary_id"] for m in reader.messages() if m.topic == "/step"}
            samples = sum(len(reader.words(m)["samples"]) for m in reader.messages() if m.topic == "/samples")
        assert len(names) >= 3
        assert samples > 400


def test_where_the_quota_is_reached_the_journal_says_so_once(tmp_path: Path, port: int) -> None:
    node, lines = a_node(config(tmp_path, port, most_mb=0.03))
    run_in_virtual_time(for_a_while(node, seconds=15.0))
    told = [
        event
        for event in map(json.loads, lines.getvalue().splitlines())
        if event["event"] == "recording ended"
    ]
    assert [event["why"] for event in told] == ["the quota is reached"]
    assert node.late.count > 140
    assert sum(one.stat().st_size for one in (tmp_path / "recordings").iterdir()) <= 30_000


def test_a_folder_that_is_none_is_named(tmp_path: Path, port: int) -> None:
    (tmp_path / "file").write_text("")
    node, _ = a_node(config(tmp_path, port, record=str(tmp_path / "file")))
    with pytest.raises(ConfigError, match=r"\[record\] cannot write in .*file"):
        run_in_virtual_time(for_a_while(node, seconds=2.0))


class Kept(AbstractTransport):
    """Keeps what is sent, and when."""

    def __init__(self) -> None:
        self.frames: list[tuple[float, bytes]] = []

    def send(self, octets: bytes, *, sent_s: float) -> None:
        """Keep it."""
        self.frames.append((sent_s, octets))

    def receive(self, until_s: float) -> list[Arrival]:  # noqa: ARG002
        """Nothing."""
        return []


@pytest.mark.parametrize("times", [1.0, 4.0])
def test_frames_are_sent_again_at_their_times(recording: Path, times: float) -> None:
    with RecordReader(recording) as reader:
        expected: list[tuple[float, bytes]] = []
        for message in reader.messages():
            if message.topic == "/heard":
                arrival = read_heard(reader.words(message)).arrival
                expected.append((arrival.received_s, arrival.octets))
            elif message.topic == "/sent":
                sent = read_sent(reader.words(message))
                expected.append((sent.now_s, sent.octets))

    async def emitted() -> Kept:
        kept = Kept()
        assert await emit_recording(
            recording, kept, LoopClock(), times_as_fast=times, stop=asyncio.Event()
        ) == len(expected)
        return kept

    frames = run_in_virtual_time(emitted()).frames
    assert [octets for _, octets in frames] == [octets for _, octets in expected]
    first_s = expected[0][0]
    latest_s = first_s
    for (sent_s, _), (was_s, _) in zip(frames, expected, strict=True):
        latest_s = max(latest_s, was_s)
        assert sent_s == pytest.approx((latest_s - first_s) / times, abs=1e-6)


def test_who_stops_it_ends_it(recording: Path) -> None:
    async def stopped() -> int:
        stop = asyncio.Event()
        asyncio.get_running_loop().call_later(2.0, stop.set)
        return await emit_recording(recording, Kept(), LoopClock(), stop=stop)

    assert 0 < run_in_virtual_time(stopped()) < 20


def test_another_socket_hears_them(recording: Path, port: int) -> None:
    async def heard() -> tuple[int, int]:
        clock = LoopClock()
        with (
            MulticastTransport(clock.now_s, group="239.255.16.92", port=port) as one,
            MulticastTransport(clock.now_s, group="239.255.16.92", port=port) as other,
        ):
            sent = await emit_recording(recording, one, clock, times_as_fast=100.0, stop=asyncio.Event())
            return sent, len(other.receive(clock.now_s()))

    sent, received = run_in_virtual_time(heard())
    assert sent == received > 20
