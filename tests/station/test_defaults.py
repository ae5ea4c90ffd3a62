"""Defaults and codes, written down once more: a number of a standard does not change unnoticed.

SAE J2945/1 and its readings (docs/congestion.md), ETSI TS 102 687 (reactive and adaptive control), ETSI
EN 302 637-2 (generation rules), and the codes that files, tables and compiled steps share.
"""

import math

import numpy as np

from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.station.policy import error_driven_kernels, hindsight_kernels, j2945_kernels
from modelcast.station.policy.base import Decisions, MessageKind
from modelcast.station.policy.cam import CamTriggering, CooperativeAwareness
from modelcast.station.policy.dcc import AdaptiveDcc, ReactiveDcc
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.hindsight import LAGS_S, hindsight_scores
from modelcast.station.policy.j2945 import J2945, Cause
from modelcast.station.policy.j2945_parameters import (
    J2945Parameters,
    j2945_relaxed_parameters,
    j3161_parameters,
)
from modelcast.station.receiver.ears import Ears
from modelcast.station.receiver.heard import HeardKind, heard_messages
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap, Receipt
from modelcast.station.receiver.plausibility import Finding, Plausibility
from modelcast.station.receiver.plausibility_limits import PlausibilityLimits
from modelcast.station.sender.sender import Sender, named_sender

J2945_1 = {
    "per_interval_s": 5.0,
    "per_sub_interval_s": 1.0,
    "per_range_m": 100.0,
    "max_packet_error_ratio": 0.3,
    "channel_quality_weight": 1.0,
    "density_interval_s": 0.1,
    "density_weight": 0.05,
    "density_coefficient": 25.0,
    "min_inter_transmit_time_s": 0.1,
    "max_inter_transmit_time_s": 0.6,
    "rate_control_interval_s": 0.1,
    "busy_weight": 0.5,
    "local_as_is_age_s": 0.05,
    "local_max_age_s": 0.15,
    "remote_as_is_age_s": 0.05,
    "remote_max_age_s": 3.0,
    "tracking_error_trigger": True,
    "min_tracking_error_m": 0.2,
    "max_tracking_error_m": 0.5,
    "error_sensitivity": 75.0,
    "squared_exponent": True,
    "reschedule_threshold_s": 0.025,
    "jitter_s": 0.005,
    "time_accuracy_s": 0.001,
    "max_successive_failures": 3,
    "critical_interval_s": 0.1,
    "critical_deceleration_mps2": 0.4 * 9.80665,
    "power_control": True,
    "min_power_dbm": 10.0,
    "max_power_dbm": 20.0,
    "start_power_dbm": 15.0,
    "power_gain": 0.5,
    "min_busy_ratio": 0.5,
    "max_busy_ratio": 0.8,
    "max_error_growth": 1.0,
    "follow_up_s": 0.0,
}


def test_j2945_1_has_the_constants_of_its_table() -> None:
    assert J2945Parameters() == J2945Parameters(**J2945_1)  # type: ignore[arg-type]
    assert J2945Parameters().sub_intervals == 5
    assert J2945().parameters == J2945Parameters()


def test_the_relaxed_and_the_cellular_readings_change_what_they_say_and_nothing_else() -> None:
    def changed(parameters: J2945Parameters) -> set[str]:
        return {name for name, value in J2945_1.items() if getattr(parameters, name) != value}

    relaxed = j2945_relaxed_parameters(2.0)
    assert changed(relaxed) == {
        "min_inter_transmit_time_s",
        "max_inter_transmit_time_s",
        "remote_max_age_s",
        "min_tracking_error_m",
        "max_tracking_error_m",
        *(("max_error_growth",) if relaxed.max_error_growth != 1.0 else ()),
        *(("follow_up_s",) if relaxed.follow_up_s != 0.0 else ()),
    }
    assert relaxed.min_inter_transmit_time_s == relaxed.max_inter_transmit_time_s == 2.0
    assert relaxed.remote_max_age_s == math.inf
    assert changed(j3161_parameters()) == {"power_control", "tracking_error_trigger"}
    assert changed(j3161_parameters(power_control=True, tracking_error_trigger=True)) == set()


def test_congestion_control_has_the_constants_of_ts_102_687() -> None:
    assert AdaptiveDcc() == AdaptiveDcc(
        relaxation=0.016,
        gain=0.0012,
        target_busy_ratio=0.68,
        min_share=0.0006,
        max_share=0.03,
        max_rise=0.0005,
        max_fall=-0.00025,
        busy_weight=0.5,
        measures_an_update=2,
        shortest_s=0.025,
        longest_s=1.0,
        measuring_interval_s=0.1,
        start_share=None,
    )
    assert ReactiveDcc() == ReactiveDcc(
        bounds_ratio=(0.3, 0.4, 0.5, 0.6),
        intervals_s=(0.1, 0.2, 0.4, 0.5, 1.0),
        measuring_interval_s=0.1,
        neighbouring_only=False,
    )
    assert CooperativeAwareness().control == AdaptiveDcc()


