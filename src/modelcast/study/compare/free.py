"""The free receiver among the candidates: whoever is compared is held against it too."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from modelcast.models.bank import Bank
from modelcast.study.compare.candidate import AbstractCandidate, FixedCandidate
from modelcast.study.rules import FREE_RECEIVER
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory

__all__ = ["FreeReceiver", "free_name", "with_free"]

_SECOND_NAME = "free receiver"
"""Its name where another candidate has the first one."""


@dataclass(frozen=True, slots=True)
class FreeReceiver(AbstractCandidate):
    """Plain messages whose receiver extrapolates well; the error-driven policy calls for them.

    Parameters
    ----------
    label
        Name in tables and figures.
    bank
        What its receivers coast by.
    trained_on
        Fingerprints of the trips that the bank was trained on.
    """

    label: str
    bank: Bank
    trained_on: frozenset[str] = frozenset()

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
        """The free receiver's settings, with its own belief where none is asked for."""
        own = replace(settings, free=self.bank).of_free
        return replace(own, believe=settings.believe, trained_on=self.trained_on)


def with_free(
    candidates: Sequence[AbstractCandidate], settings: EvaluationSettings
) -> tuple[AbstractCandidate, ...]:
    """The candidates, and behind them the free receiver where it is run and none of them is it.

    Parameters
    ----------
    candidates
        What is compared; where there are none, nothing is put behind them.
    settings
        What all candidates share; without a free receiver where `EvaluationSettings.free` is None.
    """
    if settings.free is None or not candidates or free_name(candidates, settings) is not None:
        return tuple(candidates)
    is_taken = FREE_RECEIVER in [candidate.name for candidate in candidates]
    label = _SECOND_NAME if is_taken else FREE_RECEIVER
    return (*candidates, FreeReceiver(label, settings.free, settings.free_training_trips))


def free_name(candidates: Sequence[AbstractCandidate], settings: EvaluationSettings) -> str | None:
    """The name of the candidate that is the free receiver; None where none is, or it is not run.

    Parameters
    ----------
    candidates, settings
        As for `with_free`.
    """
    if settings.free is None:
        return None
    for candidate in candidates:
        # Where a policy decides, it calls for the messages of a bank that is named, too.
        if isinstance(candidate, FreeReceiver) or (
            isinstance(candidate, FixedCandidate)
            and settings.decides is None
            and candidate.bank == settings.free
        ):
            return candidate.name
    return None
