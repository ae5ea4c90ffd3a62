"""Compiled tables of the remotes that each host hears: what density and packet error ratio are counted from.

Every host has C slots and a hashed index of them, twice as long and a power of two. A slot stays where it is
while its remote is heard, so other arrays can be kept by (host, slot). A message costs one probe of the index
on average, a survey one pass over the host's slots; neither depends on the size of the fleet.

``hosts``, ``slots``, ``index`` (the tables' ``lookup``) and ``free`` are those of `NeighbourTables`.
"""

import math
from typing import Annotated, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, Int16Matrix, IntMatrix, IntVector, Layout

__all__ = [
    "HOST_TYPE",
    "MESSAGE_COUNTS",
    "MOST_KEPT",
    "SLOT_TYPE",
    "HostVector",
    "NeighbourTables",
    "Slot",
    "SlotMatrix",
    "count",
    "count_each",
    "delivered_each",
    "find",
    "forget",
    "hear",
    "hear_each",
    "place",
    "survey",
    "survey_each",
]

MESSAGE_COUNTS = 128
"""Messages are counted modulo this (DE_MsgCount of SAE J2735)."""

MOST_KEPT = 10
"""Sub-intervals that a slot has room for: with them it fills a cache line."""

HOST_TYPE: Any = np.dtype(
    [("phase_s", "f8"), ("used", "i4"), ("free", "i4"), ("refused", "i8"), ("kept", "i8")], align=True
)
"""A host: when its sub-intervals start; no slot from ``used`` on was ever used; how many slots were given up;
messages for which there was no slot; sub-intervals it keeps, up to `MOST_KEPT`."""

SLOT_TYPE: Any = np.dtype(
    [
        ("heard_s", "f8"),
        ("east_m", "f8"),
        ("north_m", "f8"),
        ("remote", "i4"),
        ("newest", "i4"),
        ("first", "u1", (MOST_KEPT,)),
        ("last", "u1", (MOST_KEPT,)),
        ("received", "u1", (MOST_KEPT,)),
    ],
    align=True,
)
"""A slot, one cache line: ``remote`` who is in it, -1 for nobody; ``newest`` number of the last sub-interval
with a message; ``heard_s``, ``east_m``, ``north_m`` when that message came and the place it states;
``first``, ``last``, ``received`` message count of the first and last message of each sub-interval and how
many there were, at its number modulo those kept."""

HostVector = Annotated[npt.NDArray[Any], Layout(HOST_TYPE, 1)]
SlotMatrix = Annotated[npt.NDArray[Any], Layout(SLOT_TYPE, 2)]
Slot = Annotated[Any, Layout(SLOT_TYPE, 0)]


class NeighbourTables(NamedTuple):
    """Tables of H hosts with C slots each, index length X, and R sub-intervals kept.

    ``hosts`` (H,) of `HOST_TYPE`; ``slots`` (H, C) of `SLOT_TYPE`; ``lookup`` (H, X) slots by hash, -1 for
    none; ``free`` (H, C) slots given up.
    """

    hosts: HostVector
    slots: SlotMatrix
    lookup: Int16Matrix
    free: Int16Matrix


_EMPTY = -1
_MOST = 255
"""Messages of a sub-interval that are counted."""

_NEVER = -(2**30)
"""Number of a sub-interval before all others."""

_BOUNDARY_SLACK = 1e-6
"""Share of a sub-interval by which a time may fall short of its start through rounding."""


@kernel(inlined=True)
def place(remote: int, length: int) -> int:
    """Where in an index of that length, a power of two, the search for a remote starts."""
    return ((remote * 0x9E3779B1) >> 11) & (length - 1)


@kernel(inlined=True)
def _sub_interval(t_s: float, phase_s: float, sub_interval_s: float) -> int:
    """Number of the sub-interval that a time is in."""
    return math.floor((t_s - phase_s) / sub_interval_s + _BOUNDARY_SLACK)


@kernel(inlined=True)
def find(slots: SlotMatrix, index: Int16Matrix, host: int, remote: int) -> int:
    """Slot of a remote at a host, -1 where it is not known."""
    length = index.shape[1]
    at = place(remote, length)
    while True:
        slot = index[host, at]
        if slot == _EMPTY or slots[host, slot].remote == remote:
            return slot
        at = (at + 1) & (length - 1)


