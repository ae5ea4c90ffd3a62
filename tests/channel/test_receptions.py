"""What no fleet can take in of a radio is refused."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.channel.radio import OUTCOMES, Receptions

HEARD = Receptions(
    np.array([5, 6]),
    np.array([0, 1]),
    receiver=np.array([1, 2]),
    t_s=np.array([0.1, 0.15]),
    rssi_dbm=np.array([-80.0, np.nan]),
    outcomes=np.zeros((2, len(OUTCOMES)), dtype=np.int64),
    expired=np.array([], dtype=np.int64),
)


def test_receptions_of_the_interval_are_taken() -> None:
    HEARD.check(3)
    HEARD.check(3, 0.1)


def test_nothing_arrives_before_the_interval() -> None:
    with pytest.raises(ValueError, match=r"t_s must lie after the interval's start, 0\.11 s, got 0\.1"):
        HEARD.check(3, 0.11)


def test_nobody_receives_what_it_sends_itself() -> None:
    with pytest.raises(ValueError, match="vehicle 1 must not receive what it sends itself"):
        replace(HEARD, receiver=np.array([1, 1])).check(3)
