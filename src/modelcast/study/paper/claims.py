"""The paper's claims that can be tested on trips, and what is found under every reading.

The sentences are the paper's in our words. Claims that say one thing is smaller than another are judged by
`modelcast.study.paper.verdict.verdict_of`; how the others are judged stands in their rows.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from modelcast.study.compare.result import RatioRow, TrackingRatioRow
from modelcast.study.paper.choices import PLAIN, PLAIN_LABEL, Reading
from modelcast.study.paper.complement import Complement
from modelcast.study.paper.plan import PaperPlan
from modelcast.study.paper.readings import ReadingRows
from modelcast.study.paper.result import ClaimRow, ReadingResult
from modelcast.study.paper.verdict import Estimate, Verdict, verdict_of
from modelcast.study.result import POOLED, EvaluationResult
from modelcast.study.wording import centimetres

__all__ = ["COMMAND", "claim_rows"]

COMMAND = "modelcast reproduce paper TRIPS..."
_LEAST_SHARE = 0.01


@dataclass(frozen=True, slots=True)
class _ByReading:
    """A claim whose ratios every reading has.

    Parameters
    ----------
    name, place, sentence, measure, shown_in
        As in `ClaimRow`.
    estimates
        The ratios that are to lie below 1, and what each is of.
    worst
        The trip that speaks against it most.
    """

    name: str
    place: str
    sentence: str
    measure: str
    shown_in: str
    estimates: Callable[[ReadingRows, Reading], list[tuple[str, Estimate]]]
    worst: Callable[[ReadingRows, Reading], str]


def claim_rows(
    readings: Sequence[ReadingResult],
    evaluation: EvaluationResult,
    complement: Complement,
    plan: PaperPlan,
) -> tuple[ClaimRow, ...]:
    """Judge every claim.

    Parameters
    ----------
    readings
        The plain one first.
    evaluation
        Of the plain reading.
    complement
        Who held when, in the plain reading.
    plan
        Thresholds and ratios.
    """
    rows = [_judged(claim, readings) for claim in _by_reading(plan)]
    rows += [
        _falling(evaluation),
        _sweep(evaluation, plan),
        _hybrid(readings),
        _complementary(complement),
        _manoeuvres(complement),
    ]
    order = ("abstract", "system", "evaluation", "conclusion")
    return tuple(sorted(rows, key=lambda row: order.index(row.place)))


def _by_reading(plan: PaperPlan) -> tuple[_ByReading, ...]:
    per = f"{100 * plan.headline_ratio:g} %"
    return (
        _ByReading(
            "fewer messages",
            "abstract",
            "The architecture reduces the required message exchange rate.",
            "Updates and identifications over the baseline's messages at the same threshold, below 1.",
            "message_rate",
            lambda rows, _: _message_estimates(rows.messages),
            lambda rows, _: _worst_messages(rows.messages),
        ),
        _ByReading(
            "more precise tracking",
            "abstract",
            "The architecture increases the precision with which remotes are tracked.",
            f"90th percentile of the error at a PER of {per} over that of the equal-rate baseline, below 1.",
            "tracking_loss",
            lambda rows, reading: _tracking_estimates(rows.pooled(reading), "p90"),
            lambda rows, reading: _worst_tracking(rows.by_trip(reading), "p90"),
        ),
        _ByReading(
            "less of the channel",
            "abstract",
            "Model-based communication relieves a congested channel.",
            "Airtime of MBC over the baseline's at the same threshold, all layers counted, below 1.",
            "message_rate",
            lambda rows, _: [
                (centimetres(row.threshold_m), Estimate(row.airtime_ratio, row.airtime_low, row.airtime_high))
                for row in rows.messages
            ],
            _no_trip,
        ),
        _ByReading(
            "fewer updates",
            "evaluation",
            "Model updates are sent less often than the baseline sends messages, at every threshold.",
            "Updates over the baseline's messages at the same threshold, below 1.",
            "message_rate",
            lambda rows, _: _message_estimates(rows.updates),
            lambda rows, _: _worst_messages(rows.updates),
        ),
        _ByReading(
            "a better distribution",
            "evaluation",
            f"At a PER of {per} the distribution of the error lies left of the equal-rate baseline's.",
            "90th and 99th percentile over those of the baseline at an equal rate, below 1.",
            "tracking_distribution",
            lambda rows, reading: [
                *_tracking_estimates(rows.pooled(reading), "p90"),
                *_tracking_estimates(rows.pooled(reading), "p99"),
            ],
            lambda rows, reading: _worst_tracking(rows.by_trip(reading), "p99"),
        ),
    )


def _no_trip(_rows: ReadingRows, _reading: Reading) -> str:
    """Where trips are not told apart."""
    return ""


def _judged(claim: _ByReading, readings: Sequence[ReadingResult]) -> ClaimRow:
    plain = readings[0]
    own = plain.labelled.reading
    return ClaimRow(
        claim.name,
        claim.place,
        claim.sentence,
        measure=claim.measure,
        figure=_shown(claim.estimates(plain.rows, own)),
        worst=claim.worst(plain.rows, own),
        verdicts={
            one.labelled.label: verdict_of(
                [estimate for _, estimate in claim.estimates(one.rows, one.labelled.reading)]
            )
            for one in readings
        },
        shown_in=claim.shown_in,
        command=COMMAND,
    )


def _hybrid(readings: Sequence[ReadingResult]) -> ClaimRow:
    """The hybrid beside each of its members: cv is the baseline itself."""

    def estimates(rows: ReadingRows) -> list[tuple[str, Estimate]]:
        found: list[tuple[str, Estimate]] = []
        for both, alone in zip(rows.messages, rows.alone, strict=True):
            if alone.message_ratio >= 1.0:
                found.append((centimetres(both.threshold_m), _message_estimate(both)))
                continue
            low, high = both.difference_low, both.difference_high
            scale = alone.message_ratio
            found.append(
                (
                    centimetres(both.threshold_m),
                    Estimate(
                        both.message_ratio / scale,
                        None if low is None else 1.0 + low / scale,
                        None if high is None else 1.0 + high / scale,
                    ),
                )
            )
        return found

    return ClaimRow(
        "better than its members",
        "system",
        "A hybrid of sub-models serves better than either of them.",
        measure="All messages of the hybrid over those of the better of its two sub-models alone, below 1.",
        figure=_shown(estimates(readings[0].rows)),
        worst="",
        verdicts={one.labelled.label: verdict_of([x for _, x in estimates(one.rows)]) for one in readings},
        shown_in="readings",
        command=COMMAND,
    )


def _falling(evaluation: EvaluationResult) -> ClaimRow:
    rates = {
        policy: [
            row.total_rate_hz
            for row in sorted(evaluation.rates, key=lambda row: row.threshold_m)
            if row.trip == POOLED and row.policy == policy
        ]
        for policy in ("mbc", "baseline")
    }
    falls = all(bool((np.diff(values) < 0).all()) for values in rates.values())
    verdict: Verdict = "not run" if len(rates["mbc"]) < 2 else "holds" if falls else "fails"
    shown = "; ".join(
        f"{name} {', '.join(f'{rate:.2f}' for rate in values)}" for name, values in rates.items()
    )
    return ClaimRow(
        "wider threshold, fewer messages",
        "evaluation",
        "The wider the threshold, the fewer messages are sent, by MBC and by the baseline.",
        measure="Message rates over rising thresholds, each below the one before [1/s].",
        figure=shown,
        worst="",
        verdicts={PLAIN_LABEL: verdict},
        shown_in="message_rate",
        command=COMMAND,
    )


def _sweep(evaluation: EvaluationResult, plan: PaperPlan) -> ClaimRow:
    """At every packet error ratio with losses: the row of the equal-rate baseline beside MBC's."""
    found: dict[str, Verdict] = {}
    shown = ""
    for label, basis, schedule in (
        (PLAIN_LABEL, PLAIN.rate_basis, PLAIN.schedule),
        ("rate basis: all messages", "total", PLAIN.schedule),
        ("baseline's schedule: error-driven", PLAIN.rate_basis, "matched"),
    ):
        by_ratio: list[tuple[str, list[Estimate]]] = []
        for ratio in plan.packet_error_ratios:
            if ratio > 0:
                at = [(ratio, threshold_m) for threshold_m in plan.thresholds_m]
                by_ratio.append((f"{100 * ratio:g} %", list(_p90_over(evaluation, at, basis, schedule))))
        found[label] = verdict_of([one for _, estimates in by_ratio for one in estimates])
        if label == PLAIN_LABEL:
            shown = ", ".join(
                f"{name}: {min(values):.2f} to {max(values):.2f}"
                for name, values in ((name, [one.value for one in estimates]) for name, estimates in by_ratio)
                if values
            )
    return ClaimRow(
        "better at every loss",
        "evaluation",
        "The 90th percentile of the error lies below the baseline's at every packet error ratio.",
        measure="90th percentile over that of the equal-rate baseline, at every PER and threshold, below 1.",
        figure=shown,
        worst="",
        verdicts=found,
        shown_in="tracking_loss",
        command=COMMAND,
    )


