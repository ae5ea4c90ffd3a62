"""A transmit policy as the compiled station takes it."""

from typing import NamedTuple

from modelcast.core.kernel_types import FloatVector

__all__ = ["RULE_CAM", "RULE_ERROR_DRIVEN", "RULE_J2945", "RULE_PERIODIC", "RULE_PLAIN", "PolicyNumbers"]

RULE_PERIODIC, RULE_ERROR_DRIVEN, RULE_J2945, RULE_CAM, RULE_PLAIN = range(5)
"""Codes of the rules; the last is decided in NumPy, between two compiled steps."""


class PolicyNumbers(NamedTuple):
    """Numbers of a policy.

    ``rule`` is one of the codes above and ``constants`` are its own; ``control`` and ``control_constants``
    are those of congestion control (`dcc_kernels`), ``start_share`` what a new station takes of the channel;
    ``interval_s`` the time between messages, or the least one. A deceleration of ``critical_mps2`` is an
    event.
    """

    rule: int
    constants: FloatVector
    control: int
    control_constants: FloatVector
    start_share: float
    interval_s: float
    critical_mps2: float
