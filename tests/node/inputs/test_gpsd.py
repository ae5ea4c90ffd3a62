"""gpsd as a source, against a server that plays one."""

import asyncio
import contextlib
import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.node.inputs.gpsd import GpsdSource, read_report, read_tpv
from modelcast.node.inputs.line_stream import StreamRules

ZERO_S = 1_700_000_040.0
"""UTC at the node's 0, 2023-11-14T22:14:00Z."""

TPV = {"class": "TPV", "device": "/dev/a", "mode": 3, "lat": 42.0, "lon": -83.0, "speed": 12.5, "track": 90.0}
SKY = {"class": "SKY", "uSat": 9, "hdop": 0.8}


def line(report: dict, **more: object) -> bytes:
    return json.dumps(report | more).encode() + b"\r\n"


def source(port: int = 1, *, at_s: float = 10.0, **rules: float) -> GpsdSource:
    given = StreamRules(**({"hello": b"?WATCH\n", "ping": b"?VERSION;\n", "retry_s": 0.01} | rules))
    return GpsdSource(
        "127.0.0.1", port, now_s=lambda: at_s, utc_at_zero_s=ZERO_S, rules=given if rules else None
    )


def heard(*lines: bytes, at_s: float = 10.0) -> GpsdSource:
    one = source(at_s=at_s)
    for text in lines:
        one.hear(text.strip())
    return one


def test_a_fix_has_its_units_turned_and_its_own_time():
    (fix,) = heard(line(TPV, time="2023-11-14T22:14:09.900Z", altHAE=200.0)).take(10.0)
    assert (fix.latitude_deg, fix.longitude_deg, fix.altitude_m, fix.speed_mps) == (42.0, -83.0, 200.0, 12.5)
    assert fix.heading_rad == pytest.approx(math.pi / 2.0)
    assert (fix.received_s, fix.measured_s) == (10.0, pytest.approx(9.9, abs=1e-6))


def test_a_sky_report_before_any_fix_is_no_hindrance():
    one = heard(line(SKY), line(TPV))
    assert len(one.take(10.0)) == 1
    assert one.satellites == 9


@pytest.mark.parametrize("mode", [0, 1])
def test_modes_below_two_are_no_fix(mode: int):
    one = heard(line(TPV, mode=mode))
    assert one.take(10.0) == []
    assert one.counts()["no fix"] == 1


def test_without_error_estimates_the_ellipse_is_unavailable():
    (fix,) = heard(line(TPV)).take(10.0)
    assert not fix.has_ellipse


def test_error_estimates_are_95_percent_limits_on_their_axes():
    north = read_tpv(TPV | {"epx": 1.96, "epy": 3.92}, received_s=0.0, measured_s=0.0)
    east = read_tpv(TPV | {"epx": 3.92, "epy": 1.96}, received_s=0.0, measured_s=0.0)
    both = read_tpv(TPV | {"eph": 2.4477}, received_s=0.0, measured_s=0.0)
    assert (north.semi_major_m, north.semi_minor_m) == (
        pytest.approx(2.0, abs=1e-3),
        pytest.approx(1.0, abs=1e-3),
    )
    assert (north.ellipse_orientation_rad, east.ellipse_orientation_rad) == (0.0, math.pi / 2.0)
    assert both.semi_major_m == both.semi_minor_m == pytest.approx(1.0, abs=1e-3)


def test_a_fix_from_the_future_is_refused_and_one_a_little_ahead_taken_as_of_now():
    one = heard(line(TPV, time="2023-11-14T22:19:10Z"), line(TPV, time="2023-11-14T22:14:10.05Z"))
    (fix,) = one.take(10.0)
    assert fix.measured_s == fix.received_s == 10.0
    assert one.counts()["ahead"] == 1
    assert one.newest_utc == (10.0, ZERO_S + 10.05)


def test_a_fix_without_a_time_is_of_its_arrival():
    (fix,) = heard(line(TPV, time="yesterday")).take(10.0)
    assert fix.measured_s == 10.0


def test_one_device_is_listened_to_until_it_is_silent_for_two_seconds():
    clock = {"s": 10.0}
    one = GpsdSource("127.0.0.1", 1, now_s=lambda: clock["s"], utc_at_zero_s=ZERO_S)
    one.hear(line(TPV))
    clock["s"] = 11.9
    one.hear(line(TPV, device="/dev/b"))
    assert (len(one.take(20.0)), one.counts()["other device"]) == (1, 1)
    clock["s"] = 12.0
    one.hear(line(TPV, device="/dev/b"))
    assert len(one.take(20.0)) == 1


def test_fixes_do_not_queue_up_the_newest_are_kept():
    one = heard(*(line(TPV, lat=at / 1000.0) for at in range(1000)))
    fixes = one.take(10.0)
    assert len(fixes) == 32
    assert fixes[-1].latitude_deg == 0.999
    assert one.counts()["overrun"] == 968


