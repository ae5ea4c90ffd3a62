"""What a candidate is held against on one trip beside its equal-rate baselines.

At its own threshold the baseline and the free receiver; at its own rate the free receiver.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from modelcast.core.arrays import SingleArray
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.station.policy.rules import BelieveRule
from modelcast.study.pooling import sorted_errors
from modelcast.study.rules import RateBasis
from modelcast.study.settings import EvaluationSettings
from modelcast.study.tracking import FreeRuns, LossRuns, TrackingRun, walks_under_loss

__all__ = ["BesideRuns", "SortedErrors"]


@dataclass(frozen=True, slots=True)
class SortedErrors:
    """Errors of one contender over one trip, at every loss ratio (L of them).

    Parameters
    ----------
    errors_m
        For each ratio its sorted errors, one array a seed [m].
    messages
        Messages sent, means over the seeds, (L,).
    """

    errors_m: list[list[SingleArray]]
    messages: tuple[float, ...]

    @classmethod
    def of(cls, run: TrackingRun) -> Self:
        """Those of a run.

        Parameters
        ----------
        run
            The run.
        """
        rows = range(len(run.messages))
        return cls([sorted_errors(run, row) for row in rows], run.messages)


class BesideRuns:
    """The rivals of all candidates over one trip; those at the same threshold are run once for all.

    Parameters
    ----------
    losses
        The loss runs of the trip.
    free
        The free receiver's bank, ready for what the sender sees; None where it is not run.
    """

    def __init__(self, losses: LossRuns, free: TripRuntime | None) -> None:
        self._losses = losses
        self._free = free
        self._known: dict[tuple[str, BelieveRule, float], SortedErrors] = {}

    def at_threshold(self, settings: EvaluationSettings, threshold_m: float) -> dict[str, SortedErrors]:
        """The errors of the baseline and of the free receiver at a threshold, by name.

        The free receiver's sender takes its remotes to hold what the candidate's does.

        Parameters
        ----------
        settings
            The candidate's.
        threshold_m
            Threshold [m].
        """
        found = {"baseline": self._baseline(settings, threshold_m)}
        if self._free is not None:
            key = "free", settings.belief, threshold_m
            if key not in self._known:
                runs, sent = self._sent(self._free, settings, threshold_m)
                self._known[key] = SortedErrors.of(runs.at_threshold(threshold_m, sent))
            found["free"] = self._known[key]
        return found

    def at_equal_rate(
        self,
        settings: EvaluationSettings,
        threshold_m: float,
        walks: Sequence[TripMessages],
        bases: Sequence[RateBasis],
    ) -> list[SortedErrors]:
        """The errors of the free receiver at a candidate's rate, one a basis; none where it is not run.

        Parameters
        ----------
        settings
            The candidate's.
        threshold_m
            Its threshold [m].
        walks
            What it sent, as `walks_under_loss` gives it.
        bases
            Which of its messages count.
        """
        if self._free is None:
            return []
        runs, sent = self._sent(self._free, settings, threshold_m)
        return [SortedErrors.of(run) for run in runs.at_equal_rate(threshold_m, sent, walks, bases)]

    def _baseline(self, settings: EvaluationSettings, threshold_m: float) -> SortedErrors:
        key = "baseline", "sent", threshold_m  # it takes its remotes to hold whatever it sent
        if key not in self._known:
            policy = settings.policy(threshold_m, keep_alive=True)
            self._known[key] = SortedErrors.of(self._losses.at_threshold(policy))
        return self._known[key]

    def _sent(
        self, free: TripRuntime, settings: EvaluationSettings, threshold_m: float
    ) -> tuple[FreeRuns, list[TripMessages]]:
        """The free receiver's runs by a candidate's rules, and what its sender sends at a threshold."""
        own = settings.of_free
        return FreeRuns(free, self._losses, own), walks_under_loss([free], own, threshold_m)
