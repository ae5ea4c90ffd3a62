"""Compiled error-driven sending: what every lane does at a sample, for trips, fleets and the road alike.

A guarded lane holds nothing itself: it says what the lane of its bank says, or that of one of its guards
(`modelcast.station.policy.guard`). Those stand before it and have decided.
"""

from math import hypot

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector, IntMatrix
from modelcast.models.member_kernels import absorb_member
from modelcast.models.point_kernels import EAST, NORTH, VELOCITY_EAST, VELOCITY_NORTH
from modelcast.station.arrays import OLDER_HEAD, Fits, LaneRules, Lanes, Sensed
from modelcast.station.policy.believed_loss_kernels import error_growth, share_held
from modelcast.station.policy.error_driven_kernels import (
    IDENTIFY_NEVER,
    KEEP_ALIVE,
    NOTHING,
    START_RECENT,
    START_SURVIVOR,
    UPDATE,
    for_legacy,
    longest_silence_s,
    step,
)
from modelcast.station.policy.guard_kernels import BANK, forget_guard, steer
from modelcast.station.sender.expecting_kernels import life_of
from modelcast.station.sender.fitting_kernels import SenderModels, distance_to, fit
from modelcast.station.sender.motion_kernels import displace_straight, state_motion
from modelcast.station.sender.starting_kernels import available, chosen

__all__ = [
    "SCRATCH",
    "compose",
    "expect",
    "followed",
    "forget_lane",
    "hold",
    "longest_s",
    "member_error",
    "speak",
    "speak_through",
]

SCRATCH = 5
"""Numbers that these steps overwrite."""

_TIME_SLACK_S = 1e-9


@kernel(inlined=True)
def forget_lane(lanes: Lanes, b: int) -> None:
    """Let a lane have sent nothing: another vehicle has taken its place."""
    lanes.update[b] = lanes.in_use[b] = -1
    lanes.message_s[b] = -np.inf
    lanes.kind[b] = NOTHING
    forget_guard(lanes.guarded, b)
    lanes.loss[b], lanes.olders[b], lanes.life_s[b] = 0.0, 0, np.inf
    for m in range(lanes.usable.shape[1]):
        lanes.usable[b, m] = lanes.last_usable[b, m] = False
        lanes.failed_s[b, m] = np.inf
        lanes.scores[b, m] = -1.0


@kernel(inlined=True)
def member_error(
    models: SenderModels,
    s: Sensed,
    rules: LaneRules,
    lanes: Lanes,
    b: int,
    at: int,
    m: int,
    scratch: FloatVector,
) -> float:
    """Tracking error of a member that remotes hold; infinite where it had no full window."""
    if not lanes.usable[b, m]:
        return np.inf
    v, offsets = rules.vehicle[b], models.members.offsets
    own = lanes.held[b, offsets[m] : offsets[m + 1]]
    return distance_to(models, m, own, lanes.origin[b], s.t_s[v, at], s.samples[v, at], scratch)


@kernel(inlined=True)
def expect(
    models: SenderModels,
    s: Sensed,
    rules: LaneRules,
    lanes: Lanes,
    b: int,
    at: int,
    threshold_m: float,
    scratch: FloatVector,
) -> None:
    """Write how long the message that a lane is about to send will hold, by how long the one before did."""
    lanes.life_s[b] = np.inf
    if lanes.update[b] >= 0:
        error_m = member_error(models, s, rules, lanes, b, at, lanes.in_use[b], scratch)
        age_s = s.t_s[rules.vehicle[b], at] - lanes.origin[b, 0]
        lanes.life_s[b] = life_of(age_s, error_m, threshold_m)


@kernel(inlined=True)
def _expected_error(
    models: SenderModels, s: Sensed, rules: LaneRules, lanes: Lanes, b: int, at: int, scratch: FloatVector
) -> float:
    """Mean tracking error over what a remote may hold, each of the last messages by its probability."""
    newest = member_error(models, s, rules, lanes, b, at, lanes.in_use[b], scratch)
    loss, olders = float(lanes.loss[b]), lanes.olders[b]
    if loss <= 0.0 or olders == 0:
        return newest
    v, offsets = rules.vehicle[b], models.members.offsets
    mean = share_held(loss, 0, False) * newest
    for k in range(olders):
        m = int(lanes.older[b, k, 0])
        own = lanes.older[b, k, OLDER_HEAD : OLDER_HEAD + offsets[m + 1] - offsets[m]]
        origin = lanes.older[b, k, 1:OLDER_HEAD]
        error_m = distance_to(models, m, own, origin, s.t_s[v, at], s.samples[v, at], scratch)
        mean += share_held(loss, k + 1, k + 1 == olders) * error_m
    return mean


