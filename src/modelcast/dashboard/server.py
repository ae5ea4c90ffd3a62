"""The page's server: static files, and a socket a browser with one slot for what is newest.

It answers five kinds of request and nothing else, and every request passes `modelcast.dashboard.gate` first.
"""

import asyncio
import json
import socket
from collections.abc import Generator
from contextlib import contextmanager, nullcontext
from importlib.resources import files
from typing import TYPE_CHECKING

from modelcast.core.exceptions import MissingExtraError, ModelcastError
from modelcast.core.json_text import parse_json
from modelcast.core.rules import Keys, Number, check
from modelcast.dashboard.feed import KINDS, AbstractFeed
from modelcast.dashboard.gate import COOKIE, HEADERS, Gate, is_loopback
from modelcast.dashboard.slot import LatestSlot

try:
    import uvicorn
    from starlette.applications import Starlette
    from starlette.datastructures import Headers, MutableHeaders
    from starlette.requests import Request
    from starlette.responses import PlainTextResponse, RedirectResponse, Response
    from starlette.routing import Route, WebSocketRoute
    from starlette.websockets import WebSocket, WebSocketDisconnect
except ImportError as error:
    raise MissingExtraError("the page", "node") from error

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

__all__ = ["MOST_CLIENTS", "listen", "page_app", "page_server"]

MOST_CLIENTS = 32
"""Sockets at a time; further ones are refused."""

