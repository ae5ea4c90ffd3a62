"""Compiled sending: once a step every station asks its rule, and posts what it sends."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector
from modelcast.messages.stack_kernels import airtime, frame_bytes
from modelcast.station.policy.error_driven_kernels import NOTHING
from modelcast.station.policy.j2945_kernels import CAUSE_NOTHING, CAUSE_TIME
from modelcast.station.policy.neighbours_kernels import NeighbourTables
from modelcast.station.policy.policy_numbers import RULE_CAM, RULE_ERROR_DRIVEN, RULE_J2945
from modelcast.station.sender.expecting_kernels import steps_on, until_cam
from modelcast.station.sender.message_arrays import (
    Contents,
    Outbox,
    SentTally,
)
from modelcast.station.sender.posting_kernels import SendingStations, StepInputs, has_begun, post, post_timed
from modelcast.station.sender.speaking_kernels import SCRATCH, longest_s, speak
from modelcast.station.sender.timed_kernels import (
    LOCAL,
    ask_cam,
    ask_j2945,
    ask_periodic,
    observe_loss,
)

__all__ = ["send_each"]


@kernel(inlined=True)
def _send_j2945(
    f: SendingStations,
    v: int,
    b: int,
    x: StepInputs,
    tables: NeighbourTables,
    contents: Contents,
    out: Outbox,
    tally: SentTally,
    scratch: FloatVector,
) -> None:
    """Post what waits, and what the rules of SAE J2945/1 call for; what falls due later waits."""
    waits, until_s = f.timers.pending[v], x.t_s + x.dt_s
    if waits[0] < until_s:
        how = (max(waits[0], x.t_s), waits[1], waits[2] > 0.0, int(waits[3]))
        post_timed(f, v, b, how, np.inf, x.dt_s, contents, out, tally, scratch)
        waits[0] = np.inf
    ask_s = x.t_s + f.timers.phase[v] * x.dt_s
    cause, sent_s, power_dbm, believed = ask_j2945(
        f.models, f.sensed, f.rules, f.lanes, f.timers, f.policy, b,
        (ask_s, ask_s + x.dt_s, x.busy_ratio[v], x.critical[v]), tables, x.uniforms[v], scratch,
    )  # fmt: skip
    if cause == CAUSE_NOTHING:
        return
    if sent_s < until_s:
        how = (sent_s, power_dbm, believed, cause)
        post_timed(f, v, b, how, np.inf, x.dt_s, contents, out, tally, scratch)
    else:
        waits[0], waits[1], waits[2], waits[3] = sent_s, power_dbm, 1.0 if believed else 0.0, float(cause)


@kernel(inlined=True)
def _send_otherwise(
    f: SendingStations,
    v: int,
    x: StepInputs,
    tables: NeighbourTables,
    contents: Contents,
    out: Outbox,
    tally: SentTally,
    scratch: FloatVector,
) -> None:
    """Post what an error, the rules of CAM or a fixed rate call for, at once."""
    each = f.rules.vehicle.size // f.senders.vehicle.size
    b = (v + 1) * each - 1
    n = f.numbers
    ask_s = x.t_s + f.timers.phase[v] * (x.dt_s - n.jitter_s)
    how = (ask_s + n.jitter_s * x.uniforms[v, 1], n.power_dbm, True, CAUSE_TIME)
    if f.policy.rule == RULE_ERROR_DRIVEN:
        number, kind, loss = f.sensed.taken[v] - 1, NOTHING, 0.0
        if f.rules.expects[b]:
            loss = observe_loss(f.sensed, f.timers, f.policy, v, ask_s, tables)
        for lane in range(v * each, b + 1):
            f.lanes.loss[lane] = loss
            kind = speak(f.models, f.sensed, f.fits, f.rules, f.lanes, lane, number, scratch)
            f.lanes.kind[lane] = kind
        if kind != NOTHING:
            ring = f.sensed.stated_m.shape[1]
            life_s = min(f.lanes.life_s[b], longest_s(f.sensed, f.rules, b, number % ring + ring))
            next_s = steps_on(ask_s, life_s, x.dt_s) + n.jitter_s
            post(f, v, b, (kind, f.lanes.in_use[b]), how, next_s, contents, out, tally)
        return
    sends, next_s = False, np.inf
    if f.policy.rule == RULE_CAM:
        largest = f.models.sizes[f.models.sizes.size - 1]
        airtime_s = airtime(frame_bytes(largest, True, n.stack), n.stack)
        sends = ask_cam(f.sensed, f.timers, f.policy, v, ask_s, x.busy_ratio[v], airtime_s)
        sample = f.sensed.samples[v, (f.sensed.taken[v] - 1) % f.sensed.stated_m.shape[1]]
        wait_s = until_cam(f.timers.rows[v], sample, f.policy.interval_s, f.policy.constants)
        next_s = steps_on(ask_s, wait_s, x.dt_s) + n.jitter_s
    else:
        sends = ask_periodic(f.timers, f.policy, v, ask_s, x.uniforms[v, 0])
        next_s = steps_on(ask_s, f.timers.due_s[v] - ask_s, x.dt_s) + n.jitter_s
    if sends:
        post_timed(f, v, b, how, next_s, x.dt_s, contents, out, tally, scratch)


@kernel(inlined=True)
def _send_all(
    f: SendingStations,
    x: StepInputs,
    tables: NeighbourTables,
    contents: Contents,
    out: Outbox,
    tally: SentTally,
    first: int,
    end: int,
    scratch: FloatVector,
) -> None:
    """Let the stations of some slots decide; ``scratch`` is overwritten."""
    each = f.rules.vehicle.size // f.senders.vehicle.size
    out.filled[0] = 0
    for v in range(first, end):
        if not has_begun(f, v, x):
            continue
        if f.policy.rule == RULE_J2945:
            _send_j2945(f, v, (v + 1) * each - 1, x, tables, contents, out, tally, scratch)
        else:
            _send_otherwise(f, v, x, tables, contents, out, tally, scratch)


@kernel
def send_each(
    f: SendingStations,
    x: StepInputs,
    tables: NeighbourTables,
    contents: Contents,
    out: Outbox,
    tally: SentTally,
    first: int,
    end: int,
) -> None:
    """Let the stations of some slots decide what they send in [t, t + dt), each at a time of its own."""
    _send_all(f, x, tables, contents, out, tally, first, end, np.empty(max(SCRATCH, 2 + LOCAL)))
