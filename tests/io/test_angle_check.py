"""Claims about angles of tables: degrees that cannot be are refused, all that can be are read."""

import math

import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io.trips import read_trips
from modelcast.trips.trajectory import MAX_HEADING_RAD, build_trajectory


def _place(latitude: float, longitude: float, rows: int = 5) -> str:
    lines = [f"{k / 10},{latitude + 1e-6 * k:.8f},{longitude:.8f}" for k in range(rows)]
    return "\n".join(["t_s,lat,lon", *lines]) + "\n"


@pytest.mark.parametrize(
    ("latitude", "longitude"),
    [
        (42.3, -83.7),
        (-77.85, 166.7),  # a road to McMurdo
        (-54.8, -68.3),  # Ushuaia
        (1.29, 103.85),  # Singapore
        (5.55, -0.2),  # Accra
        (0.33, 6.73),  # São Tomé
        (0.0, 0.0),  # not known
        (51.5, 0.0),  # Greenwich
    ],
)
def test_places_with_roads_are_read(latitude: float, longitude: float, made) -> None:
    assert len(read_trips(made.write("a.csv", _place(latitude, longitude)))[0]) == 5


@pytest.mark.parametrize(
    ("latitude", "longitude", "problem", "remedy"),
    [
        (-83.7, 42.3, "south of all roads", "lat=lon,lon=lat"),
        (139.7, 35.7, "beyond 90", "lat=lon,lon=lat"),
        (423000000.0, -837000000.0, "beyond 90", "Correct the value"),
        (math.radians(42.3), math.radians(-83.7), "at sea", "180 / pi"),
        (math.radians(-33.9), math.radians(151.2), "at sea", "180 / pi"),
    ],
)
def test_places_without_are_refused(
    latitude: float, longitude: float, problem: str, remedy: str, made
) -> None:
    with pytest.raises(DataFormatError) as refused:
        list(read_trips(made.write("a.csv", _place(latitude, longitude))))
    assert problem in refused.value.problem
    assert remedy in refused.value.remedy
    assert refused.value.row == 2


@pytest.mark.parametrize(("heading", "taken"), [(MAX_HEADING_RAD, True), (26.0, False), (-270.0, False)])
def test_a_heading_may_go_on_over_four_turns_and_no_further(heading: float, taken: bool, made) -> None:
    text = "t_s,east_m,north_m,heading_rad\n" + "".join(f"{k / 10},{k},0,{heading!r}\n" for k in range(5))
    t_s = [k / 10 for k in range(5)]
    position_m = [[k, 0] for k in range(5)]
    if taken:
        assert len(read_trips(made.write("a.csv", text))[0]) == 5
        assert len(build_trajectory("a", t_s, position_m, heading_rad=[heading] * 5)) == 5
        return
    with pytest.raises(DataFormatError, match=r"too large for radians.*heading_deg=heading_rad"):
        list(read_trips(made.write("a.csv", text)))
    with pytest.raises(ValueError, match=r"a: heading_rad is .* at sample 0, too large for radians"):
        build_trajectory("a", t_s, position_m, heading_rad=[heading] * 5)
