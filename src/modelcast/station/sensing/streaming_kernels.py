"""Compiled: the state that sub-models carry from sample to sample, written behind what was measured."""

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import IntVector
from modelcast.models.member_kernels import Members, observe_member
from modelcast.station.arrays import Sensed

__all__ = ["observe_each"]


@kernel
def observe_each(members: Members, s: Sensed, vehicle: IntVector, first: IntVector) -> None:
    """Let all members observe K vehicles' samples in turn, from number ``first`` (K,) to the newest.

    The ring holds them all, and the one before the first.
    """
    ring, columns = s.stated_m.shape[1], s.samples.shape[2]
    for k in range(vehicle.size):
        v = vehicle[k]
        for number in range(first[k], s.taken[v]):
            place = number % ring
            at = place + ring
            width = columns if s.history[v, place] > 1 else 0
            for m in range(members.windows.size):
                observe_member(members, m, s.samples[v, at - 1, :width], s.samples[v, at])
            for column in range(columns):
                s.samples[v, place, column] = s.samples[v, at, column]
