"""Claims about who goes on under another temporary id: exactly at each bound, worked out by hand."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from modelcast.models.bank import Bank
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.station.receiver.heard import Heard, HeardKind
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap, MapState, Receipt

AROUND = LocalDynamicMap((Bank((ConstantTurnRateAcceleration(),)),))
EAST_RAD, WEST_RAD = 0.5 * math.pi, 1.5 * math.pi
FAR_M = 900.0


@dataclass(frozen=True)
class Said:
    """A message of a car that goes east; by a model that accelerates, or by Part I."""

    vehicle: int
    t_s: float
    east_m: float
    speed_mps: float = 20.0
    received_s: float | None = None
    """None for at once."""
    heading_rad: float = EAST_RAD
    acceleration_mps2: float | None = None
    """Of the model; None for a plain message."""
    model_mps: float | None = None
    """Its speed; None for the one stated."""


def course_of(one: Said) -> tuple[float, float]:
    """Velocity that its model begins with."""
    return (one.speed_mps if one.model_mps is None else one.model_mps, 0.0)


def heard(*said: Said) -> Heard:
    """The messages in this order."""
    count = len(said)
    unknown, models = np.full(count, np.nan), [one.acceleration_mps2 for one in said]
    return Heard(
        np.array([HeardKind.PLAIN if one is None else HeardKind.UPDATE for one in models], dtype=np.int64),
        np.array([one.vehicle for one in said]),
        np.zeros(count, dtype=np.int64),
        t_s=np.array([one.t_s for one in said]),
        received_s=np.array([one.t_s if one.received_s is None else one.received_s for one in said]),
        position_m=np.array([[one.east_m, 0.0] for one in said]),
        speed_mps=np.array([one.speed_mps for one in said]),
        heading_rad=np.array([one.heading_rad for one in said]),
        acceleration_mps2=unknown,
        yaw_rate_radps=unknown,
        profile=np.array([-1 if one is None else 0 for one in models]),
        in_use=np.zeros(count, dtype=np.int64),
        parameters=np.array([[*course_of(one), one.acceleration_mps2 or 0.0, 0.0] for one in said]),
        length_m=unknown,
        width_m=unknown,
        user=np.full(count, -1),
    )


def after(*batches: tuple[Said, ...], around: LocalDynamicMap = AROUND) -> MapState:
    """All batches are accepted, each in one call."""
    state = around.init()
    for batch in batches:
        receipts, state = around.hear(state, heard(*batch))
        assert set(receipts.tolist()) == {Receipt.ACCEPTED}
    return state


def held(state: MapState, t_s: float, around: LocalDynamicMap = AROUND) -> list[int]:
    """Ids held at that time; each that is gone was counted as renamed."""
    return around.positions(state, t_s)[0].tolist()


def test_the_age_is_from_fit_to_instant_however_late_the_new_id_arrives() -> None:
    """0.2 s old when the new id speaks, 3.5 s when that arrives."""
    state = after((Said(1, 10.0, 0.0),), (Said(2, 10.2, 4.0, received_s=13.5),))
    assert (held(state, 13.5), state.renamed) == ([2], 1)


def test_the_age_is_from_fit_to_instant_however_late_the_track_arrived() -> None:
    """The track's own message took a second: it arrived after the instant of the new id's."""
    state = after((Said(1, 10.0, 0.0, received_s=11.0),), (Said(2, 10.8, 16.0, received_s=11.1),))
    assert (held(state, 11.1), state.renamed) == ([2], 1)


def test_silence_is_from_arrival_to_arrival() -> None:
    """0.9 s lie between the two instants, 0.02 s between the arrivals: two vehicles."""
    state = after((Said(1, 10.0, 0.0, received_s=11.0),), (Said(2, 10.9, 18.0, received_s=11.02),))
    assert (held(state, 11.1), state.renamed) == ([1, 2], 0)


@pytest.mark.parametrize(("received_s", "renamed"), [(0.05, 1), (0.0499, 0)])
def test_silence_of_just_the_bound_is_enough(received_s: float, renamed: int) -> None:
    state = after((Said(1, 0.0, 0.0),), (Said(2, 0.0, 0.0, received_s=received_s),))
    assert state.renamed == renamed


def test_a_track_that_expired_before_the_new_id_arrived_ends_no_more() -> None:
    """At the new id's instant it was 0.3 s old, at its arrival 0.7 s; 0.5 s is the end."""
    around = LocalDynamicMap((), 0.5)
    for received_s, renamed in ((10.45, 1), (10.7, 0)):
        state = after((Said(1, 10.0, 0.0),), (Said(2, 10.3, 6.0, received_s=received_s),), around=around)
        assert state.renamed == renamed


@pytest.mark.parametrize(
    ("age_s", "renamed"), [(0.0, 1), (3.0, 1), (math.nextafter(3.0, 4.0), 0)], ids=["none", "most", "more"]
)
def test_ages_up_to_three_seconds_count_both_ends_included(age_s: float, renamed: int) -> None:
    state = after((Said(1, 0.0, 0.0, 0.0),), (Said(2, age_s, 0.0, 0.0, received_s=age_s + 0.1),))
    assert state.renamed == renamed


