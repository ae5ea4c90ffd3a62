"""Surrogate safety measures: closed forms, a public implementation's values, and what changes nothing."""

import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.apps.motions import Motions
from modelcast.apps.surrogates import (
    deceleration_to_avoid_2d_mps2,
    deceleration_to_avoid_mps2,
    modified_time_to_collision_s,
    post_encroachment_time_s,
    time_to_collision_2d_s,
    time_to_collision_s,
)

GOLDEN = Path(__file__).parent / "surrogates_golden.csv"
"""Ten pairs, with the values of github.com/Yiru-Jiao/Two-Dimensional-Time-To-Collision, src/TwoDimSSM.py at
commit 102e15ef812e1bbdf5b05405bbdab532f075d500; written by `validation/surrogates.py PATH --write`."""


def golden() -> tuple[Motions, Motions, dict[str, np.ndarray]]:
    with GOLDEN.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    table = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
    host, remote = (
        Motions.of(
            np.stack([table[f"{name}_x"], table[f"{name}_y"]], axis=1),
            speed_mps=table[f"{name}_speed"],
            heading_rad=table[f"{name}_heading"],
            length_m=table[f"{name}_length"],
            width_m=table[f"{name}_width"],
        )
        for name in ("host", "remote")
    )
    return host, remote, table


def test_the_plane_s_measures_are_those_of_a_public_implementation():
    host, remote, table = golden()
    assert 4 <= np.isfinite(table["ttc"]).sum() <= 8
    np.testing.assert_allclose(time_to_collision_2d_s(host, remote), table["ttc"], rtol=1e-9)
    np.testing.assert_allclose(deceleration_to_avoid_2d_mps2(host, remote), table["drac"], rtol=1e-9)


def test_the_modified_time_is_that_of_a_public_implementation():
    """Along the way to the contact; its eighth pair is one that only an acceleration brings together."""
    host, remote, table = golden()
    relative = np.linalg.norm(host.velocity_mps - remote.velocity_mps, axis=1)
    touch = np.isfinite(table["ttc"])
    found = modified_time_to_collision_s(table["ttc"][touch] * relative[touch], relative[touch],
                                         table["host_acceleration"][touch])  # fmt: skip
    np.testing.assert_allclose(found, table["mttc"][touch], rtol=1e-9)
    gap = table["remote_y"][7] - 4.5
    assert modified_time_to_collision_s(gap, -10.0, 1.0)[0] == pytest.approx(table["mttc"][7], rel=1e-9)


def test_along_a_lane_the_plane_s_measures_are_the_lane_s():
    speeds = np.array([5.0, 12.0, 20.0])
    host = Motions.of(np.zeros((3, 2)), speed_mps=15.0, heading_rad=0.7)
    way = 30.0 * np.array([np.sin(0.7), np.cos(0.7)])
    remote = Motions.of(np.tile(way, (3, 1)), speed_mps=speeds, heading_rad=0.7)
    gap = 30.0 - 4.5
    np.testing.assert_allclose(time_to_collision_2d_s(host, remote), time_to_collision_s(gap, 15.0 - speeds))
    np.testing.assert_allclose(
        deceleration_to_avoid_2d_mps2(host, remote),
        deceleration_to_avoid_mps2(gap, 15.0 - speeds),
        atol=1e-15,
    )


@given(gap=st.floats(0.1, 200), closing=st.floats(-30, 30), gain=st.floats(-8, 8))
def test_at_the_modified_time_the_gap_is_closed_for_the_first_time(gap: float, closing: float, gain: float):
    (time,) = modified_time_to_collision_s(gap, closing, gain)
    left = lambda t: gap - closing * t - 0.5 * gain * t * t  # noqa: E731 - the equation of motion
    if np.isfinite(time):
        assert abs(left(time)) <= 1e-6 * (gap + abs(closing) * time + abs(gain) * time**2)
        assert (left(np.linspace(0.0, time, 50)[:-1]) > 0.0).all()
    else:
        assert (left(np.linspace(0.0, 100.0, 200)) > -1e-6).all()


def test_the_deceleration_that_avoids_does_so_just():
    """Braking by it, the closing speed is used up where the gap is."""
    needed = deceleration_to_avoid_mps2(17.0, 6.0)
    assert modified_time_to_collision_s(17.0, 6.0, -needed * 1.001)[0] == np.inf
    assert np.isfinite(modified_time_to_collision_s(17.0, 6.0, -needed * 0.999)[0])


