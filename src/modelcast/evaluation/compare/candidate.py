"""What is compared: a name, and how to get a bank and its rules for trips that it may not have seen."""

import abc
from collections.abc import Sequence
from dataclasses import dataclass, replace

from modelcast.core.trajectory import Trajectory
from modelcast.evaluation.settings import EvaluationSettings
from modelcast.models.bank import Bank
from modelcast.policy.rules import IdentifyRule, StartRule

__all__ = ["AbstractCandidate", "FixedCandidate"]


class AbstractCandidate(abc.ABC):
    """Something that sends: it is given the trips it may learn from, and says how it is to be evaluated.

    Implementations are frozen dataclasses that can be pickled, so that they may be compared in processes of
    their own.
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
        The policy's rules, as in `modelcast.policy.error_driven.ErrorDriven`.
    """

    label: str
    bank: Bank
    start: StartRule = "order"
    identify: IdentifyRule = "on-failure"

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
        return replace(settings, bank=self.bank, start=self.start, identify=self.identify)