@kernel(inlined=True)
def _insert(index: Int16Matrix, host: int, remote: int, slot: int) -> None:
    """Enter a slot into the index of a host."""
    length = index.shape[1]
    at = place(remote, length)
    while index[host, at] != _EMPTY:
        at = (at + 1) & (length - 1)
    index[host, at] = slot


@kernel(inlined=True)
def forget(
    hosts: HostVector,
    slots: SlotMatrix,
    index: Int16Matrix,
    free: Int16Matrix,
    host: int,
    t_s: float,
    expiry_s: float,
) -> int:
    """Free the slots of remotes not heard for longer than ``expiry_s``; returns how many."""
    about = hosts[host]
    freed = 0
    for slot in range(about.used):
        held = slots[host, slot]
        if held.remote != _EMPTY and t_s - held.heard_s > expiry_s:
            held.remote = _EMPTY
            free[host, about.free] = slot
            about.free += 1
            freed += 1
    if freed > 0:
        for at in range(index.shape[1]):
            index[host, at] = _EMPTY
        for slot in range(about.used):
            if slots[host, slot].remote != _EMPTY:
                _insert(index, host, slots[host, slot].remote, slot)
    return freed


@kernel(inlined=True)
def _new_slot(
    hosts: HostVector,
    slots: SlotMatrix,
    index: Int16Matrix,
    free: Int16Matrix,
    host: int,
    remote: int,
    t_s: float,
    expiry_s: float,
) -> int:
    """Give a new remote a slot, -1 where all are taken by remotes heard of late."""
    about = hosts[host]
    if about.free == 0 and about.used == slots.shape[1]:
        forget(hosts, slots, index, free, host, t_s, expiry_s)
    if about.free > 0:
        about.free -= 1
        slot = free[host, about.free]
    elif about.used < slots.shape[1]:
        slot = about.used
        about.used += 1
    else:
        about.refused += 1
        return _EMPTY
    _insert(index, host, remote, slot)
    slots[host, slot].remote = remote
    slots[host, slot].newest = _NEVER
    return slot


@kernel(inlined=True)
def hear(
    hosts: HostVector,
    slots: SlotMatrix,
    index: Int16Matrix,
    free: Int16Matrix,
    host: int,
    remote: int,
    message_count: int,
    heard_s: float,
    east_m: float,
    north_m: float,
    sub_interval_s: float,
) -> int:
    """Take in one message that a host received: its slot, -1 where the table is full.

    A host's messages come in the order of time. A remote silent for longer than the sub-intervals kept gives
    up its slot where another needs one.
    """
    kept = hosts[host].kept
    slot = find(slots, index, host, remote)
    if slot == _EMPTY:
        slot = _new_slot(hosts, slots, index, free, host, remote, heard_s, kept * sub_interval_s)
        if slot == _EMPTY:
            return _EMPTY
    held = slots[host, slot]
    number = _sub_interval(heard_s, hosts[host].phase_s, sub_interval_s)
    at = number % kept
    if number != held.newest:
        for passed in range(max(held.newest + 1, number - kept + 1), number):
            held.received[passed % kept] = 0
        held.first[at] = message_count
        held.received[at] = 0
        held.newest = number
    held.last[at] = message_count
    if held.received[at] < _MOST:
        held.received[at] += 1
    held.heard_s = heard_s
    held.east_m = east_m
    held.north_m = north_m
    return slot


@kernel(inlined=True)
def _delivered(held: Slot, number: int, kept: int) -> tuple[int, int]:
    """Messages of one remote in the sub-intervals before ``number``: (received, sent by their counts)."""
    newest = held.newest
    received, first, last = 0, 0, 0
    oldest = max(number, newest) - kept + 1
    at = oldest % kept
    for _ in range(oldest, min(number, newest + 1)):
        here = int(held.received[at])
        if here > 0:
            if received == 0:
                first = int(held.first[at])
            last = int(held.last[at])
            received += here
        at = at + 1 if at + 1 < kept else 0
    if received == 0:
        return 0, 0
    return received, max(1 + ((last - first) & (MESSAGE_COUNTS - 1)), received)


@kernel(inlined=True)
def _packet_error_ratio(held: Slot, number: int, kept: int) -> float:
    """Ratio of one remote over the sub-intervals before ``number``; NaN for fewer than two messages."""
    received, expected = _delivered(held, number, kept)
    return (expected - received) / expected if received > 1 else np.nan


