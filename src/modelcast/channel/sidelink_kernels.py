"""Compiled LTE-V2X mode 4: one interval of sensing-based semi-persistent scheduling, subframe by subframe.

In every subframe of 1 ms: vehicles whose turn it is send; everybody else adds up the power in each
sub-channel, decodes what it can, and remembers both; messages that became ready choose a resource if they
have none that fits.
"""

from typing import NamedTuple

import numpy as np

from modelcast.channel.antennas import Antennas
from modelcast.channel.copies_kernels import Copies, copies_room, kept_copies, settle
from modelcast.channel.frame_errors import FrameErrors
from modelcast.channel.frame_kernels import Asked, Heard, heard_room, nothing_heard
from modelcast.channel.frame_link_kernels import Links, no_links
from modelcast.channel.frame_outcome_kernels import tell_frame
from modelcast.channel.pool_air_kernels import (
    Air,
    Turns,
    add_turn,
    air_room,
    is_there,
    judge_frame,
    measure_busy,
    receive_frames,
    sensed_mw,
    silence,
    silent_air,
    surroundings,
)
from modelcast.channel.propagation_kernels import PropagationTables
from modelcast.channel.random_kernels import uniform
from modelcast.channel.shadowing_kernels import Sweep
from modelcast.channel.sidelink_grant_kernels import (
    AHEAD,
    BAND,
    BYTES,
    COUNTER,
    INTERVAL,
    LENGTH,
    MESSAGE,
    NEXT,
    RESERVED,
    SENT,
    SHOT,
    SHOT_LENGTH,
    SHOTS,
    SKIPS,
    TURNS,
    UNUSED,
    VIA,
    WISH,
    draw_counter,
    draw_shots,
    interval_for,
    is_foreseen,
    wants_one_shot,
)
from modelcast.channel.sidelink_parameters import MEMORY, STEP
from modelcast.channel.sidelink_selection_kernels import SidelinkConstants, select_resource
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    Float32Cube,
    FloatCube,
    FloatMatrix,
    FloatVector,
    IntMatrix,
    IntVector,
    UInt64Vector,
)

__all__ = ["Memory", "advance"]

_ANY = 0
_ALTERNATIVES_MS = 100
_WHICH, _AGAIN = 0, 1
"""Columns of ``own`` (V, 2), beside `Turns`: which of its vehicle's turns one is; whether it comes back."""


class Memory(NamedTuple):
    """What vehicles keep between subframes: arrays of `SidelinkState`."""

    grant: IntMatrix
    power_dbm: FloatVector
    sensed: Float32Cube
    reserved: Float32Cube
    busy: IntMatrix
    busy_ratio: FloatVector
    copies: Copies


@kernel(inlined=True)
def _fits(
    v: int, kind: int, subframe: int, length: int, grant: IntMatrix, constants: SidelinkConstants
) -> bool:
    """Whether a turn of a kind is there for a message that is ready, in time and long enough."""
    long_enough = grant[v, LENGTH if kind == RESERVED else SHOT_LENGTH] >= length
    ahead = grant[v, NEXT + kind] - subframe
    return bool(grant[v, BAND + kind] >= 0 and long_enough and constants.first <= ahead <= constants.last)


@kernel
def _choose(
    v: int,
    kind: int,
    subframe: int,
    length: int,
    interval: int,
    memory: Memory,
    random: UInt64Vector,
    constants: SidelinkConstants,
) -> None:
    """Choose the turns of a kind by sensing, or by chance where it is the first and the parameters say so."""
    grant = memory.grant
    blind = constants.first_by_chance and grant[v, LENGTH] == 0 and grant[v, SHOT_LENGTH] == 0
    when, band, when_again, band_again = select_resource(
        v, subframe, length, interval, blind, memory.sensed, memory.reserved, random, constants
    )
    grant[v, BAND + kind], grant[v, NEXT + kind] = band, when
    grant[v, BAND + kind + 1], grant[v, NEXT + kind + 1] = band_again, when_again


