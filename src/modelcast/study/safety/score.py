"""Pairs of one recording scored: what hosts warn of, against perfect knowledge."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from modelcast.apps.base import AbstractApplication
from modelcast.apps.motions import Motions
from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.models.point_kernels import ACCELERATION, VELOCITY_EAST, VELOCITY_NORTH, YAW_RATE
from modelcast.runtime.trip.replay import replay, schedules_of
from modelcast.runtime.trip.runtime import TripMessages, sense_trip
from modelcast.runtime.trip.together import placed
from modelcast.station.receiver.belief_kernels import (
    BELIEF_ACCELERATION,
    BELIEF_HEADING,
    BELIEF_SPEED,
    BELIEF_YAW_RATE,
)
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.study.case import TripCase, make_case
from modelcast.study.compare.candidate import FixedCandidate
from modelcast.study.context import trip_runtimes
from modelcast.study.safety.events import TrueWarnings, delays_s, false_warnings, true_warnings
from modelcast.study.safety.pairs import FollowingPair, Recording
from modelcast.study.safety.result import ConditionScores, PairNames, RecordingScores, SenderSpend
from modelcast.study.safety.senders import LeadingSender, Spent
from modelcast.study.safety.settings import Basis, SafetySettings
from modelcast.study.tracking import draw_losses
from modelcast.world.true_motion import true_motion

__all__ = ["SMOOTH_S", "Walked", "score_recording"]

SMOOTH_S = 0.3
"""Accelerations that are true are slopes over this long to either side [s]: brakes take as long to bite."""


def _columns(motion: FloatArray) -> Motions:
    """Motions from columns of `true_motion`."""
    return Motions.of(
        motion[:, :2], speed_mps=motion[:, 2], heading_rad=motion[:, 3],
        acceleration_mps2=motion[:, 4], yaw_rate_radps=motion[:, 5],
    )  # fmt: skip


def _seen_motion(case: TripCase) -> FloatArray:
    """How a vehicle sees itself move, columns as those of `true_motion`, (T, 6)."""
    samples = sample_matrix(case.seen, case.estimator)
    east, north = samples[:, VELOCITY_EAST], samples[:, VELOCITY_NORTH]
    course = np.unwrap(np.arctan2(east, north))
    return np.column_stack(
        (samples[:, :2], np.hypot(east, north), course, samples[:, ACCELERATION], samples[:, YAW_RATE])
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Ready:
    """A pair with what is true of it: instants that count, and where perfect knowledge warns."""

    pair: FollowingPair
    t_s: FloatArray
    counted: BoolArray
    warned: BoolArray
    true: TrueWarnings
    host: Motions


def _ready(pair: FollowingPair, cases: Mapping[int, TripCase], settings: SafetySettings) -> _Ready:
    leader, follower = cases[pair.leader], cases[pair.follower]
    seen = placed(pair.at_follower(_seen_motion(follower)), follower.truth, leader.truth)
    host, remote = _columns(seen), _seen_motion(leader)[pair.samples]
    right = host
    if settings.truth == "knowledge":
        motion = pair.at_follower(true_motion(follower.truth, smooth_s=SMOOTH_S))
        right = _columns(placed(motion, follower.truth, leader.truth))
        remote = true_motion(leader.truth, smooth_s=SMOOTH_S)[pair.samples]
    found = settings.application.assess(right, _columns(remote))
    near, warned = np.abs(found.margin_m) < settings.near_m, found.warned
    t_s = leader.truth.t_s[pair.samples]
    return _Ready(pair, t_s, near, warned, true_warnings(warned, near, t_s, merge_s=settings.merge_s), host)


def _warned(application: AbstractApplication, ready: _Ready, motions: FloatArray) -> BoolArray:
    """Where hosts warn that believe the leader to move like this, (R, T, 8) at its samples; (R, N)."""
    runs, at = motions.shape[0], np.flatnonzero(ready.counted)
    rows = motions[:, ready.pair.samples[at]].reshape(-1, motions.shape[2])
    own = np.tile(at, runs)
    host = ready.host
    found = application.assess(
        Motions.of(
            host.position_m[own], speed_mps=host.speed_mps[own], heading_rad=host.heading_rad[own],
            acceleration_mps2=host.acceleration_mps2[own], yaw_rate_radps=host.yaw_rate_radps[own],
        ),
        Motions.of(
            rows[:, :2], speed_mps=rows[:, BELIEF_SPEED], heading_rad=rows[:, BELIEF_HEADING],
            acceleration_mps2=rows[:, BELIEF_ACCELERATION], yaw_rate_radps=rows[:, BELIEF_YAW_RATE],
        ),
    )  # fmt: skip
    warned: BoolArray = np.zeros((runs, ready.counted.size), dtype=np.bool_)
    warned[:, at] = found.warned.reshape(runs, -1)
    return warned


@dataclass(frozen=True, slots=True, eq=False)
class _Runs:
    """What K runs of one pair gave under one condition."""

    missed: IntArray
    delay_s: FloatArray
    false: IntArray
    false_warnings: IntArray


def _scored(ready: _Ready, warned: BoolArray, settings: SafetySettings) -> _Runs:
    """Score one pair's runs, (K, N)."""
    true, misses = ready.true, ready.counted & ready.warned & ~warned
    by_event = np.zeros((true.first.size, warned.shape[0]), dtype=np.int64)
    for run, row in enumerate(misses):
        of = true.event[row]
        by_event[:, run] = np.bincount(of[of >= 0], minlength=true.first.size)
    return _Runs(
        by_event,
        delays_s(true, warned, ready.t_s, grace_s=settings.grace_s),
        (warned & ready.counted & ~ready.warned).sum(axis=1),
        false_warnings(warned, ready.warned, ready.counted, ready.t_s, merge_s=settings.merge_s),
    )


