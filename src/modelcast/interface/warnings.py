"""`evaluate_warnings`: what followers warn of by messages alone, with a result of frames and figures."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import polars as pl

from modelcast.core.argument_types import require_several, require_type
from modelcast.interface.comparison import CANDIDATE_REMEDY
from modelcast.interface.given_trips import GivenTripList, GivenTrips
from modelcast.interface.result import AbstractFrames
from modelcast.io.safety import write_safety
from modelcast.report.console import left_out_text
from modelcast.report.figures.safety import plot_accuracy, plot_delays
from modelcast.report.safety import write_safety_report
from modelcast.report.tables import frame
from modelcast.study.compare.candidate import FixedCandidate
from modelcast.study.safety.result import SafetyResult
from modelcast.study.safety.run import evaluate_safety
from modelcast.study.safety.settings import SafetySettings
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.fingerprint import known_trips

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["WarningEvaluation", "WarningPlots", "evaluate_warnings"]

_EVALUATION = EvaluationSettings((0.5,), (0.0, 0.2, 0.4, 0.6), seeds=3, protocol="sensor", references=False)


@dataclass(frozen=True, slots=True)
class WarningPlots:
    """The figures of an evaluation of warnings, each as a Matplotlib figure.

    Parameters
    ----------
    result
        Its rows.
    """

    result: SafetyResult

    def accuracy(self) -> "Figure":
        """Missed and false warnings against packet error ratio."""
        return plot_accuracy(self.result)

    def delays(self) -> "Figure":
        """How late hosts warn."""
        return plot_delays(self.result)


@dataclass(frozen=True, slots=True, repr=False)
class WarningEvaluation(AbstractFrames):
    """An evaluation of warnings as data frames, figures and files.

    Parameters
    ----------
    result
        Its rows.
    trips
        How many were given.
    training_trips
        Those of them that a candidate was trained on.
    """

    result: SafetyResult
    trips: int
    training_trips: tuple[str, ...]

    @property
    def settings(self) -> Mapping[str, Any]:
        """What was asked for, as plain values."""
        return self.result.settings

    @property
    def pooled(self) -> pl.DataFrame:
        """A row for each loss ratio, basis and candidate (`POOLED_SAFETY`)."""
        return frame(self.result.pooled)

    @property
    def skipped(self) -> Mapping[str, str]:
        """Files and vehicles that held no trip, with the reason."""
        return self.result.skipped

    @property
    def plot(self) -> WarningPlots:
        """The figures."""
        return WarningPlots(self.result)

    @property
    def scope(self) -> str:
        """What was run, in one line."""
        return f"pairs: {self.result.pairs}, true warnings: {self.result.events}" + left_out_text(
            self.result.failures, self.result.skipped
        )

    @property
    def headline(self) -> pl.DataFrame:
        """Missed and false warnings."""
        keys = ["packet_error_ratio", "basis", "candidate"]
        return self.pooled.select(*keys, "missed_ratio", "false_ratio", "message_rate_hz", "airtime_ratio")

    def _write(self, folder: Path) -> list[Path]:
        return write_safety(self.result, folder)

    def _report(self, folder: Path) -> list[Path]:
        return write_safety_report(self.result, folder, training_trips=self.training_trips, trips=self.trips)


def evaluate_warnings(
    trips: GivenTrips,
    candidates: FixedCandidate | Sequence[FixedCandidate],
    settings: SafetySettings | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> WarningEvaluation:
    """Score what followers warn of by the messages of their leaders, against perfect knowledge.

    Parameters
    ----------
    trips
        Recorded trips, some of which follow each other, as a platoon: a path, a data frame, what `read_trips`
        gave, or several of them.
    candidates
        Who sends, one or several.
    settings
        Application, losses and sensor; None for forward collision warning, a threshold of 0.5 m, and losses
        of 0, 20, 40 and 60 %.
    progress
        Called with recordings done and recordings to do.

    Raises
    ------
    ConfigError
        Where no vehicle follows another, names repeat, or a name in the settings is none of a candidate.
    DataFormatError
        Where a file cannot be read.
    TypeError
        Where a trip or a candidate is none, or the settings are of another study.
    """
    asked = SafetySettings(_EVALUATION) if settings is None else settings
    require_type("settings", asked, SafetySettings)
    senders = require_several("candidates", candidates, FixedCandidate, remedy=CANDIDATE_REMEDY)
    source = GivenTripList(trips)
    taken = source.recorded()
    trained_on = frozenset[str]().union(*(one.trained_on or () for one in senders))
    result = evaluate_safety(taken, senders, asked, progress=progress)
    result = replace(result, skipped=source.skipped)
    return WarningEvaluation(result, len(taken), tuple(known_trips(taken, trained_on)))
