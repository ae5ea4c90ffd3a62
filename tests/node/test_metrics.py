"""Claims about figures for Prometheus."""

import asyncio

import pytest

from modelcast.node.metrics import Metric, exposition, serve_metrics

HEARD = Metric("heard_total", "counter", "Frames.", {"accepted": 3.0, 'a "b"\\\n': float("inf")}, "receipt")


def test_labels_and_numbers_are_written_as_prometheus_reads_them() -> None:
    assert exposition([HEARD, Metric("load", "gauge", "Of\nit.", {"": 0.25})]).splitlines() == [
        "# HELP heard_total Frames.",
        "# TYPE heard_total counter",
        'heard_total{receipt="accepted"} 3',
        'heard_total{receipt="a \\"b\\"\\\\\\n"} +Inf',
        "# HELP load Of\\nit.",
        "# TYPE load gauge",
        "load 0.25",
    ]


@pytest.mark.parametrize(("name", "kind"), [("Heard", "gauge"), ("heard-total", "gauge"), ("heard", "sum")])
def test_a_name_that_prometheus_would_refuse_is_refused(name: str, kind: str) -> None:
    with pytest.raises(ValueError, match="must be"):
        Metric(name, kind, "", {})


async def asked(request: bytes) -> bytes:
    server = await serve_metrics(lambda: [HEARD], host="127.0.0.1", port=0)
    async with server:
        reader, writer = await asyncio.open_connection(*server.sockets[0].getsockname())
        writer.write(request)
        writer.write_eof()
        answer = await reader.read()
        writer.close()
    return answer


@pytest.mark.parametrize(
    ("request_octets", "status"),
    [
        (b"GET /metrics HTTP/1.1\r\nHost: a\r\n\r\n", b"200 OK"),
        (b"GET /metrics?a=b HTTP/1.1\r\n\r\n", b"200 OK"),
        (b"GET / HTTP/1.1\r\n\r\n", b"404 Not Found"),
        (b"POST /metrics HTTP/1.1\r\n\r\n", b"405 Method Not Allowed"),
        (b"\x16\x03\x01\x02\x00\r\n\r\n", b"405 Method Not Allowed"),
        (b"GET /metrics", b"400 Bad Request"),
        (b"GET /" + b"a" * 10_000 + b" HTTP/1.1\r\n\r\n", b"400 Bad Request"),
    ],
)
def test_one_page_is_served_and_nothing_else(request_octets: bytes, status: bytes) -> None:
    answer = asyncio.run(asked(request_octets))
    assert answer.startswith(b"HTTP/1.1 " + status)
    head, _, body = answer.partition(b"\r\n\r\n")
    assert f"Content-Length: {len(body)}".encode() in head
    assert (b"heard_total" in body) == (status == b"200 OK")