def _senders(
    case: TripCase, candidates: Sequence[FixedCandidate], settings: SafetySettings
) -> dict[str, LeadingSender]:
    """The candidates as senders of one trip."""
    found: dict[str, LeadingSender] = {}
    sensed = sense_trip(case.seen, case.estimator, quantised=settings.evaluation.quantised)
    for candidate in candidates:
        own = candidate.fitted((), settings.evaluation)
        ready, _ = trip_runtimes(case, own, sensed)
        found[candidate.name] = LeadingSender(case, ready, own)
    return found


Condition = tuple[str, Basis, float]
"""Candidate, basis, packet error ratio."""


def _walks(
    senders: Mapping[str, LeadingSender], settings: SafetySettings
) -> dict[Condition, tuple[TripMessages, Spent]]:
    """What every candidate sends over one trip, by condition."""
    names = list(senders)
    budget = names[-1] if settings.budget is None else settings.budget
    threshold_m = settings.evaluation.thresholds_m[0]
    found: dict[Condition, tuple[TripMessages, Spent]] = {}
    for ratio in settings.evaluation.packet_error_ratios:
        model = senders[budget].walked(threshold_m, ratio)
        for name in names:
            for basis in settings.bases:
                if basis == "threshold":
                    own = senders[name].walked(threshold_m, ratio)
                else:
                    own = model if name == budget else senders[name].matched(model[1], basis, ratio)
                found[name, basis, ratio] = own
    return found


def _score_pair(
    ready: _Ready,
    senders: Mapping[str, LeadingSender],
    walks: Mapping[Condition, tuple[TripMessages, Spent]],
    lost: BoolArray,
    settings: SafetySettings,
) -> dict[Condition, _Runs]:
    """Score one pair under every condition; what was sent alike is replayed once."""
    evaluation = settings.evaluation
    found: dict[Condition, _Runs] = {}
    for name, sender in senders.items():
        done: dict[int, _Runs] = {}
        for row, ratio in enumerate(evaluation.packet_error_ratios):
            done.clear()
            for basis in settings.bases:
                walk, _ = walks[name, basis, ratio]
                if id(walk) not in done:
                    replayed = replay(
                        sender.ready,
                        schedules_of([walk]),
                        lost[row],
                        sender.case.truth.position_m,
                        sender.case.direction,
                        delay_s=evaluation.delay_s,
                        expiry_s=np.inf if evaluation.expiry_s is None else evaluation.expiry_s,
                        motions=True,
                    )
                    warned = _warned(settings.application, ready, replayed.motions)
                    done[id(walk)] = _scored(ready, warned, settings)
                found[name, basis, ratio] = done[id(walk)]
    return found


