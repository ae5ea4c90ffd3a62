"""Claims about clients that do not read, do not say hello, or come in floods: none holds the server up.

Server and clients share a loop whose time passes whenever nobody has anything to do.
"""

import asyncio
import socket
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("msgpack", reason="the extra `node` brings MessagePack")

from modelcast.node.serving.framing import framed
from modelcast.node.serving.schema import step_protocol
from modelcast.node.serving.server import StepServer
from modelcast.runtime.external.senders import sender_of

from ..virtual_time import run_in_virtual_time  # noqa: TID252 - tests are no package

SPOKEN = step_protocol()
HELLO = framed(SPOKEN.pack("hello", {"protocol": 1, "slots": 1}))
BAD_HELLO = framed(SPOKEN.pack("hello", {"protocol": 1, "slots": 0}))
LONG_ANSWER = framed(SPOKEN.pack("warnings", {"host": np.arange(0), "applications": ["x" * 4000]}))
ONE_STEP = framed(SPOKEN.pack("step", {"t_s": 0.0, "vehicle": np.arange(1), "position_m": np.zeros((1, 2))}))

Peer = tuple[asyncio.StreamReader, asyncio.StreamWriter]
Scene = Callable[[StepServer, str], Awaitable[None]]


def played(path: Path, scene: Scene, most: int = 2) -> list[str]:
    """What a server complains of that a scene is played with; it has ended when this returns."""
    told: list[str] = []

    async def main() -> None:
        server = StepServer(sender_of, most=most, tell=told.append)
        listening = await server.listen(path=str(path), port=0)
        await scene(server, str(path))
        listening.close()
        await server.close()
        assert len(asyncio.all_tasks()) == 1

    run_in_virtual_time(main())
    return told


@asynccontextmanager
async def connected(path: str) -> AsyncIterator[Peer]:
    reader, writer = await asyncio.open_connection(sock=connected_socket(path))
    try:
        yield reader, writer
    finally:
        writer.close()


def connected_socket(path: str) -> socket.socket:
    own = socket.socket(socket.AF_UNIX)
    own.connect(path)
    own.setblocking(False)
    return own


async def heard(reader: asyncio.StreamReader) -> tuple[str, dict[str, Any]]:
    """The next message of the server."""
    length = int.from_bytes(await reader.readexactly(4), "little")
    return SPOKEN.unpack(await reader.readexactly(length), "server")


async def asked(peer: Peer, octets: bytes) -> tuple[str, dict[str, Any]]:
    peer[1].write(octets)
    return await heard(peer[0])


async def passed(time_s: float) -> None:
    """Wait in the time of the loop, which costs none of ours."""
    await asyncio.sleep(time_s)


@asynccontextmanager
async def flooded(path: str) -> AsyncIterator[None]:
    """Meanwhile a client with a session asks for as long as it is let, and reads nothing."""
    with connected_socket(path) as own:
        loop = asyncio.get_running_loop()
        await loop.sock_sendall(own, HELLO)
        more = asyncio.create_task(loop.sock_sendall(own, LONG_ANSWER * 500))
        yield
        more.cancel()
        await asyncio.gather(more, return_exceptions=True)


async def until(what: Callable[[], bool]) -> None:
    """Let time pass until something holds."""
    for _ in range(10**5):
        if what():
            return
        await passed(1.0)
    raise AssertionError("it never holds")


def test_who_does_not_read_loses_its_slot(tmp_path: Path) -> None:
    """Answers pile up until the server waits for them to be read; after a while it cuts it off."""

    async def scene(server: StepServer, path: str) -> None:
        async with flooded(path):
            await until(lambda: server.sessions == 1)
            await until(lambda: server.sessions == 0)
            async with connected(path) as peer:
                assert (await asked(peer, HELLO))[0] == "welcome"

    assert played(tmp_path / "s", scene, most=1) == []


def test_who_does_not_read_does_not_hold_up_the_end(tmp_path: Path) -> None:
    async def scene(server: StepServer, path: str) -> None:
        async with flooded(path):
            await until(lambda: server.sessions == 1)
            await passed(30.0)
            await server.close()
            assert server.sessions == 0

    assert played(tmp_path / "s", scene) == []


