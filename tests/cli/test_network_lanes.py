"""Lanes of a highway grow with its density."""

from dataclasses import replace

from modelcast.cli.network_plan import NetworkPlan
from modelcast.cli.options import SensorOptions


def test_lanes_never_hold_more_than_a_hundred_a_kilometre_above_1200() -> None:
    plan = NetworkPlan(
        "highway",
        duration_s=2.0,
        warm_up_s=1.0,
        length_m=500.0,
        lanes=0,
        blocks=5,
        seed=0,
        certificates="gap",
        banks=("default",),
        profile=None,
        start=None,
        identify=None,
        cost="bytes",
        threads=1,
        thresholds_m=(0.2,),
        keep_alive_s=1.0,
        believe=None,
        budget=1.3,
        approach_m=20.0,
        legacy_threshold_m=0.0,
        relaxed_error_m=None,
        sensor=SensorOptions(),
    )
    assert [plan.lanes_for(density) for density in (100.0, 201.0, 800.0, 1200.0)] == [3, 4, 5, 6]
    assert [plan.lanes_for(density) for density in (1201.0, 2000.0, 6000.0)] == [7, 10, 30]
    assert replace(plan, lanes=2).lanes_for(6000.0) == 2
