"""Pairs scored: closed forms of what a host misses, and what must not change anything."""

from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest

from modelcast.apps.forward_collision import ForwardCollisionWarning
from modelcast.channel.link_record import LinkRecord
from modelcast.channel.recorded import RecordedLosses
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.station.banks import named_bank
from modelcast.study.case import make_case
from modelcast.study.compare.candidate import FixedCandidate
from modelcast.study.safety.film import film_event, telling_event
from modelcast.study.safety.pairs import Recording, recordings_of
from modelcast.study.safety.result import RecordingScores
from modelcast.study.safety.scene import make_scene
from modelcast.study.safety.score import Walked, score_recording
from modelcast.study.safety.settings import SafetySettings
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory
from modelcast.world.named_sensors import named_sensor

CV = FixedCandidate("cv", Bank((ConstantVelocity(),)))
_FREE = named_bank("free")
FREE = FixedCandidate("free", _FREE.bank, _FREE.start, _FREE.identify)
IN_PATH = ForwardCollisionWarning(lane_half_width_m=inf)


def settings(threshold_m: float, *ratios: float, sensor: str = "ideal", **others: object) -> SafetySettings:
    """Settings of one threshold, in two runs."""
    evaluation = EvaluationSettings(
        (threshold_m,), ratios, seeds=2, protocol="sensor", sensor=named_sensor(sensor), references=False
    )
    return SafetySettings(evaluation, IN_PATH, **others)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def recording(platoon: list[Trajectory]) -> Recording:
    (found,) = recordings_of(platoon)
    return found


def missed(scores: RecordingScores, candidate: str, basis: str, ratio: float) -> np.ndarray:
    """Missed instants by event and run."""
    (one,) = (
        c
        for c in scores.conditions
        if (c.candidate, c.basis, c.packet_error_ratio) == (candidate, basis, ratio)
    )
    return one.missed


def test_a_braking_leader_is_a_true_warning_of_every_pair(recording: Recording) -> None:
    scores = score_recording(recording, [CV], settings(0.2, 0.0))
    assert len(scores.pairs) == 2
    assert set(scores.event_pair.tolist()) == {0, 1}
    first = scores.event_s[np.searchsorted(scores.event_pair, 0)]
    assert 29.5 <= first <= 31.5
    assert (scores.counted >= scores.negatives).all()
    assert scores.positives.sum() == (scores.counted - scores.negatives).sum()


def test_who_hears_every_exact_sample_warns_as_perfect_communication_does(recording: Recording) -> None:
    exact = settings(1e-4, 0.0, truth="communication")
    exact = replace(exact, evaluation=replace(exact.evaluation, quantised=False))
    scores = score_recording(recording, [CV], exact)
    (one, *_) = scores.conditions
    # What is left are roundings of Part I's acceleration at the edges of warnings.
    assert one.missed.sum() <= 0.02 * scores.positives.sum() * 2
    assert one.false.sum() <= 0.002 * scores.negatives.sum() * 2
    assert one.delay_s.max() <= 0.1 + 1e-9


def test_where_nothing_arrives_all_is_missed_and_nothing_false(recording: Recording) -> None:
    lost = settings(0.2, 1.0)
    lost = replace(lost, evaluation=replace(lost.evaluation, expiry_s=1.0))
    scores = score_recording(recording, [CV], lost)
    for one in scores.conditions:
        assert np.array_equal(one.missed, np.repeat(scores.positives[:, None], 2, axis=1))
        assert np.isinf(one.delay_s).all()
        assert one.false.sum() == 0
        assert one.false_warnings.sum() == 0


def test_at_equal_airtime_and_messages_rivals_spend_what_the_budget_has(recording: Recording) -> None:
    scores = score_recording(recording, [CV, FREE], settings(0.1, 0.0, 0.4, sensor="default"))
    by = {(c.candidate, c.basis, c.packet_error_ratio): c.spend for c in scores.conditions}
    for ratio in (0.0, 0.4):
        budget = by["free", "airtime", ratio]
        assert by["free", "messages", ratio] == budget == by["free", "threshold", ratio]
        assert by["cv", "airtime", ratio].airtime_s == pytest.approx(budget.airtime_s, rel=0.06)
        assert by["cv", "messages", ratio].messages == pytest.approx(budget.messages, abs=4)
        assert by["cv", "threshold", ratio].thresholds_m == (0.1, 0.1)
        assert by["cv", "threshold", ratio].messages == by["cv", "threshold", 0.0].messages
    assert by["cv", "threshold", 0.0].messages > by["free", "threshold", 0.0].messages


def test_same_seed_same_scores_and_what_was_walked_before_changes_nothing(recording: Recording) -> None:
    asked = settings(0.2, 0.4, sensor="default")
    walked: dict[int, Walked] = {}
    first = score_recording(recording, [CV, FREE], asked, walked=walked)
    bursts = replace(asked, evaluation=replace(asked.evaluation, mean_burst_s=0.5))
    again = score_recording(recording, [CV, FREE], bursts, walked=walked)
    alone = score_recording(recording, [CV, FREE], bursts)
    other = score_recording(recording, [CV, FREE], asked)
    for a, b in ((first, other), (again, alone)):
        for one, two in zip(a.conditions, b.conditions, strict=True):
            assert one.spend == two.spend
            assert np.array_equal(one.missed, two.missed)
            assert np.array_equal(one.delay_s, two.delay_s)
            assert np.array_equal(one.false, two.false)


