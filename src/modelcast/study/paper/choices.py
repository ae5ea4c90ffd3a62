"""What the paper leaves open, and what it says: each choice, its options, and one set of them, a reading.

"The paper" is H. N. Mahjoub, B. Toghi, S. M. O. Gani, Y. P. Fallah, "V2X System Architecture Utilizing Hybrid
Gaussian Process-based Model Structures", 2019. Where it says what to do, that is the first option and the
choice is marked as stated; where it is silent, the first option is the plainest.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal

from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.station.banks import PAPER_BANK, PAPER_NOISE_FLOOR_M
from modelcast.station.policy.rules import IdentifyRule, StartRule
from modelcast.station.sensing.rules import VelocityRule
from modelcast.study.rules import RateBasis

__all__ = [
    "CHOICES",
    "ENDS",
    "PLAIN",
    "PLAIN_LABEL",
    "Choice",
    "Figure",
    "LabelledReading",
    "Option",
    "Reading",
    "combined",
    "one_at_a_time",
]

Order = Literal["cv-first", "gp-first"]
Schedule = Literal["periodic", "matched"]
Figure = Literal["messages", "tracking"]
"""What says that one option is better than another: messages sent, or the error under loss."""

ENDS: dict[str, tuple[Figure, Literal[1, -1]]] = {
    "combined: fewest messages": ("messages", 1),
    "combined: most messages": ("messages", -1),
    "combined: best tracking": ("tracking", 1),
    "combined: worst tracking": ("tracking", -1),
}
"""Readings that take of every choice the option whose figure, times the sign, was smallest by itself.