def _p90_over(
    evaluation: EvaluationResult, at: Iterable[tuple[float, float]], basis: str, schedule: str
) -> Iterable[Estimate]:
    rows = {
        (row.policy, row.rate_basis, row.packet_error_ratio, row.threshold_m): row.pte_p90_m
        for row in evaluation.tracking
        if row.trip == POOLED
    }
    for ratio, threshold_m in at:
        own = rows.get(("mbc", None, ratio, threshold_m))
        rival = rows.get((f"baseline-{schedule}", basis, ratio, threshold_m))
        if own is not None and rival:
            yield Estimate(own / rival)


def _complementary(found: Complement) -> ClaimRow:
    total_s = sum(found.only_s) + found.both_s + found.neither_s
    shares = [one / total_s for one in found.only_s] if total_s else [0.0 for _ in found.only_s]
    enough = sum(share >= _LEAST_SHARE for share in shares)
    verdict: Verdict = "holds" if enough == len(shares) else "in part" if enough else "fails"
    only = ", ".join(
        f"only {name} {100 * share:.1f} %" for name, share in zip(found.members, shares, strict=True)
    )
    rest = [100 * one / total_s if total_s else 0.0 for one in (found.both_s, found.neither_s)]
    return ClaimRow(
        "they complete each other",
        "evaluation",
        "At times one sub-model stays under the threshold while the other fails, and the other way round.",
        measure=(
            f"Time that each alone held, at {centimetres(found.threshold_m)}; holds where both had 1 %."
        ),
        figure=f"{only}, both {rest[0]:.1f} %, neither {rest[1]:.1f} %",
        worst="",
        verdicts={PLAIN_LABEL: verdict},
        shown_in="sub_models",
        command=COMMAND,
    )