@kernel(inlined=True)
def _is_near(held: Slot, oldest_s: float, east_m: float, north_m: float, range_m: float) -> bool:
    """Whether a slot holds a remote heard since ``oldest_s`` that stated a place within range."""
    if held.remote == _EMPTY or held.heard_s < oldest_s:
        return False
    east, north = held.east_m - east_m, held.north_m - north_m
    return east * east + north * north <= range_m * range_m


@kernel(inlined=True)
def count(
    hosts: HostVector,
    slots: SlotMatrix,
    host: int,
    t_s: float,
    east_m: float,
    north_m: float,
    sub_interval_s: float,
    range_m: float,
) -> int:
    """Count the remotes that `survey` counts, without their packet error ratios."""
    oldest_s = t_s - sub_interval_s * (1.0 + _BOUNDARY_SLACK)
    near = 0
    for slot in range(hosts[host].used):
        if _is_near(slots[host, slot], oldest_s, east_m, north_m, range_m):
            near += 1
    return near


@kernel(inlined=True)
def survey(
    hosts: HostVector,
    slots: SlotMatrix,
    host: int,
    t_s: float,
    east_m: float,
    north_m: float,
    sub_interval_s: float,
    range_m: float,
) -> tuple[int, float]:
    """Count the remotes heard within a sub-interval and a range: (how many, mean packet error ratio).

    A ratio covers the sub-intervals that are over, all but one of those kept. The mean is over the remotes
    counted that have one, NaN where none has.
    """
    number = _sub_interval(t_s, hosts[host].phase_s, sub_interval_s)
    oldest_s = t_s - sub_interval_s * (1.0 + _BOUNDARY_SLACK)
    near, ratios, total = 0, 0, 0.0
    for slot in range(hosts[host].used):
        held = slots[host, slot]
        if _is_near(held, oldest_s, east_m, north_m, range_m):
            near += 1
            ratio = _packet_error_ratio(held, number, hosts[host].kept)
            if ratio >= 0.0:
                ratios += 1
                total += ratio
    return near, total / ratios if ratios > 0 else np.nan


@kernel
def delivered_each(
    hosts: HostVector,
    slots: SlotMatrix,
    index: Int16Matrix,
    host: int,
    remote: IntVector,
    t_s: float,
    sub_interval_s: float,
    out: IntMatrix,
) -> None:
    """Messages of K remotes in the sub-intervals that are over: received, and sent by counts, (K, 2)."""
    number = _sub_interval(t_s, hosts[host].phase_s, sub_interval_s)
    for k in range(remote.size):
        slot = find(slots, index, host, remote[k])
        if slot == _EMPTY:
            out[k, 0], out[k, 1] = 0, 0
        else:
            out[k, 0], out[k, 1] = _delivered(slots[host, slot], number, hosts[host].kept)


@kernel
def hear_each(
    hosts: HostVector,
    slots: SlotMatrix,
    index: Int16Matrix,
    free: Int16Matrix,
    host: IntVector,
    remote: IntVector,
    message_count: IntVector,
    heard_s: FloatVector,
    position_m: FloatMatrix,
    sub_interval_s: float,
    out_slot: IntVector,
) -> None:
    """Take in K receptions in the order given; all arrays (K,), positions (K, 2)."""
    for k in range(host.size):
        out_slot[k] = hear(
            hosts,
            slots,
            index,
            free,
            host[k],
            remote[k],
            message_count[k],
            heard_s[k],
            position_m[k, 0],
            position_m[k, 1],
            sub_interval_s,
        )


@kernel
def count_each(
    hosts: HostVector,
    slots: SlotMatrix,
    t_s: FloatVector,
    position_m: FloatMatrix,
    sub_interval_s: float,
    range_m: float,
    out_count: IntVector,
) -> None:
    """Count for every host at its own time and place; all arrays (H,), positions (H, 2)."""
    for host in range(t_s.size):
        out_count[host] = count(
            hosts, slots, host, t_s[host], position_m[host, 0], position_m[host, 1], sub_interval_s, range_m
        )


@kernel
def survey_each(
    hosts: HostVector,
    slots: SlotMatrix,
    t_s: FloatVector,
    position_m: FloatMatrix,
    sub_interval_s: float,
    range_m: float,
    out_count: IntVector,
    out_ratio: FloatVector,
) -> None:
    """Survey every host at its own time and place; all arrays (H,), positions (H, 2)."""
    for host in range(t_s.size):
        out_count[host], out_ratio[host] = survey(
            hosts, slots, host, t_s[host], position_m[host, 0], position_m[host, 1], sub_interval_s, range_m
        )
