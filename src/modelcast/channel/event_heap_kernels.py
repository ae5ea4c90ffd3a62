"""Compiled event heap: two arrays, times and what happens then, the earliest first."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector, IntVector

__all__ = ["heap_room", "pop_event", "push_event"]


@kernel(inlined=True)
def push_event(times: FloatVector, what: IntVector, count: int, t_s: float, event: int) -> int:
    """Put an event into the heap, whose arrays have room; return the new count."""
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
def pop_event(times: FloatVector, what: IntVector, count: int) -> int:
    """Take the first event out of the heap; return the new count."""
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
def heap_room(times: FloatVector, what: IntVector, count: int) -> tuple[FloatVector, IntVector]:
    """Return a heap with room for ``count`` events and two more."""
    if count + 2 <= times.size:
        return times, what
    held = times.size
    new_times, new_what = np.empty(2 * count + 2), np.empty(2 * count + 2, dtype=np.int64)
    new_times[:held], new_what[:held] = times, what
    return new_times, new_what
