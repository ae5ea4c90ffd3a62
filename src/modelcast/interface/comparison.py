"""`compare`: candidates side by side, with trips in any form and a result of frames and figures."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import polars as pl

from modelcast.core.argument_types import require_several, require_type
from modelcast.interface.given_trips import GivenTripList, GivenTrips
from modelcast.interface.result import AbstractFrames
from modelcast.io.comparison import write_comparison
from modelcast.report.comparison import scope_line, write_comparison_report
from modelcast.report.figures import plot_comparison
from modelcast.report.tables import frame
from modelcast.study.compare.candidate import AbstractCandidate
from modelcast.study.compare.result import ComparisonResult
from modelcast.study.compare.run import compare as compare_trips
from modelcast.study.compare.settings import CompareSettings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["CANDIDATE_REMEDY", "Comparison", "ComparisonPlots", "compare"]

CANDIDATE_REMEDY = 'give modelcast.FixedCandidate("cv", modelcast.bank_from_text("cv")) or its like'
"""What to do where a candidate is none."""


@dataclass(frozen=True, slots=True)
class ComparisonPlots:
    """The figures of a comparison, each as a Matplotlib figure.

    Parameters
    ----------
    result
        Its rows.
    """

    result: ComparisonResult

    def ratios(self) -> "Figure":
        """Messages, bytes, airtime and tracking of every candidate against threshold."""
        return plot_comparison(self.result)


@dataclass(frozen=True, slots=True, repr=False)
class Comparison(AbstractFrames):
    """A comparison as data frames, figures and files.

    Parameters
    ----------
    result
        Its rows.
    """

    result: ComparisonResult

    @property
    def settings(self) -> Mapping[str, Any]:
        """What was asked for, as plain values."""
        return self.result.settings

    @property
    def routes(self) -> pl.DataFrame:
        """A row a route (`ROUTES`)."""
        return frame(self.result.routes)

    @property
    def trips(self) -> pl.DataFrame:
        """A row a trip (`ComparedTrip`); of its warnings the kinds."""
        rows = [{**asdict(trip), "warnings": ", ".join(trip.warnings)} for trip in self.result.trips]
        return pl.DataFrame(rows)

    @property
    def candidates(self) -> pl.DataFrame:
        """A row a candidate (`CandidateRow`)."""
        rows = [{**asdict(row), "sub_models": ", ".join(row.sub_models)} for row in self.result.candidates]
        return pl.DataFrame(rows)

    @property
    def ratios(self) -> pl.DataFrame:
        """A row for each candidate, protocol and threshold, with 95 % intervals over trips (`RATIOS`)."""
        return frame(self.result.ratios)

    @property
    def rivals(self) -> pl.DataFrame:
        """A row for each candidate, rival, protocol and threshold (`RIVAL_RATIOS`)."""
        return frame(self.result.rivals)

    @property
    def tracking(self) -> pl.DataFrame:
        """A row for each candidate, protocol, trip, threshold and packet error ratio (`TRACKING_RATIOS`)."""
        return frame(self.result.tracking)

    @property
    def counts(self) -> pl.DataFrame:
        """A row for each candidate, protocol, trip and threshold (`COUNTS`)."""
        return frame(self.result.counts)

    @property
    def references(self) -> pl.DataFrame:
        """A row for each reference, protocol and threshold (`REFERENCE_RATIOS`)."""
        return frame(self.result.references)

    @property
    def failures(self) -> Mapping[str, str]:
        """Trips that could not be compared, with the reason."""
        return self.result.failures

    @property
    def skipped(self) -> Mapping[str, str]:
        """Files and vehicles that held no trip, with the reason."""
        return self.result.skipped

    @property
    def plot(self) -> ComparisonPlots:
        """The figures."""
        return ComparisonPlots(self.result)

    @property
    def scope(self) -> str:
        """What was run, in one line."""
        return scope_line(self.result)

    @property
    def headline(self) -> pl.DataFrame:
        """The ratios."""
        return self.ratios

    def _write(self, folder: Path) -> list[Path]:
        return write_comparison(self.result, folder)

    def _report(self, folder: Path) -> list[Path]:
        return write_comparison_report(self.result, folder)


def compare(
    trips: GivenTrips,
    candidates: AbstractCandidate | Sequence[AbstractCandidate],
    settings: CompareSettings | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> Comparison:
    """Evaluate every candidate on the same trips, thresholds, losses and protocols.

    Parameters
    ----------
    trips
        Recorded trips with distinct identifiers: a path, a data frame, a trip, what `read_trips` gave, or
        several of them.
    candidates
        What is compared, one or several; a trained one is fitted anew for every route, on the trips of the
        others. The free receiver is put behind them, unless it is one of them or `EvaluationSettings.free` is
        None.
    settings
        What to do.
    progress
        Called with trips done and trips to do, counted over all candidates and protocols.

    Raises
    ------
    ConfigError
        Where names repeat, no trip is long enough, or a trained candidate has no other route to learn from.
    DataFormatError
        Where a file cannot be read.
    TypeError
        Where a trip or a candidate is none, or the settings are of another study.

    Examples
    --------
    >>> from modelcast.station.banks import BASELINE_BANK
    >>> from modelcast.study.compare.candidate import FixedCandidate
    >>> from modelcast.study.settings import EvaluationSettings
    >>> from modelcast.world.drive import generate_drive
    >>> asked = CompareSettings(EvaluationSettings((0.5,), (0.0,), seeds=1, references=False), ("recorded",))
    >>> found = compare(generate_drive(1, 90.0).truth, [FixedCandidate("cv", BASELINE_BANK)], asked)
    >>> found.ratios["candidate"].to_list(), found.ratios["message_ratio"][0]
    (['cv', 'free'], 1.0)
    """
    if settings is not None:
        require_type("settings", settings, CompareSettings)
    asked = require_several("candidates", candidates, AbstractCandidate, remedy=CANDIDATE_REMEDY)
    taken = GivenTripList(trips)
    result = compare_trips(taken.recorded(), asked, settings, progress=progress)
    return Comparison(replace(result, skipped=taken.skipped))
