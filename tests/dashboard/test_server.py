"""Claims: the server answers its few requests to who may ask; a client that stops reading costs little."""

import asyncio
import contextlib
import gc
import json
import logging
import socket
import tracemalloc
from collections.abc import AsyncGenerator, Callable
from importlib.resources import files
from pathlib import Path

import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from modelcast.dashboard.document import read_snapshot, snapshot_text
from modelcast.dashboard.feed import AbstractFeed, LiveFeed
from modelcast.dashboard.gate import COOKIE, HEADERS, Gate
from modelcast.dashboard.log import SnapshotLog, SnapshotLogWriter
from modelcast.dashboard.server import MOST_CLIENTS, listen, page_server
from modelcast.dashboard.snapshot import Snapshot

MakeSnapshot = Callable[..., Snapshot]
TOKEN = "a-token-of-some-length"  # noqa: S105 - of this test
MEGABYTE = 1_000_000


@contextlib.asynccontextmanager
async def serving(feed: AbstractFeed, gate: Gate | None = None) -> AsyncGenerator[str]:
    """The server on a free port of the loopback, by its address and port."""
    used = Gate() if gate is None else gate
    with listen("127.0.0.1", 0, used) as place:
        place.listen()
        server = page_server(feed, used)
        running = asyncio.create_task(server.serve(sockets=[place]))
        try:
            yield f"127.0.0.1:{place.getsockname()[1]}"
        finally:
            server.should_exit = True
            await running


async def asked(where: str, path: str = "/", **heads: str) -> tuple[int, dict[str, str], bytes]:
    """One request by hand: status, heads in small letters, body."""
    address, port = where.split(":")
    reader, writer = await asyncio.open_connection(address, int(port))
    lines = {"Host": where, "Connection": "close", **heads}
    writer.write(f"GET {path} HTTP/1.1\r\n".encode())
    writer.write("".join(f"{key}: {value}\r\n" for key, value in lines.items()).encode() + b"\r\n")
    answer = await reader.read()
    writer.close()
    await writer.wait_closed()
    head, _, body = answer.partition(b"\r\n\r\n")
    first, *rest = head.decode().split("\r\n")
    return int(first.split()[1]), {k.lower(): v for k, v in (one.split(": ", 1) for one in rest)}, body


def test_the_page_and_all_its_files_are_served_with_the_heads_that_guard_them() -> None:
    async def run() -> None:
        names = [item.name for item in (files("modelcast.dashboard") / "static").iterdir()]
        async with serving(LiveFeed("test")) as where:
            for path in ("/", *(f"/static/{name}" for name in names)):
                status, heads, body = await asked(where, path)
                assert (status, bool(body)) == (200, True), path
                assert {key: heads[key.lower()] for key in HEADERS} == dict(HEADERS)
            for path in ("/static/../server.py", "/static/none.js", "/static/%2e%2e%2fserver.py", "/other"):
                status, heads, _ = await asked(where, path)
                assert status == 404, path
                assert heads["content-security-policy"].startswith("default-src 'self'")

    asyncio.run(run())


def test_no_file_of_the_page_asks_for_anything_elsewhere() -> None:
    for item in (files("modelcast.dashboard") / "static").iterdir():
        text = item.read_text().replace("http://www.w3.org/2000/svg", "").replace("${scheme}://", "")
        assert "://" not in text, item.name
        assert "innerHTML" not in text, item.name


def test_a_request_under_another_name_is_turned_away() -> None:
    async def run() -> None:
        async with serving(LiveFeed("test")) as where:
            status, _, _ = await asked(where, Host="evil.example")
            assert status == 421
            with pytest.raises(InvalidStatus):
                await connect(f"ws://{where}/watch", origin="http://evil.example", proxy=None)  # type: ignore[arg-type]

    asyncio.run(run())


