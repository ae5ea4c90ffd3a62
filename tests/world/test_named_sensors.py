"""Claims about sensors that have a name."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from modelcast.cli.options import SensorOptions
from modelcast.core.arrays import FloatArray
from modelcast.trips.trajectory import build_trajectory
from modelcast.world.named_sensors import SENSORS, named_sensor, sensor_table
from modelcast.world.sensors import IDEAL, SensorModel, sense

PAGE = (Path(__file__).parents[2] / "docs" / "protocols.md").read_text(encoding="utf-8")


def errors(name: str, duration_s: float) -> FloatArray:
    """Position errors of a car, (T, 2) [m]; what it does makes no difference to them without latency."""
    t = np.arange(0.0, duration_s, 0.1)
    truth = build_trajectory("made/1", t, np.stack([10.0 * t, 0.0 * t], axis=1))
    seen = sense(truth, replace(named_sensor(name), latency_s=0.0), np.random.default_rng(1))
    return seen.position_m - truth.position_m


def jitter_m(error: FloatArray) -> float:
    """What a quadratic over 1 s leaves, median over time [m]."""
    powers = np.vander(np.linspace(-1.0, 1.0, 11), 3)
    left = np.eye(11) - powers @ np.linalg.pinv(powers)
    windows = np.lib.stride_tricks.sliding_window_view(error[:, 0], 11)
    return float(np.median(np.sqrt(((windows @ left.T) ** 2).sum(axis=1) / 8.0)))


def test_the_page_has_the_table_that_the_code_makes() -> None:
    assert sensor_table() in PAGE


def test_default_and_ideal_are_those_of_the_model() -> None:
    assert named_sensor("default") == SensorModel() == SensorOptions().model()
    assert named_sensor("ideal") == IDEAL


def test_an_unknown_name_is_refused_with_all_that_are_known() -> None:
    with pytest.raises(ValueError, match="sensor must be one of default, ideal, gnss, gnss-rtk, ins, phone"):
        named_sensor("gps")


def test_the_help_lists_all_names() -> None:
    assert f"by name: {', '.join(SENSORS)}." in str(SensorOptions.__doc__)


@pytest.mark.parametrize("name", SENSORS)
def test_a_single_option_replaces_one_field_of_the_sensor(name: str) -> None:
    found = SensorOptions(sensor=name, heading_noise=90.0, latency=0.0).model()
    assert found == replace(named_sensor(name), heading_noise_rad=0.5 * np.pi, latency_s=0.0)


@pytest.mark.parametrize(
    ("name", "half_m"), [("gnss-rtk", 0.02), ("ins", 0.01 * np.sqrt(2.0 * np.log(2.0))), ("phone", 4.9)]
)
def test_half_of_the_positions_are_within_what_the_source_states(name: str, half_m: float) -> None:
    """Within 3 %: sizes are rounded."""
    model = named_sensor(name)
    parts = (model.position_noise_m, model.slow_position_noise_m, model.multipath_noise_m)
    assert np.sqrt(2.0 * np.log(2.0)) * np.hypot.reduce(parts) == pytest.approx(half_m, rel=0.03)


def test_gnss_has_the_correlations_of_the_measured_receiver() -> None:
    """0.96 at 10 s and 0.84 at 60 s."""
    error = errors("gnss", 200_000.0)
    assert error.std() == pytest.approx(0.5, rel=0.05)
    for lag_s, measured in ((10, 0.96), (60, 0.84)):
        found = np.corrcoef(error[: -10 * lag_s, 0], error[10 * lag_s :, 0])[0, 1]
        assert found == pytest.approx(measured, abs=0.04)


@pytest.mark.parametrize(
    ("name", "low_m", "high_m"), [("gnss", 0.009, 0.011), ("gnss-rtk", 0.004, 0.007), ("phone", 0.02, 0.04)]
)
def test_jitter_over_a_second_is_what_the_page_says(name: str, low_m: float, high_m: float) -> None:
    assert low_m < jitter_m(errors(name, 2000.0)) < high_m


@pytest.mark.parametrize("name", SENSORS)
def test_every_sensor_says_where_its_figures_come_from(name: str) -> None:
    sensor = SENSORS[name]
    assert sensor.what
    assert sensor.source
    assert sensor.certainty
    assert "|" not in sensor.what + sensor.source + sensor.certainty
