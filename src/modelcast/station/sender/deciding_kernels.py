"""Compiled steps around a policy in NumPy: what stations know before it decides, and what they post after."""

from math import hypot
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolMatrix, BoolVector, FloatMatrix, FloatVector, IntMatrix, IntVector
from modelcast.models.point_kernels import EAST, NORTH, VELOCITY_EAST, VELOCITY_NORTH
from modelcast.station.arrays import Fits, LaneRules, Lanes, Sensed
from modelcast.station.policy import j2945_kernels
from modelcast.station.policy.error_driven_kernels import NOTHING
from modelcast.station.policy.j2945_kernels import CAUSE_TIME
from modelcast.station.policy.neighbours_kernels import NeighbourTables, survey
from modelcast.station.sender.fitting_kernels import SenderModels, fit
from modelcast.station.sender.message_arrays import Contents, Outbox, SentTally
from modelcast.station.sender.posting_kernels import SendingStations, StepInputs, has_begun, post
from modelcast.station.sender.speaking_kernels import SCRATCH, compose, hold, member_error
from modelcast.station.sender.starting_kernels import available

__all__ = ["Asked", "Decided", "asked", "know_each", "know_sample", "post_each", "say_sample"]


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


def asked(vehicles: int, members: int) -> Asked:
    """Return room for what so many stations know of so many sub-models."""
    columns: list[FloatVector] = [np.zeros(vehicles) for _ in range(7)]
    return Asked(
        np.zeros(vehicles, dtype=np.bool_),
        np.zeros(vehicles, dtype=np.bool_),
        *columns,
        position_m=np.zeros((vehicles, 2)),
        error_m=np.full((vehicles, members), np.inf),
        available=np.zeros((vehicles, members), dtype=np.bool_),
        in_use=np.full(vehicles, -1, dtype=np.int64),
    )


class Decided(NamedTuple):
    """What V stations send, (V,) each.

    ``kind`` and ``member``, -1 for the station's choice; ``send_s``, ``power_dbm`` and ``believed``;
    ``waiting`` (V, 2) kind and sub-model of what waits for the next step.
    """

    kind: IntVector
    member: IntVector
    send_s: FloatVector
    power_dbm: FloatVector
    believed: BoolVector
    waiting: IntMatrix


@kernel(inlined=True)
def _know(
    models: SenderModels,
    s: Sensed,
    rules: LaneRules,
    lanes: Lanes,
    b: int,
    number: int,
    ask_s: float,
    scratch: FloatVector,
    out: Asked,
) -> None:
    """Write what the station of a lane knows of itself at a sample."""
    v, ring = rules.vehicle[b], s.stated_m.shape[1]
    at = number % ring + ring
    sample = s.samples[v, at]
    available(models, s, rules, lanes, b, number)
    sent = lanes.update[b] >= 0
    out.ask_s[v], out.in_use[v] = ask_s, lanes.in_use[b] if sent else -1
    out.age_s[v] = ask_s - lanes.origin[b, 0] if sent else np.inf
    out.silence_s[v] = ask_s - lanes.message_s[b]
    for m in range(models.members.windows.size):
        out.available[v, m], out.error_m[v, m] = lanes.available[b, m], np.inf
        if sent:
            out.error_m[v, m] = member_error(models, s, rules, lanes, b, at, m, scratch)
    out.position_m[v, 0], out.position_m[v, 1] = sample[EAST], sample[NORTH]
    out.speed_mps[v] = hypot(sample[VELOCITY_EAST], sample[VELOCITY_NORTH])
    out.heading_rad[v] = np.arctan2(sample[VELOCITY_EAST], sample[VELOCITY_NORTH])


@kernel(inlined=True)
def _compose(
    models: SenderModels,
    s: Sensed,
    fits: Fits,
    rules: LaneRules,
    lanes: Lanes,
    b: int,
    number: int,
    wanted: int,
    believed: bool,
    scratch: FloatVector,
) -> int:
    """Compose a lane's message at a sample by a sub-model, -1 for the station's choice; which it is."""
    member = compose(models, s, fits, rules, lanes, b, number, scratch)
    if wanted >= 0 and fit(models, s, fits, rules.vehicle[b], number, wanted):
        lanes.available[b, wanted] = True
        member = wanted
    if believed:
        hold(models, s, fits, rules, lanes, b, number, member)
    return member


@kernel
def know_sample(
    models: SenderModels, s: Sensed, rules: LaneRules, lanes: Lanes, number: int, t_s: float, out: Asked
) -> None:
    """Write what the one station of a recorded trip knows at a sample."""
    _know(models, s, rules, lanes, 0, number, t_s, np.empty(SCRATCH), out)


@kernel
def say_sample(
    models: SenderModels,
    s: Sensed,
    fits: Fits,
    rules: LaneRules,
    lanes: Lanes,
    number: int,
    t_s: float,
    wanted: int,
    believed: bool,
) -> int:
    """Let the one station of a recorded trip send at a sample; by which sub-model it does."""
    lanes.message_s[0] = t_s
    return _compose(models, s, fits, rules, lanes, 0, number, wanted, believed, np.empty(SCRATCH))


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
        ask_s = x.t_s + f.timers.phase[v] * (x.dt_s - f.numbers.jitter_s)
        number = f.sensed.taken[v] - 1
        _know(f.models, f.sensed, f.rules, f.lanes, (v + 1) * each - 1, number, ask_s, scratch, out)
        near, ratio = survey(
            tables.hosts, tables.slots, v, ask_s, out.position_m[v, 0], out.position_m[v, 1],
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
    """Compose a message of the newest sample, and post it."""
    kind, wanted = what
    sent_s, power_dbm, believed = how
    b = (v + 1) * (f.rules.vehicle.size // f.senders.vehicle.size) - 1
    number = f.sensed.taken[v] - 1
    member = _compose(f.models, f.sensed, f.fits, f.rules, f.lanes, b, number, wanted, believed, scratch)
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
            what = decided.waiting[v, 0], decided.waiting[v, 1]
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
            decided.waiting[v, 0], decided.waiting[v, 1] = decided.kind[v], decided.member[v]
