"""A vehicle's bus, on python-can's virtual one."""

import asyncio
import math
import struct
from pathlib import Path
from threading import Event

import pytest

from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.node.inputs.samples import PLAUSIBLE
from modelcast.node.inputs.signals import PRESETS, UNITS, read_signals, unit_scale

can = pytest.importorskip("can")
pytest.importorskip("cantools")

from modelcast.node.inputs.can_bus import CanSource, bus_by_name  # noqa: E402
from modelcast.node.inputs.frames import read_frames  # noqa: E402

DBC = """VERSION ""

BS_:

BU_: XXX

BO_ 180 SPEED: 8 XXX
 SG_ SPEED : 47|16@0+ (0.01,0) [0|655] "km/h" XXX

BO_ 36 KINEMATICS: 8 XXX
 SG_ YAW_RATE : 7|16@0- (0.01,0) [-300|300] "deg/s" XXX
 SG_ RIGHT : 16|1@0+ (1,0) [0|1] "" XXX
 SG_ ODD : 39|8@0+ (1,0) [0|255] "furlongs" XXX

BO_ 2364540158 WIDE: 2 XXX
 SG_ PEDAL : 0|1@0+ (1,0) [0|1] "" XXX

BO_ 99 OTHER: 8 XXX
 SG_ ANY : 7|8@0+ (1,0) [0|255] "" XXX
"""
MAP = "speed_mps=SPEED.SPEED, yaw_rate_radps=KINEMATICS.YAW_RATE[-deg/s], brake=WIDE.PEDAL[flag]"


@pytest.fixture
def dbc(tmp_path: Path) -> Path:
    path = tmp_path / "made.dbc"
    path.write_text(DBC)
    return path


def speed_frame(raw: int) -> bytes:
    return bytes(5) + struct.pack(">H", raw) + b"\0"


def yaw_frame(raw: int, right: int = 0) -> bytes:
    return struct.pack(">hB", raw, right) + bytes(5)


def test_values_are_in_si_and_clockwise(dbc):
    reader = read_frames(dbc, read_signals(MAP))
    assert dict(reader.read(180, speed_frame(3600)).values) == {"speed_mps": pytest.approx(10.0)}
    assert dict(reader.read(36, yaw_frame(1000)).values) == {
        "yaw_rate_radps": pytest.approx(-math.radians(10.0))
    }
    assert dict(reader.read(0x0CF004FE, b"\1\0", extended=True).values) == {"brake": 1.0}


def test_a_sign_of_its_own_turns_a_value_round(dbc):
    reader = read_frames(dbc, read_signals("yaw_rate_radps=KINEMATICS.YAW_RATE~RIGHT[-deg/s]"))
    values = [dict(reader.read(36, yaw_frame(1000, right)).values)["yaw_rate_radps"] for right in (0, 1)]
    assert values == [pytest.approx(-math.radians(10.0)), pytest.approx(math.radians(10.0))]


@pytest.mark.parametrize(
    ("frame_id", "data", "fault"),
    [(1234, bytes(8), "unknown id"), (99, bytes(8), ""), (180, bytes(3), "bad frame"),
     (180, speed_frame(65_000), "implausible"), (180, speed_frame(36_000), "")],
)  # fmt: skip
def test_what_is_left_out_has_a_reason(dbc, frame_id: int, data: bytes, fault: str):
    assert read_frames(dbc, read_signals(MAP)).read(frame_id, data).fault == fault


@pytest.mark.parametrize(
    ("signals", "word"),
    [
        ("speed_mps=NONE.SPEED[km/h]", "no message 'NONE'"),
        ("speed_mps=SPEED.NONE[km/h]", "no signal 'NONE'"),
        ("acceleration_mps2=KINEMATICS.ODD", "cannot be in 'furlongs'"),
        ("speed_mps=SPEED.SPEED[deg/s]", "cannot be in 'deg/s'"),
        ("speed_mps", "is no signal"),
        ("sped=SPEED.SPEED", "may stand once"),
        ("speed_mps=SPEED.SPEED, speed_mps=SPEED.SPEED", "may stand once"),
        ("speed_mps=SPEED.SPEED[1.2.3 km/h]", "is no number"),
    ],
)
def test_a_map_that_cannot_be_followed_is_refused_in_words(dbc, signals: str, word: str):
    with pytest.raises(ConfigError, match=word):
        read_frames(dbc, read_signals(signals))


