"""What stations hold, as plain arrays that compiled steps write: one vehicle is a batch of one.

V vehicles measure (`Sensed`) and fit sub-models (`Fits`). L *lanes* decide: each is one sender of one
vehicle, by one rule at one threshold, so that all that decide over the same samples share the fits. A vehicle
on the road has one lane; an evaluation has one a threshold; a guarded sender has two or three more,
which stay silent.
Samples of a vehicle are numbered from 0; the rings hold them at their number modulo the ring's length.
"""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel_types import (
    BoolMatrix,
    BoolVector,
    FloatCube,
    FloatMatrix,
    FloatVector,
    IntCube,
    IntMatrix,
    IntVector,
)
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.station.policy.guard_kernels import Guarding, guarding

__all__ = ["MEASURED", "OLDER_HEAD", "Fits", "LaneRules", "Lanes", "Sensed", "fits", "lanes", "sensed"]

OLDER_HEAD = 4
"""Columns of an older message before the parameters: member, instant, position."""

MEASURED = 6
"""Columns of a measurement: east, north [m], speed [m/s], heading [rad], acceleration along the course
[m/s²], yaw
rate, clockwise [rad/s]; not a number where there is none."""


class Sensed(NamedTuple):
    """What V vehicles measured, in rings of R samples.

    ``t_s`` (V, 2R) and ``samples`` (V, 2R, 9 + S): every sample stands twice, R apart, so that each window
    lies in one piece; behind its measured columns stands the state that sub-models carry from sample to
    sample, if any. ``stated_s`` (V, R) and ``stated_m`` (V, R, 2) are the instant and the position that a
    message states; ``history`` (V, R) samples of its gapless part up to each; ``taken`` (V,) samples so far;
    ``noise`` (V, 2) running mean of squares, and how many; ``shown`` (V, 6) the newest measurement, filtered
    where there is a filter, whose ``states`` (V, 6) and ``spreads`` (V, 6, 6) follow.
    """

    t_s: FloatMatrix
    samples: FloatCube
    stated_s: FloatMatrix
    stated_m: FloatCube
    history: IntMatrix
    taken: IntVector
    noise: FloatMatrix
    shown: FloatMatrix
    states: FloatMatrix
    spreads: FloatCube


class Fits(NamedTuple):
    """Sub-models as their receivers hold them, in rings of F samples.

    ``parameters`` (V, F, P) of all members in turn, and their ``codes``; ``number`` (V, F, M) the sample that
    each was fitted at, -1 for none.
    """

    parameters: FloatCube
    codes: IntCube
    number: IntCube


class Lanes(NamedTuple):
    """What L senders remember.

    ``update`` (L,) sample of the update that their remotes are believed to hold, -1 for none; ``in_use`` (L,)
    its sub-model; ``origin`` (L, 3) its instant [s] and the position it states [m]; ``held`` (L, P) its
    parameters and ``usable`` (L, M) which members it fitted; ``failed_s`` (L, M) its age when each first
    failed [s]; ``message_s`` (L,) when the last message of any kind was decided [s]; ``kind`` (L,) what was
    decided last; ``stated`` (L, 4) what Part I of that update states of motion, where the rules mind legacy
    receivers.

    ``last`` (L, P), ``last_usable`` (L, M) and ``last_origin`` (L, 3) are those of the last message, whether
    it is believed received or not, and ``scores`` (L, M) the recent errors of each member's. ``guarded`` is
    what guarded lanes know of their guards. ``loss`` (L,) is the share of messages believed lost; ``older``
    (L, D, 4 + P) what the messages before the newest one gave remotes to hold, newest first, where the rules
    ask for it: member, instant [s], position [m] and the member's parameters; ``olders`` (L,) how many there
    are. ``life_s`` (L,) is how long the newest message is expected to hold, by how long the one before did
    [s]. ``errors`` (L, M), ``chances`` (L, M) and ``available`` (L, M) are overwritten.
    """

    update: IntVector
    in_use: IntVector
    origin: FloatMatrix
    held: FloatMatrix
    usable: BoolMatrix
    failed_s: FloatMatrix
    message_s: FloatVector
    kind: IntVector
    stated: FloatMatrix
    last: FloatMatrix
    last_usable: BoolMatrix
    last_origin: FloatMatrix
    scores: FloatMatrix
    guarded: Guarding
    loss: FloatVector
    older: FloatCube
    olders: IntVector
    life_s: FloatVector
    errors: FloatMatrix
    chances: FloatMatrix
    available: BoolMatrix


