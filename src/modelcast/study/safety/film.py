"""One true warning from up close: what was sent and lost, and what the host believed under each sender."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.apps.motions import Motions
from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.runtime.trip.replay import replay, schedules_of
from modelcast.station.receiver.belief_kernels import BELIEF_COLUMNS
from modelcast.study.case import make_case
from modelcast.study.compare.candidate import FixedCandidate
from modelcast.study.safety.pairs import FollowingPair, Recording
from modelcast.study.safety.result import RecordingScores
from modelcast.study.safety.scene import assess_believed, make_scene
from modelcast.study.safety.score import sent_by
from modelcast.study.safety.settings import SafetySettings
from modelcast.study.tracking import draw_losses

__all__ = ["Believer", "EventFilm", "film_event", "telling_event"]

BEFORE_S, AFTER_S = 4.0, 3.0
"""Time that a film shows before a warning begins and after [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Believer:
    """What the host makes of one sender, at the film's N instants.

    Parameters
    ----------
    candidate
        Who sends.
    motion
        How the leader is believed to move, (N, BELIEF_COLUMNS); NaN where nothing is held.
    margin_m
        The application's margin by that, (N,) [m].
    warned
        Whether the host warns, (N,).
    sent, lost
        Whether a message was sent, and whether it was lost, (N,).
    """

    candidate: str
    motion: FloatArray
    margin_m: FloatArray
    warned: BoolArray
    sent: BoolArray
    lost: BoolArray


@dataclass(frozen=True, slots=True, eq=False)
class EventFilm:
    """One true warning.

    Parameters
    ----------
    leader, follower
        Identifiers of their trips.
    sensor, packet_error_ratio, basis
        Under which conditions.
    begins
        Instant of the film at which the warning begins.
    t_s
        Instants, from the warning on, (N,) [s].
    host, leader_motion
        How both truly move.
    margin_m, warned
        What perfect knowledge gives, (N,).
    believers
        The candidates.
    """

    leader: str
    follower: str
    _: KW_ONLY
    sensor: str
    packet_error_ratio: float
    basis: str
    begins: int
    t_s: FloatArray
    host: Motions
    leader_motion: Motions
    margin_m: FloatArray
    warned: BoolArray
    believers: Sequence[Believer]


def telling_event(
    scores: Sequence[RecordingScores], ratio: float, basis: str, names: tuple[str, str]
) -> tuple[int, int] | None:
    """The warning in whose first run two candidates differ most, as places of recording and event.

    Parameters
    ----------
    scores
        Of one sensor and kind of loss.
    ratio, basis
        Under which conditions.
    names
        Both candidates: the second is hoped to miss less.

    Returns
    -------
    tuple of int or None
        None where there is no true warning.
    """
    best: tuple[int, int] | None = None
    most = -np.inf
    for at, one in enumerate(scores):
        missed = {
            condition.candidate: condition.missed[:, 0]
            for condition in one.conditions
            if (condition.packet_error_ratio, condition.basis) == (ratio, basis)
        }
        gained = missed[names[0]] - missed[names[1]]
        for event, gain in enumerate(gained.tolist()):
            if gain > most:
                best, most = (at, event), gain
    return best


def film_event(
    recording: Recording,
    pair: FollowingPair,
    event: int,
    candidates: Sequence[FixedCandidate],
    settings: SafetySettings,
    *,
    sensor: str,
    ratio: float,
) -> EventFilm:
    """Film a pair's warning, in the first run.

    Parameters
    ----------
    recording, pair
        Whose.
    event
        Which of the pair's true warnings.
    candidates, settings
        As for `score_recording`; of the bases the last counts.
    sensor
        Name of the sensor.
    ratio
        One of the settings' packet error ratios.
    """
    places = (pair.leader, pair.follower)
    cases = {place: make_case(recording.trips[place], settings.evaluation) for place in places}
    scene = make_scene(pair, cases, settings)
    senders, sent = sent_by(cases[pair.leader], candidates, settings)
    row = settings.evaluation.packet_error_ratios.index(ratio)
    lost = draw_losses(cases[pair.leader], settings.evaluation)[row, :1]
    starts_s = scene.t_s[scene.true.first[event]]
    at = np.flatnonzero((scene.t_s >= starts_s - BEFORE_S) & (scene.t_s <= starts_s + AFTER_S))
    basis, samples = settings.bases[-1], pair.samples[at]
    believers: list[Believer] = []
    for name, sender in senders.items():
        walk, _ = sent[name, basis, ratio]
        truth = sender.case.truth
        moves = replay(
            sender.ready, schedules_of([walk]), lost, truth.position_m, sender.case.direction,
            delay_s=settings.evaluation.delay_s, motions=True,
        ).motions  # fmt: skip
        found = assess_believed(settings.application, scene, moves, at)
        motion = moves[0, samples].reshape(-1, BELIEF_COLUMNS)
        speaks = walk.transmits[samples]
        believers.append(
            Believer(name, motion, found.margin_m, settings.warned(found), speaks, speaks & lost[0, samples])
        )
    return EventFilm(
        recording.trips[pair.leader].trip_id,
        recording.trips[pair.follower].trip_id,
        sensor=sensor,
        packet_error_ratio=ratio,
        basis=basis,
        begins=int(np.searchsorted(scene.t_s[at], starts_s)),
        t_s=scene.t_s[at] - starts_s,
        host=_rows(scene.right_host, at),
        leader_motion=_rows(scene.right_remote, at),
        margin_m=scene.margin_m[at],
        warned=scene.warned[at],
        believers=believers,
    )


def _rows(motions: Motions, at: np.ndarray[tuple[int], np.dtype[np.int64]]) -> Motions:
    return Motions.of(
        motions.position_m[at], speed_mps=motions.speed_mps[at], heading_rad=motions.heading_rad[at],
        acceleration_mps2=motions.acceleration_mps2[at], yaw_rate_radps=motions.yaw_rate_radps[at],
    )  # fmt: skip