@kernel
def _take_in(
    n: int,
    subframe: int,
    memory: Memory,
    asked: Asked,
    lengths: IntVector,
    random: UInt64Vector,
    constants: SidelinkConstants,
) -> None:
    """Let a message wait for the vehicle's resource; choose one where it has none that fits."""
    grant, v, size_bytes, wish = memory.grant, asked.sender[n], asked.size_bytes[n], asked.grant[n]
    length = int(lengths[size_bytes])
    grant[v, MESSAGE], grant[v, BYTES], grant[v, WISH] = asked.message_id[n], size_bytes, wish
    grant[v, AHEAD] = int(np.floor(asked.next_s[n] * 1e3 + 1e-6)) if asked.next_s[n] < 1e12 else -1
    grant[v, VIA], grant[v, SENT], grant[v, SKIPS] = RESERVED, 0, 0
    memory.power_dbm[v] = asked.power_dbm[n]
    fits = _fits(v, RESERVED, subframe, length, grant, constants)
    shot = wants_one_shot(wish, constants)
    if constants.interleaved and fits and not shot:
        grant[v, SHOTS] -= 1
        if grant[v, SHOTS] <= 0:
            grant[v, SHOTS], grant[v, SKIPS], shot = draw_shots(random, constants), 1, True
    if fits and not shot:
        return
    if wish == _ANY and constants.grant_by_next and not shot:
        shot = not is_foreseen(grant, v, subframe + constants.first, constants)
        if shot:
            grant[v, BAND] = grant[v, BAND + 1] = -1
    if shot:
        grant[v, VIA] = SHOT
        if not _fits(v, SHOT, subframe, length, grant, constants):
            _choose(v, SHOT, subframe, length, 0, memory, random, constants)
            grant[v, SHOT_LENGTH] = length
        return
    interval = interval_for(grant, v, subframe + constants.first, constants)
    _choose(v, RESERVED, subframe, length, interval, memory, random, constants)
    grant[v, LENGTH], grant[v, COUNTER], grant[v, UNUSED] = length, draw_counter(random, constants), 0
    grant[v, INTERVAL] = interval
    if constants.interleaved and grant[v, SHOTS] <= 0:
        grant[v, SHOTS] = draw_shots(random, constants)


@kernel(inlined=True)
def _pass_by(v: int, which: int, grant: IntMatrix, constants: SidelinkConstants) -> None:
    """Let a reserved turn pass without a message."""
    grant[v, NEXT + which] += grant[v, INTERVAL]
    if which != RESERVED:
        return
    if grant[v, SKIPS] > 0:
        grant[v, SKIPS] = 0
        grant[v, COUNTER] = max(grant[v, COUNTER] - 1, 1)
        return
    grant[v, UNUSED] += 1
    if grant[v, UNUSED] >= constants.reselect_after:
        grant[v, BAND] = grant[v, BAND + 1] = -1


@kernel(inlined=True)
def _goes_on(
    v: int, subframe: int, memory: Memory, random: UInt64Vector, constants: SidelinkConstants
) -> bool:
    """Whether a resource that is used now comes back; its interval is written."""
    grant = memory.grant
    grant[v, UNUSED] = 0
    if grant[v, COUNTER] > 1:
        grant[v, COUNTER] -= 1
    elif uniform(random) < constants.keep_ratio:
        grant[v, COUNTER] = draw_counter(random, constants)
    else:
        return False
    if not constants.interval_by_next and not constants.grant_by_next:
        return True
    if grant[v, WISH] == _ANY and constants.grant_by_next and not is_foreseen(grant, v, subframe, constants):
        return False
    grant[v, INTERVAL] = interval_for(grant, v, subframe, constants)
    if grant[v, INTERVAL] == constants.horizon:
        return True  # nobody can have announced anything so far ahead; its phase is still that of now
    phase = (subframe + grant[v, INTERVAL]) % constants.horizon
    for s in range(grant[v, BAND], grant[v, BAND] + grant[v, LENGTH]):
        if memory.reserved[phase, v, s] > constants.pool.reserved_mw:
            return False  # another will be there
    return True


@kernel(inlined=True)
def _let_go(v: int, lapsed: int, memory: Memory, heard: Heard) -> int:
    """Give up the message that waits: expired, or settled where a copy was sent; return how many lapsed."""
    grant = memory.grant
    if grant[v, MESSAGE] >= 0:
        if grant[v, SENT] == 0:
            heard.expired[lapsed] = grant[v, MESSAGE]
            lapsed += 1
        else:
            settle(memory.copies, v, heard.outcomes)  # no other copy is to come
    grant[v, MESSAGE] = -1
    return lapsed