def test_what_is_no_dbc_is_a_fault_of_the_file(tmp_path: Path):
    (tmp_path / "no.dbc").write_text("this is no database")
    for name in ("no.dbc", "missing.dbc"):
        with pytest.raises(DataFormatError, match=name):
            read_frames(tmp_path / name, read_signals(MAP))


def test_presets_can_be_read_and_hold_what_dead_reckoning_needs():
    for name in PRESETS:
        quantities = {signal.quantity for signal in read_signals(name)}
        assert quantities == set(PLAUSIBLE)
        by_quantity = {signal.quantity: signal for signal in read_signals(name)}
        assert by_quantity["yaw_rate_radps"].scale < 0.0  # public files count leftwards
        assert by_quantity["steering_rad"].scale < 0.0


def test_units_have_their_definitions():
    assert unit_scale("speed_mps", "mph") == pytest.approx(0.44704)
    assert unit_scale("acceleration_mps2", "g") == 9.80665
    assert all(scale > 0.0 for _, scale in UNITS.values())


def test_frames_of_a_virtual_bus_become_values(dbc, until):
    async def run() -> CanSource:
        with can.Bus(interface="virtual", channel="frames") as sender:
            source = CanSource(
                bus_by_name("virtual", "frames"), read_frames(dbc, read_signals(MAP)), now_s=lambda: 5.0
            )
            await source.start()
            await until(lambda: source.counts().get("connections") == 1)
            for frame_id, data in ((180, speed_frame(3600)), (1234, bytes(8)), (36, yaw_frame(100))):
                sender.send(can.Message(arbitration_id=frame_id, data=data, is_extended_id=False))
            await until(lambda: source.counts().get("samples") == 2)
            await source.stop()
            return source

    source = asyncio.run(run())
    assert source.counts()["unknown id"] == 1
    assert [(one.quantity, one.measured_s) for one in source.take(5.0)] == [
        ("speed_mps", 5.0),
        ("yaw_rate_radps", 5.0),
    ]


def test_frames_come_over_udp_multicast(dbc, until):
    pytest.importorskip("msgpack")
    channel = "239.74.163.77"
    try:
        sender = can.Bus(interface="udp_multicast", channel=channel)
    except (can.CanError, OSError) as error:
        pytest.skip(f"no multicast here: {error}")

    async def run() -> dict[str, int]:
        opened = bus_by_name("udp_multicast", channel)
        source = CanSource(opened, read_frames(dbc, read_signals(MAP)), now_s=lambda: 5.0)
        await source.start()
        await until(lambda: source.counts().get("connections") == 1)

        def came() -> bool:
            sender.send(can.Message(arbitration_id=180, data=speed_frame(3600), is_extended_id=False))
            return source.counts().get("samples", 0) > 0

        await until(came)
        await source.stop()
        return dict(source.counts())

    with sender:
        assert asyncio.run(run())["samples"] > 0


@pytest.mark.parametrize("kind", ["error", "remote"])
def test_frames_that_hold_no_values_are_only_counted(dbc, kind: str):
    source = CanSource(bus_by_name("virtual", "x"), read_frames(dbc, read_signals(MAP)), now_s=lambda: 0.0)
    flags = {f"is_{kind}_frame": True}
    source.hear(
        can.Message(
            arbitration_id=180, data=b"" if kind == "remote" else bytes(8), is_extended_id=False, **flags
        )
    )
    assert source.counts() == {"frames": 1, f"{kind} frame": 1}


def test_a_bus_that_fails_is_opened_again(dbc, until):
    opened = Event()
    attempts: list[int] = []

    def open_bus() -> can.BusABC:
        attempts.append(len(attempts))
        if len(attempts) == 1:
            raise can.CanInitializationError("no such device")
        opened.set()
        return can.Bus(interface="virtual", channel="again")

    async def run() -> dict[str, int]:
        source = CanSource(open_bus, read_frames(dbc, read_signals(MAP)), now_s=lambda: 0.0)
        await source.start()
        await until(opened.is_set)
        await source.stop()
        return dict(source.counts())

    counts = asyncio.run(run())
    assert counts["not reached"] == 1
    assert counts["connections"] == 1


def test_an_interface_that_python_can_does_not_know_is_refused():
    with pytest.raises(ConfigError, match="no interface 'socketcam'"):
        bus_by_name("socketcam", "can0")
