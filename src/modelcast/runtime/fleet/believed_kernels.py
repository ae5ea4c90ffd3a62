"""Compiled beliefs of a fleet's hosts, from the messages that their tracks hold and the way each reads."""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    BoolVector,
    FloatCube,
    FloatMatrix,
    FloatVector,
    IntVector,
)
from modelcast.models.member_kernels import Members
from modelcast.runtime.fleet.arrays import TRACK_MESSAGE, TRACK_RECEIVED_S, Tracks
from modelcast.station.policy.neighbours_kernels import NeighbourTables, find
from modelcast.station.receiver.reading_kernels import (
    FREE,
    MODEL,
    FreeRule,
    coast_by_member,
    coast_freely,
    coast_straight,
    state_rates,
)
from modelcast.station.sender.message_arrays import (
    CONTENT_EAST_M,
    CONTENT_FIRST,
    CONTENT_FIT_S,
    CONTENT_HEADING_RAD,
    CONTENT_MEMBER,
    CONTENT_NORTH_M,
    CONTENT_NUMBER,
    CONTENT_SPEED_MPS,
    CONTENT_VEHICLE,
    MESSAGES_KEPT,
    SENDER_BITS,
)
from modelcast.station.sender.motion_kernels import MOTION

__all__ = ["Pairs", "Readers", "believe_each", "believe_model", "own_span"]


class Readers(NamedTuple):
    """What hosts believe with.

    Members of all senders' banks, and which of them go straight on at constant velocity, (M,); how Part I is
    coasted freely; time, and silence after which a track is lost [s]; who is where, (V,).
    """

    members: Members
    straight: BoolVector
    free: FreeRule
    t_s: float
    expiry_s: float
    vehicle: IntVector


class Pairs(NamedTuple):
    """N pairs of host and remote, by their slots, and how each host reads; then what it believes.

    ``held`` (N,) whether it has a live track, ``age_s`` (N,) since the fit, ``motion`` (N, BELIEF_COLUMNS).
    """

    host: IntVector
    remote: IntVector
    reading: IntVector
    held: BoolVector
    age_s: FloatVector
    motion: FloatMatrix


@kernel(inlined=True)
def own_span(members: Members, row: FloatVector) -> tuple[int, int]:
    """Columns of a message's content from the first to the end of its sub-model's parameters."""
    member, first = int(row[CONTENT_MEMBER]), int(row[CONTENT_FIRST])
    return first, first + members.offsets[member + 1] - members.offsets[member]


@kernel
def believe_model(members: Members, t_s: float, row: FloatVector, heading: float, out: FloatVector) -> None:
    """Where and how the sender of a message moves by its sub-model, ``out`` (BELIEF_COLUMNS,)."""
    first, end = own_span(members, row)
    age_s = t_s - row[CONTENT_FIT_S]
    coast_by_member(members, int(row[CONTENT_MEMBER]), row[first:end], age_s, heading, out)
    out[0] += row[CONTENT_EAST_M]
    out[1] += row[CONTENT_NORTH_M]


@kernel
def _believe(x: Readers, reading: int, row: FloatVector, out: FloatVector) -> None:
    """Where and how the sender of a message moves as a host reads it, ``out`` (BELIEF_COLUMNS,)."""
    stated = row[CONTENT_SPEED_MPS : CONTENT_SPEED_MPS + MOTION]
    if reading == MODEL:
        believe_model(x.members, x.t_s, row, row[CONTENT_HEADING_RAD], out)
        if x.straight[int(row[CONTENT_MEMBER])]:
            state_rates(stated, out)
        return
    age_s = x.t_s - row[CONTENT_FIT_S]
    if reading == FREE:
        coast_freely(x.free, stated, age_s, out)
    else:
        coast_straight(stated, age_s, out)
    out[0] += row[CONTENT_EAST_M]
    out[1] += row[CONTENT_NORTH_M]


@kernel
def believe_each(x: Readers, tables: NeighbourTables, tracks: Tracks, rows: FloatCube, pairs: Pairs) -> None:
    """Write what hosts believe of remotes; whoever has no live track of one believes nothing of it."""
    mask = (1 << SENDER_BITS) - 1
    for k in range(pairs.host.size):
        pairs.held[k], pairs.age_s[k] = False, np.nan
        for column in range(pairs.motion.shape[1]):
            pairs.motion[k, column] = np.nan
        host, vehicle = int(pairs.host[k]), int(x.vehicle[pairs.remote[k]])
        if vehicle < 0 or x.vehicle[host] < 0:
            continue
        slot = find(tables.slots, tables.lookup, host, vehicle)
        if slot < 0 or tracks.vehicle[host, slot] != vehicle:
            continue
        held = tracks.held[host, slot]
        if held[TRACK_MESSAGE] < 0.0 or x.t_s - held[TRACK_RECEIVED_S] > x.expiry_s:
            continue
        message = int(held[TRACK_MESSAGE])
        number = message >> SENDER_BITS
        row = rows[message & mask, number % MESSAGES_KEPT]
        if row[CONTENT_NUMBER] != number or row[CONTENT_VEHICLE] != vehicle:
            continue
        _believe(x, pairs.reading[k], row, pairs.motion[k])
        pairs.held[k], pairs.age_s[k] = True, x.t_s - row[CONTENT_FIT_S]