def test_a_token_lets_in_once_by_the_address_and_then_by_the_cookie(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async def run() -> None:
        async with serving(LiveFeed("test"), Gate(TOKEN)) as where:
            assert (await asked(where))[0] == 403
            assert (await asked(where, "/static/main.js"))[0] == 403
            assert (await asked(where, f"/?token={TOKEN}x"))[0] == 403
            with pytest.raises(InvalidStatus):
                await connect(f"ws://{where}/watch", proxy=None)
            status, heads, _ = await asked(where, f"/?token={TOKEN}")
            assert (status, heads["location"]) == (303, "/")
            cookie = heads["set-cookie"]
            assert "httponly" in cookie.lower()
            assert "samesite=strict" in cookie.lower()
            assert (await asked(where, Cookie=f"{COOKIE}={TOKEN}"))[0] == 200
            async with connect(
                f"ws://{where}/watch", additional_headers={"Cookie": f"{COOKIE}={TOKEN}"}, proxy=None
            ) as browser:
                assert json.loads(await browser.recv())["kind"] == "hello"

    with caplog.at_level(logging.DEBUG, logger="uvicorn"):
        asyncio.run(run())
    shown = [one.getMessage() for one in caplog.records if one.name.startswith("uvicorn")]
    assert not [line for line in shown if TOKEN in line]


def test_a_browser_is_given_the_newest_snapshot(make_snapshot: MakeSnapshot) -> None:
    async def run() -> None:
        feed = LiveFeed("a drive")
        feed.publish(make_snapshot(1.0))
        async with serving(feed) as where, connect(f"ws://{where}/watch", proxy=None) as browser:
            assert json.loads(await browser.recv()) == {"kind": "hello", "name": "a drive", "span_s": None}
            assert read_snapshot(str(await browser.recv())).t_s == 1.0
            feed.publish(make_snapshot(2.0, warned=False))
            assert "road" in str(await browser.recv())[:20]
            assert read_snapshot(str(await browser.recv())).t_s == 2.0
        assert not feed.watched

    asyncio.run(run())


def test_a_log_is_wound_to_the_time_asked_for(tmp_path: Path, make_snapshot: MakeSnapshot) -> None:
    path = tmp_path / "log.jsonl"
    with SnapshotLogWriter(path) as writer:
        for step in range(10):
            writer.write(make_snapshot(1.0 + step))

    async def run() -> None:
        with SnapshotLog(path) as log:
            async with serving(log) as where, connect(f"ws://{where}/watch", proxy=None) as browser:
                assert json.loads(await browser.recv())["span_s"] == [1.0, 10.0, 1.0]
                assert "road" in str(await browser.recv())[:20]
                assert read_snapshot(str(await browser.recv())).t_s == 1.0
                await browser.send('{"at_s": 7.5}')
                assert read_snapshot(str(await browser.recv())).t_s == 7.0

    asyncio.run(run())


@pytest.mark.parametrize(
    "asked_for", ["", "7", "{}", '{"at_s": "1"}', '{"at_s": 1, "b": 2}', '{"at_s": NaN}', "x" * 1000]
)
def test_who_asks_for_anything_but_a_time_is_sent_away(asked_for: str) -> None:
    async def run() -> None:
        feed = LiveFeed("test")
        async with serving(feed) as where, connect(f"ws://{where}/watch", proxy=None) as browser:
            await browser.recv()
            await browser.send(asked_for)
            with pytest.raises(ConnectionClosed):
                await browser.recv()

    asyncio.run(run())


def test_no_more_clients_are_served_than_there_is_room_for() -> None:
    async def run() -> None:
        async with serving(LiveFeed("test")) as where, contextlib.AsyncExitStack() as all_open:
            for _ in range(MOST_CLIENTS):
                browser = await all_open.enter_async_context(connect(f"ws://{where}/watch", proxy=None))
                await browser.recv()
            with pytest.raises(InvalidStatus):
                await connect(f"ws://{where}/watch", proxy=None)

    asyncio.run(run())


def test_a_client_that_stops_reading_costs_less_than_a_megabyte(make_snapshot: MakeSnapshot) -> None:
    """A thousand remotes, two thousand snapshots, one client that reads its first answer and nothing more."""
    texts = [snapshot_text(make_snapshot(0.1 * step, 1000)) for step in range(4)]

    async def run() -> tuple[int, int]:
        feed = _Given("test")
        async with serving(feed) as where:
            address, port = where.split(":")
            lazy = socket.create_connection((address, int(port)))
            lazy.setblocking(False)
            request = (
                f"GET /watch HTTP/1.1\r\nHost: {where}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
            )
            loop = asyncio.get_running_loop()
            await loop.sock_sendall(lazy, request.encode())
            await loop.sock_recv(lazy, 100)
            await feed.attached.wait()
            tracemalloc.start()
            gc.collect()
            before = tracemalloc.get_traced_memory()[0]
            for number in range(2000):
                # As a new text each time: what is kept of it counts.
                feed.give(texts[number % 4][:-1] + " " * (number % 7 + 1) + "}")
                await asyncio.sleep(0)
            gc.collect()
            held = tracemalloc.get_traced_memory()[0] - before
            tracemalloc.stop()
            lazy.close()
            return held, len(texts[0])

    held, length = asyncio.run(run())
    assert length > 90_000
    assert held < MEGABYTE


class _Given(AbstractFeed):
    """A feed that gives texts as they are, and knows when somebody looks."""

    def __init__(self, name: str) -> None:
        self._feed = LiveFeed(name)
        self.attached = asyncio.Event()
        self._slots: list[object] = []

    @property
    def name(self) -> str:
        return self._feed.name

    @property
    def span(self) -> None:
        return None

    def attach(self, slot: object) -> None:
        self._slots.append(slot)
        self.attached.set()

    def detach(self, slot: object) -> None:
        self._slots.remove(slot)

    def seek(self, slot: object, t_s: float) -> None:
        """Nothing."""

    def give(self, text: str) -> None:
        for slot in self._slots:
            slot.put("snapshot", text)  # type: ignore[attr-defined]
