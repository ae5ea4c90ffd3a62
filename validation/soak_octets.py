"""Every octet of real frames altered to every other value, and what a station makes of each."""

import secrets
from collections import Counter
from collections.abc import Sequence

from modelcast.cli.node import sender_of_config
from modelcast.core.geodesy import Origin
from modelcast.node.config import NodeConfig
from modelcast.node.envelope import Unsecured
from modelcast.station.receiver.local_dynamic_map import Receipt
from modelcast.station.station import Station

__all__ = ["altered_octets"]

_AIR_S = 0.01


def altered_octets(frames: Sequence[tuple[float, bytes]], origin: Origin) -> Counter[str]:
    """What became of altered frames, by reason; ``frames`` and ``altered`` are how many there were.

    Parameters
    ----------
    frames
        When they were on the air [UTC, s], and their octets.
    origin
        Of the host's plane.
    """
    found: Counter[str] = Counter({"frames": len(frames)})
    envelope = Unsecured()
    for sent_s, frame in frames:
        now_s = sent_s % 60.0 + _AIR_S
        for at in range(len(frame)):
            # Each octet meets a new map: what one takes in must not be why another is refused.
            station = Station(
                sender_of_config(NodeConfig()), temporary_id=1, dt_s=0.1, origin=origin,
                seed=secrets.randbits(63),
            )  # fmt: skip
            octets: list[bytes] = []
            for value in range(256):
                if value == frame[at]:
                    continue
                found["altered"] += 1
                opened = envelope.open(frame[:at] + bytes([value]) + frame[at + 1 :], received_s=now_s)
                if opened.octets is None:
                    found[opened.why] += 1
                else:
                    octets.append(opened.octets)
            for receipt in station.hear(octets, received_s=[now_s] * len(octets)).tolist():
                found[Receipt(receipt).reason] += 1
    return found
