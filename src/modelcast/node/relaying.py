"""A node's relay: which of the messages that it hears it repeats, octet by octet as they came."""

from collections.abc import Sequence
from hashlib import blake2b
from typing import final

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import CodecError
from modelcast.messages.mbc_wire import IDENTIFICATION_MESSAGE, decode_identification
from modelcast.messages.message_heads import decode_safety, part_one_of
from modelcast.station.receiver.local_dynamic_map import Beliefs, Receipt
from modelcast.station.relay import Overheard, RelayRule, RelayState

__all__ = ["Relaying"]

_REPEATABLE = frozenset({Receipt.ACCEPTED, Receipt.UNKNOWN_UPDATE})
"""What is repeated: an identification that the relay cannot read, others may."""


@final
class Relaying:
    """One unit's relay.

    Parameters
    ----------
    rule
        What it repeats.
    tick_s
        Time between turns [s].

    Notes
    -----
    Octets that come a second time were repeated by another relay: then they are not repeated here. A message
    that comes from another relay first cannot be told from the original, and is repeated once. Only what the
    map accepted is, so that neither a recording played again nor nonsense is spread. The age of a message is
    that of what it tells, and its place that of its author on the map.
    """

    def __init__(self, rule: RelayRule, tick_s: float) -> None:
        self.rule, self._tick_s = rule, tick_s
        self._state: RelayState = rule.init(1)
        self._octets: dict[int, bytes] = {}
        self._heard: list[tuple[int, int, float]] = []

    @property
    def counts(self) -> dict[str, int]:
        """Messages repeated, and why others were not, by the names of `RelayState`."""
        names = ("repeated", "by_another", "replaced", "too_old", "too_far")
        return {name: int(getattr(self._state, name)[0]) for name in names}

    def hear(
        self, octets: Sequence[bytes], received_s: Sequence[float] | FloatArray, receipts: IntArray
    ) -> None:
        """Take in messages that arrived.

        Parameters
        ----------
        octets, received_s
            Messages without their envelopes, and when each arrived [s].
        receipts
            A `Receipt` each, (K,).
        """
        for one, at_s, receipt in zip(octets, received_s, receipts.tolist(), strict=True):
            key = int.from_bytes(blake2b(one, digest_size=8).digest(), "big") >> 1
            if key not in self._octets:
                author = _author(one) if receipt in _REPEATABLE else None
                if author is None:
                    continue
                self._octets[key] = one
                self._heard.append((key, author, float(at_s)))
            else:
                self._heard.append((key, -1, float(at_s)))

    def turn(self, now_s: float, around: Beliefs) -> list[tuple[float, bytes]]:
        """What is sent until the next turn: when [s], and the message.

        Parameters
        ----------
        now_s
            Now [s].
        around
            What the unit believes of the vehicles now, itself at the origin of its plane.
        """
        key: IntArray = np.array([one[0] for one in self._heard], dtype=np.int64)
        author: IntArray = np.array([one[1] for one in self._heard], dtype=np.int64)
        heard_s: FloatArray = np.array([one[2] for one in self._heard], dtype=np.float64)
        self._heard = []
        at = np.searchsorted(around.vehicle, author)
        at = np.minimum(at, max(around.vehicle.size - 1, 0))
        known = around.vehicle[at] == author if around.vehicle.size else np.zeros(author.size, dtype=np.bool_)
        made_s, distance_m = heard_s.copy(), np.full(author.size, np.nan)
        if around.vehicle.size:
            made_s[known] = np.minimum(heard_s[known], now_s - around.information_age_s[at[known]])
            distance_m[known] = np.hypot(*around.position_m[at[known]].T)
        overheard = Overheard(
            np.zeros(key.size, dtype=np.int64),
            key,
            author,
            made_s=made_s,
            heard_s=heard_s,
            distance_m=distance_m,
            is_copy=author < 0,
        )
        repeats, self._state = self.rule.turn(self._state, overheard, now_s, now_s + self._tick_s)
        found = [
            (send_s, self._octets[one])
            for send_s, one in zip(repeats.send_s.tolist(), repeats.key.tolist(), strict=True)
        ]
        kept = set(self._state.held.key.tolist())
        self._octets = {one: octets for one, octets in self._octets.items() if one in kept}
        return found


def _author(octets: bytes) -> int | None:
    """Temporary id of who made a message; None where it is none."""
    try:
        if int.from_bytes(octets[:2], "big") == IDENTIFICATION_MESSAGE:
            return decode_identification(octets).temporary_id
        author = part_one_of(decode_safety(octets)).value("temporary_id")
    except CodecError:
        return None
    return None if author is None else int(author)
