"""Measure the processor time of a node's tick with 1,000 remotes at 10 Hz, and of its own step.

Every remote sends a model at every step; frames go through real sockets on the loopback interface, within the
heads of the wire. What is counted is what the host does in a tenth of a second: read the sockets, open the
envelopes, decode, check, update its map, predict all remotes and assess every application. Frames arrive in
so many portions a tick: 1 is a host that was busy, 100 one that is woken for ten frames at a time.

Signed, every message is verified; beside it stands what the bare verifications of as many signatures take.

With --bank everybody speaks and holds that bank, one with a sub-model of another package for one; where its
paths are carried over the air, hosts run none of its Python. Signatures are left out then.

    python benchmarks/node_tick.py [--remotes 1000] [--ticks 200] [--bank chord]
"""

import argparse
import gc
import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from measured import record
from modelcast.apps.registry import get_application
from modelcast.core.arrays import FloatArray
from modelcast.core.chance import child_generator
from modelcast.core.geodesy import Origin
from modelcast.messages.security.authority import Authority
from modelcast.messages.security.p256 import PrivateKey, PublicKey
from modelcast.messages.security.signer import Signer
from modelcast.messages.security.time64 import since_2004_s
from modelcast.models.bank import Bank
from modelcast.node.envelope import AbstractEnvelope, Unsecured
from modelcast.node.inputs.motion import Motion
from modelcast.node.multicast import MulticastTransport
from modelcast.node.node import Node
from modelcast.node.signed import Signed
from modelcast.station.banks import named_bank
from modelcast.station.fleet import Fleet
from modelcast.station.policy.periodic import Periodic
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.station.station import Station

