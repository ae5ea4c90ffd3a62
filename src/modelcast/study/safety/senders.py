"""One leader's messages: of a candidate at a threshold, or at one that costs as much as another candidate."""

from dataclasses import dataclass, field

from modelcast.core.exceptions import ConfigError
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.station.policy.base import takes_threshold
from modelcast.study.case import TripCase
from modelcast.study.matching import matched_threshold
from modelcast.study.safety.rules import Basis
from modelcast.study.sent import sent_load
from modelcast.study.settings import EvaluationSettings

__all__ = ["LeadingSender", "Spent"]

_BISECTIONS = 11
"""Steps of the threshold of half a percent."""


@dataclass(frozen=True, slots=True)
class Spent:
    """What a sender spent over a trip.

    Parameters
    ----------
    messages
        Messages sent.
    airtime_s
        How long they occupied the channel [s].
    """

    messages: int
    airtime_s: float

    def by(self, basis: Basis) -> float:
        """Messages or airtime.

        Parameters
        ----------
        basis
            Which of them.
        """
        return self.airtime_s if basis == "airtime" else float(self.messages)


@dataclass(frozen=True, slots=True)
class LeadingSender:
    """A candidate as the sender of one trip; what it sent at a threshold is remembered.

    Parameters
    ----------
    case
        The trip.
    ready
        The candidate's bank, ready for it.
    settings
        The candidate's rules, and the sizes.
    """

    case: TripCase
    ready: TripRuntime
    settings: EvaluationSettings
    _known: dict[tuple[float, float], tuple[TripMessages, Spent]] = field(
        default_factory=dict[tuple[float, float], tuple[TripMessages, Spent]]
    )

    def walked(self, threshold_m: float, ratio: float) -> tuple[TripMessages, Spent]:
        """What it sends at a threshold, at a loss ratio that it has observed, and what that costs.

        Parameters
        ----------
        threshold_m
            Threshold [m].
        ratio
            Packet error ratio.
        """
        heeded = ratio if self.settings.belief == "expected" else 0.0
        key = threshold_m, heeded
        if key not in self._known:
            walk = self.ready.run(self.settings.under_loss(threshold_m, heeded))
            sent = sent_load(walk, self.ready.bank, self.case.truth.t_s, self.settings)
            self._known[key] = walk, Spent(int(sent.at.size), float(sent.airtime_s.sum()))
        return self._known[key]

    def matched(self, spent: Spent, basis: Basis, ratio: float) -> tuple[TripMessages, Spent]:
        """What it sends at the threshold at which it spends as much as another.

        Parameters
        ----------
        spent
            What the other spent on this trip.
        basis
            Messages or airtime.
        ratio
            Packet error ratio.

        Raises
        ------
        ConfigError
            Where its policy has no threshold.
        """
        decides = self.settings.decides
        if decides is not None and not takes_threshold(decides):
            raise ConfigError(
                f"{decides!r} has no threshold_m, so it cannot be made to cost as much as another sender: "
                "hold the senders against each other at equal threshold alone, or name one bank beside the "
                "baseline"
            )
        threshold_m = matched_threshold(
            lambda tried_m: self.walked(tried_m, ratio)[1].by(basis), spent.by(basis), bisections=_BISECTIONS
        )
        return self.walked(threshold_m, ratio)
