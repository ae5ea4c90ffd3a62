"""Claims about what stations on the air believe of losses, and how long they are silent at their speed."""

import numpy as np
import pytest

from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantAcceleration
from modelcast.station.fleet import Fleet
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sender.sender import Sender

BANK = Bank((ConstantAcceleration(), ConstantVelocity()))


def braking_fleet(sender: Sender, keep: float, seconds: float = 30.0) -> tuple[int, Fleet]:
    """Messages of the first of eight cars that surge, one behind the other, each heard with a chance."""
    rng = np.random.default_rng(4)
    cars = np.arange(8)
    fleet = Fleet(sender, slots=8, seed=1, spread_s=0.5)
    count = 0
    for k in range(round(10.0 * seconds)):
        t = 0.1 * k
        speed = 12.0 + 3.0 * np.sin(0.7 * t + cars)
        along = 12.0 * t - 3.0 / 0.7 * (np.cos(0.7 * t + cars) - np.cos(cars)) + 10.0 * cars
        sent = fleet.sense(
            t,
            cars,
            np.stack([along, np.zeros(8)], axis=1),
            speed_mps=speed,
            heading_rad=np.full(8, np.pi / 2),
            acceleration_mps2=2.1 * np.cos(0.7 * t + cars),
            yaw_rate_radps=np.zeros(8),
        )
        for one in sent:
            count += int(one.vehicle == 0)
            for host in cars[cars != one.vehicle]:
                if rng.random() < keep:
                    fleet.hear(int(host), [one.octets], received_s=[one.send_s])
    return count, fleet


def sender(policy: ErrorDriven) -> Sender:
    return Sender("made", policy, BANK)


@pytest.mark.slow
def test_a_station_that_loses_what_others_send_sends_more_itself() -> None:
    """It hears none of its own losses, so it takes those of the others; where nothing is lost it is plain."""
    expecting = ErrorDriven(0.2, "hindsight", "never", 0.8, believe="expected", budget=np.inf)
    plain = ErrorDriven(0.2, "hindsight", "never", 0.8)
    blind, lossless = (braking_fleet(sender(plain), keep)[0] for keep in (0.5, 1.0))
    assert blind == lossless
    assert braking_fleet(sender(expecting), 1.0)[0] == lossless
    assert braking_fleet(sender(expecting), 0.5)[0] > 1.2 * blind


@pytest.mark.parametrize(("speed_mps", "longest_s"), [(5.0, 2.0), (10.0, 1.0), (25.0, 0.4)])
def test_a_fast_station_is_silent_for_less_long(speed_mps: float, longest_s: float) -> None:
    """Straight on, only silence calls; times are those of samples, the jitter apart."""
    fleet = Fleet(sender(ErrorDriven(0.5, "order", "never", 2.0, approach_m=20.0)), slots=1)
    at = [
        k
        for k in range(100)
        for _ in fleet.sense(
            0.1 * k,
            np.array([1]),
            np.array([[0.1 * speed_mps * k, 0.0]]),
            speed_mps=np.array([speed_mps]),
            heading_rad=np.array([np.pi / 2]),
            acceleration_mps2=np.zeros(1),
            yaw_rate_radps=np.zeros(1),
        )
    ]
    assert set(np.diff(at).tolist()) == {round(10.0 * longest_s)}
