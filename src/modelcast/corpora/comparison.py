"""`compare` over a corpus: messages of banks and rules, trip by trip, on any number of workers.

What is shared is what knows one trip alone: messages of banks that neither learn nor read context, each trip
a route of its own. Tracking under loss pools errors over all trips, a trained bank learns from those of other
routes, and a route by its ground is found among all pairs of trips: for these `modelcast.study.compare.run`
takes all trips together.

A part holds four tables, in order of trip: ``trips`` (`COMPARED`), ``messages``
(`modelcast.study.compare.result.COUNTS`), ``references`` (`REFERENCE_COUNTS`), ``baselines`` (`BASELINES`).
"""

import fnmatch
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from itertools import pairwise
from pathlib import Path
from typing import ClassVar

import numpy as np

from modelcast.core.exceptions import ConfigError
from modelcast.corpora.job import AbstractJob, TripFailures, read_failures
from modelcast.corpora.running import Outcome
from modelcast.io.table_files import read_table, write_table
from modelcast.study.case import too_short
from modelcast.study.compare.candidate import AbstractCandidate
from modelcast.study.compare.free import free_name
from modelcast.study.compare.result import (
    COUNTS,
    RATIOS,
    REFERENCE_RATIOS,
    RIVAL_RATIOS,
    ROUTES,
    TRACKING_RATIOS,
    ComparedTrip,
    ComparisonResult,
)
from modelcast.study.compare.run import checked_reference
from modelcast.study.compare.settings import CompareSettings
from modelcast.study.compare.stage import baseline_messages, ratios_of_references, stage_trips
from modelcast.study.compare.table import Resamples, ratio_rows, rivals_rows
from modelcast.study.compare.trial import candidate_row, run_trial
from modelcast.study.context import reads_context
from modelcast.study.reference import count_references
from modelcast.study.result import REFERENCES
from modelcast.study.table import Row, Table, TableSchema, count, flag, quantity, text
from modelcast.trips.fingerprint import known_trips
from modelcast.trips.trajectory import Trajectory

__all__ = ["ComparisonJob", "pool_comparison", "why_not_shared"]

_DAMAGED = "Remove its folder and run again."
_PROTOCOL = text("protocol", "Whether inputs are recorded or simulated.")

COMPARED = TableSchema(
    "compared",
    "A trip that took part in a comparison.",
    (
        text("trip", "Identifier."),
        text("source", "Name of the format."),
        quantity("duration_s", "s", "Time observed."),
        count("samples", "Samples."),
        quantity("dt_s", "s", "Their median step."),
        text("warnings", "What must be known of the recording, by kind, as JSON."),
        flag("in_training", "Whether the profile in use was trained on it."),
    ),
)
"""Trips: a row each."""

REFERENCE_COUNTS = TableSchema(
    "reference_counts", "Messages of a reference over one trip.", (_PROTOCOL, *REFERENCES.columns)
)
"""References: a row a protocol, trip, reference and threshold."""

BASELINES = TableSchema(
    "baselines",
    "Messages of the baseline over one trip.",
    (
        _PROTOCOL,
        text("trip", "Identifier."),
        quantity("threshold_m", "m", "Tracking-error threshold."),
        count("messages", "Messages sent."),
    ),
)
"""The baseline: a row a protocol, trip and threshold."""


def why_not_shared(candidates: Sequence[AbstractCandidate], settings: CompareSettings) -> str | None:
    """Why a comparison needs all trips together; None where it does not.

    Parameters
    ----------
    candidates, settings
        As for `modelcast.study.compare.run.compare`.
    """
    evaluation = settings.evaluation
    if evaluation.packet_error_ratios:
        return "tracking under loss pools the errors of all trips: --rates-only leaves it out"
    if settings.route_by != "trip":
        return "routes are found among all pairs of trips: --route-by trip takes each as its own"
    for candidate in candidates:
        if candidate.is_trained:
            return f"{candidate.name} learns from the trips of other routes"
        if reads_context(candidate.fitted((), evaluation).bank):
            return f"{candidate.name} reads context, in which trips know of one another"
    return None


