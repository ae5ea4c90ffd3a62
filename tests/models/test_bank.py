"""Claims about a bank of sub-models."""

import numpy as np
import pytest

from modelcast.models.bank import Bank
from modelcast.models.base import Windows
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess

CV = ConstantVelocity()
GP = GaussianProcess(form="intercept")
HORIZONS_S = np.array([0.0, 0.4, 1.3])


def arcs(count: int, length: int) -> Windows:
    """Windows of cars on circles of different radius."""
    t = np.arange(1 - length, 1) * 0.1
    radius = np.linspace(20.0, 80.0, count)[:, None]
    angle = 12.0 * t / radius
    position = (radius * np.sin(angle), radius * np.cos(angle))
    velocity = (12 * np.cos(angle), -12 * np.sin(angle))
    rates = (np.zeros_like(angle), np.broadcast_to(12.0 / radius, angle.shape))
    columns = [*position, *velocity, *rates, np.zeros_like(angle)]
    return Windows(np.stack(columns, axis=-1), dt_s=0.1)


def test_a_bank_needs_a_member_and_distinct_names() -> None:
    with pytest.raises(ValueError, match="at least one"):
        Bank(())
    with pytest.raises(ValueError, match="distinct names, got cv, cv"):
        Bank((CV, ConstantVelocity(2.0)))


def test_its_name_joins_the_members_unless_labelled() -> None:
    assert Bank((GP, CV)).name == "gp-intercept+cv"
    assert Bank((GP, CV), "mine").name == "mine"


def test_its_parameters_are_the_members_own_behind_the_one_in_use() -> None:
    windows = arcs(4, 10)
    parameters = Bank((CV, GP)).fit(windows)
    assert np.array_equal(parameters, np.hstack([np.zeros((4, 1)), CV.fit(windows), GP.fit(windows)]))


@pytest.mark.parametrize(("length", "in_use"), [(1, 1), (9, 1), (10, 0), (14, 0)])
def test_the_first_member_with_a_full_window_serves(length: int, in_use: int) -> None:
    parameters = Bank((GP, CV)).fit(arcs(3, length))
    assert parameters[:, 0].tolist() == [in_use] * 3
    assert parameters[:, 1:-2].any() == (in_use == 0)


def test_each_row_is_predicted_by_the_member_it_names() -> None:
    windows = arcs(5, 10)
    parameters = Bank((CV, GP)).fit(windows)
    parameters[:, 0] = (0, 1, 1, 0, 1)
    bank = Bank((CV, GP))
    named = parameters[:, 0] == 1
    for own, rows in ((CV, ~named), (GP, named)):
        fitted = own.fit(Windows(windows.samples[rows], dt_s=0.1))
        moved = bank.predict(parameters, HORIZONS_S, dt_s=0.1)[rows]
        assert np.array_equal(moved, own.predict(fitted, HORIZONS_S, dt_s=0.1))
        spread = bank.covariance(parameters, HORIZONS_S, dt_s=0.1)[rows]
        assert np.array_equal(spread, own.covariance(fitted, HORIZONS_S, dt_s=0.1))


@pytest.mark.parametrize("in_use", [-1.0, 2.0, float("nan")])
def test_a_sub_model_that_is_not_there_is_refused(in_use: float) -> None:
    bank = Bank((CV, GP))
    parameters = bank.fit(arcs(2, 10))
    parameters[1, 0] = in_use
    with pytest.raises(ValueError, match="in_use"):
        bank.predict(parameters, HORIZONS_S, dt_s=0.1)
