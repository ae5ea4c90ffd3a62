"""A sender's models, rule and stack as the plain tuples and arrays that the compiled loop takes."""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.messages.airtime_kernels import StackNumbers
from modelcast.runtime.fleet.layout_kernels import (
    RULE_CAM,
    RULE_ERROR_DRIVEN,
    RULE_J2945,
    RULE_PERIODIC,
)
from modelcast.runtime.fleet.sender import FleetSender
from modelcast.station.policy import dcc_kernels
from modelcast.station.policy.cam import CooperativeAwareness
from modelcast.station.policy.dcc import AdaptiveDcc
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.j2945 import J2945
from modelcast.station.policy.periodic import Periodic
from modelcast.station.sensing.noise import DEFAULT_NOISE

__all__ = ["LoopConstants", "loop_constants"]


@dataclass(frozen=True, slots=True)
class LoopConstants:
    """What the compiled loop takes of a sender."""

    rule: int
    rule_constants: FloatArray
    _: KW_ONLY
    control: int
    control_constants: FloatArray
    extra: tuple[float, float, float, float]
    stack: StackNumbers
    noise: tuple[float, float, float, float, float, float]
    critical_mps2: float


def loop_constants(sender: FleetSender, dt_s: float) -> LoopConstants:
    """Return what the compiled loop takes of a sender, for steps of ``dt_s`` [s]."""
    policy, stack = sender.policy, sender.stack
    rule, control, control_constants = RULE_PERIODIC, dcc_kernels.NONE, np.zeros(1)
    interval_s, share, critical_mps2 = 0.0, 0.0, np.inf
    if isinstance(policy, Periodic):
        interval_s = 1.0 / policy.rate_hz
    elif isinstance(policy, ErrorDriven):
        rule = RULE_ERROR_DRIVEN
    elif isinstance(policy, J2945):
        rule, critical_mps2 = RULE_J2945, policy.parameters.critical_deceleration_mps2
    else:
        rule, interval_s = RULE_CAM, policy.triggering.min_inter_transmit_time_s
        control, control_constants, share = _control(policy)
    noise = DEFAULT_NOISE.numbers(dt_s)
    return LoopConstants(
        rule,
        sender.rule_constants(),
        control=control,
        control_constants=control_constants,
        extra=(sender.power_dbm, sender.jitter_s, interval_s, share),
        stack=stack.numbers,
        noise=(noise.first_mean, noise.averaged, noise.clip, noise.share, noise.prior_count, noise.free),
        critical_mps2=critical_mps2,
    )


def _control(policy: CooperativeAwareness) -> tuple[int, FloatArray, float]:
    control = policy.control
    if control is None:
        return dcc_kernels.NONE, np.zeros(1), 0.0
    share = 0.0
    if isinstance(control, AdaptiveDcc):
        share = control.max_share if control.start_share is None else control.start_share
    return control.code, control.constants(), share