@dataclass(frozen=True, slots=True)
class ComparisonJob(AbstractJob):
    """Messages of all candidates over each trip.

    Parameters
    ----------
    candidates
        As `modelcast.study.compare.free.with_free` gives them; `why_not_shared` has nothing against them.
    settings
        As for `modelcast.study.compare.run.compare`.
    pattern
        Trips whose identifier matches this shell pattern are taken.
    asked
        Hash of everything that these were made from.
    """

    name: ClassVar[str] = "compare"

    candidates: tuple[AbstractCandidate, ...]
    settings: CompareSettings
    _: KW_ONLY
    pattern: str = "*"
    asked: str

    @property
    def key(self) -> str:
        """What was asked for."""
        return self.asked

    def run(self, trips: Iterator[Trajectory], folder: Path) -> None:
        """Write the tables of a partition."""
        failures, found = TripFailures(), _Tables()
        taken = (trip for trip in trips if fnmatch.fnmatch(trip.trip_id, self.pattern))
        for _, counted in failures.each(taken, self._counted):
            found.add(counted)
        found.write(folder)
        failures.write(folder)

    def _counted(self, trip: Trajectory) -> "_Tables":
        """The rows of one trip."""
        reason = too_short(trip, max(candidate.window for candidate in self.candidates))
        if reason:
            raise ConfigError(reason)
        evaluation = self.settings.evaluation
        staged = stage_trips([trip], self.settings)
        found = _Tables()
        training: frozenset[str] = frozenset()
        for candidate in self.candidates:
            fitted = candidate.fitted((), evaluation)
            training |= fitted.training_trips
            for protocol, ready in staged.items():
                route = np.zeros(1, dtype=np.int64)
                trial = run_trial(candidate.name, protocol, ready, route, [fitted], step=_nothing)
                found.messages += trial.counts
        for protocol, (ready,) in staged.items():
            if evaluation.references:
                found.references += [
                    REFERENCE_COUNTS.row(protocol=protocol, **dict(row.items()))
                    for row in count_references(ready.case, evaluation.thresholds_m)
                ]
            found.baselines += [
                BASELINES.row(
                    protocol=protocol, trip=trip.trip_id, threshold_m=threshold_m, messages=messages
                )
                for threshold_m, messages in baseline_messages(ready, self.settings).items()
            ]
        warned = {kind: said for (ready,) in staged.values() for kind, said in ready.case.warnings.items()}
        row = COMPARED.row(
            trip=trip.trip_id,
            source=trip.source,
            duration_s=trip.duration_s,
            samples=len(trip),
            dt_s=trip.dt_s,
            warnings=json.dumps(warned),
            in_training=bool(known_trips([trip], training)),
        )
        found.trips.append(row)
        return found


