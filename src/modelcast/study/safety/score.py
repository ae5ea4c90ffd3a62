"""Pairs of one recording scored: what hosts warn of, against perfect knowledge."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.runtime.trip.replay import replay, schedules_of
from modelcast.runtime.trip.runtime import TripMessages, sense_trip
from modelcast.station.banks import BASELINE_BANK
from modelcast.study.case import TripCase, make_case
from modelcast.study.compare.candidate import FixedCandidate
from modelcast.study.context import trip_runtimes
from modelcast.study.safety.events import delays_s, false_warnings
from modelcast.study.safety.pairs import FollowingPair, Recording
from modelcast.study.safety.result import ConditionScores, PairNames, RecordingScores, SenderSpend
from modelcast.study.safety.rules import Basis
from modelcast.study.safety.scene import Scene, assess_believed, make_scene
from modelcast.study.safety.senders import LeadingSender, Spent
from modelcast.study.safety.settings import SafetySettings
from modelcast.study.tracking import draw_losses

__all__ = ["Walked", "score_recording", "sent_by"]


def _warned(settings: SafetySettings, scene: Scene, motions: FloatArray) -> BoolArray:
    """Where hosts warn that believe the leader to move like this, (R, T, 8) at its samples; (R, N)."""
    at = np.flatnonzero(scene.counted)
    found = assess_believed(settings.application, scene, motions, at)
    warned: BoolArray = np.zeros((motions.shape[0], scene.counted.size), dtype=np.bool_)
    warned[:, at] = settings.warned(found).reshape(motions.shape[0], -1)
    return warned


@dataclass(frozen=True, slots=True, eq=False)
class _Runs:
    """What K runs of one pair gave under one condition."""

    missed: IntArray
    delay_s: FloatArray
    false: IntArray
    false_warnings: IntArray


def _scored(scene: Scene, warned: BoolArray, settings: SafetySettings) -> _Runs:
    """Score one pair's runs, (K, N)."""
    misses = scene.counted & scene.warned & ~warned
    return _Runs(
        np.stack([scene.true.instants(row) for row in misses], axis=1),
        delays_s(scene.true, warned, scene.t_s, grace_s=settings.grace_s),
        (warned & scene.counted & ~scene.warned).sum(axis=1),
        false_warnings(warned, scene.warned, scene.counted, scene.t_s, merge_s=settings.merge_s),
    )


def _senders(
    case: TripCase, candidates: Sequence[FixedCandidate], settings: SafetySettings
) -> dict[str, LeadingSender]:
    """The candidates as senders of one trip; the baseline is error-driven whoever decides for the others."""
    found: dict[str, LeadingSender] = {}
    sensed = sense_trip(case.seen, case.estimator, quantised=settings.evaluation.quantised)
    for candidate in candidates:
        own = candidate.fitted((), settings.evaluation)
        if own.bank.members == BASELINE_BANK.members:
            own = replace(own, decides=None, decided_by="")
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
    scene: Scene,
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
                    warned = _warned(settings, scene, replayed.motions)
                    done[id(walk)] = _scored(scene, warned, settings)
                found[name, basis, ratio] = done[id(walk)]
    return found


Walked = tuple[Mapping[str, LeadingSender], Mapping[Condition, tuple[TripMessages, Spent]]]
"""The candidates as senders of one leader, and what they send by condition."""


def sent_by(case: TripCase, candidates: Sequence[FixedCandidate], settings: SafetySettings) -> Walked:
    """The candidates as senders of one leader, and what they send by candidate, basis and loss ratio.

    Parameters
    ----------
    case
        The leader's trip.
    candidates, settings
        As for `score_recording`.
    """
    own = _senders(case, candidates, settings)
    return own, _walks(own, settings)


def score_recording(
    recording: Recording,
    candidates: Sequence[FixedCandidate],
    settings: SafetySettings,
    *,
    sensor: str = "",
    loss_log: str = "",
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
    loss_log
        Name of the log whose losses the settings replay.
    walked
        What an earlier call on this recording found that differed in how messages are lost alone; what this
        one finds is added.
    """
    evaluation = settings.evaluation
    involved = {place for pair in recording.pairs for place in (pair.leader, pair.follower)}
    cases = {place: make_case(recording.trips[place], evaluation) for place in sorted(involved)}
    known = {} if walked is None else walked
    wanted = list(product(settings.bases, evaluation.packet_error_ratios))
    scenes: list[Scene] = []
    runs: list[dict[Condition, _Runs]] = []
    for pair in recording.pairs:
        case = cases[pair.leader]
        if pair.leader not in known:
            known[pair.leader] = sent_by(case, candidates, settings)
        senders, sent = known[pair.leader]
        if not all((name, basis, ratio) in sent for name in senders for basis, ratio in wanted):
            sent = {**sent, **_walks(senders, settings)}
            known[pair.leader] = senders, sent
        scene = make_scene(pair, cases, settings)
        scenes.append(scene)
        runs.append(_score_pair(scene, senders, sent, draw_losses(case, evaluation), settings))
    walks = {leader: sent for leader, (_, sent) in known.items()}
    return RecordingScores(
        recording.name,
        sensor,
        evaluation.mean_burst_s if evaluation.recorded is None else evaluation.recorded.mean_burst_s,
        pairs=[_names(recording, pair) for pair in recording.pairs],
        counted=np.array([scene.counted.sum() for scene in scenes]),
        negatives=np.array([(scene.counted & ~scene.warned).sum() for scene in scenes]),
        duration_s=np.array([scene.t_s.size * cases[scene.pair.leader].truth.dt_s for scene in scenes]),
        leaders_s=sum(cases[place].truth.duration_s for place in walks),
        event_pair=np.concatenate([np.full(one.true.first.size, at) for at, one in enumerate(scenes)]),
        event_s=np.concatenate([one.t_s[one.true.first] for one in scenes]),
        positives=np.concatenate([one.true.instants(one.counted & one.warned) for one in scenes]),
        conditions=[_condition(key, runs, [each[key] for each in walks.values()]) for key in runs[0]],
        loss_log=loss_log,
    )


def _names(recording: Recording, pair: FollowingPair) -> PairNames:
    leader, follower = (recording.trips[place].trip_id for place in (pair.leader, pair.follower))
    return PairNames(leader, follower, pair.headway_s)


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
