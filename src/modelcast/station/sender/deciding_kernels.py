"""Compiled steps around a policy in NumPy: what stations know before it decides, and what they post after."""

from math import hypot
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolMatrix, BoolVector, FloatMatrix, FloatVector, IntVector
from modelcast.models.point_kernels import EAST, NORTH, VELOCITY_EAST, VELOCITY_NORTH
from modelcast.station.policy import j2945_kernels
from modelcast.station.policy.error_driven_kernels import NOTHING
from modelcast.station.policy.j2945_kernels import CAUSE_TIME
from modelcast.station.policy.neighbours_kernels import NeighbourTables, survey
from modelcast.station.sender.fitting_kernels import fit
from modelcast.station.sender.message_arrays import Contents, Outbox, SentTally
from modelcast.station.sender.posting_kernels import SendingStations, StepInputs, has_begun, post
from modelcast.station.sender.speaking_kernels import SCRATCH, compose, hold, member_error
from modelcast.station.sender.starting_kernels import available
from modelcast.station.sender.timed_kernels import WAITS_KIND, WAITS_MEMBER

__all__ = ["Asked", "Decided", "know_each", "post_each"]


class Asked(NamedTuple):
    """What V stations know when their policy is asked; rows of those that do not send are left alone.

    ``asks`` and ``begins`` (V,) who is asked, and for the first time; ``ask_s``, ``age_s``, ``silence_s``,
    ``speed_mps``, ``heading_rad``, ``neighbours`` and ``error_ratio`` (V,); ``position_m`` (V, 2);
    ``error_m`` and ``available`` (V, M); ``in_use`` (V,).
    """

    asks: BoolVector
    begins: BoolVector
    ask_s: FloatVector
    age_s: FloatVector
    silence_s: FloatVector
    speed_mps: FloatVector
    heading_rad: FloatVector
    neighbours: FloatVector
    error_ratio: FloatVector
    position_m: FloatMatrix
    error_m: FloatMatrix
    available: BoolMatrix
    in_use: IntVector


class Decided(NamedTuple):
    """What V stations send, (V,) each.

    ``kind`` and ``member``, -1 for the station's choice; ``send_s``, ``power_dbm`` and ``believed``.
    """

    kind: IntVector
    member: IntVector
    send_s: FloatVector
    power_dbm: FloatVector
    believed: BoolVector


@kernel
def know_each(f: SendingStations, x: StepInputs, tables: NeighbourTables, out: Asked) -> None:
    """Write what the stations of all slots know, each at a time of its own within the step."""
    scratch = np.empty(SCRATCH)
    each = f.rules.vehicle.size // f.senders.vehicle.size
    c = f.policy.constants
    for v in range(f.senders.vehicle.size):
        before = f.timers.begun[v] and not x.started[v]
        out.asks[v] = has_begun(f, v, x)
        out.begins[v] = out.asks[v] and not before
        if not out.asks[v]:
            continue
        b, number = (v + 1) * each - 1, f.sensed.taken[v] - 1
        ring = f.sensed.stated_m.shape[1]
        at = number % ring + ring
        ask_s = x.t_s + f.timers.phase[v] * (x.dt_s - f.numbers.jitter_s)
        sample = f.sensed.samples[v, at]
        available(f.models, f.sensed, f.rules, f.lanes, b, number)
        sent = f.lanes.update[b] >= 0
        out.ask_s[v], out.in_use[v] = ask_s, f.lanes.in_use[b] if sent else -1
        out.age_s[v] = ask_s - f.lanes.origin[b, 0] if sent else np.inf
        out.silence_s[v] = ask_s - f.lanes.message_s[b]
        for m in range(f.models.members.windows.size):
            out.available[v, m] = f.lanes.available[b, m]
            out.error_m[v, m] = np.inf
            if sent:
                out.error_m[v, m] = member_error(f.models, f.sensed, f.rules, f.lanes, b, at, m, scratch)
        out.position_m[v, 0], out.position_m[v, 1] = sample[EAST], sample[NORTH]
        out.speed_mps[v] = hypot(sample[VELOCITY_EAST], sample[VELOCITY_NORTH])
        out.heading_rad[v] = np.arctan2(sample[VELOCITY_EAST], sample[VELOCITY_NORTH])
        near, ratio = survey(
            tables.hosts, tables.slots, v, ask_s, sample[EAST], sample[NORTH],
            c[j2945_kernels.PER_SUB_INTERVAL_S], c[j2945_kernels.PER_RANGE_M],
        )  # fmt: skip
        out.neighbours[v], out.error_ratio[v] = near, ratio


@kernel(inlined=True)
def _say(
    f: SendingStations,
    v: int,
    what: tuple[int, int],
    how: tuple[float, float, bool],
    contents: Contents,
    out: Outbox,
    tally: SentTally,
    scratch: FloatVector,
) -> None:
    """Compose a message of the newest sample by a sub-model, -1 for the station's choice, and post it."""
    kind, wanted = what
    sent_s, power_dbm, believed = how
    b = (v + 1) * (f.rules.vehicle.size // f.senders.vehicle.size) - 1
    number = f.sensed.taken[v] - 1
    member = compose(f.models, f.sensed, f.fits, f.rules, f.lanes, b, number, scratch)
    if wanted >= 0 and fit(f.models, f.sensed, f.fits, v, number, wanted):
        f.lanes.available[b, wanted] = True
        member = wanted
    if believed:
        hold(f.models, f.sensed, f.fits, f.rules, f.lanes, b, number, member)
    post(f, v, b, (kind, member), (sent_s, power_dbm, believed, CAUSE_TIME), np.inf, contents, out, tally)


@kernel
def post_each(
    f: SendingStations,
    x: StepInputs,
    asked: Asked,
    decided: Decided,
    contents: Contents,
    out: Outbox,
    tally: SentTally,
    first: int,
    end: int,
) -> None:
    """Post what the stations of some slots have decided; what falls due after the step waits for the next."""
    scratch = np.empty(SCRATCH)
    each = f.rules.vehicle.size // f.senders.vehicle.size
    until_s = x.t_s + x.dt_s
    out.filled[0] = 0
    for v in range(first, end):
        if f.senders.vehicle[v] < 0 or not asked.asks[v]:
            continue
        waits = f.timers.pending[v]
        if waits[0] < until_s:
            what = int(waits[WAITS_KIND]), int(waits[WAITS_MEMBER])
            _say(f, v, what, (max(waits[0], x.t_s), waits[1], waits[2] > 0.0), contents, out, tally, scratch)
            waits[0] = np.inf
        if decided.kind[v] == NOTHING:
            continue
        f.lanes.message_s[(v + 1) * each - 1] = asked.ask_s[v]
        sent_s = decided.send_s[v] + f.numbers.jitter_s * x.uniforms[v, 1]
        power_dbm, believed = decided.power_dbm[v], bool(decided.believed[v])
        if sent_s < until_s:
            what = decided.kind[v], decided.member[v]
            _say(f, v, what, (sent_s, power_dbm, believed), contents, out, tally, scratch)
        else:
            waits[0], waits[1], waits[2] = sent_s, power_dbm, 1.0 if believed else 0.0
            waits[WAITS_KIND], waits[WAITS_MEMBER] = decided.kind[v], decided.member[v]
