"""The map of a node for other programs on its machine: a local socket that gives lines of JSON.

A line is a snapshot (`modelcast.dashboard.document`). A program that reads slowly gets the newest line when
it reads again and misses those between; one that does not read costs one line and what its socket holds.
"""

import asyncio
from typing import final

from modelcast.dashboard.slot import LatestSlot
from modelcast.node.local_socket import serve_locally

__all__ = ["Subscribers"]

_MOST = 32
_WAIT_S = 10.0
"""Who does not read for so long is sent away."""

_KIND = "map"


@final
class Subscribers:
    """Programs that listen."""

    def __init__(self) -> None:
        self._slots: set[LatestSlot] = set()
        self._given: set[asyncio.Task[None]] = set()
        self.refused = 0
        """Programs that came while 32 were there, or that did not read."""

    @property
    def watched(self) -> bool:
        """Whether anybody listens."""
        return bool(self._slots)

    def publish(self, text: str) -> None:
        """Give a line to all; one that has not been taken yet is replaced.

        Parameters
        ----------
        text
            One line without its end.
        """
        for slot in self._slots:
            slot.put(_KIND, text)

    async def serve(self, path: str) -> asyncio.Server:
        """Listen at a local socket that only this user may open.

        Parameters
        ----------
        path
            Of the socket; one that was left there by an earlier node is replaced.

        Raises
        ------
        OSError
            Where it cannot be made, or something else is there.
        """
        return await serve_locally(self._meet, path)

    async def close(self) -> None:
        """Send all away; to be called once nobody new is let in."""
        for task in self._given:
            task.cancel()
        await asyncio.gather(*self._given, return_exceptions=True)

    def _meet(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        # A task of our own: one of asyncio's that is cancelled is told of as an error that nobody met.
        task = asyncio.create_task(self._give(reader, writer))
        self._given.add(task)
        task.add_done_callback(self._given.discard)

    async def _give(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if len(self._slots) >= _MOST:
            self.refused += 1
            writer.transport.abort()
            return
        slot = LatestSlot((_KIND,))
        self._slots.add(slot)
        giving = asyncio.create_task(_write_all(slot, writer))
        try:
            while await reader.read(4096):  # what it writes is thrown away
                continue
        except OSError:
            pass
        finally:
            self._slots.discard(slot)
            giving.cancel()
            (ended,) = await asyncio.gather(giving, return_exceptions=True)
            self.refused += isinstance(ended, TimeoutError)
            writer.transport.abort()


async def _write_all(slot: LatestSlot, writer: asyncio.StreamWriter) -> None:
    """Write what is newest, for as long as it is read."""
    try:
        while True:
            writer.write((await slot.take()).encode() + b"\n")
            async with asyncio.timeout(_WAIT_S):
                await writer.drain()
    finally:
        writer.transport.abort()
