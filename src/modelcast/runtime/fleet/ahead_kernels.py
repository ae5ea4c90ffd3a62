"""Compiled choice of the vehicle ahead of each host of a fleet, from the messages that its tracks hold."""

from math import hypot
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatCube, FloatMatrix, FloatVector, IntVector
from modelcast.models.member_kernels import Members, predict_member
from modelcast.models.point_kernels import EAST, NORTH
from modelcast.runtime.fleet.arrays import TRACK_MESSAGE, TRACK_RECEIVED_S
from modelcast.station.context.ahead_kernels import follow
from modelcast.station.context.ahead_numbers import FARTHEST_M, Followers
from modelcast.station.policy.neighbours_kernels import HostVector
from modelcast.station.receiver.belief_kernels import BELIEF_COLUMNS, STEP_S, differentiate
from modelcast.station.sender.message_arrays import (
    CONTENT_EAST_M,
    CONTENT_FIT_S,
    CONTENT_HEAD,
    CONTENT_MEMBER,
    CONTENT_NORTH_M,
    CONTENT_VEHICLE,
    MESSAGES_KEPT,
    SENDER_BITS,
)

__all__ = ["Believing", "follow_each"]


class Believing(NamedTuple):
    """What hosts believe with.

    Members of the bank, and whether content holds the parameters of all; time, and silence after which a
    track is lost [s]; who is where, (V,), and the heading that each states, which is that of a standing
    remote, (V,) [rad].
    """

    members: Members
    carries_all: bool
    t_s: float
    expiry_s: float
    vehicle: IntVector
    heading: FloatVector


@kernel
def _believe(x: Believing, row: FloatVector, heading: float, out: FloatVector) -> None:
    """How the sender of a message is believed to move, into ``out`` (BELIEF_COLUMNS,)."""
    member, offsets = int(row[CONTENT_MEMBER]), x.members.offsets
    first = CONTENT_HEAD + (offsets[member] if x.carries_all else 0)
    own = row[first : first + offsets[member + 1] - offsets[member]]
    age_s = x.t_s - row[CONTENT_FIT_S]
    path = np.empty((3, 2))
    middle_s = max(age_s, STEP_S)
    for at in range(3):
        predict_member(x.members, member, own, middle_s + (at - 1) * STEP_S, path[at])
    differentiate(path, age_s - middle_s, heading, out)
    predict_member(x.members, member, own, age_s, path[0])
    out[0], out[1] = row[CONTENT_EAST_M] + path[0, 0], row[CONTENT_NORTH_M] + path[0, 1]


@kernel
def follow_each(
    x: Believing,
    hosts: HostVector,
    tracks: FloatCube,
    rows: FloatCube,
    followers: Followers,
    host: IntVector,
    samples: FloatMatrix,
    out: FloatMatrix,
) -> None:
    """Write the leader's columns of K hosts' contexts (K, 13), from their newest samples (K, 9)."""
    motion = np.empty((tracks.shape[1], BELIEF_COLUMNS))
    who = np.empty(tracks.shape[1], dtype=np.int64)
    for k in range(host.size):
        h = int(host[k])
        count = 0
        for slot in range(hosts[h].used):
            held = tracks[h, slot, TRACK_MESSAGE]
            if held < 0.0 or x.t_s - tracks[h, slot, TRACK_RECEIVED_S] > x.expiry_s:
                continue
            message = int(held)
            sender = message & ((1 << SENDER_BITS) - 1)
            row = rows[sender, (message >> SENDER_BITS) % MESSAGES_KEPT]
            if row[CONTENT_VEHICLE] != x.vehicle[sender]:
                continue
            _believe(x, row, x.heading[sender], motion[count])
            away_m = hypot(motion[count, 0] - samples[k, EAST], motion[count, 1] - samples[k, NORTH])
            who[count] = sender
            count += int(away_m <= FARTHEST_M)
        follow(followers, h, x.t_s, samples[k], who[:count], motion[:count], out[k])
