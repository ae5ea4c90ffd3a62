"""What a reproduction of the paper returns: readings, claims and verdicts, and what the figures draw."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field

from modelcast.study.paper.choices import LabelledReading
from modelcast.study.paper.complement import Complement
from modelcast.study.paper.plan import PaperPlan
from modelcast.study.paper.readings import ReadingRows
from modelcast.study.paper.verdict import Verdict
from modelcast.study.result import EvaluationResult
from modelcast.study.table import Row
from modelcast.trips.manoeuvres.base import ManoeuvreCounts

__all__ = ["ClaimRow", "PaperResult", "ReadingResult"]


@dataclass(frozen=True, slots=True)
class ReadingResult:
    """A reading and what it found.

    Parameters
    ----------
    labelled
        The reading and its label.
    rows
        Its figures.
    messages, tracking
        The two numbers that rank readings (`modelcast.study.paper.readings.figure_of`).
    """

    labelled: LabelledReading
    rows: ReadingRows
    _: KW_ONLY
    messages: float
    tracking: float

    @property
    def message_rows(self) -> tuple[Row, ...]:
        """All messages over the baseline's, one row a threshold."""
        return self.rows.messages


@dataclass(frozen=True, slots=True)
class ClaimRow:
    """One claim of the paper, and what became of it.

    Parameters
    ----------
    name
        Short name.
    place
        Part of the paper: abstract, system, evaluation or conclusion; ``beside it`` for what it does not say.
    sentence
        What it says, in our words.
    measure
        What was measured, and when the claim is said to hold.
    figure
        The figures found under the plain reading, as text.
    worst
        The trip that speaks against it most, as text; empty where there is none.
    verdicts
        By label of the reading; the plain one is always there.
    shown_in
        Figure of the report; empty where it has none.
    command
        What makes the figures.
    """

    name: str
    place: str
    sentence: str
    _: KW_ONLY
    measure: str
    figure: str
    worst: str
    verdicts: Mapping[str, Verdict]
    shown_in: str
    command: str


@dataclass(frozen=True, slots=True)
class PaperResult:
    """Everything one reproduction found.

    Parameters
    ----------
    plan
        What was asked for.
    evaluation
        Rates, tracking and distributions under the plain reading, as of ``modelcast evaluate``.
    manoeuvres
        Of every trip, the richest trip first.
    picked
        What was picked from which trips, as a sentence; empty where all were taken.
    readings
        The plain reading first, then one at a time, then the combinations.
    claims
        One a claim.
    traffic
        The hybrid against the baseline in simulated traffic; empty where it was not run.
    failures, skipped
        Trips that could not be evaluated, and files and vehicles that held no trip, with the reason.
    """

    plan: PaperPlan
    _: KW_ONLY
    evaluation: EvaluationResult
    manoeuvres: tuple[ManoeuvreCounts, ...]
    readings: tuple[ReadingResult, ...]
    claims: tuple[ClaimRow, ...]
    traffic: tuple[Row, ...] = ()
    picked: str = ""
    failures: Mapping[str, str] = field(default_factory=dict[str, str])
    skipped: Mapping[str, str] = field(default_factory=dict[str, str])

    @property
    def complement(self) -> Complement:
        """Who held when, in the plain reading."""
        return self.readings[0].rows.complement
