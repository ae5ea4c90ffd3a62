"""Every octet of real frames altered to every other value, and what a station makes of each."""

from collections import Counter
from collections.abc import Sequence

from modelcast.cli.node import sender_of_config
from modelcast.core.geodesy import Origin
from modelcast.node.config import NodeConfig
from modelcast.node.envelope import Unsecured
from modelcast.station.banks import calibrations_of
from modelcast.station.receiver.ears import Ears
from modelcast.station.receiver.local_dynamic_map import Receipt

__all__ = ["altered_octets"]

_AIR_S = 0.01
_MINUTE_S = 60.0
_ROOM = 4


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
    envelope, bank = Unsecured(), sender_of_config(NodeConfig()).bank
    ears = Ears((bank,), capacity=_ROOM, calibrations=(calibrations_of(bank),))
    for sent_s, frame in frames:
        heard_s = sent_s % _MINUTE_S + _AIR_S
        for at in range(len(frame)):
            for value in range(256):
                if value == frame[at]:
                    continue
                found["altered"] += 1
                opened = envelope.open(frame[:at] + bytes([value]) + frame[at + 1 :], received_s=heard_s)
                if opened.octets is None:
                    found[opened.why] += 1
                    continue
                # Each meets a new map: what one puts in must not be why another is refused.
                receipts, _ = ears.hear(ears.init(), [opened.octets], [heard_s], origin=origin)
                found[Receipt(int(receipts[0])).reason] += 1
    return found
