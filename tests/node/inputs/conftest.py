"""Fixtures of the tests of a node's inputs."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field

import pytest

Until = Callable[[Callable[[], bool]], Awaitable[None]]


@pytest.fixture
def until() -> Until:
    """Let the loop run until a condition holds; fails after ten seconds."""

    async def wait(condition: Callable[[], bool]) -> None:
        async with asyncio.timeout(10.0):
            while not condition():  # noqa: ASYNC110 - the code under test has no event to wait for
                await asyncio.sleep(0)

    return wait


@dataclass
class Peer:
    """A server on loopback that says what a test tells it to."""

    port: int = 0
    writers: list[asyncio.StreamWriter] = field(default_factory=list)
    heard: list[bytes] = field(default_factory=list)

    def say(self, octets: bytes) -> None:
        """Send to whoever connected last."""
        self.writers[-1].write(octets)


@pytest.fixture
def peer() -> Callable[..., object]:
    """Open a `Peer`, on a given port or a free one."""

    @asynccontextmanager
    async def opened(port: int = 0) -> AsyncIterator[Peer]:
        one = Peer()

        async def meet(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            one.writers.append(writer)
            while chunk := await reader.read(4096):
                one.heard.append(chunk)

        server = await asyncio.start_server(meet, "127.0.0.1", port)
        one.port = server.sockets[0].getsockname()[1]
        try:
            yield one
        finally:
            server.close()
            for writer in one.writers:
                writer.transport.abort()

    return opened
