"""Claims about what a fleet refuses: whose it is, and that nothing has changed."""

from typing import Any

import numpy as np
import pytest

from modelcast.station.fleet import Fleet
from modelcast.station.station import Station

IDS = np.array([3, 8])


def measured(t_s: float) -> dict[str, Any]:
    return {
        "t_s": t_s,
        "vehicle": IDS,
        "position_m": np.array([[15.0 * t_s, 0.0], [12.0 * t_s - 40.0, 0.0]]),
        "speed_mps": np.array([15.0, 12.0]),
        "heading_rad": np.full(2, np.pi / 2),
    }


REFUSED: list[tuple[dict[str, Any], str]] = [
    (
        {"position_m": np.array([[0.0, 0.0], [300e3, 400e3]])},
        r"position_m of vehicle 8 \(row 1\) must be within 499 km of the origin, got 500.0 km: choose",
    ),
    (
        {"position_m": np.array([[np.nan, 0.0], [0.0, 0.0]])},
        "position_m of vehicle 3 must be finite, got nan",
    ),
    ({"speed_mps": np.array([1.0, np.inf])}, "speed_mps of vehicle 8 must be finite, got inf"),
    ({"speed_mps": np.zeros(3)}, r"speed_mps must be \(2,\)"),
    ({"vehicle": np.array([3, 3])}, "vehicles must be distinct"),
    ({"vehicle": np.array([3, -1])}, "vehicles must be distinct and from 0"),
    ({"channel_busy_ratio": np.zeros(3)}, r"channel_busy_ratio must be \(2,\), got \(3,\)"),
    ({"begins": np.zeros(1, dtype=np.bool_)}, r"begins must be \(2,\), got \(1,\)"),
    (
        {
            "vehicle": np.array([8, 9, 10]),
            "position_m": np.zeros((3, 2)),
            "speed_mps": np.zeros(3),
            "heading_rad": np.zeros(3),
        },
        "the fleet has 2 slots, and all are taken: give it more",
    ),
]


@pytest.mark.parametrize(("changed", "told"), REFUSED)
@pytest.mark.parametrize("at", [0, 7])
def test_a_step_that_is_refused_leaves_the_fleet_unharmed(
    changed: dict[str, Any], told: str, at: int
) -> None:
    """At its first step, and later; measuring something else at first is no promise if it is refused."""
    asked, unasked = Fleet("mbc", slots=2, seed=5), Fleet("mbc", slots=2, seed=5)
    sent = 0
    for step in range(20):
        own = measured(0.1 * step)
        if step == at:
            more = {"yaw_rate_radps": np.full(2, 0.1)} if at == 0 and "vehicle" not in changed else {}
            with pytest.raises(ValueError, match=told):
                asked.sense(**own | changed | more)
        found, wanted = asked.sense(**own), unasked.sense(**own)
        assert found == wanted
        sent += len(found)
        for one in found:
            for fleet in (asked, unasked):
                fleet.hear(11 - one.vehicle, [one.octets], received_s=[one.send_s])
    assert sent
    np.testing.assert_array_equal(asked.believe(3, 2.0).position_m, unasked.believe(3, 2.0).position_m)


@pytest.mark.parametrize("sender", ["mbc", "baseline", "j2945-mbc"])
def test_at_the_limit_positions_are_stated(sender: str) -> None:
    station = Station(sender, temporary_id=1)
    sent = 0
    for step in range(30):
        east_m = 498_900.0 + 30.0 * 0.1 * step
        found = station.sense(
            0.1 * step,
            (east_m, 0.0),
            speed_mps=30.0,
            heading_rad=np.pi / 2,
            acceleration_mps2=0.0,
            yaw_rate_radps=0.0,
        )
        sent += len(found)
    assert sent
    with pytest.raises(ValueError, match="must be within 499 km"):
        station.sense(3.0, (499_001.0, 0.0), speed_mps=30.0, heading_rad=0.0, acceleration_mps2=0.0,
                      yaw_rate_radps=0.0)  # fmt: skip
