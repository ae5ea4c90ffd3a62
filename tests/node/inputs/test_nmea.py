"""NMEA as it arrives."""

import asyncio
import contextlib
import math
import os
import pty
from datetime import UTC, datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.io.nmea_sentences import checksum
from modelcast.node.inputs.line_stream import StreamRules, tcp
from modelcast.node.inputs.nmea import NmeaSource, serial_device

ZERO_S = datetime(2026, 3, 1, 23, 59, 0, tzinfo=UTC).timestamp()


def sentence(body: str) -> bytes:
    return f"${body}*{checksum(body):02X}\r\n".encode()


def gga(at_s: float, *, quality: int = 1) -> bytes:
    return sentence(f"GPGGA,{clock(at_s)},4200.0000,N,08300.0000,W,{quality},08,1.0,200.0,M,-34.0,M,,")


def rmc(at_s: float, *, status: str = "A", date: bool = True) -> bytes:
    day = datetime.fromtimestamp(ZERO_S + at_s, UTC).strftime("%d%m%y") if date else ""
    return sentence(f"GNRMC,{clock(at_s)},{status},4200.0000,N,08300.0000,W,20.0,90.0,{day},,,A")


def clock(at_s: float) -> str:
    return datetime.fromtimestamp(ZERO_S + at_s, UTC).strftime("%H%M%S.%f")[:9]


def heard(*lines: bytes, at_s: float = 100.0) -> NmeaSource:
    one = NmeaSource(tcp("127.0.0.1", 1), now_s=lambda: at_s, utc_at_zero_s=ZERO_S)
    for text in lines:
        one.hear(text.strip())
    return one


def test_a_gga_and_an_rmc_of_one_instant_are_one_fix_in_either_order():
    for pair in ((gga(30.5), rmc(30.5)), (rmc(30.5), gga(30.5))):
        (fix,) = heard(*pair).take(100.0)
        assert fix.measured_s == pytest.approx(30.5)
        assert (fix.latitude_deg, fix.longitude_deg, fix.altitude_m) == (42.0, -83.0, 166.0)
        assert fix.speed_mps == pytest.approx(20.0 * 1852.0 / 3600.0)
        assert fix.heading_rad == pytest.approx(math.pi / 2.0)
        assert not fix.has_ellipse


def test_a_fix_leaves_when_its_partner_comes_not_an_epoch_later():
    one = heard(gga(1.0))
    assert one.take(100.0) == []
    one.hear(rmc(1.0).strip())
    assert len(one.take(100.0)) == 1


def test_a_receiver_of_one_kind_of_sentence_is_not_waited_for_after_three():
    one = heard(*(rmc(at / 10.0) for at in range(4)))
    assert [round(fix.measured_s, 1) for fix in one.take(100.0)] == [0.0, 0.1, 0.2, 0.3]
    one.hear(rmc(0.4).strip())
    assert [round(fix.measured_s, 1) for fix in one.take(100.0)] == [0.4]


def test_midnight_without_a_date_is_no_jump_back():
    fixes = heard(*(gga(at_s) for at_s in (59.0, 59.5, 60.0, 60.5)), at_s=61.0).take(100.0)
    assert [round(fix.measured_s, 1) for fix in fixes] == [59.0, 59.5, 60.0, 60.5]


def test_the_first_fix_of_a_day_before_any_date_is_of_the_nearest_day():
    one = heard(gga(60.0), gga(60.1), at_s=59.98)  # midnight, by a clock that is 20 ms behind
    assert [fix.measured_s for fix in one.take(100.0)] == [59.98]


def test_sentences_that_say_that_there_is_no_fix_give_none():
    one = heard(gga(1.0, quality=0), rmc(1.0, status="V"), gga(2.0), rmc(2.0, status="V"), rmc(3.0), gga(3.0))
    assert [fix.measured_s for fix in one.take(100.0)] == [pytest.approx(3.0)]
    assert one.counts()["no fix"] == 2


def test_a_time_in_the_future_is_refused():
    one = heard(gga(500.0), rmc(500.0))
    assert one.take(1000.0) == []
    assert one.counts()["ahead"] == 1


@given(st.binary(max_size=120))
def test_any_octets_leave_a_source_that_reads_the_next_fix(octets: bytes):
    one = heard()
    for piece in octets.replace(b"\r", b"\n").split(b"\n"):
        with contextlib.suppress(ValueError):
            one.hear(piece)
    one.take(100.0)
    one.hear(gga(1.0).strip())
    one.hear(rmc(1.0).strip())
    assert len(one.take(100.0)) == 1


def test_a_damaged_sentence_is_counted():
    assert heard(gga(1.0).replace(b"42", b"43")).counts() == {"bad checksum": 1}


def test_fixes_come_over_tcp_and_again_after_the_peer_was_gone(peer, until):
    async def run() -> int:
        async with peer() as server:
            rules = StreamRules(retry_s=0.01)
            one = NmeaSource(
                tcp("127.0.0.1", server.port), now_s=lambda: 100.0, utc_at_zero_s=ZERO_S, rules=rules
            )
            await one.start()
            for visits in (1, 2):
                await until(lambda: len(server.writers) == visits)  # noqa: B023
                server.say(gga(float(visits)) + rmc(float(visits)))
                await until(lambda: one.counts().get("samples") == visits)  # noqa: B023
                server.writers[-1].transport.abort()
            await one.stop()
            return one.counts()["connections"]

    assert asyncio.run(run()) == 2


def test_fixes_come_from_a_serial_device_and_a_lost_one_is_opened_again(until):
    pytest.importorskip("serial")

    async def run() -> dict[str, int]:
        master, slave = pty.openpty()
        rules = StreamRules(retry_s=0.01)
        device = serial_device(os.ttyname(slave))
        one = NmeaSource(device, now_s=lambda: 100.0, utc_at_zero_s=ZERO_S, rules=rules)
        await one.start()
        await until(lambda: one.counts().get("connections") == 1)
        os.close(slave)
        os.write(master, gga(1.0) + rmc(1.0))
        await until(lambda: one.counts().get("samples") == 1)
        os.close(master)
        await until(lambda: one.counts().get("not reached", 0) > 0)
        await one.stop()
        return dict(one.counts())

    assert asyncio.run(run())["closed"] == 1
