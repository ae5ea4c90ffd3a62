"""The paper's claims that can be tested on trips, and what is found under every reading.

The sentences are the paper's in our words. Claims that say one thing is smaller than another are judged by
`modelcast.study.paper.verdict.verdict_of`; how the others are judged stands in their rows. Behind them
stand two sentences that the paper does not say (`modelcast.study.paper.beside_free`).
"""

from collections.abc import Sequence
from math import sqrt
from statistics import NormalDist

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.study.paper.beside_free import BESIDE, beside_free
from modelcast.study.paper.by_reading import (
    ByReading,
    message_estimate,
    message_estimates,
    shown_estimates,
    tracking_estimates,
    worst_messages,
    worst_tracking,
)
from modelcast.study.paper.choices import Reading
from modelcast.study.paper.complement import Complement
from modelcast.study.paper.readings import ReadingRows
from modelcast.study.paper.result import ClaimRow, ReadingResult
from modelcast.study.paper.verdict import Estimate, Verdict, verdict_of
from modelcast.study.table import Row
from modelcast.study.wording import centimetres

__all__ = ["COMMAND", "claim_rows"]

COMMAND = "modelcast reproduce paper TRIPS..."
_LEAST_SHARE = 0.01


def claim_rows(
    readings: Sequence[ReadingResult],
) -> tuple[ClaimRow, ...]:
    """Judge every claim.

    Parameters
    ----------
    readings
        The plain one first.
    """
    ratio = readings[0].rows.headline_ratio
    rows = [_judged(claim, readings) for claim in (*_by_reading(ratio), *beside_free(ratio))]
    rows += [
        _falling(readings),
        _sweep(readings),
        _hybrid(readings),
        _complementary(readings),
        _manoeuvres(readings),
    ]
    order = ("abstract", "system", "evaluation", "conclusion", BESIDE)
    return tuple(sorted(rows, key=lambda row: order.index(row.place)))