def _manoeuvres(found: Complement) -> ClaimRow:
    """A sign test: of the manoeuvres in which the paths fail at different times, who wins how many."""
    process = next(name for name in found.members if name != "cv")
    lives = [(one.survival_s[process], one.survival_s["cv"]) for one in found.survivals]
    longer, shorter = sum(a > b for a, b in lives), sum(a < b for a, b in lives)
    verdict: Verdict = "not run"
    shown = "no manoeuvre found"
    if lives:
        low, high = 0.0, 1.0
        if longer + shorter:
            interval = stats.binomtest(longer, longer + shorter).proportion_ci(0.95, "wilson")
            low, high = float(interval.low), float(interval.high)
        verdict = "holds" if low > 0.5 else "fails" if high < 0.5 else "not shown"
        medians = np.median(np.array(lives), axis=0)
        shown = (
            f"{len(lives)} manoeuvres: the process longer in {longer}, constant velocity in {shorter}; "
            f"medians {medians[0]:.1f} and {medians[1]:.1f} s"
        )
    return ClaimRow(
        "the process follows manoeuvres",
        "evaluation",
        "In a manoeuvre the Gaussian process follows the true path longer than constant velocity.",
        measure=(
            f"Time until each path is {centimetres(found.threshold_m)} off, from half a second before each "
            "manoeuvre on, 4 s at most; holds where the process wins more of them than chance would (95 %)."
        ),
        figure=shown,
        worst="",
        verdicts={PLAIN_LABEL: verdict},
        shown_in="manoeuvre",
        command=COMMAND,
    )


def _message_estimate(row: RatioRow) -> Estimate:
    return Estimate(row.message_ratio, row.message_low, row.message_high)


def _message_estimates(rows: Iterable[RatioRow]) -> list[tuple[str, Estimate]]:
    return [(centimetres(row.threshold_m), _message_estimate(row)) for row in rows]


def _tracking_estimates(rows: Iterable[TrackingRatioRow], quantile: str) -> list[tuple[str, Estimate]]:
    return [
        (
            f"{quantile} {centimetres(row.threshold_m)}",
            Estimate(*(getattr(row, f"{quantile}_{what}") for what in ("ratio", "low", "high"))),
        )
        for row in rows
    ]


def _worst_messages(rows: Sequence[RatioRow]) -> str:
    worst = max(rows, key=lambda row: row.worst_ratio, default=None)
    if worst is None or worst.trips < 2:
        return ""
    return f"{worst.worst_trip} {worst.worst_ratio:.2f} at {centimetres(worst.threshold_m)}"


def _worst_tracking(rows: Sequence[TrackingRatioRow], quantile: str) -> str:
    usable = [row for row in rows if np.isfinite(getattr(row, f"{quantile}_ratio"))]
    if len({row.trip for row in rows}) < 2 or not usable:
        return ""
    worst = max(usable, key=lambda row: getattr(row, f"{quantile}_ratio"))
    return f"{worst.trip} {getattr(worst, f'{quantile}_ratio'):.2f} at {centimetres(worst.threshold_m)}"


def _shown(estimates: Sequence[tuple[str, Estimate]]) -> str:
    return ", ".join(
        f"{name}: {one.value:.2f}" + ("" if one.low is None else f" ({one.low:.2f} to {one.high:.2f})")
        for name, one in estimates
    )
