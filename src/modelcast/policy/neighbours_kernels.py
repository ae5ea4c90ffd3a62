"""Compiled tables of the remotes that each host hears: what density and packet error ratio are counted from.

Every host has C slots and a hashed index of them, twice as long and a power of two. A slot stays where it is
while its remote is heard, so other arrays can be kept by (host, slot). A message costs one probe of the index
on average, a survey one pass over the host's slots; neither depends on the size of the fleet.
"""

import math
from typing import Any, NamedTuple

import numba
import numpy as np

__all__ = [
    "MESSAGE_COUNTS",
    "NeighbourTables",
    "count",
    "find",
    "forget",
    "hear",
    "hear_each",
    "survey",
    "survey_each",
]

MESSAGE_COUNTS = 128
"""Messages are counted modulo this (DE_MsgCount of SAE J2735)."""

_EMPTY = -1
_BOUNDARY_SLACK = 1e-6
"""Share of a sub-interval by which a time may fall short of its start through rounding."""


class NeighbourTables(NamedTuple):
    """Tables of H hosts with C slots each, index length X, and R sub-intervals kept.

    ``remote`` (H, C) who is in the slot, -1 for nobody; ``heard_s`` (H, C) and ``position_m`` (H, C, 2) of
    the last message; ``newest`` (H, C) number of the last sub-interval with a message; ``first``, ``last``,
    ``received`` (H, C, R) message counts and number of messages of each sub-interval, at its number modulo R;
    ``index`` (H, X) slots by hash, -1 for none; ``used`` (H,) no slot from here on was ever used; ``free``
    (H, C), ``free_count`` (H,) slots to use again; ``refused`` (H,) messages for which there was no slot;
    ``phase_s`` (H,) when the host's sub-intervals start.
    """

    remote: Any
    heard_s: Any
    position_m: Any
    newest: Any
    first: Any
    last: Any
    received: Any
    index: Any
    used: Any
    free: Any
    free_count: Any
    refused: Any
    phase_s: Any


@numba.njit(cache=True, nogil=True)
def _place(remote: int, length: int) -> int:
    """Where in an index of that length, a power of two, the search for a remote starts."""
    return ((remote * 0x9E3779B1) >> 11) & (length - 1)


@numba.njit(cache=True, nogil=True)
def _sub_interval(t_s: float, phase_s: float, sub_interval_s: float) -> int:
    """Number of the sub-interval that a time is in."""
    return math.floor((t_s - phase_s) / sub_interval_s + _BOUNDARY_SLACK)


@numba.njit(cache=True, nogil=True)
def find(tables: Any, host: int, remote: int) -> int:
    """Slot of a remote at a host, -1 where it is not known."""
    index, remotes = tables.index[host], tables.remote[host]
    at = _place(remote, index.size)
    while index[at] != _EMPTY:
        if remotes[index[at]] == remote:
            return index[at]
        at = (at + 1) & (index.size - 1)
    return _EMPTY


@numba.njit(cache=True, nogil=True)
def _insert(index: Any, remote: int, slot: int) -> None:
    """Enter a slot into the index of a host."""
    at = _place(remote, index.size)
    while index[at] != _EMPTY:
        at = (at + 1) & (index.size - 1)
    index[at] = slot


@numba.njit(cache=True, nogil=True)
def forget(tables: Any, host: int, t_s: float, expiry_s: float) -> int:
    """Free the slots of remotes not heard for longer than ``expiry_s``; returns how many."""
    remotes, heard_s = tables.remote[host], tables.heard_s[host]
    freed = 0
    for slot in range(tables.used[host]):
        if remotes[slot] != _EMPTY and t_s - heard_s[slot] > expiry_s:
            remotes[slot] = _EMPTY
            tables.free[host, tables.free_count[host]] = slot
            tables.free_count[host] += 1
            freed += 1
    if freed > 0:
        index = tables.index[host]
        for at in range(index.size):
            index[at] = _EMPTY
        for slot in range(tables.used[host]):
            if remotes[slot] != _EMPTY:
                _insert(index, remotes[slot], slot)
    return freed


@numba.njit(cache=True, nogil=True)
def _new_slot(tables: Any, host: int, t_s: float, expiry_s: float) -> int:
    """Take a slot for a new remote, -1 where all are taken by remotes heard of late."""
    if tables.free_count[host] == 0 and tables.used[host] == tables.remote.shape[1]:
        forget(tables, host, t_s, expiry_s)
    if tables.free_count[host] > 0:
        tables.free_count[host] -= 1
        return tables.free[host, tables.free_count[host]]
    if tables.used[host] < tables.remote.shape[1]:
        tables.used[host] += 1
        return tables.used[host] - 1
    return _EMPTY


