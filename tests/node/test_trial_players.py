"""Claims about the gpsd and the bus that nodes are tried with, against the real clients."""

import asyncio
from dataclasses import replace

import numpy as np
import pytest

from modelcast.node.demo import demo_trips
from modelcast.node.inputs.gpsd import GpsdSource
from modelcast.node.inputs.samples import GnssFix
from modelcast.node.inputs.signals import read_signals
from modelcast.node.trials.drive import Drive
from modelcast.node.trials.gpsd_player import Gives, GpsdPlayer
from modelcast.node.trials.pacing import at_every

from .virtual_time import run_in_virtual_time

BEGIN_S = 1_764_000_000.0
TRIP = demo_trips(100.0)["crossing"]


def utc_s() -> float:
    return BEGIN_S + asyncio.get_running_loop().time()


def drive() -> Drive:
    return Drive(TRIP, begin_utc_s=BEGIN_S)


def test_a_drive_is_the_trip_at_its_samples_and_stays_where_it_begins_and_ends() -> None:
    assert TRIP.speed_mps is not None
    own = drive()
    for row in (0, 17, 500):
        assert own.at(BEGIN_S + 0.1 * row).speed_mps == pytest.approx(TRIP.speed_mps[row], abs=1e-6)
    assert own.at(BEGIN_S - 5.0) == own.at(BEGIN_S)
    assert own.at(BEGIN_S + 200.0) == own.at(BEGIN_S + 100.0)


def test_a_heading_through_north_is_not_turned_round() -> None:
    trip = replace(TRIP, heading_rad=np.where(np.arange(len(TRIP)) % 2, 0.1, 2.0 * np.pi - 0.1))
    heading_rad = Drive(trip, begin_utc_s=0.0).at(0.05).heading_rad
    assert min(heading_rad, 2.0 * np.pi - heading_rad) == pytest.approx(0.0, abs=1e-6)


def test_a_trip_without_motion_is_no_drive() -> None:
    with pytest.raises(ValueError, match="must have speed"):
        Drive(replace(TRIP, yaw_rate_radps=None), begin_utc_s=0.0)


def test_work_is_done_at_whole_multiples_and_what_came_too_late_is_left_out() -> None:
    done: list[float] = []
    spent = {"s": 0.0}

    async def main() -> None:
        def work(due_s: float) -> None:
            done.append(due_s - BEGIN_S)
            spent["s"] += 0.35 if len(done) == 2 else 0.0

        task = asyncio.create_task(at_every(0.1, lambda: utc_s() + spent["s"], work))
        await asyncio.sleep(0.42)
        task.cancel()

    run_in_virtual_time(main())
    assert done == pytest.approx([0.1, 0.2, 0.5, 0.6, 0.7], abs=1e-6)


async def heard(player: GpsdPlayer, seconds: float) -> tuple[list[GnssFix], dict[str, int]]:
    """Fixes that a client has after a while."""
    source = GpsdSource("127.0.0.1", player.port, now_s=lambda: utc_s() - BEGIN_S, utc_at_zero_s=BEGIN_S)
    await source.start()
    fixes: list[GnssFix] = []
    for _ in range(round(seconds / 0.1)):
        await asyncio.sleep(0.1)
        fixes += [one for one in source.take(utc_s() - BEGIN_S) if isinstance(one, GnssFix)]
    await source.stop()
    return fixes, dict(source.counts())


def played(
    seconds: float, *, gives: Gives = "fixes", splits: bool = False
) -> tuple[list[GnssFix], dict[str, int]]:
    async def main() -> tuple[list[GnssFix], dict[str, int]]:
        player = GpsdPlayer(drive(), utc_s)
        player.gives, player.splits = gives, splits
        await player.start()
        try:
            return await heard(player, seconds)
        finally:
            await player.stop()

    return run_in_virtual_time(main())


@pytest.mark.parametrize("splits", [False, True])
def test_a_client_hears_ten_fixes_a_second_where_the_vehicle_was(splits: bool) -> None:
    fixes, counts = played(5.0, splits=splits)
    assert len(fixes) == pytest.approx(50, abs=3)
    assert counts["SKY"] == pytest.approx(5, abs=1)
    assert "garbage" not in counts
    for fix in fixes:
        true = drive().at(BEGIN_S + fix.measured_s)
        assert fix.latitude_deg == pytest.approx(true.latitude_deg, abs=2e-9)
        assert fix.received_s - fix.measured_s == pytest.approx(0.15 if splits else 0.05, abs=0.02)


def test_reports_without_a_fix_are_counted_as_such() -> None:
    fixes, counts = played(2.0, gives="no fix")
    assert fixes == []
    assert counts["no fix"] > 15


def test_a_receiver_that_hangs_says_one_place_with_new_times() -> None:
    fixes, _ = played(2.0, gives="same fix")
    assert len({fix.latitude_deg for fix in fixes}) == 1
    assert len({fix.measured_s for fix in fixes}) == len(fixes) > 15


def test_a_connection_without_an_octet_is_given_up_by_the_client() -> None:
    fixes, counts = played(6.0, gives="nothing")
    assert fixes == []
    assert counts["silent"] == 2


def test_a_client_is_back_within_two_seconds_of_a_restart() -> None:
    async def main() -> float:
        player = GpsdPlayer(drive(), utc_s)
        await player.start()
        listening = asyncio.create_task(heard(player, 8.0))
        await asyncio.sleep(2.0)
        await player.stop()
        await asyncio.sleep(1.0)
        begin_s, port = utc_s(), player.port
        await player.start()
        assert player.port == port
        await listening
        await player.stop()
        return player.last_connection_utc_s - begin_s

    assert 0.0 <= run_in_virtual_time(main()) < 2.0


def test_a_bus_says_what_is_driven_until_it_hangs() -> None:
    can = pytest.importorskip("can")
    pytest.importorskip("cantools")
    import cantools  # noqa: PLC0415 - the extra

    from modelcast.node.inputs.frames import FrameReader  # noqa: PLC0415
    from modelcast.node.trials.bus_player import BUS_DBC, BUS_SIGNALS, BusPlayer  # noqa: PLC0415

    reader = FrameReader(cantools.database.load_string(BUS_DBC, "dbc"), read_signals(BUS_SIGNALS))

    async def main() -> None:
        listener = can.Bus(interface="virtual", channel="trial")
        player = BusPlayer(can.Bus(interface="virtual", channel="trial"), drive(), utc_s)

        def newest() -> dict[str, float]:
            found = b""
            while (frame := listener.recv(0)) is not None:
                found = frame.data
            return dict(reader.read(180, found).values) if found else {}

        player.start()
        await asyncio.sleep(3.0)
        values, true = newest(), drive().at(BEGIN_S + 3.0)
        assert values["speed_mps"] == pytest.approx(true.speed_mps, abs=0.05)
        assert values["yaw_rate_radps"] == pytest.approx(true.yaw_rate_radps, abs=0.005)
        assert values["acceleration_mps2"] == pytest.approx(true.acceleration_mps2, abs=0.05)
        player.gives = "same values"
        await asyncio.sleep(2.0)
        held = newest()
        await asyncio.sleep(2.0)
        assert newest() == held
        player.gives = "nothing"
        await asyncio.sleep(1.0)
        newest()
        await asyncio.sleep(1.0)
        assert newest() == {}
        await player.stop()
        listener.shutdown()

    run_in_virtual_time(main())
