"""Claims about the context of recorded trips."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.channel.erasure import IndependentErasure
from modelcast.models.bank import Bank
from modelcast.models.base import Windows
from modelcast.models.context_columns import (
    CONTEXT_COLUMNS,
    LEADER_ACCELERATION,
    LEADER_GAP,
    LEADER_KNOWN,
    LEADER_RELATIVE_SPEED,
    ROAD_KNOWN,
    ROAD_TURN,
)
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.members import ReadyBank
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.models.predicted_path import PredictedPath
from modelcast.models.trusted import Trusted
from modelcast.runtime.trip.context import ContextSettings, TripContexts, trip_context
from modelcast.runtime.trip.runtime import TripRuntime, sense_trip
from modelcast.station.context.survey import survey_roads
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sensing.streaming import with_states
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.study.evaluate import evaluate
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory, build_trajectory

GAP_M = 25.0


def car(number: int, *, clock_s: float = 0.0, name: str = "run") -> Trajectory:
    """A car of a platoon on a straight road, whose speed swings; the first leads by `GAP_M` each."""
    t_s = np.arange(clock_s, 60.0, 0.1)
    east = 15.0 * t_s + 20.0 * np.sin(0.25 * t_s) - GAP_M * number
    speed = 15.0 + 5.0 * np.cos(0.25 * t_s)
    return build_trajectory(
        f"{name}/{number}",
        t_s,
        np.stack([east, np.zeros(t_s.size)], axis=1),
        speed_mps=speed,
        heading_rad=np.full(t_s.size, np.pi / 2),
        acceleration_mps2=-1.25 * np.sin(0.25 * t_s),
        yaw_rate_radps=np.zeros(t_s.size),
        clock_s=clock_s,
    )


def circling(laps: float, *, clock_s: float | None = 0.0, name: str = "laps/1") -> Trajectory:
    """A car on a circle of 100 m at 10 m/s."""
    t_s = np.arange(0.0, laps * 20.0 * np.pi, 0.1)
    position = 100.0 * np.stack([np.sin(0.1 * t_s), np.cos(0.1 * t_s)], axis=1)
    return build_trajectory(name, t_s, position, clock_s=clock_s)


def test_a_follower_knows_the_car_ahead_by_its_messages_and_the_first_knows_nobody() -> None:
    contexts = TripContexts([car(0), car(1), car(2)])
    first, second, third = (contexts.of(which) for which in range(3))
    assert not first[:, : LEADER_KNOWN + 1].any()
    for found in (second, third):
        assert found[10:, LEADER_KNOWN].all()
        # Its belief is off by less than the threshold that its leader sends at, and what it moves till heard.
        np.testing.assert_allclose(found[10:, LEADER_GAP], GAP_M, atol=0.6)
        np.testing.assert_allclose(found[10:, LEADER_RELATIVE_SPEED], 0.0, atol=1.3)
    truth = car(0).acceleration_mps2
    assert truth is not None
    assert np.corrcoef(second[10:, LEADER_ACCELERATION], truth[10:])[0, 1] > 0.9


def test_who_began_later_on_the_clock_is_set_against_the_right_instant() -> None:
    contexts = TripContexts([car(0, clock_s=7.3), car(1), car(2, clock_s=3.1)])
    second, third = contexts.of(1), contexts.of(2)
    known = np.flatnonzero(second[:, LEADER_KNOWN])
    assert known[0] == pytest.approx(74, abs=1)  # 7.3 s, and 0.1 s until it is heard
    np.testing.assert_allclose(second[known, LEADER_GAP], GAP_M, atol=0.6)
    assert third[5:, LEADER_KNOWN].all()
    np.testing.assert_allclose(third[5:, LEADER_GAP], GAP_M, atol=0.6)


def test_what_is_lost_is_not_known_and_the_same_seed_loses_the_same() -> None:
    trips = [car(0), car(1)]
    heard, half, none = (
        TripContexts(trips, ContextSettings(channel=IndependentErasure(ratio))) for ratio in (0.0, 0.5, 1.0)
    )
    assert not none.of(1).any()
    assert half.of(1)[:, LEADER_KNOWN].any()

    def off_m(contexts: TripContexts) -> float:
        found = contexts.of(1)
        known = found[:, LEADER_KNOWN] > 0.0
        return float(np.abs(found[known, LEADER_GAP] - GAP_M).mean())

    assert off_m(half) > 1.2 * off_m(heard)
    again = trip_context(trips, 1, ContextSettings(channel=IndependentErasure(0.5)))
    np.testing.assert_array_equal(half.of(1), again)
    np.testing.assert_array_equal(heard.of(1, IndependentErasure(0.5)), again)


def test_messages_are_late() -> None:
    trips = [car(0), car(1)]
    slow = trip_context(trips, 1, ContextSettings(delay_s=2.0))
    assert np.flatnonzero(slow[:, LEADER_KNOWN])[0] == 20


def test_context_depends_on_the_past_alone() -> None:
    trips = [car(0), car(1)]
    whole = trip_context(trips, 1)
    cut = [
        build_trajectory(
            one.trip_id,
            one.t_s[:300],
            one.position_m[:300],
            speed_mps=one.speed_mps[:300],
            heading_rad=one.heading_rad[:300],
            acceleration_mps2=one.acceleration_mps2[:300],
            yaw_rate_radps=one.yaw_rate_radps[:300],
            clock_s=0.0,
        )
        for one in trips
        if one.speed_mps is not None
        and one.heading_rad is not None
        and one.acceleration_mps2 is not None
        and one.yaw_rate_radps is not None
    ]
    np.testing.assert_array_equal(trip_context(cut, 1), whole[:300])


@pytest.mark.parametrize(
    "other",
    [car(0, name="another"), replace(car(0), clock_s=None), replace(car(0), clock_s=500.0)],
    ids=["another file", "no clock", "another time"],
)
def test_trips_without_a_common_clock_do_not_know_each_other(other: Trajectory) -> None:
    assert not trip_context([other, car(1)], 1)[:, : LEADER_KNOWN + 1].any()


def test_each_part_can_be_left_out() -> None:
    trips = [circling(1.0), circling(0.5, clock_s=100.0, name="laps/2")]
    assert trip_context(trips, 1)[:, ROAD_KNOWN].any()
    assert not trip_context(trips, 1, ContextSettings("none")).any()
    platoon = [car(0), car(1)]
    assert not trip_context(platoon, 1, ContextSettings(leader=False)).any()


def test_a_road_is_remembered_of_trips_that_ended_before_and_of_no_others() -> None:
    before, after = circling(1.0), circling(0.5, clock_s=63.0, name="laps/2")
    found = trip_context([before, after], 1)
    assert found[100, ROAD_KNOWN] == 1.0
    assert found[100, ROAD_TURN] == pytest.approx(0.1, abs=0.01)
    assert not trip_context([before, after], 0).any()
    still_driving = replace(after, clock_s=60.0)
    assert not trip_context([before, still_driving], 1)[:, ROAD_KNOWN].any()


def test_a_survey_tells_other_trips_the_road_and_not_its_own() -> None:
    first, other = circling(1.0, clock_s=None), circling(0.5, clock_s=None, name="elsewhere/1")
    settings = ContextSettings(survey_roads([first]))
    contexts = TripContexts([first, other], settings)
    assert contexts.of(1)[100, ROAD_KNOWN] == 1.0
    assert not contexts.of(0).any()
    seen = replace(first, position_m=first.position_m + 0.01)
    assert not TripContexts([seen], settings, recorded=[first]).of(0).any()


def test_a_sub_model_finds_the_context_in_windows_and_in_what_was_sensed(reader: Bank) -> None:
    model = reader.members[0]
    rows = np.zeros((1, 1, SAMPLE_COLUMNS + CONTEXT_COLUMNS))
    rows[0, 0, 3] = 10.0
    rows[0, 0, SAMPLE_COLUMNS + ROAD_TURN], rows[0, 0, SAMPLE_COLUMNS + ROAD_KNOWN] = 0.25, 1.0
    assert model.fit(Windows(rows, dt_s=0.1))[0, 3] == 0.25
    assert model.fit(Windows(rows[..., :SAMPLE_COLUMNS].copy(), dt_s=0.1))[0, 3] == 0.0
    with pytest.raises(ValueError, match="with context"):
        Windows(rows[..., : SAMPLE_COLUMNS + 2].copy(), dt_s=0.1)
    trip = circling(1.5)
    context = trip_context([trip], 0)
    ready = ReadyBank.of(reader, trip.dt_s)
    assert ready.sample_columns == SAMPLE_COLUMNS + CONTEXT_COLUMNS
    held = with_states(sense_trip(trip, velocity_estimator_for(trip)), ready, context)
    count = len(trip)
    np.testing.assert_array_equal(held.samples[0, :count, SAMPLE_COLUMNS:], context)
    np.testing.assert_array_equal(held.samples[0, count : 2 * count, SAMPLE_COLUMNS:], context)
    with pytest.raises(ValueError, match="context must be"):
        with_states(sense_trip(trip, velocity_estimator_for(trip)), ready, context[:-1])


def test_context_is_found_behind_what_is_wrapped_and_no_bank_pays_that_reads_none(reader: Bank) -> None:
    model = reader.members[0]
    for wrapped in (Trusted(model, 2.0), PredictedPath(model)):
        functions = wrapped.point_functions(0.1)
        assert functions.context_at is not None
        constants = functions.reading_context(7)
        assert np.flatnonzero(constants != functions.addressed).tolist() == [functions.context_at]
    plain = ReadyBank.of(Bank((ConstantTurnRateAcceleration(),)), 0.1)
    assert (plain.reads_context, plain.sample_columns) == (False, SAMPLE_COLUMNS)
    both = ReadyBank.of(Bank((ConstantTurnRateAcceleration(), model)), 0.1)
    assert both.members.constants.tolist() == [SAMPLE_COLUMNS]


def test_a_sender_that_knows_the_road_sends_less_where_the_road_turns(reader: Bank) -> None:
    """On a road of bends the turn ahead is told before the car's own motion shows it."""
    t_s = np.arange(0.0, 120.0, 0.1)
    heading = 0.9 * np.sin(2.0 * np.pi * t_s / 30.0)
    position = np.cumsum(1.5 * np.stack([np.sin(heading), np.cos(heading)], axis=1), axis=0)
    first = build_trajectory("bends/1", t_s, position, clock_s=0.0)
    second = replace(first, trip_id="bends/2", clock_s=200.0)
    context = trip_context([first, second], 1)
    estimator, rule = velocity_estimator_for(second), ErrorDriven(0.5)
    knowing = TripRuntime(second, reader, estimator, context=context).run(rule).updates
    blind = TripRuntime(second, reader, estimator).run(rule).updates
    free = TripRuntime(second, Bank((ConstantTurnRateAcceleration(),)), estimator).run(rule).updates
    assert blind == free
    assert knowing < 0.8 * blind


def test_an_evaluation_lets_a_bank_know_what_its_settings_say(reader: Bank) -> None:
    trips = [car(0), car(1)]
    asked = EvaluationSettings(
        (0.3,), (0.0, 1.0 / 3.0), seeds=2, bank=reader, identify="never", start="order", references=False
    )
    blind = replace(asked, context=ContextSettings("none", leader=False))
    knows, does_not = (
        {row.packet_error_ratio: row for row in evaluate(trips, one).tracking if row.trip == "run/1"}
        for one in (asked, blind)
    )
    assert set(knows) == {0.0, 1.0 / 3.0}
    assert knows != does_not
    assert asked.as_plain()["context"]["road"] == "own"
