"""What the vehicles of a fleet send, and by which rule: the senders that a network run compares.

| name | rule | content, and what the sender measures its error against |
|---|---|---|
| `bsm-10hz` | `Periodic`, 10 Hz | basic safety message, coasting |
| `baseline` | `ErrorDriven` with keep-alive | the same |
| `mbc` | `ErrorDriven` with keep-alive | the model |
| `j2945` | `J2945` | basic safety message, coasting |
| `j2945-filtered` | the same | the same, of the filtered motion |
| `j2945-mbc` | the same, same timers | the model, of the filtered motion |
| `j2945-mbc-relaxed`, `j2945-mbc-relaxed-5` | small errors, or 2 s or 5 s of silence | the same |
| `cam` | `CooperativeAwareness` under adaptive control | basic safety message, coasting |

Filtered motion is what `MotionFilter` makes of a vehicle's samples. `j2945-filtered` is there to tell what
the filter does from what the models do.
"""

from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Literal

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.messages.airtime import Stack
from modelcast.messages.quantisation import core_steps, quantised_bank
from modelcast.messages.sizes import SizeModel
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.profile import default_profile
from modelcast.station.policy.cam import CooperativeAwareness
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.j2945 import J2945
from modelcast.station.policy.j2945_parameters import (
    RELAXED_ERROR_M,
    J2945Parameters,
    j2945_relaxed_parameters,
)
from modelcast.station.policy.periodic import Periodic
from modelcast.station.sensing.motion_filter import MotionFilter

__all__ = ["SENDERS", "FleetSender", "engine_parameters", "named_sender"]

SENDERS = (
    "bsm-10hz",
    "baseline",
    "mbc",
    "j2945",
    "j2945-filtered",
    "j2945-mbc",
    "j2945-mbc-relaxed",
    "j2945-mbc-relaxed-5",
    "cam",
)
"""Names that `named_sender` knows."""

Rule = Periodic | ErrorDriven | J2945 | CooperativeAwareness

_JITTER_S = 0.005

_PLAIN_SHARE = 0.4
"""Of the error that calls for a message: a plain one must not spend more of it than this (decision 021)."""


