"""The gpsd of the machine, fed with NMEA over a socket; where there is none, `test_gpsd` plays one."""

import asyncio
import shutil
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime

import pytest

from modelcast.io.nmea_sentences import checksum
from modelcast.node.inputs.gpsd import GpsdSource

GPSD = shutil.which("gpsd", path="/usr/sbin:/usr/local/sbin:/usr/bin:/usr/local/bin:/opt/homebrew/sbin")

pytestmark = pytest.mark.skipif(GPSD is None, reason="gpsd is not installed")


def sentence(body: str) -> bytes:
    return f"${body}*{checksum(body):02X}\r\n".encode()


def epoch(second: int) -> bytes:
    at = datetime(2026, 3, 1, 12, 0, second, tzinfo=UTC)
    time = at.strftime("%H%M%S.00")
    return (
        sentence(f"GPGGA,{time},4200.0000,N,08300.{second:04d},W,1,08,1.0,200.0,M,-34.0,M,,")
        + sentence("GPGSA,A,3,04,05,06,09,12,24,25,29,,,,,1.8,1.0,1.5")
        + sentence(f"GPRMC,{time},A,4200.0000,N,08300.{second:04d},W,20.0,90.0,{at:%d%m%y},,,A")
    )  # fmt: skip


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


@contextmanager
def gpsd(port: int, feed: int) -> Iterator[None]:
    command = [str(GPSD), "-N", "-n", "-b", "-S", str(port), f"tcp://127.0.0.1:{feed}"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:  # noqa: S603
        try:
            yield
        finally:
            process.terminate()


def test_fixes_of_the_real_gpsd_arrive_and_again_after_its_restart(peer, until):
    port = free_port()
    zero_s = datetime(2026, 3, 1, 12, 0, 0, tzinfo=UTC).timestamp()

    async def fixes(one: GpsdSource, feed: object) -> list:
        """Feed epochs until gpsd has made a fix of one."""
        await until(lambda: bool(feed.writers))
        found: list = []
        for second in range(1, 50):
            feed.say(epoch(second))
            try:
                async with asyncio.timeout(0.5):
                    while not found:
                        await asyncio.sleep(0)
                        found = one.take(1e6)
            except TimeoutError:
                continue
            return found
        return found

    async def run() -> tuple[list, list, GpsdSource]:
        clock = {"s": 60.0}
        one = GpsdSource("127.0.0.1", port, now_s=lambda: clock["s"], utc_at_zero_s=zero_s)
        await one.start()
        async with peer() as feed:
            with gpsd(port, feed.port):
                first = await fixes(one, feed)
        clock["s"] = 70.0  # the receiver has another name now, and is taken for another one for two seconds
        async with peer() as feed:
            with gpsd(port, feed.port):
                second = await fixes(one, feed)
        await one.stop()
        return first, second, one

    first, second, one = asyncio.run(run())
    for found in (first, second):
        assert found[0].latitude_deg == pytest.approx(42.0)
        assert found[0].longitude_deg == pytest.approx(-83.0, abs=0.01)
        assert found[0].speed_mps == pytest.approx(20.0 * 1852.0 / 3600.0, abs=0.01)
    assert one.release
    assert one.counts()["connections"] == 2