Walked = tuple[Mapping[str, LeadingSender], Mapping[Condition, tuple[TripMessages, Spent]]]
"""The candidates as senders of one leader, and what they send by condition."""


def score_recording(
    recording: Recording,
    candidates: Sequence[FixedCandidate],
    settings: SafetySettings,
    *,
    sensor: str = "",
    walked: dict[int, Walked] | None = None,
) -> RecordingScores:
    """Score all pairs of a recording: every candidate, basis and loss ratio.

    Parameters
    ----------
    recording
        The trips and pairs.
    candidates
        Who sends; no two of one name.
    settings
        Application, losses and sensor; of several thresholds the first.
    sensor
        Name of the sensor, for tables.
    walked
        What an earlier call on this recording found that differed in how messages are lost alone; what this
        one finds is added.
    """
    evaluation = settings.evaluation
    involved = {place for pair in recording.pairs for place in (pair.leader, pair.follower)}
    cases = {place: make_case(recording.trips[place], evaluation) for place in sorted(involved)}
    known = {} if walked is None else walked
    readies: list[_Ready] = []
    runs: list[dict[Condition, _Runs]] = []
    for pair in recording.pairs:
        case = cases[pair.leader]
        if pair.leader not in known:
            own = _senders(case, candidates, settings)
            known[pair.leader] = own, _walks(own, settings)
        senders, sent = known[pair.leader]
        ready = _ready(pair, cases, settings)
        readies.append(ready)
        runs.append(_score_pair(ready, senders, sent, draw_losses(case, evaluation), settings))
    walks = {leader: sent for leader, (_, sent) in known.items()}
    return RecordingScores(
        recording.name,
        sensor,
        evaluation.mean_burst_s,
        pairs=[_names(recording, pair) for pair in recording.pairs],
        counted=np.array([ready.counted.sum() for ready in readies]),
        negatives=np.array([(ready.counted & ~ready.warned).sum() for ready in readies]),
        duration_s=np.array([ready.t_s.size * cases[ready.pair.leader].truth.dt_s for ready in readies]),
        leaders_s=sum(cases[place].truth.duration_s for place in walks),
        event_pair=np.concatenate([np.full(one.true.first.size, at) for at, one in enumerate(readies)]),
        event_s=np.concatenate([one.t_s[one.true.first] for one in readies]),
        positives=np.concatenate([_positives(one) for one in readies]),
        conditions=[_condition(key, runs, [each[key] for each in walks.values()]) for key in runs[0]],
    )


def _names(recording: Recording, pair: FollowingPair) -> PairNames:
    leader, follower = (recording.trips[place].trip_id for place in (pair.leader, pair.follower))
    return PairNames(leader, follower, pair.headway_s)


def _positives(ready: _Ready) -> IntArray:
    """Instants of each true warning that count, (E,)."""
    of = ready.true.event[ready.counted & ready.warned]
    return np.bincount(of, minlength=ready.true.first.size)


def _condition(
    key: Condition,
    runs: Sequence[Mapping[Condition, _Runs]],
    walks: Sequence[tuple[TripMessages, Spent]],
) -> ConditionScores:
    own = [one[key] for one in runs]
    return ConditionScores(
        *key,
        spend=SenderSpend(
            sum(spent.messages for _, spent in walks),
            sum(spent.airtime_s for _, spent in walks),
            tuple(walk.policy.threshold_m for walk, _ in walks),
        ),
        missed=np.concatenate([one.missed for one in own]),
        delay_s=np.concatenate([one.delay_s for one in own]),
        false=np.stack([one.false for one in own]),
        false_warnings=np.stack([one.false_warnings for one in own]),
    )
