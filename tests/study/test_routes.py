"""Claims about which trips share a route."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.exceptions import ConfigError
from modelcast.core.geodesy import Origin
from modelcast.io.trips import read_trips
from modelcast.study.routes import CELL_M, ground_cells, route_names, routes
from modelcast.trips.trajectory import Trajectory, build_trajectory

HOME = Origin(47.0, 19.0)
AWAY = Origin(47.1, 19.0, 200.0)  # 11 km further north


def straight(
    name: str,
    origin: Origin | None = HOME,
    *,
    start_m: tuple[float, float] = (0.0, 0.0),
    heading_rad: float = 0.7,
    count: int = 400,
) -> Trajectory:
    """A drive of 2 m a sample along a straight line."""
    t_s = 0.1 * np.arange(count)
    along = np.stack([np.sin(heading_rad) * 20.0 * t_s, np.cos(heading_rad) * 20.0 * t_s], axis=1)
    return build_trajectory(name, t_s, along + np.asarray(start_m), origin=origin)


def test_the_same_road_is_one_route_in_whichever_frame_it_is_given() -> None:
    other_frame = replace(straight("b/1", AWAY), position_m=straight("b/1").position_m - [0.0, 11_118.0])
    far = straight("c/1", AWAY)
    assert routes([straight("a/1"), other_frame, far]).tolist() == [0, 0, 1]


@given(st.floats(-80.0, 80.0), st.floats(-180.0, 180.0), st.floats(0.0, 6.3), st.floats(-6.0, 6.0))
def test_two_lanes_are_one_route_anywhere_on_earth(
    latitude_deg: float, longitude_deg: float, heading_rad: float, aside_m: float
) -> None:
    at = Origin(latitude_deg, longitude_deg)
    one = straight("a/1", at, heading_rad=heading_rad)
    beside = straight("b/1", at, heading_rad=heading_rad, start_m=(aside_m, -aside_m))
    away = straight("c/1", at, heading_rad=heading_rad, start_m=(2500.0, 2500.0))
    assert routes([one, beside, away]).tolist() == [0, 0, 1]


def test_a_crossing_does_not_join_two_roads() -> None:
    one = straight("a/1", heading_rad=0.0, count=2000)
    across = straight("b/1", heading_rad=np.pi / 2, start_m=(-2000.0, 2000.0), count=2000)
    assert routes([one, across]).tolist() == [0, 1]


def test_sharing_is_handed_on() -> None:
    first = straight("a/1", heading_rad=0.0)
    second = straight("b/1", heading_rad=0.0, start_m=(0.0, 600.0))
    third = straight("c/1", heading_rad=0.0, start_m=(0.0, 1200.0))
    assert routes([first, third]).tolist() == [0, 1]
    assert routes([first, third, second]).tolist() == [0, 0, 0]


def test_a_platoon_stays_together_where_places_are_unknown() -> None:
    trips = [straight("p/1", None), straight("q/1", None), straight("p/2", None)]
    assert routes(trips).tolist() == [0, 1, 0]
    assert route_names(trips, routes(trips)) == ["p", "q/1"]


def test_a_platoon_stays_together_though_its_cars_drive_apart() -> None:
    """Two cars of one file start side by side in directions at a right angle: their bounds meet."""
    north, east = straight("p/1", heading_rad=0.0), straight("p/2", heading_rad=np.pi / 2)
    assert routes([north, east]).tolist() == [0, 0]
    assert routes([north, replace(east, trip_id="q/2")]).tolist() == [0, 1]


def test_one_file_is_kept_apart_by_place_or_by_absolute_time() -> None:
    assert routes([straight("p/1"), straight("p/2", AWAY)]).tolist() == [0, 1]
    early, late = (replace(straight("p/1", None), start_unix_s=start_s) for start_s in (0.0, 1e4))
    assert routes([early, replace(late, trip_id="p/2")]).tolist() == [0, 1]
    assert routes([early, replace(late, trip_id="p/2", start_unix_s=20.0)]).tolist() == [0, 0]


def test_a_user_can_say_file_or_trip() -> None:
    trips = [straight("p/1"), straight("p/2", AWAY), straight("q/1")]
    assert routes(trips, "file").tolist() == [0, 0, 1]
    assert routes(trips, "trip").tolist() == [0, 1, 2]
    with pytest.raises(ConfigError, match="auto, file or trip"):
        routes(trips, "road")  # type: ignore[arg-type]


def test_ground_is_counted_once_however_often_it_is_driven() -> None:
    """A kilometre and a half in cells of 40 m, in one frame or none; other files add theirs."""
    t_s = np.arange(0.0, 50.0, 0.1)
    line = np.column_stack([30.0 * t_s, np.full(t_s.size, 10.0)])
    once = build_trajectory("a/1", t_s, line)
    again = build_trajectory("a/2", t_s, line[::-1])
    other = build_trajectory("b/1", t_s, line)
    assert ground_cells([once]) == ground_cells([once, again]) == 38
    assert ground_cells([once, other]) == 76
    placed = [replace(trip, origin=Origin(48.0, 11.0, 500.0)) for trip in (once, again, other)]
    assert ground_cells(placed) == ground_cells(placed[:1]) >= 38
    assert ground_cells([]) == 0


def test_no_trips_have_no_routes() -> None:
    assert routes([]).size == 0


def gap_m(one: Trajectory, other: Trajectory) -> float:
    """Least distance between two trips whose origins lie a few kilometres apart."""
    assert one.origin is not None
    assert other.origin is not None
    north_m = np.deg2rad(other.origin.latitude_deg - one.origin.latitude_deg) * 6.37e6
    east_m = np.deg2rad(other.origin.longitude_deg - one.origin.longitude_deg) * 6.37e6
    east_m *= np.cos(np.deg2rad(one.origin.latitude_deg))
    placed = other.position_m[::5] + np.array([east_m, north_m])
    return float(np.hypot(*(one.position_m[::5, None] - placed).transpose(2, 0, 1)).min())


@pytest.mark.real
def test_the_proving_ground_has_two_courses(data_folder: Path) -> None:
    """Three files of the handling course and two of the dynamic platform, and no ground in common."""
    trips: Sequence[Trajectory] = list(read_trips(data_folder / "openacc_zalazone"))
    route = routes(trips)
    assert route.max() == 1
    for number, course, count in ((0, "dynamic", 18), (1, "handling", 27)):
        members = [trip for trip, own in zip(trips, route, strict=True) if own == number]
        assert len(members) == count
        assert all(course in trip.trip_id for trip in members)
    assert gap_m(trips[0], trips[-1]) > 2 * CELL_M