_LONGEST_REQUEST = 256
_REQUEST = Keys({"at_s": Number(-1e10, 1e10)})
_MEDIA = {".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".svg": "image/svg+xml"}
_MISDIRECTED, _FORBIDDEN, _BUSY = 421, 403, 1013


def page_app(feed: AbstractFeed, gate: Gate) -> Starlette:
    """The page as an ASGI application.

    Parameters
    ----------
    feed
        What is shown.
    gate
        Who may look.
    """
    static = {item.name: item.read_bytes() for item in (files("modelcast.dashboard") / "static").iterdir()}
    open_now: set[LatestSlot] = set()

    def file(request: Request) -> Response:
        name = request.path_params.get("name", "index.html")
        media = _MEDIA.get(name[name.rfind(".") :]) if name in static else None
        if media is None:
            return PlainTextResponse("not found", 404)
        return Response(static[name], media_type=media)

    async def watch(browser: WebSocket) -> None:
        if len(open_now) >= MOST_CLIENTS:
            await browser.close(_BUSY)
            return
        await browser.accept()
        slot = LatestSlot(KINDS)
        open_now.add(slot)
        try:
            await _serve(browser, feed, slot)
        finally:
            open_now.discard(slot)
            feed.detach(slot)

    app = Starlette(
        routes=[
            Route("/", file),
            Route("/static/{name}", file),
            WebSocketRoute("/watch", watch),
        ]
    )
    app.add_middleware(_Guarded, gate=gate)
    return app


def page_server(feed: AbstractFeed, gate: Gate, *, heeds_signals: bool = True) -> uvicorn.Server:
    """The page's server; ``await server.serve(sockets=[listen(...)])`` runs it until ``should_exit``.

    It logs no request, so no token comes into a log.

    Parameters
    ----------
    feed, gate
        As in `page_app`.
    heeds_signals
        Whether SIGINT and SIGTERM end it; else they are left to whoever runs it.
    """
    config = uvicorn.Config(
        page_app(feed, gate),
        access_log=False,
        log_level="warning",
        lifespan="off",
        server_header=False,
        ws_max_size=_LONGEST_REQUEST,
        ws_per_message_deflate=False,
        h11_max_incomplete_event_size=16_384,
        timeout_graceful_shutdown=1,
        backlog=64,
    )
    return _PageServer(config, heeds_signals=heeds_signals)


def listen(host: str, port: int, gate: Gate) -> socket.socket:
    """A socket that listens there.

    Parameters
    ----------
    host
        Address or name.
    port
        0 for any free one.
    gate
        Who may look.

    Raises
    ------
    ValueError
        Where others than this machine would reach it and the gate asks for no token.
    OSError
        Where the place is taken or not this machine's.
    """
    if not is_loopback(host) and not gate.token:
        raise ValueError(f"{host} is reached by other machines: a token is needed")
    family, _, _, _, address = socket.getaddrinfo(
        host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
    )[0]
    found = socket.socket(family, socket.SOCK_STREAM)
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind(address)
    except OSError as error:
        found.close()
        error.filename = f"{address[0]}:{address[1]}"
        raise
    return found


async def _serve(browser: WebSocket, feed: AbstractFeed, slot: LatestSlot) -> None:
    """Give a browser what is newest until it leaves."""
    span = feed.span
    hello = {"kind": "hello", "name": feed.name, "span_s": None if span is None else _span(feed)}
    await browser.send_text(json.dumps(hello))
    feed.attach(slot)
    giving = asyncio.create_task(_give(browser, slot))
    asking = asyncio.create_task(_ask(browser, feed, slot))
    done, left = await asyncio.wait({giving, asking}, return_when=asyncio.FIRST_COMPLETED)
    for task in left:
        task.cancel()
    for result in await asyncio.gather(*done, *left, return_exceptions=True):
        if isinstance(result, BaseException) and not isinstance(
            result, asyncio.CancelledError | WebSocketDisconnect
        ):
            raise result


def _span(feed: AbstractFeed) -> list[float]:
    span = feed.span
    return [] if span is None else [span.first_s, span.last_s, span.step_s]


async def _give(browser: WebSocket, slot: LatestSlot) -> None:
    while True:
        await browser.send_text(await slot.take())


async def _ask(browser: WebSocket, feed: AbstractFeed, slot: LatestSlot) -> None:
    """Take in what a browser asks for; who asks for anything but a time is sent away."""
    while True:
        asked = _time_of(await browser.receive_text())
        if asked is None:
            await browser.close(1003)
            return
        try:
            feed.seek(slot, asked)
        except ModelcastError as error:
            await browser.send_text(json.dumps({"kind": "fault", "text": str(error)}))


def _time_of(text: str) -> float | None:
    try:
        request = parse_json(text)
        check(request, _REQUEST)
    except ValueError:
        return None
    return float(request["at_s"])


class _PageServer(uvicorn.Server):
    """A server whose signals may be somebody else's."""

    def __init__(self, config: uvicorn.Config, *, heeds_signals: bool) -> None:
        super().__init__(config)
        self._heeds_signals = heeds_signals

    @contextmanager
    def capture_signals(self) -> Generator[None]:
        """Take the handlers of signals for as long as the block lasts, where they are its own."""
        with super().capture_signals() if self._heeds_signals else nullcontext():
            yield


class _Guarded:
    """Asks the gate before anything else, and puts its heads on every answer."""

    def __init__(self, app: "ASGIApp", *, gate: Gate) -> None:
        self._app, self._gate = app, gate

    async def __call__(self, scope: "Scope", receive: "Receive", send: "Send") -> None:
        async def guarded(message: "Message") -> None:
            if message["type"] in {"http.response.start", "websocket.http.response.start"}:
                MutableHeaders(scope=message).update(HEADERS)
            await send(message)

        refusal = self._refusal(scope)
        if refusal is None:
            await self._app(scope, receive, guarded)
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008})
        else:
            await refusal(scope, receive, guarded)

    def _refusal(self, scope: "Scope") -> Response | None:
        """What is answered instead; None where the gate lets in."""
        heads, gate = Headers(scope=scope), self._gate
        host = heads.get("host", "")
        if not gate.names_here(host):
            return PlainTextResponse("this server has another name", _MISDIRECTED)
        if scope["type"] == "websocket":
            good = gate.same_page(heads.get("origin"), host) and gate.admits_cookies(heads.getlist("cookie"))
            return None if good else PlainTextResponse("", _FORBIDDEN)
        shown = Request(scope).query_params.get("token")
        if gate.token and scope["path"] == "/" and shown is not None and gate.admits(shown):
            entered = RedirectResponse("/", 303)
            entered.set_cookie(COOKIE, gate.token, httponly=True, samesite="strict")
            return entered
        if not gate.admits_cookies(heads.getlist("cookie")):
            return PlainTextResponse("open the address with the token that was printed", _FORBIDDEN)
        return None
