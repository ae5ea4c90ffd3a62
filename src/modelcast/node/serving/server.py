"""The socket of the step protocol: several clients at once, each with a session of its own.

Requests are answered in threads, one a client: a session that works hard, or whose client is gone, holds no
other up. What a session holds is freed when its connection ends, however it ends.
"""

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import final

from modelcast.node.local_socket import serve_locally
from modelcast.node.serving.conversation import Conversation
from modelcast.node.serving.framing import LENGTH_BYTES, framed, length_of
from modelcast.node.serving.schema import FrameError, step_protocol
from modelcast.runtime.external.exchange import SessionSettings
from modelcast.runtime.external.refusal import FieldError
from modelcast.station.sender.sender import Sender

__all__ = ["StepServer"]

_HELLO_S = 10.0
"""Who has not said hello by then is sent away."""

_FRAME_S = 60.0
"""So is whose message takes longer than this from its first octet to its last, or who does not read."""

_AHEAD_BYTES = 2**20
_LOOPBACK = "127.0.0.1"


@final
class StepServer:
    """Serves sessions on this machine.

    Parameters
    ----------
    make
        Gives what stations send, and when, from the settings that a client asks for.
    most
        Sessions at a time; who comes beyond is refused.
    tell
        Is given a line where something goes wrong in here.
    """

    def __init__(
        self, make: Callable[[SessionSettings], Sender], *, most: int, tell: Callable[[str], None]
    ) -> None:
        self._make, self._most, self._tell = make, most, tell
        self._tasks: set[asyncio.Task[None]] = set()
        self._threads = ThreadPoolExecutor(most, "session")
        self.served = asyncio.Event()
        """Set once a session has ended."""

    @property
    def sessions(self) -> int:
        """How many clients there are."""
        return len(self._tasks)

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
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self._threads.shutdown()

    def _meet(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.create_task(self._talk(reader, writer))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _talk(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Answer one client until it goes or is sent away."""
        talk = Conversation(self._make)
        try:
            if len(self._tasks) > self._most:
                full = FieldError("session", len(self._tasks), f"one of {self._most} at a time")
                await _write(writer, talk.refusal(full, ends=True))
                return
            await self._answer_all(talk, reader, writer)
        except FrameError as error:
            await _write(writer, talk.refusal(FieldError("frame", error, "a shorter one"), ends=True))
        except (OSError, asyncio.IncompleteReadError, TimeoutError):
            pass  # it is gone, or as good as gone
        except Exception as error:  # noqa: BLE001 - a session that breaks must hurt no other
            self._tell(f"a session ended by an error of our own: {type(error).__name__}: {error}")
            broken = FieldError("session", type(error).__name__, "served: this is an error of the server")
            await _write(writer, talk.refusal(broken, ends=True))
        finally:
            await _hang_up(writer)
            self.served.set()

    async def _answer_all(
        self, talk: Conversation, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        loop, ends = asyncio.get_running_loop(), False
        async with asyncio.timeout(_HELLO_S):
            octets = await _read(reader)
        while not ends:
            answer, ends = await loop.run_in_executor(self._threads, talk.answer, octets)
            async with asyncio.timeout(_FRAME_S):
                await _write(writer, answer)
            if not ends:
                octets = await _read(reader)


async def _read(reader: asyncio.StreamReader) -> bytes:
    """The next frame, whenever it begins."""
    head = await reader.readexactly(1)
    async with asyncio.timeout(_FRAME_S):
        head += await reader.readexactly(LENGTH_BYTES - 1)
        return await reader.readexactly(length_of(head, step_protocol().frame_bytes))


async def _write(writer: asyncio.StreamWriter, octets: bytes) -> None:
    writer.write(framed(octets))
    await writer.drain()


async def _hang_up(writer: asyncio.StreamWriter) -> None:
    """End a connection; what is still to be read of it is lost with it."""
    writer.close()
    with suppress(OSError):
        await writer.wait_closed()
