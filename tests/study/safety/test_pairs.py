"""Who follows whom is found from where vehicles were and when."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.core.exceptions import ConfigError
from modelcast.study.safety.pairs import following_pairs, instants_together, recordings_of
from modelcast.trips.trajectory import Trajectory

from .conftest import HEADWAY_S, follower_of


def test_order_and_headway_of_a_platoon_on_a_winding_road(platoon: list[Trajectory]) -> None:
    pairs = following_pairs([platoon[2], platoon[0], platoon[1]])
    assert sorted((pair.leader, pair.follower) for pair in pairs) == [(1, 2), (2, 0)]
    assert all(abs(pair.headway_s - HEADWAY_S) <= 0.25 for pair in pairs)
    assert all(pair.samples.size == 600 for pair in pairs)


def test_who_drives_elsewhere_or_another_time_follows_nobody(platoon: list[Trajectory]) -> None:
    aside = replace(
        platoon[0], trip_id="made/aside", position_m=platoon[0].position_m + np.array([0.0, 20.0])
    )
    later = replace(follower_of("made/later", 0.0), clock_s=500.0)
    back = replace(platoon[0], trip_id="made/back", position_m=np.array([900.0, 3.5]) - platoon[0].position_m)
    pairs = following_pairs([*platoon, aside, later, back])
    assert sorted((pair.leader, pair.follower) for pair in pairs) == [(0, 1), (1, 2)]


def test_platoons_of_one_file_are_recordings_of_their_own(platoon: list[Trajectory]) -> None:
    others = [
        replace(trip, trip_id=f"{trip.trip_id}2", position_m=trip.position_m + np.array([0.0, 500.0]))
        for trip in platoon
    ]
    found = recordings_of([*platoon, *others])
    assert [len(one.trips) for one in found] == [3, 3]
    assert [one.name for one in found] == ["made/b", "made/b2"]
    assert all(
        {one.trips[pair.leader].trip_id[-1] == "2" for pair in one.pairs} == {number == 1}
        for number, one in enumerate(found)
    )


def test_instants_are_those_inside_a_gapless_part_of_the_follower(platoon: list[Trajectory]) -> None:
    gone = np.r_[0:200, 230:600]
    own = platoon[1]
    columns = {name: value[gone] for name, value in own.columns().items()}
    halved = replace(own, **columns, segments=np.array([0, 200, 570]), dt_s=own.dt_s)
    samples, (at, share) = instants_together(platoon[0], halved, 0.04)
    t_s = platoon[0].t_s[samples] - 0.04
    assert samples.min() == 1
    assert not ((t_s > 19.9 + 1e-9) & (t_s < 23.0)).any()
    assert np.allclose(halved.t_s[at] + share * 0.1, t_s)


@pytest.mark.parametrize(
    ("trips", "told"),
    [
        ([follower_of("made/a", 0.0)], "one trip has nobody ahead"),
        (
            [follower_of("made/a", 0.0), replace(follower_of("made/b", 1.0), clock_s=None)],
            "made/b and 0 more of the 2 trips state no common clock",
        ),
        (
            [follower_of("made/a", 0.0), replace(follower_of("made/b", 1.0), clock_s=155.0)],
            "recorded together for 10 s",
        ),
        (
            [
                follower_of("made/a", 0.0),
                replace(follower_of("made/b", 1.0), position_m=follower_of("made/b", 1.0).position_m + 80.0),
            ],
            "no vehicle follows another",
        ),
    ],
)
def test_trips_without_pairs_are_told_why(trips: list[Trajectory], told: str) -> None:
    with pytest.raises(ConfigError, match=told):
        following_pairs(trips)
