"""What a comparison is asked to do."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, Literal, get_args

from modelcast.study.routes import CELL_M, SHARED_RATIO, RouteRule
from modelcast.study.rules import RATE_BASES, RateBasis
from modelcast.study.settings import EvaluationSettings

__all__ = ["Cluster", "CompareSettings", "Protocol"]

Protocol = Literal["auto", "recorded", "sensor"]
Cluster = Literal["trip", "route"]


def _default_evaluation() -> EvaluationSettings:
    return EvaluationSettings(packet_error_ratios=(0.0, 0.2, 0.4, 0.6), seeds=3)


@dataclass(frozen=True, slots=True)
class CompareSettings:
    """What a comparison is asked to do.

    Parameters
    ----------
    evaluation
        Thresholds, losses, seeds, sensor and sizes, the same for all candidates; its bank, rules and protocol
        are not looked at. The free receiver is run beside all candidates, unless it is None there.
    protocols
        Each trip is evaluated in each of these.
    against
        Name of the candidate that differences are taken to; None for the free receiver, or the first where
        that is not run.
    route_by
        How trips are told apart into routes, as in `modelcast.study.routes.routes`.
    resamples
        Bootstrap resamples behind every interval.
    cluster
        What is resampled: single trips, or whole routes.
    rate_basis
        Which of a candidate's messages the equal-rate baselines send as many of: all of them, or its model
        updates alone (the paper's).

    Raises
    ------
    ValueError
        Where a value is out of its range.
    """

    evaluation: EvaluationSettings = field(default_factory=_default_evaluation)
    protocols: tuple[Protocol, ...] = ("recorded", "sensor")
    _: KW_ONLY
    against: str | None = None
    route_by: RouteRule = "auto"
    resamples: int = 2000
    cluster: Cluster = "trip"
    rate_basis: RateBasis = "total"

    def __post_init__(self) -> None:
        if not self.protocols or len(set(self.protocols)) != len(self.protocols):
            raise ValueError(f"protocols must be one or more, each once, got {self.protocols}")
        for name, values, known in (
            ("protocols", self.protocols, get_args(Protocol)),
            ("route_by", (self.route_by,), get_args(RouteRule)),
            ("cluster", (self.cluster,), get_args(Cluster)),
            ("rate_basis", (self.rate_basis,), RATE_BASES),
        ):
            for value in values:
                if value not in known:
                    raise ValueError(f"{name} must be of {', '.join(known)}, got {value!r}")
        if self.resamples < 1:
            raise ValueError(f"resamples must be >= 1, got {self.resamples}")

    def as_plain(self) -> Mapping[str, Any]:
        """The settings as plain values, for summaries; what differs between candidates is not among them."""
        own = {
            "bank",
            "sub_models",
            "start",
            "identify",
            "selector",
            "costs",
            "protocol",
            "keep_samples",
            "free",
            "detail_threshold_m",
            "sub_model_names",
            "plain_messages",
            "is_free_receiver",
        }
        shared = {key: value for key, value in self.evaluation.as_plain().items() if key not in own}
        free = self.evaluation.free
        return {
            **shared,
            "free_names": None if free is None else [member.name for member in free.members],
            "protocols": list(self.protocols),
            "against": self.against,
            "route_by": self.route_by,
            "route_cell_m": CELL_M,
            "route_shared_ratio": SHARED_RATIO,
            "resamples": self.resamples,
            "cluster": self.cluster,
            "rate_basis": self.rate_basis,
        }