Choices do not add up, so a combination need not be an end.
"""

PLAIN_LABEL = "plain"
"""Label of the reading that takes the first option of every choice."""


@dataclass(frozen=True, slots=True)
class Reading:
    """One option of every choice; the defaults are what the paper says, or the plainest where it is silent.

    Parameters
    ----------
    start, identify
        Rules of the policy, as in `modelcast.station.policy.error_driven.ErrorDriven`.
    order
        Which of the two sub-models is the first of the bank.
    noise_floor_m
        Smallest position noise that the Gaussian process may assume [m].
    velocity
        Where constant velocity takes its velocity from, as in `modelcast.study.settings.EvaluationSettings`.
    protocol
        ``recorded``: the log is both input and truth. ``sensor``: the sender sees it through a sensor.
    quantised
        Whether sub-models are used as messages carry them, or as they were fitted.
    keep_alive_s
        Longest silence under loss [s]; None for none.
    rate_basis
        Which of MBC's messages the baseline under loss sends as many of.
    schedule
        Whether that baseline sends periodically, or when its error reaches a threshold of its own.
    """

    start: StartRule = "order"
    identify: IdentifyRule = "on-failure"
    order: Order = "cv-first"
    noise_floor_m: float = PAPER_NOISE_FLOOR_M
    velocity: VelocityRule = "auto"
    protocol: Literal["recorded", "sensor"] = "recorded"
    quantised: bool = False
    keep_alive_s: float | None = None
    rate_basis: RateBasis = "update"
    schedule: Schedule = "periodic"

    @property
    def bank(self) -> Bank:
        """Constant velocity and the per-axis Gaussian process with a linear and an RBF kernel, window 10."""
        process = GaussianProcess(form="anchored", noise_floor_m=self.noise_floor_m)
        members = (ConstantVelocity(), process) if self.order == "cv-first" else (process, ConstantVelocity())
        return Bank(members, PAPER_BANK.name)

    @property
    def run(self) -> "Reading":
        """The reading whose messages and errors serve this one: rivals are picked from what it found."""
        return replace(self, rate_basis=PLAIN.rate_basis, schedule=PLAIN.schedule)


PLAIN = Reading()
"""What the paper says, and the plainest where it is silent."""


@dataclass(frozen=True, slots=True)
class Option:
    """One way to decide a choice.

    Parameters
    ----------
    value
        Of the field of `Reading`.
    label
        In tables.
    text
        What it means.
    """

    value: Any
    label: str
    text: str


@dataclass(frozen=True, slots=True)
class Choice:
    """Something that the figures depend on.

    Parameters
    ----------
    field
        Of `Reading`.
    title, question
        In tables, and as a question.
    stated
        Whether the paper says it: the first option is then its own.
    options
        The first is the one of `PLAIN`.
    """

    field: str
    title: str
    question: str
    stated: bool
    options: tuple[Option, ...]


CHOICES = (
    Choice(
        "start",
        "start rule",
        "Which sub-model is in use after an update?",
        stated=False,
        options=(
            Option("order", "order", "the first of the bank"),
            Option("keep", "keep", "the one in use before"),
            Option("survivor", "survivor", "the one that failed last before"),
        ),
    ),
    Choice(
        "identify",
        "identification rule",
        "When is another sub-model named?",
        stated=False,
        options=(
            Option("on-failure", "on failure", "when the one in use fails while another holds"),
            Option("final", "final", "the same, and who failed once is out until the next update"),
            Option("best", "best", "whenever another has the smallest error"),
        ),
    ),
    Choice(
        "order",
        "order of the bank",
        "Which of the two sub-models comes first?",
        stated=False,
        options=(
            Option("cv-first", "constant velocity", "constant velocity, then the Gaussian process"),
            Option("gp-first", "Gaussian process", "the Gaussian process, then constant velocity"),
        ),
    ),
    Choice(
        "noise_floor_m",
        "noise floor",
        "How little position noise may the Gaussian process assume?",
        stated=False,
        options=(
            Option(PAPER_NOISE_FLOOR_M, "none", "a hundredth of a millimetre stands for none"),
            Option(0.001, "1 mm", "1 mm"),
            Option(0.01, "1 cm", "1 cm"),
        ),
    ),
    Choice(
        "velocity",
        "velocity",
        "Where does constant velocity, and with it the baseline, take its velocity from?",
        stated=False,
        options=(
            Option(
                "auto", "as logged", "the log's speed and heading; a quadratic through four positions if none"
            ),
            Option("slope-2", "two positions", "the last two positions"),
        ),
    ),
    Choice(
        "protocol",
        "what is true",
        "What is a prediction held against?",
        stated=True,
        options=(
            Option("recorded", "the log", "the position that the sender's own receiver logged next"),
            Option(
                "sensor",
                "behind a sensor",
                "the log, smoothed if rough; the sender sees it with sensor noise",
            ),
        ),
    ),
    Choice(
        "quantised",
        "rounding",
        "Are sub-models used as messages carry them?",
        stated=False,
        options=(
            Option(False, "none", "as they were fitted"),
            Option(True, "as sent", "rounded as modelcast's messages carry them"),
        ),
    ),
    Choice(
        "keep_alive_s",
        "keep-alive",
        "Does a sender that has nothing to correct speak at all?",
        stated=False,
        options=(
            Option(None, "none", "never"),
            Option(2.0, "2 s", "after 2 s of silence"),
        ),
    ),
    Choice(
        "rate_basis",
        "rate basis",
        "Which of MBC's messages does the baseline under loss send as many of?",
        stated=True,
        options=(
            Option("update", "updates", "as many as MBC sends model updates"),
            Option("total", "all messages", "as many as MBC sends updates and identifications"),
        ),
    ),
    Choice(
        "schedule",
        "baseline's schedule",
        "When does the baseline of that rate send?",
        stated=False,
        options=(
            Option("periodic", "periodic", "at equal intervals"),
            Option(
                "matched", "error-driven", "when its error reaches a threshold, set so that the counts agree"
            ),
        ),
    ),
)
"""Everything that the paper's figures depend on, in the order of its text: sender, log, then losses."""


@dataclass(frozen=True, slots=True)
class LabelledReading:
    """A reading, and what it is called.

    Parameters
    ----------
    label
        ``plain``, one of `ENDS`, or the choice and the option that differ from the plain one.
    reading
        The options.
    choice, option
        What differs; empty where not one thing alone does.
    """

    label: str
    reading: Reading
    choice: str = ""
    option: str = ""


def one_at_a_time() -> tuple[LabelledReading, ...]:
    """The plain reading, then every other option of every choice by itself.

    Examples
    --------
    >>> [one.label for one in one_at_a_time()][:3]
    ['plain', 'start rule: keep', 'start rule: survivor']
    """
    found = [LabelledReading(PLAIN_LABEL, PLAIN)]
    for choice in CHOICES:
        for option in choice.options[1:]:
            changed = replace(PLAIN, **{choice.field: option.value})
            label = f"{choice.title}: {option.label}"
            found.append(LabelledReading(label, changed, choice.title, option.label))
    return tuple(found)


def combined(label: str, options: Iterable[tuple[Choice, Option]]) -> LabelledReading:
    """The reading that takes these options, and the plain one of every other choice.

    Parameters
    ----------
    label
        What it is called.
    options
        Choices, each with the option taken.
    """
    return LabelledReading(
        label, replace(PLAIN, **{choice.field: option.value for choice, option in options})
    )