class LaneRules(NamedTuple):
    """Rules of L lanes.

    ``vehicle`` (L,) whose samples each decides over; ``threshold_m`` and ``silence_s`` (L,) error and silence
    that call for a message; ``start`` and ``identify`` (L,) codes of the rules; ``costs`` (L, C) as
    `CostTable.packed`, ``selector`` (L, K) constants of the selector at each threshold; ``only`` (L,) the one
    member that a lane may use, and constant velocity while that has no full window, -1 for all; for a guarded
    lane ``bank`` (L,) and ``guards`` (L, 2) the lanes before it that run the same bank unguarded and each
    guard alone, else -1; for its bank's lane ``speaker`` (L,) that guarded lane, else -1. ``expects`` (L,)
    says which measure the error expected over all that remotes may hold, ``loss`` (L,) which share of their
    messages they believe lost at first, and ``budget`` (L,) how many times the messages of a channel without
    losses they may send. ``approach_m`` (L,) is the way that two vehicles may come closer between two
    messages. ``legacy_m`` (L,) is the error of legacy receivers that calls for an update, infinite for none.
    ``within_m`` is the resolution below which recent errors are equal [m].
    """

    vehicle: IntVector
    threshold_m: FloatVector
    silence_s: FloatVector
    start: IntVector
    identify: IntVector
    costs: FloatMatrix
    selector: FloatMatrix
    only: IntVector
    speaker: IntVector
    bank: IntVector
    guards: IntMatrix
    expects: BoolVector
    loss: FloatVector
    budget: FloatVector
    approach_m: FloatVector
    legacy_m: FloatVector
    within_m: float


def sensed(vehicles: int, ring: int, columns: int = SAMPLE_COLUMNS) -> Sensed:
    """Return what vehicles hold that measured nothing.

    Parameters
    ----------
    vehicles, ring
        V and R.
    columns
        Of a sample, the state of sub-models counted (`ReadyBank.sample_columns`).
    """
    return Sensed(
        t_s=np.zeros((vehicles, 2 * ring)),
        samples=np.zeros((vehicles, 2 * ring, columns)),
        stated_s=np.zeros((vehicles, ring)),
        stated_m=np.zeros((vehicles, ring, 2)),
        history=np.zeros((vehicles, ring), dtype=np.int64),
        taken=np.zeros(vehicles, dtype=np.int64),
        noise=np.zeros((vehicles, 2)),
        shown=np.zeros((vehicles, MEASURED)),
        states=np.zeros((vehicles, MEASURED)),
        spreads=np.zeros((vehicles, MEASURED, MEASURED)),
    )


def fits(vehicles: int, ring: int, *, members: int, parameters: int) -> Fits:
    """Return fits of nothing.

    Parameters
    ----------
    vehicles, ring
        V and F.
    members, parameters
        M, and P of all together.
    """
    return Fits(
        np.zeros((vehicles, ring, parameters)),
        np.zeros((vehicles, ring, parameters), dtype=np.int64),
        np.full((vehicles, ring, members), -1, dtype=np.int64),
    )


def lanes(count: int, *, members: int, parameters: int, older: int = 0) -> Lanes:
    """Return senders that have sent nothing.

    Parameters
    ----------
    count
        L.
    members, parameters
        M, and P of all together.
    older
        D, messages that each remembers beside the newest.
    """
    return Lanes(
        update=np.full(count, -1, dtype=np.int64),
        in_use=np.full(count, -1, dtype=np.int64),
        origin=np.zeros((count, 3)),
        held=np.zeros((count, parameters)),
        usable=np.zeros((count, members), dtype=np.bool_),
        failed_s=np.full((count, members), np.inf),
        message_s=np.full(count, -np.inf),
        kind=np.zeros(count, dtype=np.int64),
        stated=np.zeros((count, 4)),
        last=np.zeros((count, parameters)),
        last_usable=np.zeros((count, members), dtype=np.bool_),
        last_origin=np.zeros((count, 3)),
        scores=np.full((count, members), -1.0),
        guarded=guarding(count),
        loss=np.zeros(count),
        older=np.zeros((count, older, OLDER_HEAD + parameters)),
        olders=np.zeros(count, dtype=np.int64),
        life_s=np.full(count, np.inf),
        errors=np.zeros((count, members)),
        chances=np.zeros((count, members)),
        available=np.zeros((count, members), dtype=np.bool_),
    )