@kernel
def _take_turns(
    subframe: int,
    lapsed: int,
    memory: Memory,
    position_m: FloatMatrix,
    lengths: IntVector,
    filled: FloatVector,
    leak: FloatCube,
    turns: Turns,
    own: IntMatrix,
    air: Air,
    heard: Heard,
    random: UInt64Vector,
    constants: SidelinkConstants,
) -> tuple[int, int]:
    """Write who sends in this subframe; return how many, and how many messages have lapsed.

    Who is not there lets its message go.
    """
    count, grant = 0, memory.grant
    for v in range(grant.shape[0]):
        for which in range(TURNS if constants.copies > 1 else TURNS - 1):
            if grant[v, NEXT + which] != subframe or grant[v, BAND + which] < 0:
                continue
            kind = which & SHOT
            due = grant[v, MESSAGE] >= 0 and grant[v, VIA] == kind and grant[v, SENT] == which - kind
            if due and not is_there(v, position_m):
                lapsed, due = _let_go(v, lapsed, memory, heard), False
            if not due:
                if kind == RESERVED:
                    _pass_by(v, which, grant, constants)
                continue
            size, dbm = int(grant[v, BYTES]), float(memory.power_dbm[v])
            length, fills, band = int(lengths[size]), float(filled[size]), int(grant[v, BAND + which])
            add_turn(count, v, band, length, fills, size, dbm, position_m, leak, turns, air, random)
            if which == RESERVED:
                again = _goes_on(v, subframe, memory, random, constants)
            else:
                again = kind == RESERVED and grant[v, BAND] >= 0
            own[count, _WHICH], own[count, _AGAIN] = which, int(again)
            if kind == RESERVED:
                grant[v, NEXT + which] += grant[v, INTERVAL]
            count += 1
    return count, lapsed


@kernel
def _remember(
    subframe: int, count: int, turns: Turns, memory: Memory, air: Air, constants: SidelinkConstants
) -> None:
    """Keep what everybody sensed; what was reserved in this phase has come."""
    sensed, power = memory.sensed[subframe % STEP], air.power
    channels = power.shape[1]
    first = subframe % MEMORY // STEP * channels
    for v in range(power.shape[0]):
        for s in range(channels):
            sensed[v, first + s] = sensed_mw(power[v, s], constants.pool)
    for turn in range(count):
        sensed[turns.who[turn, 0], first : first + channels] = np.inf
    memory.reserved[subframe % constants.horizon] = 0.0


@kernel(inlined=True)
def _mark(j: int, subframe: int, band: int, length: int, rsrp_mw: float, reserved: Float32Cube) -> None:
    """Let a vehicle know that a resource is taken in one subframe to come."""
    phase, power = subframe % reserved.shape[0], np.float32(rsrp_mw)
    for s in range(band, band + length):
        reserved[phase, j, s] = max(reserved[phase, j, s], power)


@kernel(inlined=True)
def _hear_reservations(
    turn: int,
    subframe: int,
    more: bool,
    turns: Turns,
    own: IntMatrix,
    links: Links,
    memory: Memory,
    constants: SidelinkConstants,
) -> None:
    """Let who understands a frame's control information remember what it announces.

    That is its own resource, short intervals as often as 100 ms hold, and that of the second copy.
    """
    v, again = turns.who[turn, 0], own[turn, _AGAIN] == 1
    if not again and not more:
        return
    grant, reserved, pool = memory.grant, memory.reserved, constants.pool
    band, length, filled = turns.who[turn, 1], turns.who[turn, 2], turns.filled[turn]
    interval, second = int(grant[v, INTERVAL]), int(own[turn, _WHICH]) + 1
    when, place = int(grant[v, NEXT + second]), int(grant[v, BAND + second])
    end = subframe + max(interval, _ALTERNATIVES_MS) + 1
    # What is weaker excludes nothing, except where the mean decides.
    least_mw = 0.0 if constants.reserved_by_mean else pool.reserved_mw
    for k in range(turns.first_link[turn], turns.first_link[turn + 1]):
        j, power_mw, rsrp_mw = links.receiver[k], links.mw[k], links.mw[k] / (filled * pool.elements)
        understood = power_mw >= pool.control_ratio * (pool.noise_mw * filled + links.other_mw[k])
        if rsrp_mw <= least_mw or not understood:
            continue
        if again:
            for later in range(subframe + interval, end, interval):
                _mark(j, later, band, length, rsrp_mw, reserved)
        if more:
            _mark(j, when, place, length, rsrp_mw, reserved)