@kernel(inlined=True)
def _legacy_error(s: Sensed, rules: LaneRules, lanes: Lanes, b: int, at: int, scratch: FloatVector) -> float:
    """Error of those who coast Part I of a lane's update at constant velocity."""
    v = rules.vehicle[b]
    displace_straight(lanes.stated[b], s.t_s[v, at] - lanes.origin[b, 0], scratch)
    east = lanes.origin[b, 1] + scratch[0] - s.samples[v, at, EAST]
    return hypot(east, lanes.origin[b, 2] + scratch[1] - s.samples[v, at, NORTH])


@kernel(inlined=True)
def longest_s(s: Sensed, rules: LaneRules, b: int, at: int) -> float:
    """Longest silence of a lane at its speed."""
    if rules.approach_m[b] == np.inf:
        return float(rules.silence_s[b])
    sample = s.samples[rules.vehicle[b], at]
    speed = hypot(sample[VELOCITY_EAST], sample[VELOCITY_NORTH])
    return longest_silence_s(rules.silence_s[b], rules.approach_m[b], speed)


@kernel(inlined=True)
def _ask(
    models: SenderModels, s: Sensed, rules: LaneRules, lanes: Lanes, b: int, at: int, scratch: FloatVector
) -> int:
    """Ask Algorithm 1 what a lane sends that sent before; an identification changes ``lanes.in_use``."""
    t_s = s.t_s[rules.vehicle[b], at]
    if rules.expects[b] or (rules.identify[b] == IDENTIFY_NEVER and rules.start[b] != START_SURVIVOR):
        # Whether others hold changes nothing, and nobody asks when they failed.
        growth = error_growth(lanes.loss[b], rules.budget[b]) if rules.expects[b] else 1.0
        error_m = _expected_error(models, s, rules, lanes, b, at, scratch)
        if not error_m < growth * rules.threshold_m[b]:
            return UPDATE
        silent = t_s - lanes.message_s[b] >= longest_s(s, rules, b, at) - _TIME_SLACK_S
        return KEEP_ALIVE if silent else NOTHING
    for m in range(models.members.windows.size):
        lanes.errors[b, m] = member_error(models, s, rules, lanes, b, at, m, scratch)
    kind, lanes.in_use[b] = step(
        lanes.errors[b],
        lanes.failed_s[b],
        lanes.in_use[b],
        t_s - lanes.origin[b, 0],
        t_s - lanes.message_s[b],
        rules.threshold_m[b],
        longest_s(s, rules, b, at),
        rules.identify[b],
        rules.costs[b],
    )
    return kind


@kernel(inlined=True)
def _keep_older(models: SenderModels, lanes: Lanes, b: int) -> None:
    """Remember what the newest message gave remotes to hold: the next one may be lost."""
    m = lanes.in_use[b]
    if lanes.older.shape[1] == 0 or lanes.update[b] < 0 or not lanes.usable[b, m]:
        return
    lanes.olders[b] = min(lanes.olders[b] + 1, lanes.older.shape[1])
    for k in range(lanes.olders[b] - 1, 0, -1):
        for i in range(lanes.older.shape[2]):
            lanes.older[b, k, i] = lanes.older[b, k - 1, i]
    lanes.older[b, 0, 0] = m
    for i in range(3):
        lanes.older[b, 0, 1 + i] = lanes.origin[b, i]
    first = models.members.offsets[m]
    for i in range(models.members.offsets[m + 1] - first):
        lanes.older[b, 0, OLDER_HEAD + i] = lanes.held[b, first + i]


