"""What is compared: a name, and how to get a bank and its rules for trips that it may not have seen."""

import abc
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from modelcast.core.argument_types import require_type
from modelcast.models.bank import Bank
from modelcast.models.learned import Selector
from modelcast.station.policy.costs import CostTable
from modelcast.station.policy.rules import IdentifyRule, StartRule
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory

__all__ = ["AbstractCandidate", "FixedCandidate", "TrainedCandidate"]


class AbstractCandidate(abc.ABC):
    """Something that sends: it is given the trips it may learn from, and says how it is to be evaluated.

    Implementations are frozen dataclasses.
    """

    @property
    @abc.abstractmethod
    def name(self) -> str:
        """Name in tables and figures."""

    @property
    @abc.abstractmethod
    def is_trained(self) -> bool:
        """Whether `fitted` learns from the trips: if so, it is called for every route left out."""

    @property
    @abc.abstractmethod
    def window(self) -> int:
        """Samples the longest window holds; trips without so long a part are left out for all candidates."""

    @abc.abstractmethod
    def fitted(self, trips: Sequence[Trajectory], settings: EvaluationSettings) -> EvaluationSettings:
        """The settings with this candidate's bank and rules in place of whatever they held.

        Parameters
        ----------
        trips
            Trips of all other routes; empty where the candidate is not trained.
        settings
            Everything else of the evaluation, the same for all candidates.
        """


@dataclass(frozen=True, slots=True)
class FixedCandidate(AbstractCandidate):
    """A bank and rules that learn nothing.

    Parameters
    ----------
    label
        Name in tables and figures.
    bank
        Its sub-models.
    start, identify
        The policy's rules, as in `modelcast.station.policy.error_driven.ErrorDriven`.
    selector, costs
        What the rules ``predicted`` and ``cheapest`` need.
    trained_on
        As in `EvaluationSettings`.
    """

    label: str
    bank: Bank
    start: StartRule = "order"
    identify: IdentifyRule = "on-failure"
    selector: Selector | None = None
    costs: CostTable | None = None
    trained_on: frozenset[str] | None = None

    def __post_init__(self) -> None:
        require_type("bank", self.bank, Bank, remedy='give modelcast.bank_from_text("cv") or its like')

    @property
    def name(self) -> str:
        """The label."""
        return self.label

    @property
    def is_trained(self) -> bool:
        """Never."""
        return False

    @property
    def window(self) -> int:
        """The longest window of the bank's members."""
        return int(self.bank.windows.max())

    def fitted(
        self,
        trips: Sequence[Trajectory],  # noqa: ARG002 - it learns nothing
        settings: EvaluationSettings,
    ) -> EvaluationSettings:
        """The settings with this bank and these rules."""
        return replace(
            settings,
            bank=self.bank,
            start=self.start,
            identify=self.identify,
            selector=self.selector,
            costs=self.costs,
            trained_on=self.trained_on,
        )


@dataclass(frozen=True, slots=True)
class TrainedCandidate(AbstractCandidate):
    """A bank and rules that a function learns from trips.

    Parameters
    ----------
    label
        Name in tables and figures.
    learn
        Takes the trips of all other routes and the settings that all candidates share; returns these settings
        with the bank and rules it learnt.
    longest_window
        Samples that the longest window of what it learns holds.
    """

    label: str
    learn: Callable[[Sequence[Trajectory], EvaluationSettings], EvaluationSettings]
    longest_window: int = 10

    @property
    def name(self) -> str:
        """The label."""
        return self.label

    @property
    def is_trained(self) -> bool:
        """Always."""
        return True

    @property
    def window(self) -> int:
        """The longest window it may learn."""
        return self.longest_window

    def fitted(self, trips: Sequence[Trajectory], settings: EvaluationSettings) -> EvaluationSettings:
        """What was learnt from these trips."""
        return self.learn(trips, settings)
