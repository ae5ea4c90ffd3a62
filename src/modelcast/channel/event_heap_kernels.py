"""Compiled event heap: two arrays, times and what happens then, the earliest first."""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector, IntVector

__all__ = ["Events", "heap_room", "pop_event", "push_event"]


class Events(NamedTuple):
    """A heap: ``times`` [s] and ``what`` happens then, both longer than what is in them."""

    times: FloatVector
    what: IntVector


@kernel(inlined=True)
def push_event(events: Events, count: int, t_s: float, event: int) -> int:
    """Put an event into the heap, whose arrays have room; return the new count."""
    times, what = events.times, events.what
    at = count
    while at > 0:
        parent = (at - 1) >> 1
        if times[parent] <= t_s:
            break
        times[at], what[at] = times[parent], what[parent]
        at = parent
    times[at], what[at] = t_s, event
    return count + 1


@kernel(inlined=True)
def pop_event(events: Events, count: int) -> int:
    """Take the first event out of the heap; return the new count."""
    times, what = events.times, events.what
    count -= 1
    t_s, event = times[count], what[count]
    at = 0
    while True:
        child = 2 * at + 1
        if child >= count:
            break
        if child + 1 < count and times[child + 1] < times[child]:
            child += 1
        if times[child] >= t_s:
            break
        times[at], what[at] = times[child], what[child]
        at = child
    times[at], what[at] = t_s, event
    return count


@kernel
def heap_room(events: Events, count: int) -> Events:
    """Return a heap with room for ``count`` events and two more."""
    held = events.times.size
    if count + 2 <= held:
        return events
    roomier = Events(np.empty(2 * count + 2), np.empty(2 * count + 2, dtype=np.int64))
    roomier.times[:held], roomier.what[:held] = events.times, events.what
    return roomier