@kernel(inlined=True)
def hold(
    models: SenderModels,
    s: Sensed,
    fits: Fits,
    rules: LaneRules,
    lanes: Lanes,
    b: int,
    number: int,
    member: int,
) -> None:
    """Take what a lane says at a sample for what its remotes hold from now on."""
    v, ring = rules.vehicle[b], s.stated_m.shape[1]
    place, offsets = number % fits.parameters.shape[1], models.members.offsets
    _keep_older(models, lanes, b)
    stated_s = s.stated_s[v, number % ring]
    east_m, north_m = s.stated_m[v, number % ring, 0], s.stated_m[v, number % ring, 1]
    lanes.origin[b, 0] = stated_s - lanes.origin[b, 0]
    lanes.origin[b, 1], lanes.origin[b, 2] = east_m - lanes.origin[b, 1], north_m - lanes.origin[b, 2]
    same = lanes.update[b] >= 0 and lanes.in_use[b] == member
    for m in range(models.members.windows.size):
        continues = same and m == member and lanes.usable[b, m]
        lanes.usable[b, m] = fits.number[v, place, m] == number and lanes.available[b, m]
        lanes.failed_s[b, m] = np.inf
        if lanes.usable[b, m]:
            own = fits.parameters[v, place, offsets[m] : offsets[m + 1]]
            held = lanes.held[b, offsets[m] : offsets[m + 1]]
            absorb_member(models.members, m, own, lanes.origin[b], continues, held)
    if rules.legacy_m[b] < np.inf:
        others = rules.identify[b] != IDENTIFY_NEVER and models.members.windows.size > 1
        state_motion(models.part_one, s, fits, v, number, member, others, lanes.stated[b])
    lanes.update[b], lanes.in_use[b] = number, member
    lanes.origin[b, 0], lanes.origin[b, 1], lanes.origin[b, 2] = stated_s, east_m, north_m


@kernel(inlined=True)
def _remember(
    models: SenderModels, s: Sensed, fits: Fits, rules: LaneRules, lanes: Lanes, b: int, number: int
) -> None:
    """Keep the members fitted for a message: the next one sets them against what happened."""
    v, ring = rules.vehicle[b], s.stated_m.shape[1]
    place, offsets = number % fits.parameters.shape[1], models.members.offsets
    lanes.last_origin[b, 0] = s.stated_s[v, number % ring]
    lanes.last_origin[b, 1], lanes.last_origin[b, 2] = (
        s.stated_m[v, number % ring, 0],
        s.stated_m[v, number % ring, 1],
    )
    for m in range(models.members.windows.size):
        lanes.last_usable[b, m] = lanes.available[b, m]
        if lanes.available[b, m]:
            for i in range(offsets[m], offsets[m + 1]):
                lanes.last[b, i] = fits.parameters[v, place, i]


@kernel(inlined=True)
def _first(
    models: SenderModels, s: Sensed, fits: Fits, rules: LaneRules, lanes: Lanes, b: int, number: int
) -> int:
    """First member that can be fitted, where the one chosen could not; 0 for none."""
    for m in range(models.members.windows.size):
        if lanes.available[b, m] and fit(models, s, fits, rules.vehicle[b], number, m):
            return m
    return 0  # nothing serves: an update falls due at the next sample


@kernel(inlined=True)
def compose(
    models: SenderModels,
    s: Sensed,
    fits: Fits,
    rules: LaneRules,
    lanes: Lanes,
    b: int,
    number: int,
    scratch: FloatVector,
) -> int:
    """Fit what a lane's message at a sample carries; returns the sub-model in use.

    Where another member may be named later, or its errors are asked for, all are fitted that have a full
    window.
    """
    available(models, s, rules, lanes, b, number)
    member = chosen(models, s, fits, rules, lanes, b, number, scratch)
    start = rules.start[b]
    every = rules.identify[b] != IDENTIFY_NEVER or start in (START_SURVIVOR, START_RECENT)
    for m in range(models.members.windows.size):
        if lanes.available[b, m] and (every or m == member):
            lanes.available[b, m] = fit(models, s, fits, rules.vehicle[b], number, m)
    if member >= 0 and not lanes.available[b, member]:
        member = _first(models, s, fits, rules, lanes, b, number)
    if start == START_RECENT:
        _remember(models, s, fits, rules, lanes, b, number)
    return member


