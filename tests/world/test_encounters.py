"""Claims about pairs of vehicles that are close to each other."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.world.encounters import near_pairs


@settings(derandomize=True, deadline=None, max_examples=60)
@given(seed=st.integers(0, 2**32 - 1), vehicles=st.integers(0, 60), radius_m=st.floats(1.0, 400.0))
def test_the_pairs_are_those_of_all_distances(seed: int, vehicles: int, radius_m: float) -> None:
    """Against the plain definition: every two active slots within the radius, in order."""
    rng = np.random.default_rng(seed)
    place = rng.uniform(-300.0, 300.0, (vehicles, 2))
    active = rng.random(vehicles) < 0.8
    apart = np.hypot(*(place[:, None] - place[None]).transpose(2, 0, 1))
    near = (apart <= radius_m) & active[:, None] & active[None] & ~np.eye(vehicles, dtype=np.bool_)
    hosts, remotes = near_pairs(place, active, radius_m)
    expected = np.argwhere(near)
    assert hosts.tolist() == expected[:, 0].tolist()
    assert remotes.tolist() == expected[:, 1].tolist()
    assert hosts.dtype == remotes.dtype == np.int64


def test_slots_without_a_vehicle_may_hold_anything() -> None:
    place = np.array([[0.0, 0.0], [np.nan, np.nan], [3.0, 4.0]])
    hosts, remotes = near_pairs(place, np.array([True, False, True]), 5.0)
    assert (hosts.tolist(), remotes.tolist()) == ([0, 2], [2, 0])


@pytest.mark.parametrize(
    ("place", "active", "radius_m", "match"),
    [
        (np.zeros((2, 3)), np.ones(2, dtype=np.bool_), 10.0, "position_m must have shape"),
        (np.zeros((2, 2)), np.ones(2, dtype=np.bool_), 0.0, "radius_m"),
        (np.zeros((2, 2)), np.ones(2, dtype=np.bool_), np.inf, "radius_m"),
        (np.full((2, 2), np.nan), np.ones(2, dtype=np.bool_), 10.0, "not finite"),
    ],
)
def test_bad_input_is_refused(place: np.ndarray, active: np.ndarray, radius_m: float, match: str) -> None:
    with pytest.raises(ValueError, match=match):
        near_pairs(place, active, radius_m)
