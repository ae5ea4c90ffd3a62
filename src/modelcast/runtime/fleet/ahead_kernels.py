"""Compiled choice of the vehicle ahead of each host of a fleet, from the messages that its tracks hold."""

from math import hypot
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatCube, FloatMatrix, FloatVector, IntVector
from modelcast.models.member_kernels import Members
from modelcast.models.point_kernels import EAST, NORTH
from modelcast.runtime.fleet.arrays import TRACK_MESSAGE, TRACK_RECEIVED_S
from modelcast.runtime.fleet.believed_kernels import believe_model
from modelcast.station.context.ahead_kernels import follow
from modelcast.station.context.ahead_numbers import FARTHEST_M, Followers
from modelcast.station.policy.neighbours_kernels import HostVector
from modelcast.station.receiver.belief_kernels import BELIEF_COLUMNS
from modelcast.station.sender.message_arrays import (
    CONTENT_VEHICLE,
    MESSAGES_KEPT,
    SENDER_BITS,
)

__all__ = ["Believing", "follow_each"]


class Believing(NamedTuple):
    """What hosts believe with.

    Members of all senders' banks; time, and silence after which a track is lost [s]; who is where, (V,), and
    the heading of each, which is that of a standing remote, (V,) [rad].
    """

    members: Members
    t_s: float
    expiry_s: float
    vehicle: IntVector
    heading: FloatVector


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
            believe_model(x.members, x.t_s, row, x.heading[sender], motion[count])
            away_m = hypot(motion[count, 0] - samples[k, EAST], motion[count, 1] - samples[k, NORTH])
            who[count] = sender
            count += int(away_m <= FARTHEST_M)
        follow(followers, h, x.t_s, samples[k], who[:count], motion[:count], out[k])
