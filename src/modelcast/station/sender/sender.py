"""What a station sends, and by which rule: the senders that a network run compares, and any other.

| name | rule | content, and what the sender measures its error against |
|---|---|---|
| `bsm-10hz` | `Periodic`, 10 Hz | basic safety message, coasting |
| `baseline` | `ErrorDriven` with keep-alive | the same |
| `mbc` | `ErrorDriven` with keep-alive | the model |
| `free` | the same | basic safety message, coasted by the best free sub-model |
| `j2945` | `J2945` | basic safety message, coasting |
| `j2945-filtered` | the same | the same, of the filtered motion |
| `j2945-mbc` | the same, same timers | the model, of the filtered motion |
| `j2945-mbc-relaxed`, `j2945-mbc-relaxed-5` | small errors, or 2 s or 5 s of silence | the same |
| `j2945-free`, `j2945-free-relaxed`, `j2945-free-relaxed-5` | as the three before | as `free`, filtered |
| `j3161`, `j3161-mbc`, `j3161-mbc-relaxed` | `J2945` as SAE J3161/1 has it | as the `j2945` ones |
| `cam` | `CooperativeAwareness` under adaptive control | basic safety message, coasting |
| `cam-reactive`, `cam-uncontrolled` | the same under reactive control, and under none | the same |
| `cam-road` | `MeasuredCam` under adaptive control | the same in frames as long as cars' were |

Filtered motion is what `MotionFilter` makes of a vehicle's samples. `j2945-filtered` is there to tell what
the filter does from what the models do, and the free ones to tell what models do that cost bytes: their
messages are plain (`modelcast.station.banks.free_bank`). Frames of `cam-road` are 200 to 455 bytes with all
that goes round a message (`modelcast.messages.cam_sizes`): rules of certificates do not change them.
"""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from math import inf
from types import MappingProxyType
from typing import Any

from modelcast.channel.radio import Grant
from modelcast.core.arrays import IntArray
from modelcast.core.kinds import Kind
from modelcast.messages.airtime import Stack
from modelcast.messages.cam_sizes import FrameSizes, measured_cam_sizes
from modelcast.messages.mbc_profile import carries_all, plain_members
from modelcast.messages.sizes import SizeModel
from modelcast.models.bank import Bank
from modelcast.models.learned import Selector
from modelcast.models.profile import default_profile
from modelcast.station.banks import BASELINE_BANK, believe_of, free_bank, rules_of
from modelcast.station.policy.base import AbstractTransmitPolicy
from modelcast.station.policy.cam import CooperativeAwareness
from modelcast.station.policy.costs import CostTable
from modelcast.station.policy.dcc import AdaptiveDcc, ReactiveDcc
from modelcast.station.policy.error_driven import APPROACH_M, LOSS_BUDGET, ErrorDriven
from modelcast.station.policy.guard import unguarded
from modelcast.station.policy.j2945 import J2945
from modelcast.station.policy.j2945_parameters import (
    RELAXED_ERROR_M,
    J2945Parameters,
    j2945_relaxed_parameters,
    j3161_parameters,
)
from modelcast.station.policy.measured_cam import MeasuredCam
from modelcast.station.policy.periodic import Periodic
from modelcast.station.policy.rules import BelieveRule, IdentifyRule, StartRule
from modelcast.station.sender.lane_rules import check_rules
from modelcast.station.sender.names import (
    SENDERS,
    OwnSettings,
    check_sender,
    own_sender,
    own_settings,
    plain_policy,
    sends_free,
    sends_models,
)
from modelcast.station.sensing.motion_filter import MotionFilter

__all__ = [
    "THRESHOLD_STARTS",
    "TIMED_STARTS",
    "Sender",
    "engine_parameters",
    "named_sender",
]

THRESHOLD_STARTS = ("guarded", "hindsight", "predicted")
"""Start rules that judge sub-models by a threshold, also where timers call for messages."""

TIMED_STARTS = ("order", "keep", "predicted", "hindsight", "recent")
"""Start rules of senders whose timers, not the failures of sub-models, call for messages."""