@dataclass(frozen=True, slots=True)
class FleetSender:
    """A rule and a bank of sub-models, the same for all vehicles.

    Parameters
    ----------
    name
        As in tables.
    policy
        When a vehicle sends.
    bank
        What it sends; quantised here as its receivers hold it. Constant velocity, the plain basic safety
        message, is added last where it is not.
    stack
        What goes round the payload on the air.
    sizes
        Bytes of the payload.
    power_dbm
        Transmit power where the policy leaves it open [dBm].
    jitter_s
        A message that leaves at once is handed to the radio up to this much later, so that two vehicles do
        not meet on the air again and again; vTxRand of SAE J2945/1 [s].
    choice
        Which sub-model a message carries. ``order``: the first of the bank that has a full window, but a
        plain message where its path and that of coasting are the same within `plain_within_m`, half-way to
        `plain_horizon_s` and there. ``recent``: the smallest message whose sub-model, fitted at one message
        and judged at the next, erred no more of late than the best one's, but for `plain_within_m` (mean
        squares).
    motion
        How a vehicle estimates its motion from what its sensors show; None takes the newest sample as it is,
        as a basic safety message does.
    plain_within_m, plain_horizon_s
        The default of the first is the step of the position on the wire [m], [s].

    Raises
    ------
    ValueError
        Where a value is out of its range, or an error-driven policy names sub-models: only the one in use is
        sent here.

    Examples
    --------
    >>> sender = named_sender("j2945-mbc")
    >>> [member.name for member in sender.bank.members], sender.payload_bytes.tolist()
    (['learned', 'ctra', 'gp-vehicle', 'cv'], [53, 47, 60, 40])
    """

    name: str
    policy: Rule
    bank: Bank
    _: KW_ONLY
    stack: Stack = field(default_factory=Stack)
    sizes: SizeModel = field(default_factory=SizeModel)
    power_dbm: float = 20.0
    jitter_s: float = _JITTER_S
    plain_within_m: float = field(default_factory=lambda: core_steps().position_m)
    plain_horizon_s: float = 2.0
    choice: Literal["order", "recent"] = "order"
    motion: MotionFilter | None = None

    def __post_init__(self) -> None:
        policy = self.policy
        if isinstance(policy, ErrorDriven) and (policy.identify, policy.start) != ("never", "order"):
            raise ValueError(
                "an error-driven sender sends the sub-model in use alone: identify must be 'never' and start "
                f"'order', got {policy.identify!r} and {policy.start!r}"
            )
        if not 0.0 <= self.jitter_s < 0.1:
            raise ValueError(f"jitter_s must lie in [0, 0.1), got {self.jitter_s}")
        for name in ("plain_within_m", "plain_horizon_s"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must not be negative, got {getattr(self, name)}")
        bank = quantised_bank(self.bank)
        if bank.members[-1].name != ConstantVelocity().name:
            plain = quantised_bank(Bank((ConstantVelocity(),)))
            bank = Bank((*bank.members, *plain.members), bank.name)
        object.__setattr__(self, "bank", bank)

    @property
    def limits(self) -> tuple[float, float, float]:
        """What chooses the sub-model, as the compiled loop takes it."""
        return self.plain_within_m, self.plain_horizon_s, float(self.choice == "recent")

    @property
    def payload_bytes(self) -> IntArray:
        """Bytes of a message by its sub-model, (M,)."""
        return self.sizes.each_update_bytes(self.bank, "never")

    @property
    def parameter_counts(self) -> IntArray:
        """How many parameters each sub-model has, (M,)."""
        return np.array([len(member.parameter_names) for member in self.bank.members], dtype=np.int64)

    def rule_constants(self) -> FloatArray:
        """Constants of the rule as its compiled step takes them."""
        policy = self.policy
        if isinstance(policy, J2945):
            return policy.parameters.constants()
        if isinstance(policy, CooperativeAwareness):
            return policy.triggering.constants()
        if isinstance(policy, ErrorDriven):
            return np.array(policy.codes[:2], dtype=np.float64)
        return np.zeros(1)

    @property
    def longest_silence_s(self) -> float:
        """Longest time between two messages that the rule allows [s]."""
        policy = self.policy
        if isinstance(policy, J2945):
            return policy.parameters.max_inter_transmit_time_s
        if isinstance(policy, CooperativeAwareness):
            return policy.triggering.max_inter_transmit_time_s
        if isinstance(policy, ErrorDriven):
            return policy.codes[1]
        return 1.0 / policy.rate_hz


def engine_parameters(parameters: J2945Parameters | None = None) -> J2945Parameters:
    """J2945/1's constants with positions extrapolated at any age, as a public stack has them.

    A fleet is asked at times of its own between two samples. The standard's estimate "as it is" below 50 ms
    would set a position of 40 ms ago against an extrapolated one: at 30 m/s a tracking error of 1.2 m that
    nobody has, and a message at every step. `docs/decisions/020-closed-loop.md` has the measurement.

    Parameters
    ----------
    parameters
        What everything else is taken from; None for the standard's.
    """
    given = J2945Parameters() if parameters is None else parameters
    return replace(given, local_as_is_age_s=0.0, local_max_age_s=0.2, remote_as_is_age_s=0.0)


def named_sender(
    name: str,
    *,
    bank: Bank | None = None,
    threshold_m: float = 0.2,
    keep_alive_s: float = 2.0,
    parameters: J2945Parameters | None = None,
    relaxed_error_m: float | None = None,
    motion: MotionFilter | None = None,
    stack: Stack | None = None,
) -> FleetSender:
    """The sender of that name.

    Parameters
    ----------
    name
        One of `SENDERS`.
    bank
        Sub-models of those that send models; None for the shipped profile's.
    threshold_m, keep_alive_s
        Of the error-driven ones [m], [s].
    parameters
        Constants of J2945/1; None for `engine_parameters`.
    relaxed_error_m
        Error that calls for a message of the relaxed ones where traffic is thin [m]; None for
        `RELAXED_ERROR_M`, or the noise of the position that the filter is told where that is more.
    motion
        Filter of those that filter their motion; None for one that knows the default sensors.
    stack
        What goes round the payload; None for the default table.

    Raises
    ------
    ValueError
        Where there is no such name, or an error is not positive.
    """
    timers = engine_parameters() if parameters is None else parameters
    coasting = Bank((ConstantVelocity(),), "cv")
    own = MotionFilter() if motion is None else motion
    relaxed = {"j2945-mbc-relaxed": 2.0, "j2945-mbc-relaxed-5": 5.0}
    if name not in SENDERS:
        raise ValueError(f"sender must be one of {', '.join(SENDERS)}, got {name!r}")
    if relaxed_error_m is not None and not relaxed_error_m > 0.0:
        raise ValueError(f"relaxed_error_m must be positive, got {relaxed_error_m}")
    within_m = core_steps().position_m
    if name in relaxed:
        error_m = max(RELAXED_ERROR_M, own.position_m) if relaxed_error_m is None else relaxed_error_m
        timers = j2945_relaxed_parameters(relaxed[name], timers, error_m=error_m)
        within_m = min(within_m, _PLAIN_SHARE * error_m)
    policy: Rule = J2945(timers)
    if name == "bsm-10hz":
        policy = Periodic(10.0)
    elif name in {"baseline", "mbc"}:
        policy = ErrorDriven(threshold_m, identify="never", max_inter_transmit_time_s=keep_alive_s)
    elif name == "cam":
        policy = CooperativeAwareness()
    sends_models = "mbc" in name
    filters = isinstance(policy, J2945) and name != "j2945"
    return FleetSender(
        name,
        policy,
        (default_profile().bank if bank is None else bank) if sends_models else coasting,
        stack=Stack() if stack is None else stack,
        plain_within_m=within_m,
        choice="recent" if sends_models and isinstance(policy, J2945) else "order",
        motion=own if filters else None,
    )
