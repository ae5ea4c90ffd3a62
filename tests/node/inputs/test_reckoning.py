"""Ways by speed and yaw rate, and series of values."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.node.inputs.outage import BusErrors, bus_errors
from modelcast.node.inputs.reckoning import Growth, ellipse_covariance_m2, ellipse_of, way
from modelcast.node.inputs.samples import PLAUSIBLE, BusValue, GnssFix, measured_at
from modelcast.node.inputs.series import Series, stale_after_s


def circle_error_m(step_s: float) -> float:
    """Distance between the summed and the closed form of an arc of 10 s."""
    knots = np.arange(0.0, 10.0, step_s)
    driven = way(lambda _: 12.0, lambda _: 0.2, knots, from_s=0.0, to_s=10.0, heading_rad=0.4)
    radius_m = 12.0 / 0.2
    east_m = radius_m * (math.cos(0.4) - math.cos(2.4))
    north_m = radius_m * (math.sin(2.4) - math.sin(0.4))
    return math.hypot(driven.east_m - east_m, driven.north_m - north_m)


def test_an_arc_is_summed_to_second_order():
    assert circle_error_m(0.2) / circle_error_m(0.1) == pytest.approx(4.0, rel=0.02)


def test_growth_is_that_of_its_formula():
    growth = Growth(speed_ratio=0.01, speed_mps=0.1, course_rad=0.02, yaw_rate_radps=0.01)
    driven = way(lambda _: 20.0, lambda _: 0.0, (), from_s=0.0, to_s=3.0, heading_rad=0.0)
    expected = np.diag([(60.0 * (0.02 + 0.015)) ** 2, (0.6 + 0.3) ** 2])
    assert growth.covariance_m2(3.0, driven) == pytest.approx(expected)


@given(st.floats(0.1, 50.0), st.floats(0.0, 0.99), st.floats(0.0, 3.1))
def test_an_ellipse_is_what_its_covariance_was_made_of(major_m: float, ratio: float, toward_rad: float):
    found = ellipse_of(ellipse_covariance_m2(major_m, ratio * major_m, toward_rad))
    assert found[0] == pytest.approx(major_m)
    assert found[1] == pytest.approx(ratio * major_m, abs=1e-6 * major_m)
    assert math.sin(found[2] - toward_rad) == pytest.approx(0.0, abs=1e-4)


@given(
    st.lists(
        st.tuples(st.floats(0.0, 9.0), st.floats(0.0, 1.0), st.floats(-5.0, 5.0)), unique_by=lambda r: r[:2]
    )
)
def test_a_series_does_not_depend_on_the_order_of_arrival(rows: list[tuple[float, float, float]]):
    one, other = Series(1000), Series(1000)
    for row in rows:
        one.add(*row)
    for row in reversed(rows):
        other.add(*row)
    for t_s in np.arange(-1.0, 10.0, 0.3).tolist():
        assert one.at(t_s) == other.at(t_s) or math.isnan(one.at(t_s))
    assert one.same_since() == other.same_since()


def test_a_series_knows_nothing_between_its_ends_and_the_future():
    series = Series(10)
    series.add(1.0, 1.0, 10.0)
    assert series.at(0.0) == series.at(5.0) == 10.0
    series.add(2.0, 2.0, 20.0)
    assert (series.at(1.25), series.at(7.0)) == (12.5, 20.0)
    assert series.same_since() == (2.0, 1)


def test_staleness_follows_the_period_within_bounds():
    assert stale_after_s([0.0, 0.25, 0.5], 1.0) == 0.75
    assert stale_after_s([5.0], 1.0) == 0.3
    assert stale_after_s([], 0.2) == 0.2


def test_bias_scale_and_course_are_learnt_from_fixes():
    speed, yaw_rate = Series(2000), Series(2000)
    for at in range(1001):
        t_s = 0.01 * at
        speed.add(t_s, t_s, 20.0 / 1.03)
        yaw_rate.add(t_s, t_s, 0.05 + 0.008)
    fixes = [
        GnssFix(
            received_s=t_s, measured_s=t_s, latitude_deg=42.0, longitude_deg=-83.0, speed_mps=20.0,
            heading_rad=6.0 + 0.05 * t_s,
        )
        for t_s in np.arange(0.0, 10.01, 0.1).tolist()
    ]  # fmt: skip
    errors = bus_errors(fixes, speed, yaw_rate)
    assert errors.yaw_rate_radps == pytest.approx(0.008, abs=1e-9)
    assert errors.speed_scale == pytest.approx(1.03)
    assert math.remainder(errors.heading_rad - 6.5, math.tau) == pytest.approx(0.0, abs=1e-6)
    assert errors.course_rad == pytest.approx(0.0, abs=1e-6)
    assert math.isnan(bus_errors(fixes[:3], speed, yaw_rate).heading_rad)


def test_a_yaw_rate_that_showed_no_turn_widens_the_ellipse():
    growth = Growth()
    assert BusErrors().widened(growth) == growth
    wide = BusErrors(course_rad=0.3, turn_radps=0.1).widened(growth)
    assert (wide.course_rad, wide.yaw_rate_radps) == (0.3, 0.1)


@pytest.mark.parametrize("quantity", list(PLAUSIBLE))
def test_a_value_that_no_vehicle_shows_is_refused(quantity: str):
    low, high = PLAUSIBLE[quantity]
    for value in (low, high):
        assert BusValue(quantity, value, 1.0, 1.0).value == value
    for value in (low - 0.001, high + 0.001, math.nan):
        with pytest.raises(ValueError, match=quantity):
            BusValue(quantity, value, 1.0, 1.0)


def test_what_is_measured_after_it_arrived_is_refused():
    with pytest.raises(ValueError, match="arrives after"):
        BusValue("speed_mps", 1.0, 1.0, 1.1)
    with pytest.raises(ValueError, match="arrives after"):
        GnssFix(received_s=1.0, measured_s=1.1, latitude_deg=0.0, longitude_deg=0.0)
    with pytest.raises(ValueError, match="after it arrived"):
        measured_at(10.0, 10.2, 0.0)