def test_at_just_two_metres_a_second_there_is_no_course() -> None:
    """The new id's velocity is exactly so; a track at 4 m/s the other way goes on as it."""
    for speed_mps, renamed in ((2.0, 1), (math.nextafter(2.0, 3.0), 0)):
        news = Said(2, 10.1, 0.0, speed_mps, heading_rad=0.0)
        assert math.hypot(speed_mps * math.sin(0.0), speed_mps * math.cos(0.0)) == speed_mps
        state = after((Said(1, 10.0, 0.0, 4.0, heading_rad=math.pi),), (news,))
        assert state.renamed == renamed


def test_courses_may_differ_by_just_the_bound() -> None:
    """The cosine of the angle between is 0.866 in floating point too, one heading on it is not."""
    heading = math.asin(0.866)
    assert 4.0 * math.sin(heading) == 0.866 * 4.0
    for heading_rad, renamed in ((heading, 1), (heading - 1e-9, 0)):
        new = Said(2, 0.0, 0.0, 4.0, received_s=0.1, heading_rad=heading_rad)
        assert after((Said(1, 0.0, 0.0, 4.0),), (new,)).renamed == renamed


def test_the_track_s_speed_is_that_of_its_next_twentieth_of_a_second() -> None:
    """It gains 8 m/s²: over 0.05 s the mean is 0.2 m/s above the speed at the instant."""
    for slower_mps, renamed in ((2.9, 1), (3.1, 0)):
        new = Said(2, 11.0, 24.0, 28.2 - slower_mps)
        state = after((Said(1, 10.0, 0.0, acceleration_mps2=8.0),), (new,))
        assert state.renamed == renamed


@pytest.mark.parametrize(("acceleration_mps2", "renamed"), [(11.4, 1), (11.6, 0)])
@pytest.mark.parametrize("start_s", [10.0, -1.0, -100.0])
def test_no_model_takes_a_vehicle_farther_than_10_mps2_and_the_place_s_bound(
    acceleration_mps2: float, renamed: int, start_s: float
) -> None:
    """Two seconds on it may be 20 m + 3 m from where it coasts: by 11.5 m/s² it would just be."""
    ahead_m = 40.0 + 2.0 * acceleration_mps2
    new = Said(2, start_s + 2.0, ahead_m, 20.0 + 2.0 * acceleration_mps2)
    state = after((Said(1, start_s, 0.0, acceleration_mps2=acceleration_mps2),), (new,))
    assert state.renamed == renamed
    late = Said(2, start_s + 2.0, ahead_m, 20.0 + 2.0 * acceleration_mps2, received_s=start_s + 2.5)
    state = after((Said(1, start_s, 0.0, acceleration_mps2=acceleration_mps2),), (late,))
    assert state.renamed == renamed


@pytest.mark.parametrize(("acceleration_mps2", "renamed"), [(11.4, 1), (11.6, 0)])
def test_the_bound_widens_by_half_the_way_between_the_first_and_the_last_new_id(
    acceleration_mps2: float, renamed: int
) -> None:
    """Another new id far away, 1 s earlier: coasting is to the middle, 10 m from either end at 20 m/s."""
    other = Said(3, 11.0, FAR_M)
    new = Said(2, 12.0, 40.0 + 2.0 * acceleration_mps2, 20.0 + 2.0 * acceleration_mps2)
    for batch in ((other, new), (other, new, Said(4, 12.0, -FAR_M))):
        state = after((Said(1, 10.0, 0.0, acceleration_mps2=acceleration_mps2),), batch)
        assert state.renamed == renamed


@pytest.mark.parametrize("start_s", [10.0, -100.0])
def test_a_fast_car_is_found_at_the_end_of_a_long_call(start_s: float) -> None:
    """At 60 m/s half of 0.4 s is 12 m, and 10 m/s² over 0.46 s are 1 m."""
    other, new = Said(3, start_s + 0.06, FAR_M, 0.0), Said(2, start_s + 0.46, 27.6, 60.0)
    assert after((Said(1, start_s, 0.0, 60.0),), (other, new)).renamed == 1


@pytest.mark.parametrize(("place_m", "renamed"), [(23.0, 1), (math.nextafter(23.0, 24.0), 0)])
def test_at_the_bound_of_what_it_can_reach_it_is_still_compared(place_m: float, renamed: int) -> None:
    """It stands by what it states. By its model it went 2 m + 20 m, and the new id is 1 m farther: 23 m."""
    old = Said(1, 0.0, 0.0, 0.0, acceleration_mps2=10.0, model_mps=1.0)
    assert after((old,), (Said(2, 2.0, place_m, 21.0),)).renamed == renamed


def test_of_two_new_ids_as_near_the_first_takes_a_track_s_place() -> None:
    """Both are 1 m from track 1. The first is nearer to track 5, whose place it takes: 1 stays."""
    tracks = (Said(1, 0.0, 0.0, 0.0), Said(5, 0.0, -1.5, 0.0))
    first, second = Said(2, 1.0, -1.0, 0.0), Said(3, 1.0, 1.0, 0.0)
    state = after(tracks, (first, second))
    assert (held(state, 1.0), state.renamed) == ([1, 2, 3], 1)
    state = after(tracks, (second, first))
    assert (held(state, 1.0), state.renamed) == ([2, 3], 2)


def test_of_two_tracks_as_near_the_one_held_longer_ends() -> None:
    for first, second in ((1, 5), (5, 1)):
        tracks = (Said(first, 0.0, -1.0, 0.0), Said(second, 0.0, 1.0, 0.0))
        state = after(tracks, (Said(2, 1.0, 0.0, 0.0),))
        assert (held(state, 1.0), state.renamed) == (sorted([2, second]), 1)