_RELAXED_S = {
    f"j2945-{content}-relaxed{ending}": longest_s
    for content in ("free", "mbc")
    for ending, longest_s in (("", 2.0), ("-5", 5.0))
} | {"j3161-mbc-relaxed": 2.0}
_GRANTS = {"any": Grant.ANY, "periodic": Grant.PERIODIC, "one-shot": Grant.ONE_SHOT}
_WHATEVER_IS_SENT: Mapping[str, AbstractTransmitPolicy[Any]] = MappingProxyType(
    {
        "bsm-10hz": Periodic(10.0),
        "cam": CooperativeAwareness(control=AdaptiveDcc()),
        "cam-reactive": CooperativeAwareness(control=ReactiveDcc()),
        "cam-uncontrolled": CooperativeAwareness(control=None),
        "cam-road": MeasuredCam(),
    }
)
"""Rules that no option changes."""

_JITTER_S = 0.005
_WITHIN_M = 0.0112
"""Of paths that are the same to a receiver: a code of latitude is worth 1.11 to 1.12 cm."""

_PLAIN_SHARE = 0.4
"""Of the error that calls for a message: a plain one must not spend more of it than this (decision 021)."""


@dataclass(frozen=True, slots=True)
class Sender:
    """A rule and a bank of sub-models, the same for all stations of a run.

    Parameters
    ----------
    name
        As in tables.
    policy
        When a station sends; an error-driven one also says with which sub-model, and when another is named.
    bank
        What it sends.
    stack
        What goes round the payload on the air.
    sizes
        Bytes of the payload, and the kind of road user that sends.
    power_dbm
        Transmit power where the policy leaves it open [dBm].
    jitter_s
        A message that leaves at once is handed to the radio up to this much later, so that two stations do
        not meet on the air again and again; vTxRand of SAE J2945/1 [s].
    start
        Which sub-model a message carries that a timer called for, one of `TIMED_STARTS`; an error-driven
        policy has its own rule. ``recent``: the smallest message whose sub-model, fitted at one message and
        judged at the next, erred no more of late than the best one's, but for `within_m` (mean squares). A
        guard there is none: what constant velocity alone would have sent is a matter of timers that other
        messages set.
    within_m
        Resolution below which recent errors are equal [m].
    threshold_m
        Error at which ``hindsight`` takes a prediction to have failed [m].
    motion
        How a station estimates its motion from what its sensors show; None takes the newest sample as it is,
        as a basic safety message does.
    selector
        Predicts which sub-model lasts, for start ``predicted``.
    grant
        Which kind of resource every message asks for, where a radio reserves resources.
    frames
        Sizes of whole frames, where they do not follow from what is sent; of vehicles alone.

    Raises
    ------
    ValueError
        Where a value is out of its range, timers cannot follow the start rule, or a rule lacks what it needs
        (`check_rules`).

    Examples
    --------
    >>> sender = named_sender("j2945-mbc")
    >>> [member.name for member in sender.bank.members], sender.update_bytes.tolist()
    (['free-predictive', 'free', 'ctra', 'cv'], [40, 40, 40, 47])
    """

    name: str
    policy: AbstractTransmitPolicy[Any]
    bank: Bank
    _: KW_ONLY
    stack: Stack = field(default_factory=Stack)
    sizes: SizeModel = field(default_factory=SizeModel)
    power_dbm: float = 20.0
    jitter_s: float = _JITTER_S
    start: StartRule = "order"
    within_m: float = _WITHIN_M
    threshold_m: float = 0.2
    motion: MotionFilter | None = None
    selector: Selector | None = None
    grant: Grant = Grant.ANY
    frames: FrameSizes | None = None

    def __post_init__(self) -> None:
        if not 0.0 <= self.jitter_s < 0.1:
            raise ValueError(f"jitter_s must lie in [0, 0.1), got {self.jitter_s}")
        if not self.within_m >= 0.0:
            raise ValueError(f"within_m must not be negative, got {self.within_m}")
        if self.start not in TIMED_STARTS:
            raise ValueError(
                f"start must be one of {', '.join(TIMED_STARTS)} under timers, got {self.start!r}"
            )
        if self.frames is not None:
            if self.kind != Kind.VEHICLE:
                raise ValueError(f"{self.name} sends frames as long as cars': {self.kind} is none")
            if self.stack.certificates != "unsigned":
                raise ValueError(f"frames hold their signature: stack must be unsigned, got {self.stack}")
            if min(self.frames.size_bytes) <= self.stack.numbers.around_bytes:
                raise ValueError(f"frames must be longer than what goes round them, got {self.frames}")
        check_rules(self.lanes, self.bank, self.selector)

    @property
    def lanes(self) -> ErrorDriven:
        """Rules of the lanes: the policy's own where errors call for messages, else of what timers send."""
        if isinstance(self.policy, ErrorDriven):
            return self.policy if len(self.bank.members) > 1 else self.policy.alone
        return ErrorDriven(self.threshold_m, self.start, "never")

    @property
    def update_bytes(self) -> IntArray:
        """Bytes of an update by its sub-model, (M,)."""
        return self.sizes.each_update_bytes(self.bank.complete(), self.lanes.identify)

    @property
    def carries_all(self) -> bool:
        """Whether an update holds the parameters of all sub-models."""
        return carries_all(self.bank.complete(), self.lanes.identify)

    @property
    def plain(self) -> tuple[bool, ...]:
        """Sub-models with which a message is a plain one."""
        return plain_members(self.bank.complete(), self.lanes.identify, self.kind)

    @property
    def kind(self) -> Kind:
        """Kind of road user that sends: a vehicle basic safety messages, a person personal ones."""
        return self.sizes.kind

    def of_kind(self, kind: Kind) -> "Sender":
        """The same rule and bank for another kind of road user.

        Parameters
        ----------
        kind
            A vehicle, or one of `modelcast.core.kinds.PEOPLE`.

        Raises
        ------
        ValueError
            Where the kind has no message of its own.

        Examples
        --------
        >>> named_sender("baseline").of_kind(Kind.CYCLIST).update_bytes.tolist()
        [29]
        """
        return replace(self, sizes=replace(self.sizes, kind=kind))

    @property
    def longest_silence_s(self) -> float:
        """Longest time between two messages that the rule allows [s]."""
        return self.policy.longest_silence_s

    def at_power(self, most_dbm: float) -> "Sender":
        """The same sender with no more power than this; a rule that chooses among powers has those below.

        Parameters
        ----------
        most_dbm
            Of every message [dBm].

        Examples
        --------
        >>> named_sender("j2945").at_power(14.0).policy.parameters.max_power_dbm
        14.0
        """
        policy = self.policy
        if isinstance(policy, J2945):
            given = policy.parameters
            parameters = replace(
                given,
                min_power_dbm=min(given.min_power_dbm, most_dbm),
                max_power_dbm=min(given.max_power_dbm, most_dbm),
                start_power_dbm=min(given.start_power_dbm, most_dbm),
            )
            policy = replace(policy, parameters=parameters)
        return replace(self, policy=policy, power_dbm=min(self.power_dbm, most_dbm))


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