def pool_comparison(
    outcome: Outcome, job: ComparisonJob, *, failures: Mapping[str, str], skipped: Mapping[str, str]
) -> ComparisonResult:
    """What all parts hold, as one comparison: as `modelcast.study.compare.run.compare` has it.

    Parameters
    ----------
    outcome
        The parts.
    job
        What was done.
    failures, skipped
        What else could not be compared, and what held no trip, with the reason.

    Raises
    ------
    ConfigError
        Where no trip could be compared, or two have one name.
    DataFormatError
        Where a part is damaged.
    """
    settings, candidates = job.settings, job.candidates
    against, free = checked_reference(candidates, settings), free_name(candidates, settings.evaluation)
    found, failed = _Tables(), dict(failures)
    for part in outcome.parts:
        found.add(_Tables.read(part.folder))
        failed |= read_failures(part.folder)
    found.trips.sort(key=lambda row: row.trip)
    if not found.trips:
        reasons = "; ".join(f"{trip}: {reason}" for trip, reason in failed.items())
        raise ConfigError("no usable trip" + (f" ({reasons})" if reasons else ""))
    places = {row.trip: at for at, row in enumerate(found.trips)}
    if len(places) < len(found.trips):
        twice = next(two.trip for one, two in pairwise(found.trips) if one.trip == two.trip)
        raise ConfigError(f"two trips of the corpus are called {twice}: ingest its sources anew")
    names = {candidate.name: at for at, candidate in enumerate(candidates)}
    protocols = {protocol: at for at, protocol in enumerate(settings.protocols)}
    # A stable sort: thresholds stay in their order.
    found.messages.sort(key=lambda row: (names[row.candidate], protocols[row.protocol], places[row.trip]))
    found.references.sort(key=lambda row: places[row.trip])
    counts = [row.replaced(route=places[row.trip]) for row in found.messages]
    clusters = np.arange(len(places), dtype=np.int64)
    resamples = Resamples.drawn(clusters, settings.resamples, settings.evaluation.seed)
    return ComparisonResult(
        {**settings.as_plain(), "against": against, "free": free},
        routes=ROUTES.table(
            ROUTES.row(route=at, name=row.trip, trips=1, duration_s=row.duration_s)
            for at, row in enumerate(found.trips)
        ),
        trips=tuple(_compared_trip(row, at) for at, row in enumerate(found.trips)),
        candidates=tuple(candidate_row(one, one.fitted((), settings.evaluation)) for one in candidates),
        ratios=RATIOS.table(ratio_rows(counts, against, resamples)),
        tracking=TRACKING_RATIOS.table(),
        counts=COUNTS.table(counts),
        rivals=RIVAL_RATIOS.table(rivals_rows(counts, against, free, resamples)),
        references=REFERENCE_RATIOS.table(_references(found, settings)),
        failures=dict(sorted(failed.items())),
        skipped=skipped,
    )


class _Tables:
    """Rows of one trip, or of many."""

    def __init__(self) -> None:
        self.trips: list[Row] = []
        self.messages: list[Row] = []
        self.references: list[Row] = []
        self.baselines: list[Row] = []

    def add(self, other: "_Tables") -> None:
        """Take over the rows of another."""
        for own, more in zip(self.named().values(), other.named().values(), strict=True):
            own[1].extend(more[1])

    def write(self, folder: Path) -> None:
        """Write a file a table."""
        for name, (schema, rows) in self.named().items():
            write_table(schema.table(rows), folder / f"{name}.parquet")

    @classmethod
    def read(cls, folder: Path) -> "_Tables":
        """The rows that a folder holds."""
        found = cls()
        for name, (schema, rows) in found.named().items():
            table: Table = read_table(schema, folder / f"{name}.parquet", remedy=_DAMAGED)
            rows.extend(table)
        return found

    def named(self) -> dict[str, tuple[TableSchema, list[Row]]]:
        """Each table by the name of its file: its columns, and its rows."""
        return {
            "trips": (COMPARED, self.trips),
            "messages": (COUNTS, self.messages),
            "references": (REFERENCE_COUNTS, self.references),
            "baselines": (BASELINES, self.baselines),
        }


def _compared_trip(row: Row, route: int) -> ComparedTrip:
    """A trip as a comparison has it."""
    return ComparedTrip(
        row.trip,
        row.source,
        route,
        duration_s=row.duration_s,
        samples=row.samples,
        dt_s=row.dt_s,
        warnings=json.loads(row.warnings),
        in_training=row.in_training,
    )


def _references(found: _Tables, settings: CompareSettings) -> list[Row]:
    """References over the baseline, by protocol."""
    if not settings.evaluation.references:
        return []
    rows: list[Row] = []
    for protocol in settings.protocols:
        baselines = dict.fromkeys(settings.evaluation.thresholds_m, 0)
        for row in found.baselines:
            if row.protocol == protocol:
                baselines[row.threshold_m] += row.messages
        own = [row for row in found.references if row.protocol == protocol]
        rows += ratios_of_references(protocol, own, baselines)
    return rows


def _nothing() -> None:
    """Nobody counts steps within a trip."""
