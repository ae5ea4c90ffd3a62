"""The socket of the step protocol: several clients at once, each with a session of its own.

Requests are answered in threads, one a client: a session that works hard, or whose client is gone, holds no
other up. What a session holds is freed when its connection ends, however it ends.
"""

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from typing import cast, final

from modelcast.node.local_socket import serve_locally
from modelcast.node.serving.conversation import Conversation
from modelcast.node.serving.framing import LENGTH_BYTES, framed, length_of
from modelcast.node.serving.schema import FrameError, step_protocol
from modelcast.runtime.external.refusal import FieldError
from modelcast.runtime.external.senders import MakeSender

__all__ = ["StepServer"]

_HELLO_S = 10.0
"""Whose session has not begun by then is sent away."""

_FRAME_S = 60.0
"""So is whose message takes longer than this from its first octet to its last, or who does not read."""

_PARTING_S = 1.0
"""What is left to be read when a connection ends is lost after this."""

_HELLO_BYTES = 2**16
"""Longest message before a session has begun: many may wait, and each may hold as much."""

_WAITING = 64
"""Connections without a session; one more, and the one that has waited longest is sent away."""

_AHEAD_BYTES = 2**20
_LOOPBACK = "127.0.0.1"


@final
class StepServer:
    """Serves sessions on this machine.

    Parameters
    ----------
    make
        Gives what stations of each kind send, and when, from the settings that a client asks for.
    most
        Sessions at a time; who comes beyond is refused.
    tell
        Is given a line where something goes wrong in here.
    """

    def __init__(self, make: MakeSender, *, most: int, tell: Callable[[str], None]) -> None:
        self._make, self._most, self._tell = make, most, tell
        self._tasks: set[asyncio.Task[None]] = set()
        self._waiting: dict[asyncio.Task[None], None] = {}
        self._seated: set[asyncio.Task[None]] = set()
        self._closing = False
        self._threads = ThreadPoolExecutor(most, "session")
        self.served = asyncio.Event()
        """Set once a session has ended; who was never welcome had none."""

    @property
    def sessions(self) -> int:
        """How many sessions there are."""
        return len(self._seated)

    async def listen(self, *, path: str | None, port: int) -> asyncio.Server:
        """Listen at a local socket that only this user may open, or at a port of this machine alone.

        Parameters
        ----------
        path
            Of the socket; None for the port.
        port
            0 for any that is free.

        Raises
        ------
        OSError
            Where that cannot be had.
        """
        if path is not None:
            return await serve_locally(self._meet, path, limit=_AHEAD_BYTES)
        return await asyncio.start_server(self._meet, _LOOPBACK, port, limit=_AHEAD_BYTES)

    async def close(self) -> None:
        """End all sessions; to be called once nobody new is let in."""
        self._closing = True
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self._threads.shutdown()

    def _meet(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self._closing:
            writer.transport.abort()
            return
        if len(self._waiting) >= _WAITING:
            longest = next(iter(self._waiting))
            del self._waiting[longest]
            longest.cancel()
        task = asyncio.create_task(self._talk(reader, writer))
        self._tasks.add(task)
        self._waiting[task] = None
        task.add_done_callback(partial(self._gone, writer=writer))

    def _gone(self, task: asyncio.Task[None], *, writer: asyncio.StreamWriter) -> None:
        """Forget a client; its connection is cut off, if it has not ended by itself."""
        self._tasks.discard(task)
        self._waiting.pop(task, None)
        self._seated.discard(task)
        writer.transport.abort()

    async def _talk(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Answer one client until it goes or is sent away."""
        task, talk = cast("asyncio.Task[None]", asyncio.current_task()), Conversation(self._make)
        try:
            await _write(writer, await self._last_answer(task, talk, reader, writer))
        except (OSError, asyncio.IncompleteReadError):
            pass  # it is gone, or as good as gone
        finally:
            await _hang_up(writer)
            if talk.begun:
                self.served.set()

    async def _last_answer(
        self,
        task: asyncio.Task[None],
        talk: Conversation,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
    ) -> bytes:
        """Answer one client; the answer that sends it away is returned."""
        loop = asyncio.get_running_loop()
        until = loop.time() + _HELLO_S
        try:
            while True:
                if talk.begun:
                    octets = await _read(reader, step_protocol().frame_bytes)
                else:
                    async with asyncio.timeout_at(until):
                        octets = await _read(reader, _HELLO_BYTES)
                    if not self._seat(task):
                        full = FieldError("session", self._most + 1, f"one of {self._most} at a time")
                        return talk.refusal(full, ends=True)
                answer, ends = await loop.run_in_executor(self._threads, talk.answer, octets)
                if ends:
                    return answer
                if not talk.begun:
                    self._unseat(task)
                await _write(writer, answer)
        except FrameError as error:
            return talk.refusal(FieldError("frame", error, "a shorter one"), ends=True)
        except (OSError, asyncio.IncompleteReadError):
            raise
        except Exception as error:  # noqa: BLE001 - a session that breaks must hurt no other
            self._tell(f"a session ended by an error of our own: {type(error).__name__}: {error}")
            broken = FieldError("session", type(error).__name__, "served: this is an error of the server")
            return talk.refusal(broken, ends=True)

    def _seat(self, task: asyncio.Task[None]) -> bool:
        """Give a client room for a session, where there is any."""
        if len(self._seated) >= self._most:
            return False
        self._waiting.pop(task, None)
        self._seated.add(task)
        return True

    def _unseat(self, task: asyncio.Task[None]) -> None:
        """Let a client wait again, whose session was refused."""
        self._seated.discard(task)
        self._waiting[task] = None


async def _read(reader: asyncio.StreamReader, most: int) -> bytes:
    """The next frame, whenever it begins."""
    head = await reader.readexactly(1)
    async with asyncio.timeout(_FRAME_S):
        head += await reader.readexactly(LENGTH_BYTES - 1)
        return await reader.readexactly(length_of(head, most))


async def _write(writer: asyncio.StreamWriter, octets: bytes) -> None:
    """Send a frame; who does not read it is not waited for without end."""
    async with asyncio.timeout(_FRAME_S):
        writer.write(framed(octets))
        await writer.drain()


async def _hang_up(writer: asyncio.StreamWriter) -> None:
    """End a connection; who does not read what is left for it is not waited for."""
    writer.close()
    with suppress(OSError):
        async with asyncio.timeout(_PARTING_S):
            await writer.wait_closed()