def _by_reading(headline_ratio: float) -> tuple[ByReading, ...]:
    per = f"{100 * headline_ratio:g} %"
    return (
        ByReading(
            "fewer messages",
            "abstract",
            "The architecture reduces the required message exchange rate.",
            "Updates and identifications over the baseline's messages at the same threshold, below 1.",
            "message_rate",
            lambda rows, _: message_estimates(rows.messages),
            lambda rows, _: worst_messages(rows.messages),
        ),
        ByReading(
            "more precise tracking",
            "abstract",
            "The architecture increases the precision with which remotes are tracked.",
            f"90th percentile of the error at a PER of {per} over that of the equal-rate baseline, below 1.",
            "loss_update",
            lambda rows, reading: tracking_estimates(rows.pooled(reading), "p90"),
            lambda rows, reading: worst_tracking(rows.by_trip(reading), "p90"),
        ),
        ByReading(
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
        ByReading(
            "fewer updates",
            "evaluation",
            "Model updates are sent less often than the baseline sends messages, at every threshold.",
            "Updates over the baseline's messages at the same threshold, below 1.",
            "message_rate",
            lambda rows, _: message_estimates(rows.updates),
            lambda rows, _: worst_messages(rows.updates),
        ),
        ByReading(
            "a better distribution",
            "evaluation",
            f"At a PER of {per} the distribution of the error lies left of the equal-rate baseline's.",
            "90th and 99th percentile over those of the baseline at an equal rate, below 1.",
            "distribution_update",
            lambda rows, reading: [
                *tracking_estimates(rows.pooled(reading), "p90"),
                *tracking_estimates(rows.pooled(reading), "p99"),
            ],
            lambda rows, reading: worst_tracking(rows.by_trip(reading), "p99"),
        ),
    )


def _no_trip(_rows: ReadingRows, _reading: Reading) -> str:
    """Where trips are not told apart."""
    return ""


def _judged(claim: ByReading, readings: Sequence[ReadingResult]) -> ClaimRow:
    plain = readings[0]
    own = plain.labelled.reading
    return ClaimRow(
        claim.name,
        claim.place,
        claim.sentence,
        measure=claim.measure,
        figure=shown_estimates(claim.estimates(plain.rows, own)),
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
                found.append((centimetres(both.threshold_m), message_estimate(both)))
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
        figure=shown_estimates(estimates(readings[0].rows)),
        worst="",
        verdicts={one.labelled.label: verdict_of([x for _, x in estimates(one.rows)]) for one in readings},
        shown_in="readings",
        command=COMMAND,
    )


def _falling(readings: Sequence[ReadingResult]) -> ClaimRow:
    def rates(rows: ReadingRows) -> dict[str, list[float]]:
        ordered = sorted(rows.messages, key=lambda row: row.threshold_m)
        return {
            "mbc": [row.update_rate_hz + row.identification_rate_hz for row in ordered],
            "baseline": [row.baseline_rate_hz for row in ordered],
        }

    def verdict(rows: ReadingRows) -> Verdict:
        found = rates(rows)
        if len(rows.messages) < 2:
            return "not run"
        falls = [bool((np.diff(values) < 0).all()) for values in found.values()]
        return "holds" if all(falls) else "in part" if any(falls) else "fails"

    return ClaimRow(
        "wider threshold, fewer messages",
        "evaluation",
        "The wider the threshold, the fewer messages are sent, by MBC and by the baseline.",
        measure="Message rates over rising thresholds, each below the one before [1/s].",
        figure="; ".join(
            f"{name} {', '.join(f'{rate:.2f}' for rate in values)}"
            for name, values in rates(readings[0].rows).items()
        ),
        worst="",
        verdicts={one.labelled.label: verdict(one.rows) for one in readings},
        shown_in="message_rate",
        command=COMMAND,
    )


def _sweep(readings: Sequence[ReadingResult]) -> ClaimRow:
    """At every packet error ratio with losses, in the readings that have the whole sweep."""

    def lossy(one: ReadingResult) -> list[Row]:
        return [row for row in one.rows.sweep(one.labelled.reading) if row.packet_error_ratio > 0]

    def estimate(row: Row) -> Estimate:
        return Estimate(row.p90_ratio, row.p90_low, row.p90_high)

    plain = readings[0]
    swept = [one for one in readings if one.rows is plain.rows]
    by_ratio: dict[float, list[float]] = {}
    for row in lossy(plain):
        by_ratio.setdefault(row.packet_error_ratio, []).append(row.p90_ratio)
    return ClaimRow(
        "better at every loss",
        "evaluation",
        "The 90th percentile of the error lies below the baseline's at every packet error ratio.",
        measure=(
            "90th percentile over that of the equal-rate baseline, at every PER above 0 and every threshold, "
            "below 1; swept with the plain sender alone, against every baseline."
        ),
        figure=", ".join(
            f"{100 * ratio:g} %: {min(values):.2f} to {max(values):.2f}"
            for ratio, values in sorted(by_ratio.items())
        ),
        worst="",
        verdicts={one.labelled.label: verdict_of([estimate(row) for row in lossy(one)]) for one in swept},
        shown_in="loss_update",
        command=COMMAND,
    )


def _complementary(readings: Sequence[ReadingResult]) -> ClaimRow:
    def shares(found: Complement) -> list[float]:
        """Of each alone, of both and of neither; nothing where they never served together."""
        times = (*found.only_s, found.both_s, found.neither_s)
        return [one / sum(times) for one in times] if sum(times) > 0 else []

    def verdict(found: Complement) -> Verdict:
        own = shares(found)[: len(found.members)]
        enough = sum(share >= _LEAST_SHARE for share in own)
        return "not run" if not own else "holds" if enough == len(own) else "in part" if enough else "fails"

    plain = readings[0].rows.complement
    names = (*(f"only {name}" for name in plain.members), "both", "neither")
    return ClaimRow(
        "they complete each other",
        "evaluation",
        "At times one sub-model stays under the threshold while the other fails, and the other way round.",
        measure=(
            f"Time that each alone held, at {centimetres(plain.threshold_m)}; holds where both had 1 %."
        ),
        figure=", ".join(
            f"{name} {100 * share:.1f} %" for name, share in zip(names, shares(plain), strict=False)
        )
        or "they never served together",
        worst="",
        verdicts={one.labelled.label: verdict(one.rows.complement) for one in readings},
        shown_in="sub_models",
        command=COMMAND,
    )


def _manoeuvres(readings: Sequence[ReadingResult]) -> ClaimRow:
    """A sign test: of the manoeuvres in which the paths fail at different times, who wins how many."""

    def lives(found: Complement) -> FloatArray:
        """Survival of the process and of constant velocity, (N, 2) [s]."""
        process = next(name for name in found.members if name != "cv")
        pairs = [(one.survival_s[process], one.survival_s["cv"]) for one in found.survivals]
        return np.array(pairs, dtype=np.float64).reshape(-1, 2)

    def wins(found: Complement) -> tuple[int, int]:
        own, other = lives(found).T
        return int((own > other).sum()), int((own < other).sum())

    def verdict(found: Complement) -> Verdict:
        if not found.survivals:
            return "not run"
        longer, shorter = wins(found)
        if not longer + shorter:
            return "not shown"
        low, high = _wilson_limits(longer, longer + shorter)
        return "holds" if low > 0.5 else "fails" if high < 0.5 else "not shown"

    plain = readings[0].rows.complement
    shown = "no manoeuvre found"
    if plain.survivals:
        longer, shorter = wins(plain)
        own_s, other_s = np.median(lives(plain), axis=0)
        shown = (
            f"{len(plain.survivals)} manoeuvres: the process longer in {longer}, constant velocity in "
            f"{shorter}; medians {own_s:.1f} and {other_s:.1f} s"
        )
    return ClaimRow(
        "the process follows manoeuvres",
        "evaluation",
        "In a manoeuvre the Gaussian process follows the true path longer than constant velocity.",
        measure=(
            f"Time until each path is {centimetres(plain.threshold_m)} off, from half a second before each "
            "manoeuvre on, 4 s at most; holds where the process wins more of them than chance would (95 %)."
        ),
        figure=shown,
        worst="",
        verdicts={one.labelled.label: verdict(one.rows.complement) for one in readings},
        shown_in="manoeuvre",
        command=COMMAND,
    )


def _wilson_limits(wins: int, trials: int) -> tuple[float, float]:
    """95 % limits of a share, after E. B. Wilson (1927)."""
    reach = NormalDist().inv_cdf(0.975)
    share, spread = wins / trials, reach**2 / trials
    centre = share + 0.5 * spread
    half = sqrt(spread * (share * (1.0 - share) + 0.25 * spread))
    return (centre - half) / (1.0 + spread), (centre + half) / (1.0 + spread)