@given(seed=st.integers(0, 200), turn_rad=st.floats(-7, 7), east_m=st.floats(-500, 500))
def test_who_is_host_and_where_north_is_changes_no_time(
    random_pairs, moved, seed: int, turn_rad: float, east_m: float
):
    host, remote = random_pairs(np.random.default_rng(seed), 30)
    time = time_to_collision_2d_s(host, remote)
    np.testing.assert_array_equal(time_to_collision_2d_s(remote, host), time)
    other = time_to_collision_2d_s(
        moved(host, turn_rad, (east_m, 0.0)), moved(remote, turn_rad, (east_m, 0.0))
    )
    grazing = np.isfinite(time) != np.isfinite(other)
    assert grazing.mean() <= 0.05
    np.testing.assert_allclose(other[~grazing], time[~grazing], rtol=1e-6, atol=1e-7)


def test_rectangles_that_overlap_touch_now():
    host = Motions.of([[0.0, 0.0]], speed_mps=5.0, heading_rad=0.0)
    remote = Motions.of([[1.0, 2.0]], speed_mps=0.0, heading_rad=0.3)
    assert time_to_collision_2d_s(host, remote)[0] == 0.0
    assert deceleration_to_avoid_2d_mps2(host, remote)[0] == np.inf
    assert time_to_collision_s(-1.0, -1.0)[0] == 0.0
    assert deceleration_to_avoid_mps2([-1.0, -1.0], [1.0, -1.0]).tolist() == [np.inf, 0.0]


def test_encroachment_is_from_leaving_to_arriving_whoever_is_first():
    """Both cross a disc of 3 m at 10 m/s; one leaves it at 2.3 s, the other arrives at 4.7 s."""
    t_s = np.arange(0.0, 8.0, 0.1)
    north = np.stack([0 * t_s, 10.0 * t_s - 20.0], axis=1)
    east = np.stack([10.0 * t_s - 50.0, 0 * t_s], axis=1)
    host, remote = (
        np.stack([north, east, north, north]),
        np.stack([east, north, north, north + np.array([30.0, 0.0])]),
    )
    found = post_encroachment_time_s(t_s, host, remote, point_m=[0.0, 0.0], radius_m=3.0)
    np.testing.assert_allclose(found, [2.4, 2.4, -0.6, np.nan])


def test_one_who_stands_in_the_area_leaves_it_at_the_end():
    track = np.zeros((1, 3, 2))
    other = np.array([[[-10.0, 0.0], [0.0, 0.0], [10.0, 0.0]]])
    found = post_encroachment_time_s([0.0, 1.0, 2.0], track, other, point_m=[0.0, 0.0], radius_m=2.0)
    np.testing.assert_allclose(found, [0.0 - 1.2])


def test_nan_gives_nan_and_bad_input_is_refused():
    assert np.isnan(time_to_collision_s([np.nan, 1.0], [1.0, np.nan])).all()
    host = Motions.of([[0.0, 0.0]], speed_mps=5.0, heading_rad=0.0)
    lost = Motions.of([[np.nan, 0.0]], speed_mps=5.0, heading_rad=0.0)
    assert np.isnan(time_to_collision_2d_s(host, lost)[0])
    assert np.isnan(deceleration_to_avoid_2d_mps2(host, lost)[0])
    with pytest.raises(ValueError, match="row by row"):
        time_to_collision_2d_s(host, Motions.of(np.zeros((2, 2)), speed_mps=1.0, heading_rad=0.0))
    track = np.zeros((1, 2, 2))
    with pytest.raises(ValueError, match="increase"):
        post_encroachment_time_s([1.0, 1.0], track, track, point_m=[0.0, 0.0], radius_m=1.0)
    with pytest.raises(ValueError, match="shape"):
        post_encroachment_time_s([0.0, 1.0, 2.0], track, track, point_m=[0.0, 0.0], radius_m=1.0)


def test_encroachment_between_samples_anywhere():
    """Two straight tracks over a disc that is no one's origin, sampled so that nothing falls on a sample."""
    t_s = 0.7 * np.arange(12)
    middle, radius = np.array([130.0, -45.0]), 2.5
    north = middle + np.stack([0 * t_s + 1.5, 9.0 * t_s - 20.0], axis=1)
    east = middle + np.stack([11.0 * t_s - 60.0, 0 * t_s - 0.7], axis=1)
    left = (20.0 + np.sqrt(radius**2 - 1.5**2)) / 9.0
    arrives = (60.0 - np.sqrt(radius**2 - 0.7**2)) / 11.0
    found = post_encroachment_time_s(t_s, north[None], east[None], point_m=middle, radius_m=radius)
    assert found[0] == pytest.approx(arrives - left)