def recorded(asked: SafetySettings, lost: np.ndarray) -> SafetySettings:
    """The settings with these losses replayed."""
    channel = RecordedLosses((LinkRecord("a hears b", np.pad(lost, 1), period_s=0.1),))
    evaluation = replace(
        asked.evaluation, recorded=channel, packet_error_ratios=(channel.packet_error_ratio,)
    )
    return replace(asked, evaluation=evaluation)


def test_a_log_without_losses_scores_as_a_channel_without(recording: Recording) -> None:
    """After other losses were scored with the same senders, at another ratio."""
    asked = settings(0.2, 0.4, sensor="default")
    walked: dict[int, Walked] = {}
    score_recording(recording, [CV, FREE], asked, walked=walked)
    nothing = recorded(asked, np.zeros(300, dtype=np.bool_))
    logged = score_recording(recording, [CV, FREE], nothing, loss_log="a.csv", walked=walked)
    drawn = score_recording(recording, [CV, FREE], settings(0.2, 0.0, sensor="default"))
    assert logged.kind == ("", None, "a.csv")
    for one, two in zip(logged.conditions, drawn.conditions, strict=True):
        assert (one.candidate, one.basis, one.packet_error_ratio) == (
            two.candidate, two.basis, two.packet_error_ratio,
        )  # fmt: skip
        assert one.spend == two.spend
        assert np.array_equal(one.missed, two.missed)
        assert np.array_equal(one.delay_s, two.delay_s)
        assert np.array_equal(one.false, two.false)


def test_recorded_losses_cost_warnings(recording: Recording) -> None:
    """Nine messages of ten are lost; a sender that takes all to arrive sends as many as without loss."""
    asked = settings(0.3, 0.0, sensor="default")
    lost = np.arange(500) % 10 != 0
    scores = score_recording(recording, [CV], recorded(asked, lost), loss_log="a.csv")
    free = score_recording(recording, [CV], asked)
    (threshold, *_), (without, *_) = scores.conditions, free.conditions
    assert threshold.spend == without.spend
    assert threshold.missed.sum() > 1.5 * without.missed.sum()
    assert scores.mean_burst_s == pytest.approx(0.9, abs=0.01)


def test_losses_cost_warnings(recording: Recording) -> None:
    scores = score_recording(recording, [CV], settings(0.3, 0.0, 0.8, sensor="default"))
    assert missed(scores, "cv", "threshold", 0.8).sum() > 1.5 * missed(scores, "cv", "threshold", 0.0).sum()


def test_film_shows_the_warning_that_was_scored(recording: Recording) -> None:
    asked = settings(0.2, 0.0, 0.4, sensor="default")
    scores = score_recording(recording, [CV, FREE], asked)
    place = telling_event([scores], 0.4, "airtime", ("cv", "free"))
    assert place is not None
    pair = int(scores.event_pair[place[1]])
    event = place[1] - int(np.searchsorted(scores.event_pair, pair))
    film = film_event(recording, recording.pairs[pair], event, [CV, FREE], asked, sensor="default", ratio=0.4)
    assert film.warned[film.begins]
    assert not film.warned[film.begins - 1]
    assert film.t_s[film.begins] == 0.0
    begins, runs = film.begins, int(scores.positives[place[1]])
    counted = np.abs(film.margin_m) < asked.near_m
    for one in film.believers:
        inside = slice(begins, begins + runs + 10)
        own = (film.warned & counted & ~one.warned)[inside].sum()
        assert own >= missed(scores, one.candidate, "airtime", 0.4)[place[1], 0]
        assert (one.lost <= one.sent).all()


def test_settings_refuse_what_cannot_be() -> None:
    cases: tuple[tuple[dict[str, Any], str], ...] = (
        ({"bases": ()}, "bases"),
        ({"bases": ("bytes",)}, "bases"),
        ({"near_m": 0.0}, "near_m"),
        ({"later_m": -1.0}, "later_m"),
        ({"truth": "radar"}, "truth"),
        ({"resamples": 0}, "resamples"),
    )
    for given, told in cases:
        with pytest.raises(ValueError, match=told):
            settings(0.2, 0.0, **given)
    with pytest.raises(ValueError, match="protocol"):
        SafetySettings(EvaluationSettings((0.2,), (0.0,)), IN_PATH)


def test_the_second_after_a_gap_of_the_recording_does_not_count(platoon: list[Trajectory]) -> None:
    gone = np.r_[0:300, 315:600]
    own = platoon[0]
    halved = replace(
        own,
        **{name: value[gone] for name, value in own.columns().items()},
        segments=np.array([0, 300, 585]),
    )
    (recording,) = recordings_of([halved, platoon[1]])
    cases = {at: make_case(trip, settings(0.2, 0.0).evaluation) for at, trip in enumerate(recording.trips)}
    scene = make_scene(recording.pairs[0], cases, settings(0.2, 0.0, near_m=1e6))
    after = (scene.t_s >= 31.5 - 1e-9) & (scene.t_s < 32.5 - 1e-9)
    assert after.sum() == 10
    assert not scene.counted[after].any()
    assert scene.counted[~after].all()


def test_who_warns_later_misses_more_and_warns_wrongly_less(recording: Recording) -> None:
    """Each host warns at a part of the instants at which it would warn otherwise."""
    early, late = (
        score_recording(recording, [CV, FREE], settings(0.2, 0.4, later_m=later_m)) for later_m in (0.0, 3.0)
    )
    assert late.positives.tolist() == early.positives.tolist()
    more = fewer = 0
    for one, other in zip(early.conditions, late.conditions, strict=True):
        assert (other.missed >= one.missed).all()
        assert (other.false <= one.false).all()
        more += int((other.missed > one.missed).sum())
        fewer += int((other.false < one.false).sum())
    assert more > 0
    assert fewer > 0