def test_a_refusal_that_cannot_be_told_is_no_error(tmp_path: Path) -> None:
    async def scene(server: StepServer, path: str) -> None:
        own = connected_socket(path)
        own.sendall(framed(b"\xc1"))
        own.close()
        await passed(1.0)
        assert server.sessions == 0

    assert played(tmp_path / "s", scene) == []


def test_only_a_session_is_served(tmp_path: Path) -> None:
    """Who comes and goes, is refused or finds no room had no session, and takes no slot."""

    async def scene(server: StepServer, path: str) -> None:
        async with connected(path):
            pass
        async with connected(path) as peer:
            assert (await asked(peer, BAD_HELLO))[0] == "error"
            assert server.sessions == 0
            assert (await asked(peer, framed(b"\xc1")))[1]["ends"]
        async with connected(path) as first:
            assert (await asked(first, HELLO))[0] == "welcome"
            async with connected(path) as second:
                assert (await asked(second, HELLO))[1]["field"] == "session"
                assert await second[0].read() == b""
                assert server.sessions == 1
            assert not server.served.is_set()
            assert (await asked(first, ONE_STEP))[0] == "sent"
        await server.served.wait()
        await until(lambda: server.sessions == 0)

    assert played(tmp_path / "s", scene, most=1) == []


def test_connections_that_say_nothing_keep_nobody_out(tmp_path: Path) -> None:
    """As many as can be: those that wait longest go, and a client that speaks is welcome."""

    async def scene(_: StepServer, path: str) -> None:
        idle = []
        for _ in range(150):
            idle.append(connected_socket(path))
            await passed(0.0)
        await passed(0.1)
        assert idle[0].recv(1) == b""
        with pytest.raises(BlockingIOError):
            idle[-1].recv(1)
        async with connected(path) as peer:
            assert (await asked(peer, HELLO))[0] == "welcome"
        await passed(10.0)
        assert idle[-1].recv(1) == b""
        for one in idle:
            one.close()

    assert played(tmp_path / "s", scene) == []


def test_a_flood_in_one_turn_of_the_loop_leaves_nothing_open(tmp_path: Path) -> None:
    """Connections that are sent away before they were looked at are closed too."""

    async def scene(_: StepServer, path: str) -> None:
        idle = [connected_socket(path) for _ in range(90)]
        await passed(20.0)
        for one in idle:
            assert one.recv(1) == b""
            one.close()

    assert played(tmp_path / "s", scene) == []


@pytest.mark.parametrize("octets", [b"", HELLO[:3], HELLO[:-1], BAD_HELLO])
def test_who_does_not_begin_is_sent_away(octets: bytes, tmp_path: Path) -> None:
    async def scene(_: StepServer, path: str) -> None:
        async with connected(path) as (reader, writer):
            writer.write(octets)
            began_s = asyncio.get_running_loop().time()
            await reader.read()
            assert asyncio.get_running_loop().time() - began_s == pytest.approx(10.0, abs=0.5)

    assert played(tmp_path / "s", scene) == []


def test_a_half_frame_is_not_held_open(tmp_path: Path) -> None:
    async def scene(server: StepServer, path: str) -> None:
        async with connected(path) as peer:
            assert (await asked(peer, HELLO))[0] == "welcome"
            await passed(1000.0)  # a simulator may think for as long as it wants
            assert (await asked(peer, ONE_STEP))[0] == "sent"
            peer[1].write(ONE_STEP[:-1])
            await passed(61.5)
            assert server.sessions == 0

    assert played(tmp_path / "s", scene) == []


def test_before_hello_no_long_message_is_held(tmp_path: Path) -> None:
    async def scene(_: StepServer, path: str) -> None:
        async with connected(path) as peer:
            _, told = await asked(peer, (2**16 + 1).to_bytes(4, "little"))
            assert told["text"].endswith("got a frame of 65537 octets: from 1 to 65536")

    assert played(tmp_path / "s", scene) == []
