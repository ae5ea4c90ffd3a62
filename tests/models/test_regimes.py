"""Claims about driving regimes as values."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modelcast.models.gp import VehicleProcess
from modelcast.models.regimes import Regimes, regime_features

TWO = Regimes(
    (VehicleProcess("gp-regime-1"), VehicleProcess("gp-regime-2")),
    ((20.0, 0.0, 0.0), (5.0, 0.0, 2.0)),
    scales=(5.0, 1.0, 1.0),
    shares=(0.6, 0.4),
)


def windows(speed_mps: float, acceleration_mps2: float, yaw_rate_radps: float) -> np.ndarray:
    last = [0.0, 0.0, 0.6 * speed_mps, 0.8 * speed_mps, acceleration_mps2, yaw_rate_radps, 0.01]
    return np.array([[[0.0] * 7, last]])


def test_features_are_those_of_the_last_sample_and_know_no_direction() -> None:
    assert regime_features(windows(10.0, -2.0, 0.1))[0] == pytest.approx([10.0, 2.0, 1.0])
    assert regime_features(windows(10.0, 2.0, -0.1))[0] == pytest.approx([10.0, 2.0, 1.0])


def test_the_noisy_yaw_rate_of_a_car_that_stands_makes_no_regime() -> None:
    assert regime_features(windows(0.0, 0.0, 1.0))[0, 2] == 0.0


def test_a_window_belongs_to_the_nearest_centre_by_the_scales() -> None:
    assert TWO.of(windows(13.0, 0.0, 0.0))[0] == 0
    assert TWO.of(windows(12.0, 0.0, 1.5 / 12.0))[0] == 1


def test_the_most_frequent_regime_s_sub_model_is_first_in_their_bank() -> None:
    assert [member.name for member in TWO.bank.members] == ["gp-regime-1", "gp-regime-2"]


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"members": TWO.members[:1]}, "members must be a list of 2"),
        ({"members": TWO.members[:1] * 2}, "distinct names"),
        ({"centres": TWO.centres[:1]}, "centres must be a list of 2"),
        ({"centres": ((1.0, 2.0), (3.0, 4.0))}, "3 items"),
        ({"centres": ((1.0, 2.0, np.inf), (3.0, 4.0, 5.0))}, r"centres\[0\]\[2\] must be a number"),
        ({"scales": (1.0, 0.0, 1.0)}, r"scales\[1\] must be a number"),
        ({"shares": (0.5, 0.6)}, "sum to one"),
    ],
)
def test_impossible_regimes_are_refused(wrong: dict[str, Any], named: str) -> None:
    with pytest.raises(ValueError, match=named):
        replace(TWO, **wrong)
