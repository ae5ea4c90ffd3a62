"""What an evaluation is asked to do."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, asdict, dataclass, field, replace
from numbers import Integral
from typing import Any, Literal, get_args

import numpy as np

from modelcast.channel.base import AbstractChannel
from modelcast.channel.erasure import GilbertElliott, IndependentErasure
from modelcast.channel.recorded import RecordedLosses
from modelcast.core.argument_types import require_type
from modelcast.messages.airtime import Stack
from modelcast.messages.sizes import SizeModel
from modelcast.models.bank import Bank
from modelcast.models.learned import Selector
from modelcast.models.profile import default_profile
from modelcast.runtime.trip.context import ContextSettings
from modelcast.station.banks import believe_of, free_bank, rules_of
from modelcast.station.policy.base import AbstractTransmitPolicy
from modelcast.station.policy.costs import CostTable
from modelcast.station.policy.error_driven import LOSS_BUDGET, ErrorDriven
from modelcast.station.policy.rules import BelieveRule, IdentifyRule, StartRule
from modelcast.station.sender.lane_rules import check_rules
from modelcast.station.sensing.rules import VelocityRule
from modelcast.study.rules import MODEL_SENDER, RIVALS
from modelcast.world.sensors import SensorModel

__all__ = ["EvaluationSettings"]

_SEVERAL = "give several numbers, as (0.2, 0.5)"


def _require_positive(name: str, value: float) -> None:
    if not value > 0:
        raise ValueError(f"{name} must be positive, got {value}")


def _require_known(name: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        raise ValueError(f"{name} must be one of {', '.join(known)}, got {value!r}")


@dataclass(frozen=True, slots=True)
class EvaluationSettings:
    """What an evaluation is asked to do.

    Parameters
    ----------
    thresholds_m
        Tracking-error thresholds [m].
    packet_error_ratios
        Mean shares of messages lost in the loss runs, 0..1.
    seeds, seed
        How many runs are drawn for every loss ratio, and the seed they are spawned from.
    bank
        Sub-models of model-based communication; the shipped profile's where not given.
    start, identify
        The policy's rules, as in `ErrorDriven`. Where None, those of that profile for its bank, and the plain
        reading of the paper, ``order`` and ``on-failure``, for any other.
    selector
        Predicts which sub-model of the bank lasts; needed for ``start`` ``predicted``.
    costs
        What messages cost and how long they serve; needed for ``identify`` ``cheapest``.
    keep_alive_s
        Longest silence in the loss runs, for every error-driven policy [s]; rate runs have none.
    believe
        What model-based senders take their remotes to hold in loss runs, as in `ErrorDriven`: whatever they
        ``sent``, or what is ``expected`` at the run's own loss ratio, which they are taken to have observed.
        Where None, as `modelcast.station.banks.believe_of` says of the rules. The paper's baselines believe
        in what they sent.
    budget
        Messages that a sender which expects losses may send, over those of a channel without.
    legacy_threshold_m
        Error of legacy receivers that calls for an update of model-based senders, as in `ErrorDriven`;
        infinite for none.
    mean_burst_s
        Mean length of loss bursts [s]; None for independent losses.
    recorded
        Losses to replay instead of drawing them; the one packet error ratio is theirs. None to draw them.
    delay_s
        Delivery delay [s].
    expiry_s
        Silence after which the host drops a remote [s]; None keeps it. Samples without a track are excluded
        and counted.
    protocol
        ``recorded``, ``sensor``, or ``auto``: sensor where the log is on a coarse grid or holds values.
    sensor
        What the sender measures in the ``sensor`` protocol.
    keep_samples
        Whose tracking-error samples are kept: of the ``first`` seed, ``all`` or ``none``.
    map_at
        Trip id and time of the manoeuvre to draw [s]; None picks the sharpest.
    detail_threshold_m
        Which of the thresholds timeline, map and figures of single trips show [m]; the first where None.
    quantised
        Whether senders, hosts and the baseline predict with what a message can say (the default), or with
        the numbers as they were fitted.
    sizes
        How many bytes each kind of message takes.
    stack
        What goes round a message on the air, and which carry a certificate.
    trained_on
        Fingerprints of the trips that the bank was trained on (`modelcast.trips.fingerprint`); those of the
        shipped profile for its bank, and none for any other, where None.
    velocity
        Where constant velocity, and with it the baseline, takes its velocity from: ``reported``, ``slope-2``,
        ``quadratic-4``, or ``auto``, as in `modelcast.station.sensing.velocity.velocity_estimator_for`.
    references
        Whether the clairvoyant references and the rules of cooperative awareness messages are counted too.
    context
        What a bank that reads context is let know of the road and the vehicle ahead; its seed is that of the
        evaluation, its delay at least `delay_s`, and its losses are those of each loss ratio.
    free
        Bank of the free receiver that MBC is held against beside the baseline: plain messages whose receiver
        extrapolates well; the shipped one where not given. It is not run where None, or where it is `bank`.
    free_trained_on
        Fingerprints of the trips that it was trained on; where None, those of the shipped profile for the
        shipped one, and none for any other.
    decides
        A policy in NumPy that calls for the messages of model-based senders, at each threshold where it has
        one; None for the error-driven one. It knows of no channel. The baselines stay error-driven.
    decided_by
        What rows call model-based senders where `decides` is given; the name of its class where empty.

    Raises
    ------
    ValueError
        Where a value is out of its range.
    """

    thresholds_m: tuple[float, ...] = (0.2, 0.3, 0.4, 0.5)
    packet_error_ratios: tuple[float, ...] = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    _: KW_ONLY
    seeds: int = 5
    seed: int = 0
    bank: Bank = field(default_factory=lambda: default_profile().bank)
    start: StartRule | None = None
    identify: IdentifyRule | None = None
    selector: Selector | None = None
    costs: CostTable | None = None
    keep_alive_s: float | None = 2.0
    believe: BelieveRule | None = None
    budget: float = LOSS_BUDGET
    legacy_threshold_m: float = np.inf
    mean_burst_s: float | None = None
    recorded: RecordedLosses | None = None
    delay_s: float = 0.0
    expiry_s: float | None = None
    protocol: Literal["auto", "recorded", "sensor"] = "auto"
    sensor: SensorModel = field(default_factory=SensorModel)
    keep_samples: Literal["first", "all", "none"] = "first"
    map_at: tuple[str, float] | None = None
    detail_threshold_m: float | None = None
    quantised: bool = True
    sizes: SizeModel = field(default_factory=SizeModel)
    stack: Stack = field(default_factory=Stack)
    trained_on: frozenset[str] | None = None
    velocity: VelocityRule = "auto"
    references: bool = True
    context: ContextSettings = field(default_factory=ContextSettings)
    free: Bank | None = field(default_factory=free_bank)
    free_trained_on: frozenset[str] | None = None
    decides: AbstractTransmitPolicy[Any] | None = None
    decided_by: str = ""

    def __post_init__(self) -> None:
        self._check_types()
        if not self.thresholds_m:
            raise ValueError("at least one threshold is needed")
        for name, values in (
            ("thresholds_m", self.thresholds_m),
            ("packet_error_ratios", self.packet_error_ratios),
        ):
            if len(set(values)) != len(values):
                raise ValueError(f"{name} must not repeat, got {values}")
        if self.seeds < 1 or self.seed < 0:
            raise ValueError(f"seeds must be >= 1 and seed >= 0, got {self.seeds} and {self.seed}")
        if not (np.isfinite(self.delay_s) and self.delay_s >= 0):
            raise ValueError(f"delay_s must be finite and not negative, got {self.delay_s}")
        if self.expiry_s is not None and not self.expiry_s > 0:
            raise ValueError(f"expiry_s must be positive or None, got {self.expiry_s}")
        _require_positive("budget", self.budget)
        _require_positive("legacy_threshold_m", self.legacy_threshold_m)
        _require_known("believe", self.belief, get_args(BelieveRule))
        _require_known("protocol", self.protocol, ("auto", "recorded", "sensor"))
        _require_known("velocity", self.velocity, get_args(VelocityRule))
        _require_known("keep_samples", self.keep_samples, ("first", "all", "none"))
        for threshold_m in self.thresholds_m:
            check_rules(self.under_loss(threshold_m, 0.0), self.bank, self.selector)
        self._check_sender()
        self._check_details()
        if self.mean_burst_s is not None and self.recorded is not None:
            raise ValueError("mean_burst_s and recorded: losses are drawn or replayed, give one of the two")
        for ratio in self.packet_error_ratios:
            self.channel(ratio)

    def policy(self, threshold_m: float, *, keep_alive: bool) -> ErrorDriven:
        """The error-driven policy at a threshold, with or without the keep-alive of the loss runs.

        Parameters
        ----------
        threshold_m
            The threshold [m].
        keep_alive
            Whether `keep_alive_s` bounds the silence.
        """
        longest = self.keep_alive_s if keep_alive else None
        start, identify = self.rules
        return ErrorDriven(
            threshold_m, start, identify, longest, self.costs, legacy_threshold_m=self.legacy_threshold_m
        )

    def under_loss(self, threshold_m: float, ratio: float) -> ErrorDriven:
        """The error-driven policy of the loss runs at a threshold and a loss ratio.

        Parameters
        ----------
        threshold_m
            The threshold [m].
        ratio
            Share of the messages that are lost, 0..1; a sender that minds losses is told it.
        """
        policy = self.policy(threshold_m, keep_alive=True)
        if self.belief == "sent":
            return policy
        return replace(policy, believe=self.belief, packet_error_ratio=ratio, budget=self.budget)

    def _check_types(self) -> None:
        """Refuse what is of another type than its name says."""
        require_type("seeds", self.seeds, Integral, remedy="give a whole number")
        require_type("seed", self.seed, Integral, remedy="give a whole number")
        require_type("bank", self.bank, Bank, remedy='give modelcast.bank_from_text("cv") or its like')
        require_type("thresholds_m", self.thresholds_m, Sequence, remedy=_SEVERAL)
        require_type("packet_error_ratios", self.packet_error_ratios, Sequence, remedy=_SEVERAL)
        if self.free is not None:
            require_type("free", self.free, Bank, remedy='give modelcast.bank_from_text("free") or None')

    def _check_details(self) -> None:
        """Refuse a threshold to show that is none of those evaluated."""
        if self.detail_threshold_m not in {None, *self.thresholds_m}:
            known = ", ".join(f"{item:g}" for item in self.thresholds_m)
            raise ValueError(f"detail_threshold_m must be one of {known}, got {self.detail_threshold_m:g}")

    def _check_sender(self) -> None:
        """Refuse a name that says nothing, or that rows give to somebody else."""
        if self.decided_by and self.decides is None:
            raise ValueError(f"decided_by must be empty where decides is None, got {self.decided_by!r}")
        if self.decides is not None and self.sender in {MODEL_SENDER, *RIVALS}:
            raise ValueError(f"decided_by must not be the name of another sender, got {self.sender!r}")

    @property
    def sender(self) -> str:
        """What rows call model-based senders: ``mbc`` where the error-driven policy decides."""
        return MODEL_SENDER if self.decides is None else self.decided_by or type(self.decides).__name__

    @property
    def detail(self) -> int:
        """Place among the thresholds of the one that detail figures show."""
        return 0 if self.detail_threshold_m is None else self.thresholds_m.index(self.detail_threshold_m)

    @property
    def rival(self) -> Bank | None:
        """The free receiver's bank where it is run: not beside itself."""
        return None if self.free == self.bank else self.free

    @property
    def of_free(self) -> "EvaluationSettings":
        """The settings that the free receiver's sender is run by: MBC's, as far as plain messages have them.

        Raises
        ------
        ValueError
            Where no free receiver is asked for.
        """
        if self.free is None:
            raise ValueError("free is None: no free receiver is asked for")
        return replace(
            self,
            bank=self.free,
            start="order",
            identify="never",
            selector=None,
            costs=None,
            believe=self.belief,
            legacy_threshold_m=np.inf,
            decides=None,
            decided_by="",
        )

    @property
    def belief(self) -> BelieveRule:
        """What senders take their remotes to hold, filled in where not given."""
        return self.believe or believe_of(*self.rules)

    @property
    def rules(self) -> tuple[StartRule, IdentifyRule]:
        """The policy's rules, those not given filled in."""
        if self.start is not None and self.identify is not None:
            return self.start, self.identify
        start, identify = rules_of(self.bank)
        return self.start or start, self.identify or identify

    @property
    def training_trips(self) -> frozenset[str]:
        """Fingerprints of the trips that the bank was trained on."""
        if self.trained_on is not None:
            return self.trained_on
        profile = default_profile()
        return frozenset(profile.training_trips if self.bank == profile.bank else ())

    @property
    def all_training_trips(self) -> frozenset[str]:
        """Fingerprints of the trips that the bank or the free receiver was trained on."""
        return self.training_trips if self.rival is None else self.training_trips | self.free_training_trips

    @property
    def free_training_trips(self) -> frozenset[str]:
        """Fingerprints of the trips that the free receiver's bank was trained on."""
        if self.free_trained_on is not None:
            return self.free_trained_on
        return frozenset(default_profile().training_trips if self.free == free_bank() else ())

    @property
    def selector_in_use(self) -> Selector | None:
        """The selector, where the start rule asks it."""
        return self.selector if self.rules[0] == "predicted" else None

    def channel(self, ratio: float) -> AbstractChannel:
        """The channel that loses this share of messages.

        Parameters
        ----------
        ratio
            Packet error ratio.

        Raises
        ------
        ValueError
            Where it is out of its range, or not that of the recorded losses.
        """
        if self.recorded is not None:
            if ratio != self.recorded.packet_error_ratio:
                raise ValueError(
                    "packet_error_ratios must be the one of the recorded losses, "
                    f"{self.recorded.packet_error_ratio}, got {ratio}"
                )
            return self.recorded
        if self.mean_burst_s is None:
            return IndependentErasure(ratio)
        return GilbertElliott(ratio, self.mean_burst_s)

    def as_plain(self) -> Mapping[str, Any]:
        """The settings as plain values, for summaries."""
        return {
            "thresholds_m": list(self.thresholds_m),
            "packet_error_ratios": list(self.packet_error_ratios),
            "seeds": self.seeds,
            "seed": self.seed,
            "bank": self.bank.name,
            "sub_models": [repr(member) for member in self.bank.members],
            "sub_model_names": [member.name for member in self.bank.members],
            "plain_messages": all(self.bank.sent_plain),
            "is_free_receiver": self.bank == self.free,
            "start": self.rules[0],
            "identify": self.rules[1],
            "selector": None if self.selector is None else self.selector.summary,
            "costs": None if self.costs is None else self.costs.as_plain(),
            "keep_alive_s": self.keep_alive_s,
            "believe": self.belief,
            "budget": self.budget,
            "legacy_threshold_m": self.legacy_threshold_m if np.isfinite(self.legacy_threshold_m) else None,
            "mean_burst_s": self.mean_burst_s,
            "recorded": None if self.recorded is None else [link.fingerprint for link in self.recorded.links],
            "delay_s": self.delay_s,
            "expiry_s": self.expiry_s,
            "protocol": self.protocol,
            "sensor": asdict(self.sensor),
            "quantised": self.quantised,
            "velocity": self.velocity,
            "sizes": asdict(self.sizes),
            "stack": asdict(self.stack),
            "keep_samples": self.keep_samples,
            "detail_threshold_m": self.thresholds_m[self.detail],
            "references": self.references,
            "context": self.context.as_plain(),
            "free": None if self.rival is None else [repr(member) for member in self.rival.members],
            "free_names": None if self.rival is None else [member.name for member in self.rival.members],
            "policy": None if self.decides is None else repr(self.decides),
            "decided_by": self.sender,
        }