def test_awareness_messages_have_the_constants_of_en_302_637_2() -> None:
    assert CamTriggering() == CamTriggering(
        min_inter_transmit_time_s=0.1,
        max_inter_transmit_time_s=1.0,
        heading_change_rad=math.radians(4.0),
        distance_m=4.0,
        speed_change_mps=0.5,
        timeouts=3,
    )
    assert CooperativeAwareness().triggering == CamTriggering()


def test_plausibility_and_maps_have_the_limits_of_their_page() -> None:
    limits = PlausibilityLimits(
        max_ahead_s=0.1,
        max_age_s=2.0,
        max_speed_mps=70.0,
        max_acceleration_mps2=10.0,
        position_tolerance_m=3.0,
        speed_tolerance_mps=0.8,
        window_s=1.0,
        stuck_after_s=2.0,
        stuck_window_s=10.0,
        speed_step_mps=0.01,
    )
    assert PlausibilityLimits() == limits
    assert Plausibility() == Plausibility(limits, memory_s=60.0)
    assert LocalDynamicMap() == LocalDynamicMap(
        (), 5.0, None, capacity=2000, dt_s=0.1, max_ahead_s=1.0, max_age_s=10.0, calibrations=()
    )
    assert Ears(()) == Ears((), 5.0, Plausibility(), capacity=2000, dt_s=0.1, calibrations=())
    assert len(Ears(()).map.init().held) == 2000


def test_senders_have_the_defaults_of_their_page() -> None:
    policy, bank = ErrorDriven(0.2), Bank((ConstantVelocity(),))
    sender = Sender("one", policy, bank)
    assert (sender.power_dbm, sender.jitter_s, sender.start) == (20.0, 0.005, "order")
    assert (sender.within_m, sender.threshold_m) == (0.0112, 0.2)
    assert (sender.motion, sender.selector) == (None, None)
    assert (policy.start, policy.identify, policy.max_inter_transmit_time_s) == ("order", "on-failure", None)
    assert named_sender("mbc").power_dbm == 20.0


def test_codes_are_those_that_files_and_compiled_steps_hold() -> None:
    assert [(one.name, one.value) for one in MessageKind] == [
        ("NOTHING", error_driven_kernels.NOTHING),
        ("UPDATE", error_driven_kernels.UPDATE),
        ("IDENTIFICATION", error_driven_kernels.IDENTIFICATION),
        ("KEEP_ALIVE", error_driven_kernels.KEEP_ALIVE),
    ]
    assert [one.value for one in MessageKind] == [0, 1, 2, 3]
    assert MessageKind.KEEP_ALIVE.label == "keep-alive"
    assert Decisions.at_once(np.array([1]), np.array([0]), np.array([2.0])).send_s.tolist() == [2.0]
    assert [(one.name, one.value) for one in Cause] == [
        ("NOTHING", j2945_kernels.CAUSE_NOTHING),
        ("TIME", j2945_kernels.CAUSE_TIME),
        ("DYNAMICS", j2945_kernels.CAUSE_DYNAMICS),
        ("CRITICAL", j2945_kernels.CAUSE_CRITICAL),
    ]
    assert [one.value for one in Cause] == [0, 1, 2, 3]


def test_receipts_and_findings_have_their_codes_and_words() -> None:
    names = "ACCEPTED OLDER UNKNOWN_UPDATE IN_FUTURE STALE REPEATED MALFORMED POSITION_JUMP SPEED_MISMATCH"
    assert [(one.name, one.value) for one in Receipt] == [
        (name, code) for code, name in enumerate((*names.split(), "STUCK_SPEED", "OTHER_KIND"))
    ]
    assert len({one.reason for one in Receipt}) == len(Receipt)
    assert Receipt.MALFORMED.reason == "not a possible message"
    names = "PLAUSIBLE IN_FUTURE STALE REPEATED OVERTAKEN POSITION_JUMP SPEED_MISMATCH STUCK_SPEED"
    assert [(one.name, one.value) for one in Finding] == [
        (name, code) for code, name in enumerate(names.split())
    ]
    assert len({one.reason for one in Finding}) == len(Finding)
    assert Finding.STUCK_SPEED.reason == "stuck speed"
    assert len(heard_messages([], []).kind) == 0
    assert [(one.name, one.value) for one in HeardKind] == [
        ("UPDATE", 0),
        ("PLAIN", 1),
        ("IDENTIFICATION", 2),
    ]


def test_scores_in_hindsight_are_the_mean_logarithm_of_the_time_to_the_threshold() -> None:
    ages, errors = np.array([0.5, 1.0]), np.array([[0.4, 0.1], [0.1, 0.4], [np.nan, np.nan]])
    expected = [
        np.mean([math.log(0.5 * math.sqrt(0.2 / 0.4)), math.log(1.0 * math.sqrt(0.2 / 0.1))]) + 0.2,
        np.mean([math.log(0.5 * math.sqrt(0.2 / 0.1)), math.log(1.0 * math.sqrt(0.2 / 0.4))]),
    ]
    found = hindsight_scores(ages, errors, 0.2)
    np.testing.assert_allclose(found[:2], expected, rtol=1e-12)
    assert np.isnan(found[2])
    assert LAGS_S is hindsight_kernels.LAGS_S
