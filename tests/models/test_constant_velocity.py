"""Claims about coasting at constant velocity."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.models.base import Windows
from modelcast.models.constant_velocity import ConstantVelocity

ROUNDING_M = 1e-9
"""Displacements of hundreds of metres carry less rounding than this."""

speeds = st.floats(-60.0, 60.0)
accelerations = st.floats(-9.0, 9.0)


@given(vx=speeds, vy=speeds, ax=accelerations, ay=accelerations, horizon_s=st.floats(0.0, 10.0))
def test_on_constant_acceleration_it_errs_by_half_a_t_squared(
    vx: float, vy: float, ax: float, ay: float, horizon_s: float
) -> None:
    model = ConstantVelocity()
    parameters = model.fit(Windows(np.array([[[5.0, 7.0, vx, vy, 0.0, 0.0, 0.0]]]), dt_s=0.1))
    moved = model.predict(parameters, np.array([horizon_s]), dt_s=0.1)[0, 0]
    true = np.array([vx, vy]) * horizon_s + 0.5 * np.array([ax, ay]) * horizon_s**2
    expected = 0.5 * np.hypot(ax, ay) * horizon_s**2
    assert np.hypot(*(moved - true)) == pytest.approx(expected, abs=ROUNDING_M)


def test_only_the_newest_sample_counts() -> None:
    old = np.array([[[9.0, 9.0, -3.0, 2.0, 1.0, 0.1, 0.0], [0.0, 0.0, 10.0, 1.0, 2.0, 0.2, 0.0]]])
    assert ConstantVelocity().fit(Windows(old, dt_s=0.1)).tolist() == [[10.0, 1.0]]


def test_the_covariance_is_that_of_an_unmodelled_acceleration() -> None:
    covariance = ConstantVelocity(2.0).covariance(np.zeros((1, 2)), np.array([0.0, 3.0]), dt_s=0.1)
    assert np.array_equal(covariance[0, 0], np.zeros((2, 2)))
    assert np.array_equal(covariance[0, 1], 81.0 * np.eye(2))
