"""Lines from a peer that may vanish: connect, listen, notice silence, connect again.

A connection whose other end is gone without a word (half open) looks like a quiet one. So after half the
allowed silence the peer is asked something it answers at once, where the protocol has such a question;
after the whole the connection is given up. Peers are not trusted: chunks and lines are bounded, and what
cannot be read is counted.
"""

import asyncio
import contextlib
from collections.abc import Awaitable, Callable
from dataclasses import dataclass

from modelcast.node.inputs.base import Mailbox
from modelcast.node.inputs.lines import LineSplitter

__all__ = ["Connect", "LineStream", "StreamRules", "tcp"]

Connect = Callable[[], Awaitable[tuple[asyncio.StreamReader, Callable[[bytes], None], Callable[[], None]]]]
"""Opens a connection: where octets come from, how some are sent, and how it is closed."""

_CHUNK = 65_536


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamRules:
    """How a connection is kept.

    Parameters
    ----------
    hello, ping
        Sent at the begin, and after half the allowed silence; nothing where empty.
    silence_s
        Without an octet for so long it is given up [s].
    retry_s
        From its end to the next attempt [s].
    connect_s
        How long an attempt may take [s].
    most_octets
        Of a line.
    """

    hello: bytes = b""
    ping: bytes = b""
    silence_s: float = 2.0
    retry_s: float = 0.5
    connect_s: float = 1.0
    most_octets: int = 16_384


class LineStream:
    """A task that hands over the lines of whoever it is connected to.

    Parameters
    ----------
    connect
        Opens a connection.
    on_line
        Takes a line; raises ``ValueError`` where it cannot be read, which is counted as "garbage".
    mailbox
        Where things are counted: "connections", "not reached", "silent", "closed", "garbage", "overlong".
    rules
        How the connection is kept.
    """

    def __init__(
        self, connect: Connect, on_line: Callable[[bytes], None], mailbox: Mailbox, rules: StreamRules
    ) -> None:
        self._connect = connect
        self._on_line = on_line
        self._box = mailbox
        self._rules = rules
        self._task: asyncio.Task[None] | None = None

    async def start(self) -> None:
        """Begin to connect."""
        if self._task is None:
            self._task = asyncio.get_running_loop().create_task(self._run())

    async def stop(self) -> None:
        """Close what is open and end."""
        task, self._task = self._task, None
        if task is not None:
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task

    async def _run(self) -> None:
        while True:
            try:
                async with asyncio.timeout(self._rules.connect_s):
                    reader, send, close = await self._connect()
            except (OSError, ValueError):  # TimeoutError is the former, a name that is no host's the latter
                self._box.count("not reached")
            else:
                self._box.count("connections")
                try:
                    self._box.count(await self._listen(reader, send))
                except OSError:
                    self._box.count("closed")
                finally:
                    close()
            await asyncio.sleep(self._rules.retry_s)

    async def _listen(self, reader: asyncio.StreamReader, send: Callable[[bytes], None]) -> str:
        """Hand over lines until the connection ends; returns why it did."""
        splitter = LineSplitter(self._rules.most_octets)
        send(self._rules.hello)
        asked = False
        while True:
            try:
                async with asyncio.timeout(self._rules.silence_s / 2.0):
                    chunk = await reader.read(_CHUNK)
            except TimeoutError:
                if asked:
                    return "silent"
                send(self._rules.ping)
                asked = True
                continue
            if not chunk:
                return "closed"
            asked = False
            before = splitter.overlong
            for line in splitter.feed(chunk):
                try:
                    self._on_line(line)
                except ValueError:
                    self._box.count("garbage")
            if splitter.overlong > before:
                self._box.count("overlong", splitter.overlong - before)


def tcp(host: str, port: int) -> Connect:
    """How a TCP peer is reached.

    Parameters
    ----------
    host, port
        Of the peer.
    """

    async def connect() -> tuple[asyncio.StreamReader, Callable[[bytes], None], Callable[[], None]]:
        reader, writer = await asyncio.open_connection(host, port, limit=_CHUNK)

        def send(octets: bytes) -> None:
            if octets:
                writer.write(octets)

        return reader, send, writer.transport.abort

    return connect