def _timers_of(name: str, given: J2945Parameters, said: OwnSettings) -> J2945Parameters:
    """Constants of J2945/1 with what J3161/1 has otherwise; relaxed senders go by their error whatever."""
    switches = said.switches
    if not name.startswith("j3161"):
        return given
    if name not in _RELAXED_S:
        theirs = j3161_parameters(**switches)
    elif switches.get("tracking_error_trigger", True):
        theirs = j3161_parameters(**{**switches, "tracking_error_trigger": True})
    else:
        raise ValueError(f"{name} sends by its tracking error: tracking_error_trigger must be yes")
    return replace(
        given,
        power_control=theirs.power_control,
        tracking_error_trigger=theirs.tracking_error_trigger,
    )


def _bank_of(name: str, bank: Bank | None) -> Bank:
    """Sub-models of the sender of that name."""
    if sends_free(name):
        chosen = free_bank() if bank is None else bank
        if len(chosen.members) > 1 or chosen.plain_place < 0:
            raise ValueError(
                f"{name} sends plain messages: its bank is one free sub-model, got {chosen.name}"
            )
        return chosen
    if not sends_models(name):
        return BASELINE_BANK
    return default_profile().bank if bank is None else bank


def named_sender(
    name: str,
    *,
    bank: Bank | None = None,
    start: StartRule | None = None,
    identify: IdentifyRule | None = None,
    costs: CostTable | None = None,
    selector: Selector | None = None,
    threshold_m: float = 0.2,
    keep_alive_s: float = 1.0,
    believe: BelieveRule | None = None,
    budget: float = LOSS_BUDGET,
    approach_m: float = APPROACH_M,
    legacy_threshold_m: float = inf,
    parameters: J2945Parameters | None = None,
    relaxed_error_m: float | None = None,
    motion: MotionFilter | None = None,
    stack: Stack | None = None,
) -> Sender:
    """The sender of that name.

    Parameters
    ----------
    name
        One of `modelcast.station.sender.names.SENDERS`, with settings or without
        (`modelcast.station.sender.names.own_settings`), or a policy of another package, as
        `modelcast.station.sender.names.check_sender` takes it; what it sends is fitted as under timers.
    bank
        Sub-models of those that send models; None for the shipped profile's. Of the free ones, a bank of one
        free sub-model; None for `free_bank`.
    start, identify
        Rules of those that send models. Where None, an error-driven one takes those of the shipped profile
        for its bank and the plain reading of the paper, ``order`` and ``on-failure``, for any other; timers
        start with what erred least of late, ``recent``, and name no other sub-model later.
    costs, selector
        What ``cheapest`` and ``predicted`` need.
    threshold_m, keep_alive_s
        Of the error-driven ones [m], [s].
    believe, budget
        Of the error-driven one that sends models, as in `ErrorDriven`. Where None, what
        `believe_of` says of its rules.
    approach_m, legacy_threshold_m
        Of the error-driven ones [m].
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
    ConfigError
        Where there is no such name, or a policy refuses its settings.
    ValueError
        Where an error is not positive, a bank of a free one says more than Part I
        does, or a rule does not go with the sender.
    """
    check_sender(name)
    if relaxed_error_m is not None and not relaxed_error_m > 0.0:
        raise ValueError(f"relaxed_error_m must be positive, got {relaxed_error_m}")
    own = MotionFilter() if motion is None else motion
    chosen = _bank_of(name, bank)
    within_m = _WITHIN_M
    word, name = name, own_sender(name) or name
    said = own_settings(word) if name in SENDERS else OwnSettings()
    timers = _timers_of(name, engine_parameters() if parameters is None else parameters, said)
    if name in _RELAXED_S:
        error_m = max(RELAXED_ERROR_M, own.position_m) if relaxed_error_m is None else relaxed_error_m
        timers = j2945_relaxed_parameters(_RELAXED_S[name], timers, error_m=error_m)
        within_m = min(within_m, _PLAIN_SHARE * error_m)
    policy: AbstractTransmitPolicy[Any] = J2945(timers)
    first: StartRule = "order"
    if name in _WHATEVER_IS_SENT:
        policy = _WHATEVER_IS_SENT[name]
    elif name in {"baseline", "free"}:
        policy = ErrorDriven(
            threshold_m,
            identify="never",
            max_inter_transmit_time_s=keep_alive_s,
            believe="sent" if name == "baseline" else believe or "expected",
            budget=budget,
            approach_m=approach_m,
            legacy_threshold_m=legacy_threshold_m,
        )
    elif name == "mbc":
        rules = rules_of(chosen)
        policy = ErrorDriven(
            threshold_m,
            start or rules[0],
            identify or rules[1],
            keep_alive_s,
            costs,
            believe=believe or believe_of(start or rules[0], identify or rules[1]),
            budget=budget,
            approach_m=approach_m,
            legacy_threshold_m=legacy_threshold_m,
        )
    elif sends_models(name):
        if name not in SENDERS:
            policy = plain_policy(word, threshold_m)
        first = unguarded(start or "recent")
        if identify not in {None, "never"}:
            raise ValueError(
                f"{name} fits all anew whenever a timer calls: identify must be never, got {identify!r}"
            )
    around = Stack() if stack is None else stack
    frames = measured_cam_sizes() if name == "cam-road" else None
    return Sender(
        word,
        policy,
        chosen,
        stack=around if frames is None else replace(around, certificates="unsigned", other_bytes=0),
        frames=frames,
        start=first,
        within_m=within_m,
        threshold_m=threshold_m,
        motion=own if isinstance(policy, J2945) and name not in {"j2945", "j3161"} else None,
        selector=selector,
        grant=_GRANTS[said.grant],
    )
