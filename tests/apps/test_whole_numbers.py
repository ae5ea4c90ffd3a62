"""Claims about settings that a user gives as whole numbers: they are numbers as any others."""

import numpy as np
import pytest

from modelcast.apps.around import repeated
from modelcast.apps.registry import get_application


@pytest.mark.parametrize(
    "text",
    [
        "fcw:longest_gap_m=190,lane_half_width_m=2,caution_s=1",
        "eebl:longest_gap_m=250,hard_braking_mps2=4,lane_half_width_m=2",
        "ima:longest_s=5,apart_s=1",
        "vru:longest_s=7,delay_s=1",
    ],
)
def test_a_whole_number_warns_as_the_same_number_with_a_point(text: str) -> None:
    shape = {"length_m": 4.5, "width_m": 1.8, "yaw_rate_radps": 0.0}
    host = repeated((0.0, 0.0), 2, speed_mps=20.0, heading_rad=0.0, acceleration_mps2=0.0, kind=0, **shape)
    remote = repeated((0.0, 30.0), 2, speed_mps=3.0, heading_rad=0.0, acceleration_mps2=-6.0, kind=0, **shape)
    name, settings = text.split(":")
    pointed = f"{name}:" + ",".join(f"{pair}.0" for pair in settings.split(","))
    whole, wanted = (get_application(word).assess(host, remote) for word in (text, pointed))
    for column in ("level", "time_s", "margin_m", "certainty"):
        np.testing.assert_array_equal(getattr(whole, column), getattr(wanted, column))
