"""The main job over a corpus: every partition by whatever worker, then one result of all.

The result is the same to the byte whatever the partitions, the workers and the order in which they end: rows
are put in order of the trips' names, and what is summed over trips is whole numbers, or summed exactly
(`modelcast.study.histogram`, `modelcast.study.rate`).
"""

import fnmatch
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

from modelcast.core.exceptions import ConfigError
from modelcast.corpora.evaluation_tables import read_tables, trips_in, write_tables_of
from modelcast.corpora.executors.versions import worker_versions
from modelcast.corpora.job import AbstractJob, TripFailures, read_failures
from modelcast.corpora.layout import Corpus
from modelcast.corpora.running import Outcome
from modelcast.io.documents import document_text, plain_value
from modelcast.io.record_files import RecordFiles
from modelcast.study.context import reads_context
from modelcast.study.evaluate import evaluate_trip
from modelcast.study.gathered import Gathered, Illustration
from modelcast.study.play import played_ratio
from modelcast.study.recording import HeldRecords
from modelcast.study.result import EvaluationResult
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory

__all__ = [
    "MOST_LISTED",
    "EvaluateJob",
    "gather_parts",
    "reduce_evaluation",
]

MOST_LISTED = 500
"""Of more trips the result holds no rows of single trips, only pooled ones: the parts' tables have them."""


@dataclass(frozen=True, slots=True)
class EvaluateJob(AbstractJob):
    """The evaluation of one partition.

    Parameters
    ----------
    settings
        What to do.
    pattern
        Trips whose identifier matches this shell pattern are taken.
    asked
        Hash of what else the findings depend on; empty where that is nothing.

    Raises
    ------
    ConfigError
        Where the bank reads context: then trips know of each other, and cannot be shared out.
    """

    name: ClassVar[str] = "evaluate"

    settings: EvaluationSettings
    pattern: str = "*"
    asked: str = ""

    def __post_init__(self) -> None:
        """Refuse a bank that reads context."""
        if reads_context(self.settings.bank):
            raise ConfigError(
                f"the bank {self.settings.bank.name} reads context, so trips know of each other: they cannot "
                "be shared out among processes"
            )

    @property
    def key(self) -> str:
        """Hash of the settings, the pattern, all versions, and the trips that bank and free receiver know.

        These are the trips that the bank or the free receiver was trained on.
        """
        depends = {
            "versions": worker_versions(),
            "asked": self.asked,
            "pattern": self.pattern,
            "settings": plain_value(self.settings.as_plain()),
            "training_trips": sorted(self.settings.all_training_trips),
        }
        return hashlib.sha256(document_text(depends).encode()).hexdigest()

    def run(self, trips: Iterator[Trajectory], folder: Path) -> None:
        """Write the tables that `modelcast.corpora.evaluation_tables` describes.

        Of a trip that fails half-way no row of any table counts; messages and samples that it had until then
        are in their files.
        """
        failures = TripFailures()
        gathered = Gathered()
        sharpest_mps2: dict[str, float] = {}
        settings = self.settings
        with RecordFiles(folder) as records:

            def work(trip: Trajectory) -> Gathered:
                return evaluate_trip(trip, settings, records=records)

            wanted = (trip for trip in trips if fnmatch.fnmatch(trip.trip_id, self.pattern))
            for trip, found in failures.each(wanted, work):
                gathered.merge(found)
                if found.illustration is not None:
                    sharpest_mps2[trip.trip_id] = found.sharpness
        failures.reasons |= gathered.failures
        failures.write(folder)
        write_tables_of(gathered, sharpest_mps2, folder)


def reduce_evaluation(corpus: Corpus, settings: EvaluationSettings, outcome: Outcome) -> EvaluationResult:
    """What the parts hold as one result.

    Messages and samples stay in the parts; so do the rows of single trips, where there are more than
    `MOST_LISTED`. Partitions that failed are among the result's failures.

    Parameters
    ----------
    corpus
        The trips: the one with the sharpest manoeuvre is read again, for its drawings.
    settings
        What was done.
    outcome
        Where the parts are.

    Raises
    ------
    ConfigError
        Where no trip could be evaluated, or none has the name to draw the map of.
    DataFormatError
        Where the corpus or a part is damaged.
    """
    gathered, each_trip = gather_parts(outcome)
    gathered.illustration = _drawn(corpus, gathered, settings)
    lost = {f"partition {name}": reason for name, reason in outcome.failures.items()}
    gathered.failures = {**lost, **gathered.failures}
    return gathered.result(settings, each_trip=each_trip)


def gather_parts(outcome: Outcome) -> tuple[Gathered, bool]:
    """What the parts hold together, in order of the trips' names; and whether single trips are listed.

    Parameters
    ----------
    outcome
        Where they are.

    Raises
    ------
    DataFormatError, ConfigError
        Where a part is damaged.
    """
    each_trip = sum(trips_in(part.folder) for part in outcome.parts) <= MOST_LISTED
    whole = Gathered()
    sharpest: list[Illustration] = []
    for part in outcome.parts:
        found = read_tables(part.folder, each_trip=each_trip)
        found.failures |= read_failures(part.folder)
        if found.illustration is not None:
            sharpest.append(found.illustration)
        whole.merge(found)
    whole.illustration = min(sharpest, key=lambda one: (-one.acceleration_mps2, one.trip), default=None)
    return whole.in_order(), each_trip


def _drawn(corpus: Corpus, gathered: Gathered, settings: EvaluationSettings) -> Illustration | None:
    """The drawings of the sharpest trip, or of the one asked for: made here, of that trip alone."""
    wanted = None if gathered.illustration is None else gathered.illustration.trip
    if settings.map_at is not None:
        wanted = settings.map_at[0]
    if wanted is None:
        return None
    ratio = played_ratio(settings)
    alone = replace(
        settings, packet_error_ratios=() if ratio is None else (ratio,), seeds=1, references=False
    )
    for partition in corpus.partitions:
        if wanted not in corpus.catalogue(partition)["trip"].to_pylist():
            continue
        for trip in corpus.trips(partition):
            if trip.trip_id == wanted:
                found = evaluate_trip(trip, alone, records=HeldRecords(), sharper_than_mps2=-1.0)
                return found.illustration
    return None