@numba.njit(cache=True, nogil=True)
def hear(
    tables: Any,
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
    kept = tables.first.shape[2]
    number = _sub_interval(heard_s, tables.phase_s[host], sub_interval_s)
    slot = find(tables, host, remote)
    if slot == _EMPTY:
        slot = _new_slot(tables, host, heard_s, kept * sub_interval_s)
        if slot == _EMPTY:
            tables.refused[host] += 1
            return _EMPTY
        _insert(tables.index[host], remote, slot)
        tables.remote[host, slot] = remote
        for at in range(kept):
            tables.received[host, slot, at] = 0
    else:
        for passed in range(max(tables.newest[host, slot] + 1, number - kept + 1), number + 1):
            tables.received[host, slot, passed % kept] = 0
    at = number % kept
    if tables.received[host, slot, at] == 0:
        tables.first[host, slot, at] = message_count
    tables.last[host, slot, at] = message_count
    tables.received[host, slot, at] += 1
    tables.newest[host, slot] = number
    tables.heard_s[host, slot] = heard_s
    tables.position_m[host, slot, 0] = east_m
    tables.position_m[host, slot, 1] = north_m
    return slot


@numba.njit(cache=True, nogil=True)
def _packet_error_ratio(tables: Any, host: int, slot: int, number: int) -> float:
    """Ratio of one remote over the sub-intervals before ``number``; NaN for fewer than two messages."""
    kept = tables.first.shape[2]
    newest = tables.newest[host, slot]
    received, first, last = 0, -1, -1
    for counted in range(max(number, newest) - kept + 1, min(number, newest + 1)):
        at = counted % kept
        if tables.received[host, slot, at] > 0:
            if first < 0:
                first = tables.first[host, slot, at]
            last = tables.last[host, slot, at]
            received += tables.received[host, slot, at]
    if received < 2:
        return np.nan
    expected = 1 + (last - first) % MESSAGE_COUNTS
    return max(expected - received, 0) / expected


@numba.njit(cache=True, nogil=True)
def _is_near(
    tables: Any,
    host: int,
    slot: int,
    t_s: float,
    east_m: float,
    north_m: float,
    sub_interval_s: float,
    range_m: float,
) -> bool:
    """Whether the slot holds a remote heard within a sub-interval, that stated a place within range."""
    if tables.remote[host, slot] == _EMPTY:
        return False
    if tables.heard_s[host, slot] < t_s - sub_interval_s * (1.0 + _BOUNDARY_SLACK):
        return False
    east = tables.position_m[host, slot, 0] - east_m
    north = tables.position_m[host, slot, 1] - north_m
    return east * east + north * north <= range_m * range_m


@numba.njit(cache=True, nogil=True)
def count(
    tables: Any, host: int, t_s: float, east_m: float, north_m: float, sub_interval_s: float, range_m: float
) -> int:
    """Count the remotes that `survey` counts, without their packet error ratios."""
    near = 0
    for slot in range(tables.used[host]):
        if _is_near(tables, host, slot, t_s, east_m, north_m, sub_interval_s, range_m):
            near += 1
    return near


@numba.njit(cache=True, nogil=True)
def survey(
    tables: Any, host: int, t_s: float, east_m: float, north_m: float, sub_interval_s: float, range_m: float
) -> tuple[int, float]:
    """Count the remotes heard within a sub-interval and a range: (how many, mean packet error ratio).

    A ratio covers the sub-intervals that are over, all but one of those kept. The mean is over the remotes
    counted that have one, NaN where none has.
    """
    number = _sub_interval(t_s, tables.phase_s[host], sub_interval_s)
    near, ratios, total = 0, 0, 0.0
    for slot in range(tables.used[host]):
        if _is_near(tables, host, slot, t_s, east_m, north_m, sub_interval_s, range_m):
            near += 1
            ratio = _packet_error_ratio(tables, host, slot, number)
            if ratio >= 0.0:
                ratios += 1
                total += ratio
    return near, total / ratios if ratios > 0 else np.nan


@numba.njit(cache=True, nogil=True)
def hear_each(
    tables: Any,
    host: Any,
    remote: Any,
    message_count: Any,
    heard_s: Any,
    position_m: Any,
    sub_interval_s: float,
    out_slot: Any,
) -> None:
    """Take in K receptions in the order given; all arrays (K,), positions (K, 2)."""
    for k in range(host.size):
        out_slot[k] = hear(
            tables,
            host[k],
            remote[k],
            message_count[k],
            heard_s[k],
            position_m[k, 0],
            position_m[k, 1],
            sub_interval_s,
        )


@numba.njit(cache=True, nogil=True)
def survey_each(
    tables: Any,
    t_s: Any,
    position_m: Any,
    sub_interval_s: float,
    range_m: float,
    out_count: Any,
    out_ratio: Any,
) -> None:
    """Survey every host at its own time and place; all arrays (H,), positions (H, 2)."""
    for host in range(t_s.size):
        out_count[host], out_ratio[host] = survey(
            tables, host, t_s[host], position_m[host, 0], position_m[host, 1], sub_interval_s, range_m
        )
