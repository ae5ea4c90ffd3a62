"""A real server on a real socket, in a thread of the tests' process."""

import asyncio
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

pytest.importorskip("msgpack", reason="the extra `node` brings MessagePack")

from modelcast.node.serving.server import StepServer
from modelcast.runtime.external.senders import sender_of


class Served:
    """A server that runs until it is stopped."""

    def __init__(self, path: Path) -> None:
        self.path, self.told = str(path), list[str]()
        self._ready = threading.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._run()))
        self._thread.start()
        assert self._ready.wait(30.0)

    async def _run(self) -> None:
        self.loop, self._stop = asyncio.get_running_loop(), asyncio.Event()
        self.server = StepServer(sender_of, most=4, tell=self.told.append)
        listening = await self.server.listen(path=self.path, port=0)
        self._ready.set()
        await self._stop.wait()
        listening.close()
        await self.server.close()

    def ask(self, what: Callable[[], object]) -> object:
        """What something gives in the server's loop."""

        async def _given() -> object:
            return what()

        return asyncio.run_coroutine_threadsafe(_given(), self.loop).result(30.0)

    def wait_until(self, what: Callable[[], bool]) -> None:
        """Wait until something holds in the server's loop, which turns meanwhile."""

        async def _held() -> None:
            async with asyncio.timeout(30.0):
                while not what():  # noqa: ASYNC110 - the server tells nobody who leaves
                    await asyncio.sleep(0.0)

        asyncio.run_coroutine_threadsafe(_held(), self.loop).result(40.0)

    def stop(self) -> None:
        """Stop it, and wait until it has."""
        self.loop.call_soon_threadsafe(self._stop.set)
        self._thread.join(60.0)
        assert not self._thread.is_alive()


@pytest.fixture(name="served")
def _served(tmp_path: Path) -> Iterator[Served]:
    one = Served(tmp_path / "step.sock")
    yield one
    one.stop()