@kernel
def _end_turns(count: int, turns: Turns, own: IntMatrix, grant: IntMatrix) -> None:
    """Messages sent in full are gone, and resources that were not reserved."""
    for turn in range(count):
        v, which = turns.who[turn, 0], own[turn, _WHICH]
        grant[v, SENT] += 1
        if which & 1 == 1 or grant[v, BAND + which + 1] < 0:
            grant[v, MESSAGE] = -1
        if own[turn, _AGAIN] == 0:
            grant[v, BAND + which] = -1


@kernel
def _with_room(memory: Memory, waiting: int, used: int) -> Memory:
    """Return the same with room for more pairs that wait for a second copy."""
    copies = copies_room(memory.copies, waiting, used)
    return Memory(
        memory.grant,
        memory.power_dbm,
        memory.sensed,
        memory.reserved,
        memory.busy,
        memory.busy_ratio,
        copies,
    )


@kernel
def advance(
    now: int,
    until: int,
    random: UInt64Vector,
    memory: Memory,
    asked: Asked,
    lengths: IntVector,
    filled: FloatVector,
    sweep: Sweep,
    antennas: Antennas,
    errors: FrameErrors,
    leak: FloatCube,
    tables: PropagationTables,
    constants: SidelinkConstants,
) -> tuple[Heard, IntMatrix, IntMatrix]:
    """Carry the subframes ``now`` to ``until``, the end excluded; the state's arrays are written into.

    Of messages of 0, 1, ... bytes, ``lengths`` are the sub-channels taken and ``filled`` those with power.
    What waits for a copy, and whose it is, comes beside what is heard.
    """
    grant, sender, position_m, pool = memory.grant, asked.sender, sweep.position_m, constants.pool
    vehicles = grant.shape[0]
    ready_subframe = np.floor(asked.ready_s * 1e3 + 1e-6).astype(np.int64)
    around = surroundings(sweep, antennas)
    heard, received, lapsed = nothing_heard(pool.bins, sender.size + vehicles), 0, 0
    air, turns = silent_air(vehicles, pool.sub_channels)
    own, links = np.empty((vehicles, 2), dtype=np.int64), no_links()
    arrival, waiting = 0, memory.copies.pair.shape[0]

    for subframe in range(now, until):
        count, lapsed = _take_turns(
            subframe,
            lapsed,
            memory,
            position_m,
            lengths,
            filled,
            leak,
            turns,
            own,
            air,
            heard,
            random,
            constants,
        )
        air = air_room(air, count)
        links, used = receive_frames(count, turns, air, links, around, tables, pool)
        _remember(subframe, count, turns, memory, air, constants)
        heard = heard_room(heard, received, used)
        if constants.copies > 1:
            memory = _with_room(memory, waiting, used)
        for turn in range(count):
            v, which = int(turns.who[turn, 0]), own[turn, _WHICH]
            first, last = turns.first_link[turn], turns.first_link[turn + 1]
            more = bool(constants.copies > 1 and which & 1 == 0 and grant[v, BAND + which + 1] >= 0)
            judge_frame(turn, count, turns, air, links, errors, pool)
            _hear_reservations(turn, subframe, more, turns, own, links, memory, constants)
            received, waiting = tell_frame(
                v,
                grant[v, MESSAGE],
                which & 1,
                more,
                first,
                last,
                (subframe + 1) * 1e-3,
                links,
                memory.copies,
                heard,
                received,
                waiting,
            )
        _end_turns(count, turns, own, grant)
        silence(count, turns, links, air, memory.busy, pool)
        if (subframe + 1) % pool.window == 0:
            measure_busy(memory.busy, memory.busy_ratio, pool)
        # Messages that became ready in this subframe choose their resource once it is over: whose turn it
        # was has sent, and what it brought is known.
        while arrival < sender.size and ready_subframe[arrival] <= subframe:
            v, n = sender[arrival], arrival
            arrival += 1
            lapsed = _let_go(v, lapsed, memory, heard)
            if is_there(v, position_m):
                _take_in(n, subframe, memory, asked, lengths, random, constants)
            else:
                heard.expired[lapsed] = asked.message_id[n]
                lapsed += 1

    who, when = heard.who[:received].copy(), heard.when[:received].copy()
    pair, span = kept_copies(memory.copies)
    return Heard(who, when, heard.outcomes, heard.expired[:lapsed].copy()), pair, span