@pytest.mark.parametrize(
    "text",
    [b"", b"{", b"[]", b'{"class":3}', b"\xff\xfe", b'{"class":"TPV","mode":"3"}', b"[" * 9000,
     b'{"class":"TPV","mode":3,"lat":NaN,"lon":1}', b'{"class":"TPV","mode":3,"lat":"4","lon":1}',
     b'{"class":"TPV","mode":3,"lat":91.0,"lon":1.0}'],
)  # fmt: skip
def test_what_is_no_report_is_an_error_of_value(text: bytes):
    with pytest.raises(ValueError):  # noqa: PT011 - any of them is counted as garbage
        heard(text)


SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8)
NAMES = st.sampled_from(
    ["class", "mode", "lat", "lon", "time", "speed", "track", "epx", "epy", "eph", "uSat", "device"]
)


@given(st.dictionaries(NAMES, SCALARS | st.just(3) | st.just("TPV") | st.lists(SCALARS, max_size=2)))
def test_any_report_is_read_or_an_error_of_value(changes: dict):
    one = source()
    with contextlib.suppress(ValueError):
        one.hear(json.dumps(TPV | changes).encode())
    one.hear(line(TPV, device="/dev/a").strip())
    assert all(abs(fix.latitude_deg) <= 90.0 for fix in one.take(10.0))


def test_a_host_that_is_no_name_is_not_reached(until):
    async def run() -> dict[str, int]:
        one = GpsdSource("x" * 300, 1, now_s=lambda: 0.0, utc_at_zero_s=0.0, rules=StreamRules(retry_s=0.01))
        await one.start()
        await until(lambda: one.counts().get("not reached", 0) > 1)
        await one.stop()
        return dict(one.counts())

    assert "connections" not in asyncio.run(run())


def test_attributes_may_come_in_any_order():
    assert read_report(b'{"mode":3,"class":"TPV"}')["mode"] == 3


def test_split_garbage_and_overlong_lines_leave_the_fixes_between_them(peer, until):
    async def run() -> dict[str, int]:
        async with peer() as server:
            one = source(server.port, most_octets=1000.0)
            await one.start()
            await until(lambda: b"?WATCH" in b"".join(server.heard))
            text = line(TPV)
            for piece in (
                text[:7],
                text[7:30],
                text[30:],
                b"nonsense\n",
                b"x" * 5000,
                b"\n",
                line(SKY),
                text,
            ):
                server.say(piece)
                await asyncio.sleep(0)
            await until(lambda: one.counts().get("samples") == 2)
            await one.stop()
            return dict(one.counts())

    counts = asyncio.run(run())
    assert (counts["garbage"], counts["overlong"], counts["SKY"]) == (1, 1, 1)


def test_it_comes_back_after_gpsd_was_restarted(peer, until):
    async def run() -> dict[str, int]:
        async with peer() as server:
            port = server.port
            one = source(port, retry_s=0.01)
            await one.start()
            await until(lambda: bool(server.writers))
            server.say(line(TPV))
            await until(lambda: one.counts().get("samples") == 1)
        await until(lambda: one.counts().get("not reached", 0) > 0)
        async with peer(port) as server:
            await until(lambda: bool(server.writers))
            server.say(line(TPV))
            await until(lambda: one.counts().get("samples") == 2)
            await one.stop()
        return dict(one.counts())

    counts = asyncio.run(run())
    assert counts["connections"] == 2


def test_a_half_open_connection_is_asked_and_then_given_up(peer, until):
    async def run() -> tuple[dict[str, int], bytes]:
        async with peer() as server:
            one = source(server.port, silence_s=0.1)
            await one.start()
            await until(lambda: len(server.writers) == 2)  # the first one never said a word
            await one.stop()
            return dict(one.counts()), b"".join(server.heard)

    counts, asked = asyncio.run(run())
    assert counts["silent"] >= 1
    assert b"?VERSION;" in asked


def test_a_quiet_gpsd_that_answers_is_kept(peer, until):
    async def run() -> dict[str, int]:
        async with peer() as server:
            one = source(server.port, silence_s=0.1)
            await one.start()
            for answers in range(1, 6):
                await until(lambda: b"".join(server.heard).count(b"?VERSION;") >= answers)  # noqa: B023
                server.say(b'{"class":"VERSION","release":"3.22"}\r\n')
                await until(lambda: one.counts().get("VERSION", 0) >= answers)  # noqa: B023
            await one.stop()
            assert one.release == "3.22"
            return dict(one.counts())

    counts = asyncio.run(run())
    assert counts["connections"] == 1
    assert "silent" not in counts