ORIGIN = Origin(48.1374, 11.5755, 520.0)
TICK_S, WARM_TICKS = 0.1, 20
LANES, ROAD_M, SPEED_MPS = 8, 800.0, 25.0
DEFAULT = "default"
APPLICATIONS = ("fcw", "eebl", "ima")
PORT = 17_399
ZERO_UTC_S = 1_764_000_000.0
START_S = int(since_2004_s(ZERO_UTC_S)) - 60


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--remotes", type=int, default=1000)
    parser.add_argument("--ticks", type=int, default=200)
    parser.add_argument("--bank", default=DEFAULT)
    given = parser.parse_args()
    bank = named_bank(given.bank).bank
    sent = frames_of(given.remotes, given.ticks, bank)
    size = np.mean([len(one) for tick in sent for one in tick])
    print(f"{given.remotes} remotes, {given.ticks} ticks, frames of {size:.0f} octets on average")
    gc.collect()
    gc.freeze()
    sizes = {"remotes": given.remotes}
    for portions in (1, 10, 100, given.remotes):
        times_ms = host(sent, portions, Unsecured(), bank)
        record(f"tick, {portions} portions, median", float(np.median(times_ms)), "ms", sizes=sizes)
        print(f"host, {portions:4} portions a tick: {row(times_ms)}", flush=True)
    print(f"remote alone: {row(alone(given.ticks, bank))}")
    if given.bank != DEFAULT:
        return
    envelope = signing()
    others = {name: envelope(2 + name) for name in range(1, given.remotes + 1)}
    signed = frames_of(given.remotes, given.ticks // 4, bank, envelopes=others)
    size = np.mean([len(one) for tick in signed for one in tick])
    print(f"signed, frames of {size:.0f} octets on average")
    bare_ms = bare(given.remotes, given.ticks // 4)
    peer = "bare verifications", float(np.median(bare_ms))
    for portions in (1, 10):
        times_ms = host(signed, portions, envelope(2), bank)
        record(
            f"tick, signed, {portions} portions, median",
            float(np.median(times_ms)),
            "ms",
            peer=peer,
            sizes=sizes,
        )
        print(f"host, {portions:4} portions a tick: {row(times_ms)}", flush=True)
    print(f"bare verifications: {row(bare_ms)}")


def signing() -> Callable[[int], Signed]:
    """What makes a new envelope of a secret number, all by one authority."""
    root = Authority.create(PrivateKey(1), start_s=START_S, duration_s=86_400)

    def envelope(secret: int) -> Signed:
        key = PrivateKey(secret)
        signer = Signer(key, root.issue(key.public_octets, start_s=START_S, duration_s=86_400))
        return Signed((root.certificate,), (signer,), utc_at_zero_s=ZERO_UTC_S)

    return envelope


def bare(count: int, ticks: int) -> FloatArray:
    """Processor time of as many verifications as there are messages in a tick [ms]."""
    key, data = PrivateKey(3), bytes(64)
    public, signature = PublicKey(key.public_octets), key.sign(data)
    found: list[float] = []
    for _ in range(ticks):
        begin = time.process_time_ns()
        for _ in range(count):
            public.verifies(data, signature)
        found.append((time.process_time_ns() - begin) / 1e6)
    return np.array(found)


def row(times_ms: FloatArray) -> str:
    """Quantiles of a tick's processor time."""
    p50, p99 = np.quantile(times_ms, (0.5, 0.99))
    return f"p50 {p50:.2f} ms, p99 {p99:.2f} ms, most {times_ms.max():.2f} ms"


def frames_of(
    remotes: int,
    ticks: int,
    bank: Bank,
    *,
    begin_s: float = 0.0,
    envelopes: Mapping[int, AbstractEnvelope] | None = None,
) -> list[list[bytes]]:
    """What all remotes send from a time on, a list a tick, in the order in which they leave."""
    sender = Sender("model at 10 Hz", Periodic(10.0), bank, start="recent")
    fleet = Fleet(sender, slots=remotes, dt_s=TICK_S, origin=ORIGIN)
    rng = child_generator(0, "node tick")
    name, plain = np.arange(1, remotes + 1), Unsecured()
    around = dict.fromkeys(name.tolist(), plain) if envelopes is None else envelopes
    lane = name % LANES
    mean_mps, phase = SPEED_MPS + rng.uniform(-5.0, 5.0, remotes), rng.uniform(0.0, 2.0 * np.pi, remotes)
    start_m = rng.uniform(-ROAD_M / 2.0, ROAD_M / 2.0, remotes)
    sent: list[list[bytes]] = []
    for tick in range(ticks + WARM_TICKS):
        t_s = begin_s + tick * TICK_S
        speed_mps = mean_mps + 2.0 * np.sin(0.5 * t_s + phase)
        way_m = start_m + mean_mps * t_s + 4.0 * (np.cos(phase) - np.cos(0.5 * t_s + phase))
        all_of_them = fleet.sense(
            t_s,
            name,
            np.stack([way_m, 3.5 * lane], axis=1),
            speed_mps=speed_mps,
            heading_rad=np.full(remotes, np.pi / 2.0),
            acceleration_mps2=np.cos(0.5 * t_s + phase),
            yaw_rate_radps=np.zeros(remotes),
        )
        leaving = sorted(all_of_them, key=lambda one: one.send_s)
        frames = [around[one.vehicle].wrap(one.octets, sent_s=one.send_s) for one in leaving]
        sent.append([one for one in frames if one is not None])
    return sent


def motion(t_s: float) -> Motion:
    """Of the host, which keeps up with them."""
    return Motion(
        t_s=t_s,
        mode="gnss+can",
        place_deg=(ORIGIN.latitude_deg, ORIGIN.longitude_deg),
        position_m=(SPEED_MPS * t_s, -10.0),
        speed_mps=SPEED_MPS,
        heading_rad=np.pi / 2.0,
        acceleration_mps2=0.0,
        yaw_rate_radps=0.0,
        derived=frozenset(),
        covariance_m2=np.eye(2),
        ellipse_known=True,
        age_s=0.0,
        begins=False,
    )


def host(
    sent: Sequence[Sequence[bytes]], portions: int, envelope: AbstractEnvelope, bank: Bank
) -> FloatArray:
    """Processor time of every tick of a host that hears them [ms]."""
    clock_s = [0.0]
    station = Station(named_sender("mbc", bank=bank), temporary_id=0, dt_s=TICK_S, origin=ORIGIN)
    found: list[float] = []
    with (
        MulticastTransport(lambda: clock_s[0], port=PORT) as out,
        MulticastTransport(lambda: clock_s[0], port=PORT) as own,
    ):
        node = Node(
            station, own, envelope, applications={name: get_application(name) for name in APPLICATIONS}
        )
        for tick, frames in enumerate(sent):
            spent_ns = 0
            bounds = np.linspace(0, len(frames), portions + 1).astype(int)
            for number in range(portions):
                clock_s[0] = TICK_S * (tick + number / portions) + 0.01
                for frame in frames[bounds[number] : bounds[number + 1]]:
                    out.send(frame, sent_s=clock_s[0])
                begin = time.process_time_ns()
                node.hear(clock_s[0])
                spent_ns += time.process_time_ns() - begin
            clock_s[0] = TICK_S * (tick + 1) + 0.011
            begin = time.process_time_ns()
            state = node.step(clock_s[0], motion(clock_s[0]))
            node.send(clock_s[0])
            spent_ns += time.process_time_ns() - begin
            if tick >= WARM_TICKS:
                found.append(spent_ns / 1e6)
        believed = node.counts["receipt: accepted"]
        if state.around.vehicle.size != len(sent[-1]) or believed != node.counts["heard"]:
            raise SystemExit(f"not all were heard and believed: {dict(node.counts)}")
    return np.array(found)


def alone(ticks: int, bank: Bank) -> FloatArray:
    """Processor time of every step of a remote that hears nobody [ms]."""
    found: list[float] = []
    with MulticastTransport(lambda: 0.0, port=PORT) as own:
        node = Node(Station(named_sender("mbc", bank=bank), dt_s=TICK_S, origin=ORIGIN), own, Unsecured())
        for tick in range(10 * ticks + WARM_TICKS):
            now_s = tick * TICK_S
            begin = time.process_time_ns()
            node.hear(now_s)
            node.step(now_s, motion(now_s))
            node.send(now_s)
            if tick >= WARM_TICKS:
                found.append((time.process_time_ns() - begin) / 1e6)
    return np.array(found)


if __name__ == "__main__":
    main()