@kernel(inlined=True)
def followed(rules: LaneRules, lanes: Lanes, b: int) -> int:
    """Return the lane that holds what remotes hold of this one: itself where it has no guard."""
    if rules.bank[b] < 0:
        return b
    step = lanes.guarded.step[b]
    return int(rules.bank[b] if step == BANK else rules.guards[b, step])


@kernel(inlined=True)
def _steered(rules: LaneRules, lanes: Lanes, a: int, kind: int) -> int:
    """Ask the guard of the lane that speaks for a bank's lane; what that one sends: an update to restart."""
    b = rules.speaker[a]
    first, second = rules.guards[b, 0], rules.guards[b, 1]
    said = (
        bool(lanes.kind[first] != NOTHING),
        bool(second >= 0 and lanes.kind[second] != NOTHING),
    )
    return UPDATE if steer(lanes.guarded, b, kind != NOTHING, said, 2 if second >= 0 else 1) else kind


@kernel(inlined=True)
def _stand_in(
    models: SenderModels,
    s: Sensed,
    fits: Fits,
    rules: LaneRules,
    lanes: Lanes,
    a: int,
    number: int,
    member: int,
) -> int:
    """Return the sub-model of the guard that a bank's lane stands in for; its own where that has none."""
    b, v = rules.speaker[a], rules.vehicle[a]
    guard = int(rules.only[rules.guards[b, lanes.guarded.stand_in[b]]])
    history = s.history[v, number % s.history.shape[1]]
    if history < models.members.windows[guard] or not fit(models, s, fits, v, number, guard):
        return member
    lanes.available[a, guard] = True
    return guard


@kernel(inlined=True)
def speak(
    models: SenderModels,
    s: Sensed,
    fits: Fits,
    rules: LaneRules,
    lanes: Lanes,
    b: int,
    number: int,
    scratch: FloatVector,
) -> int:
    """Let a lane decide at a sample: what it sends; its state is written. ``scratch`` (`SCRATCH`,)."""
    v, ring = rules.vehicle[b], s.stated_m.shape[1]
    at = number % ring + ring
    kind = UPDATE
    if rules.bank[b] >= 0:
        whom = followed(rules, lanes, b)
        kind = int(lanes.kind[whom])
        lanes.update[b], lanes.in_use[b] = lanes.update[whom], lanes.in_use[whom]
        lanes.life_s[b] = lanes.life_s[whom]
    else:
        if lanes.update[b] >= 0:
            before = lanes.in_use[b]
            kind = _ask(models, s, rules, lanes, b, at, scratch)
            if rules.legacy_m[b] < np.inf:
                kind = for_legacy(kind, _legacy_error(s, rules, lanes, b, at, scratch), rules.legacy_m[b])
                lanes.in_use[b] = before if kind == UPDATE else lanes.in_use[b]
        if rules.speaker[b] >= 0:
            kind = _steered(rules, lanes, b, kind)
        if kind in (UPDATE, KEEP_ALIVE):
            expect(models, s, rules, lanes, b, at, rules.threshold_m[b], scratch)
            member = compose(models, s, fits, rules, lanes, b, number, scratch)
            if rules.speaker[b] >= 0 and lanes.guarded.stand_in[rules.speaker[b]] != BANK:
                member = _stand_in(models, s, fits, rules, lanes, b, number, member)
            hold(models, s, fits, rules, lanes, b, number, member)
    if kind != NOTHING:
        lanes.message_s[b] = s.t_s[v, at]
    lanes.kind[b] = kind
    return kind


@kernel
def speak_through(
    models: SenderModels,
    s: Sensed,
    fits: Fits,
    rules: LaneRules,
    lanes: Lanes,
    kind: IntMatrix,
    in_use: IntMatrix,
    update_index: IntMatrix,
) -> None:
    """Let every lane decide at every sample of its vehicle, T of them: outputs are (L, T)."""
    scratch = np.empty(SCRATCH)
    for number in range(kind.shape[1]):
        for b in range(kind.shape[0]):
            kind[b, number] = speak(models, s, fits, rules, lanes, b, number, scratch)
            in_use[b, number], update_index[b, number] = lanes.in_use[b], lanes.update[b]
