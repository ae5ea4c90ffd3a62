"""Figures of a node for Prometheus: the text format, and a server that can do nothing else."""

import asyncio
import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass

__all__ = ["Metric", "exposition", "serve_metrics"]

_NAME = re.compile(r"[a-z_][a-z0-9_]*")
_HEAD_OCTETS = 4096
_WAIT_S = 5.0
_MOST_CLIENTS = 8


@dataclass(frozen=True, slots=True)
class Metric:
    """One figure.

    Parameters
    ----------
    name
        With its unit at the end, as ``modelcast_sent_octets_total``.
    kind
        ``counter`` or ``gauge``.
    text
        What it is, in a line.
    values
        By the value of ``label``, the empty text where there is none.
    label
        What tells values apart.

    Raises
    ------
    ValueError
        Where a name or the kind is none that Prometheus knows.
    """

    name: str
    kind: str
    text: str
    values: dict[str, float]
    label: str = ""

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name) or (self.label and not _NAME.fullmatch(self.label)):
            raise ValueError(
                f"name and label must be of a-z, 0-9 and _, got {self.name!r} and {self.label!r}"
            )
        if self.kind not in {"counter", "gauge"}:
            raise ValueError(f"kind must be counter or gauge, got {self.kind!r}")


def exposition(metrics: Iterable[Metric]) -> str:
    r"""Return figures in Prometheus' text format 0.0.4.

    Parameters
    ----------
    metrics
        In the order of the text.

    Examples
    --------
    >>> print(exposition([Metric("heard_total", "counter", "Frames heard.", {"": 3.0})]), end="")
    # HELP heard_total Frames heard.
    # TYPE heard_total counter
    heard_total 3
    """
    lines: list[str] = []
    for one in metrics:
        text = one.text.replace("\\", "\\\\").replace("\n", "\\n")
        lines += [f"# HELP {one.name} {text}", f"# TYPE {one.name} {one.kind}"]
        for value_of, value in one.values.items():
            shown = value_of.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
            label = f'{{{one.label}="{shown}"}}' if one.label else ""
            lines.append(f"{one.name}{label} {_number(value)}")
    return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "+Inf" if value > 0 else "-Inf"
    return f"{value:.15g}"


async def serve_metrics(gather: Callable[[], Iterable[Metric]], *, host: str, port: int) -> asyncio.Server:
    """Serve ``GET /metrics``, one answer a connection; everything else is refused.

    Parameters
    ----------
    gather
        Gives the figures of now.
    host, port
        Where to listen; port 0 for any that is free.

    Raises
    ------
    OSError
        Where the address cannot be had.
    """
    busy = asyncio.Semaphore(_MOST_CLIENTS)

    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            if busy.locked():
                status, body = "503 Service Unavailable", "too many at a time\n"
            else:
                async with busy, asyncio.timeout(_WAIT_S):
                    status, body = await _answer(reader, gather)
            head = f"HTTP/1.1 {status}\r\nContent-Type: text/plain; version=0.0.4; charset=utf-8\r\n"
            octets = body.encode()
            writer.write(
                f"{head}Content-Length: {len(octets)}\r\nConnection: close\r\n\r\n".encode() + octets
            )
            await writer.drain()
        except (OSError, TimeoutError):
            pass
        finally:
            writer.close()

    return await asyncio.start_server(answer, host, port, limit=_HEAD_OCTETS)


async def _answer(reader: asyncio.StreamReader, gather: Callable[[], Iterable[Metric]]) -> tuple[str, str]:
    try:
        head = await reader.readuntil(b"\r\n\r\n")
    except (asyncio.IncompleteReadError, asyncio.LimitOverrunError):
        return "400 Bad Request", "no head of a request\n"
    words = head.split(b"\r\n", 1)[0].split(b" ")
    if len(words) != 3 or words[0] != b"GET":
        return "405 Method Not Allowed", "GET /metrics is all there is\n"
    if words[1].split(b"?", 1)[0] != b"/metrics":
        return "404 Not Found", "GET /metrics is all there is\n"
    return "200 OK", exposition(gather())
