"""Measure how long a sample takes to another node's map, with and without a thousand others on the air.

Two nodes in two processes on the loopback interface: one drives and sends at 10 Hz, the other hears. The age
of what its map holds of the first is read the moment it has heard a frame: from the sample's instant over the
sender's step, its draw of a later start (up to 5 ms, SAE J2945/1's vTxRand), the sockets, to the map. The
others' frames are made beforehand and sent at their times by a third process.

    python benchmarks/node_latency.py [--remotes 1000] [--seconds 30]
"""

import argparse
import asyncio
import multiprocessing
import time

import numpy as np

from measured import record
from modelcast.models.profile import default_profile
from modelcast.node.clock import SystemClock
from modelcast.node.envelope import Opened, Unsecured
from modelcast.node.multicast import MulticastTransport
from modelcast.node.node import Node
from modelcast.node.run import Lateness, run_node
from modelcast.station.policy.periodic import Periodic
from modelcast.station.sender.sender import Sender
from modelcast.station.station import Station
from node_tick import ORIGIN, TICK_S, frames_of, motion

PORT = 17_398
DRIVER = 2**32 - 1
SETTLES_S = 8.0
_READ_OCTETS = 20


def _name_bits() -> int:
    """Bits among a frame's first octets that the temporary id takes."""
    frames: list[int] = []
    for name in (0, DRIVER):
        sent = Station("bsm-10hz", temporary_id=name, origin=ORIGIN).sense(
            0.0, (0.0, 0.0), speed_mps=10.0, heading_rad=0.0, acceleration_mps2=0.0, yaw_rate_radps=0.0
        )
        frame = Unsecured().wrap(sent[0].octets, sent_s=0.0)
        frames.append(int.from_bytes(frame[:_READ_OCTETS], "big"))
    return frames[0] ^ frames[1]


_NAME_BITS = _name_bits()


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--remotes", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=30.0)
    given = parser.parse_args()
    empty_late = Lateness()
    asyncio.run(empty_loop(empty_late, min(given.seconds, 10.0)))
    print(f"an empty loop wakes late: {quantiles(empty_late)}")
    for remotes in (0, given.remotes):
        measure(remotes, given.seconds)


def measure(remotes: int, seconds: float) -> None:
    """One row: the latencies that the hearing node saw."""
    start_utc_s = float(np.ceil(time.time())) + SETTLES_S
    ways = multiprocessing.get_context("spawn")
    beside = [ways.Process(target=drive, args=(seconds + SETTLES_S,))]
    if remotes:
        beside.append(ways.Process(target=flood, args=(remotes, seconds, start_utc_s)))
    for one in beside:
        one.start()
    ages_s, late = asyncio.run(hear(seconds + SETTLES_S, start_utc_s))
    for one in beside:
        one.join()
    p50, p99 = np.quantile(ages_s, (0.5, 0.99)) * 1e3
    for name, value in (("p50", p50), ("p99", p99)):
        record(f"sample to map, {name}", float(value), "ms", sizes={"others": remotes})
    print(
        f"{remotes:5} others: sample to map p50 {p50:.1f} ms, p99 {p99:.1f} ms, most "
        f"{1e3 * ages_s.max():.1f} ms ({ages_s.size} samples); the host's steps are late: {quantiles(late)}"
    )


def quantiles(late: Lateness) -> str:
    """How late steps began."""
    p50, p99 = (1e3 * late.quantile_s(share) for share in (0.5, 0.99))
    return f"p50 {p50:.2f} ms, p99 {p99:.2f} ms"


async def empty_loop(late: Lateness, seconds: float) -> None:
    """Wake every tenth of a second and do nothing."""
    loop = asyncio.get_running_loop()
    begin_s = loop.time()
    for number in range(1, int(seconds / TICK_S)):
        due_s = begin_s + number * TICK_S
        await asyncio.sleep(due_s - loop.time())
        late.add(loop.time() - due_s)


def drive(seconds: float) -> None:
    """Be the node that sends."""
    asyncio.run(_drive(seconds))


async def _drive(seconds: float) -> None:
    clock = SystemClock()
    sender = Sender("model at 10 Hz", Periodic(10.0), default_profile().bank, start="recent")
    station = Station(sender, temporary_id=DRIVER, dt_s=TICK_S, origin=ORIGIN)
    stop = asyncio.Event()
    asyncio.get_running_loop().call_later(seconds, stop.set)
    with MulticastTransport(clock.now_s, port=PORT) as air:
        await run_node(
            Node(station, air, Unsecured()), clock, motion, tick_s=TICK_S, stop=stop, fileno=air.fileno()
        )


def flood(remotes: int, seconds: float, start_utc_s: float) -> None:
    """Be all the others."""
    clock = SystemClock()
    begin_s = start_utc_s - clock.minute_utc_s
    sent = frames_of(remotes, int(seconds / TICK_S), default_profile().bank, begin_s=begin_s)
    with MulticastTransport(clock.now_s, port=PORT) as air:
        for tick, frames in enumerate(sent):
            for number, frame in enumerate(frames):
                due_s = begin_s + TICK_S * (tick + number / len(frames))
                while (wait_s := due_s - clock.now_s()) > 0.0:
                    time.sleep(max(wait_s, 1e-3))
                air.send(frame, sent_s=due_s)
            air.receive(0.0)


class Noting(Unsecured):
    """The envelope that has the map looked at when what has arrived has been heard."""

    def __init__(self, note: "Noted") -> None:
        self._note = note

    def open(self, frame: bytes, *, received_s: float) -> Opened:
        """Open the frame; where it is the driver's, the map is read once its portion has been heard."""
        if int.from_bytes(frame[:_READ_OCTETS], "big") & _NAME_BITS == _NAME_BITS:
            self._note.soon()
        return super().open(frame, received_s=received_s)


class Noted:
    """Ages of what a map holds of the driver, each read when it is new."""

    def __init__(self, clock: SystemClock, from_s: float) -> None:
        self._clock, self._from_s = clock, from_s
        self._pending, self._last_s = False, -np.inf
        self.node: Node | None = None
        self.ages_s: list[float] = []

    def soon(self) -> None:
        """Read when this turn of the loop has ended."""
        if not self._pending:
            self._pending = True
            asyncio.get_running_loop().call_soon(self._read)

    def _read(self) -> None:
        self._pending = False
        now_s = self._clock.now_s()
        assert self.node is not None
        around = self.node.station.believe(now_s)
        row = np.flatnonzero(around.vehicle == DRIVER)
        if row.size and around.received_s[row[0]] > self._last_s:
            self._last_s = float(around.received_s[row[0]])
            if now_s >= self._from_s:
                self.ages_s.append(float(around.information_age_s[row[0]]))


async def hear(seconds: float, from_utc_s: float) -> tuple[np.ndarray, Lateness]:
    """Be the node that hears; gives ages [s], and how late its steps were."""
    clock, late, stop = SystemClock(), Lateness(), asyncio.Event()
    noted = Noted(clock, from_utc_s - clock.minute_utc_s)
    station = Station("mbc", temporary_id=0, dt_s=TICK_S, origin=ORIGIN)
    asyncio.get_running_loop().call_later(seconds, stop.set)
    with MulticastTransport(clock.now_s, port=PORT) as air:
        noted.node = Node(station, air, Noting(noted))
        await run_node(
            noted.node, clock, motion, tick_s=TICK_S, stop=stop, fileno=air.fileno(), lateness=late
        )
    return np.array(noted.ages_s), late


if __name__ == "__main__":
    main()
