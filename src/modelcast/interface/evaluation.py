"""`evaluate`: the main job, with trips in any form and a result of frames and figures."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import polars as pl

from modelcast.core.argument_types import require_type
from modelcast.interface.given_trips import GivenTripList, GivenTrips
from modelcast.interface.result import AbstractFrames
from modelcast.io.results import write_results
from modelcast.report.console import scope_line
from modelcast.report.figures import (
    plot_distribution,
    plot_loss,
    plot_manoeuvre,
    plot_rates,
    plot_timeline,
    plot_trips,
)
from modelcast.report.html import write_report
from modelcast.report.tables import (
    events_frame,
    rates_frame,
    references_frame,
    samples_frame,
    tracking_frame,
    trips_frame,
)
from modelcast.study.evaluate import evaluate as evaluate_trips
from modelcast.study.recording import AbstractRecordSink
from modelcast.study.result import POOLED, EvaluationResult
from modelcast.study.settings import EvaluationSettings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Evaluation", "EvaluationPlots", "evaluate"]


@dataclass(frozen=True, slots=True)
class EvaluationPlots:
    """The figures of an evaluation, each as a Matplotlib figure.

    Parameters
    ----------
    result
        Its rows.
    """

    result: EvaluationResult

    def rates(self) -> "Figure":
        """Message rate and airtime against threshold."""
        return plot_rates(self.result)

    def tracking(self) -> "Figure":
        """Distribution of the tracking error."""
        return plot_distribution(self.result)

    def loss(self) -> "Figure":
        """Tracking error against packet error ratio."""
        return plot_loss(self.result)

    def sub_models(self) -> "Figure":
        """Errors of all sub-models around the sharpest manoeuvre."""
        return plot_timeline(self.result)

    def manoeuvre(self) -> "Figure":
        """The sharpest manoeuvre and what each sub-model predicted of it."""
        return plot_manoeuvre(self.result)

    def trips(self) -> "Figure":
        """Message rate and tracking error by trip."""
        return plot_trips(self.result)


@dataclass(frozen=True, slots=True, repr=False)
class Evaluation(AbstractFrames):
    """An evaluation as data frames, figures and files.

    Parameters
    ----------
    result
        Its rows, and what the figures draw.
    """

    result: EvaluationResult

    @property
    def settings(self) -> Mapping[str, Any]:
        """What was asked for, as plain values."""
        return self.result.settings

    @property
    def trips(self) -> pl.DataFrame:
        """A row a trip (`TRIPS`)."""
        return trips_frame(self.result)

    @property
    def rates(self) -> pl.DataFrame:
        """A row for each trip, policy, bank and threshold of the rate runs (`RATES`)."""
        return rates_frame(self.result)

    @property
    def references(self) -> pl.DataFrame:
        """A row for each trip, reference and threshold (`REFERENCES`)."""
        return references_frame(self.result)

    @property
    def tracking(self) -> pl.DataFrame:
        """A row for each trip, policy, rate basis, threshold and packet error ratio (`TRACKING`)."""
        return tracking_frame(self.result)

    @property
    def events(self) -> pl.DataFrame:
        """A row a message of the rate runs."""
        return events_frame(self.result)

    @property
    def samples(self) -> pl.DataFrame:
        """A row a tracking-error sample kept."""
        return samples_frame(self.result)

    @property
    def failures(self) -> Mapping[str, str]:
        """Trips that could not be evaluated, with the reason."""
        return self.result.failures

    @property
    def skipped(self) -> Mapping[str, str]:
        """Files and vehicles that held no trip, with the reason."""
        return self.result.skipped

    @property
    def plot(self) -> EvaluationPlots:
        """The figures."""
        return EvaluationPlots(self.result)

    @property
    def scope(self) -> str:
        """What was run, in one line."""
        return scope_line(self.result)

    @property
    def headline(self) -> pl.DataFrame:
        """The rates of all trips together."""
        return self.rates.filter(pl.col("trip") == POOLED).drop("trip")

    def _write(self, folder: Path) -> list[Path]:
        return write_results(self.result, folder)

    def _report(self, folder: Path) -> list[Path]:
        return write_report(self.result, folder)


def evaluate(
    trips: GivenTrips,
    settings: EvaluationSettings | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
    records: AbstractRecordSink | None = None,
) -> Evaluation:
    """Run the hybrid bank and the raw-message baseline over trips: rates, tracking under loss, figures' data.

    Parameters
    ----------
    trips
        A path, a data frame, a trip (also one whose truth is known apart), what `read_trips` gave, or several
        of them. Trips are taken one at a time, but all at once for a bank that reads context.
    settings
        What to do; the defaults are the paper's.
    progress
        Called with trips done and trips taken so far.
    records
        Takes messages and tracking-error samples trip by trip; the result then has none of them. Where None,
        the result keeps them.

    Raises
    ------
    ConfigError, DataFormatError
        Where the settings fit no trip, or a file cannot be read.
    TypeError
        Where a trip is none, or the settings are of another study.

    Examples
    --------
    >>> from modelcast.world.drive import generate_drive
    >>> asked = EvaluationSettings((0.5,), (0.0,), seeds=1)
    >>> evaluate(generate_drive(0, 120.0).truth, asked)
    Evaluation(1 trip, 0.03 h, protocol: recorded)
    """
    if settings is not None:
        require_type("settings", settings, EvaluationSettings)
    taken = GivenTripList(trips)
    result = evaluate_trips(taken, settings, progress=progress, records=records)
    return Evaluation(replace(result, skipped=taken.skipped))
