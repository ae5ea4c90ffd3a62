"""What an evaluation found, what it did not, and on which data, in words made from its rows.

They stand before any table. Rates at one threshold beside errors at one rate would say together what neither
says: so each sentence names its reading, and the free receiver is held against the model-based sender
wherever the baseline is.
"""

from collections.abc import Iterable, Sequence
from math import isfinite
from textwrap import shorten

from modelcast.report.data_words import data_text, protocol_text
from modelcast.report.headline import (
    EQUAL_RATE_POLICIES,
    Headline,
    evaluated_ratios,
    headlines,
    sender_label,
)
from modelcast.report.held_errors import HeldErrors, chance_text, worse_text
from modelcast.report.ratio_words import ERROR, MESSAGES, numbers, range_text, verdict
from modelcast.report.senders import (
    BASELINE_WORDS,
    expecting,
    free_words,
    is_free_receiver,
    sender_words,
)
from modelcast.study.loss_ratios import nearest_ratio
from modelcast.study.result import EvaluationResult, TripRow
from modelcast.study.rules import FREE_MATCHED, FREE_RECEIVER, MODEL_SENDER
from modelcast.study.table import Row

__all__ = ["findings"]

_FREE = "the free receiver"
_LONGEST_UNUSED = 160
"""Letters of what was not used that the first paragraphs show."""


def findings(result: EvaluationResult) -> list[tuple[str, str]]:
    """Return what was found, what was not, on which data, and what the words mean; nothing without a trip.

    Parameters
    ----------
    result
        The evaluation.

    Returns
    -------
    list of tuple
        A title and its text each.
    """
    lines = [line for line in headlines(result) if line.mbc is not None]
    if not result.trips or not lines:
        return []
    return [
        ("Found", _found(result, lines)),
        ("Not found", _not_found(result, lines)),
        ("Data", _data(result)),
        ("Words", _words(result, lines)),
    ]


def _found(result: EvaluationResult, lines: Sequence[Headline]) -> str:
    sender = sender_label(result)
    named = f"{sender} (model-based communication)" if sender == "MBC" else sender
    sent = _sent([line.ratio for line in lines], [line.free_ratio for line in lines])
    at = "At the same threshold, without loss,"
    text = f"{at} {named} sent {sent}." if sent else f"{named} was run alone."
    if is_free_receiver(result):
        text += f" Its bank is {_FREE}'s, so none is run beside it."
    ratio = nearest_ratio(evaluated_ratios(result))
    if ratio is None:
        return text
    return f"{text}{_sent_under(result, lines, ratio)}{_erred(lines, ratio)}"


def _sent(over_baseline: Iterable[float | None], over_free: Iterable[float | None]) -> str:
    """Say how many messages that is; nothing where nobody was run beside it."""
    held = (("the baseline", numbers(over_baseline)), (_FREE, numbers(over_free)))
    return " and ".join(
        f"{verdict(ratios, MESSAGES)} {name} ({range_text(ratios)} times as many)"
        for name, ratios in held
        if ratios
    )


def _sent_under(result: EvaluationResult, lines: Sequence[Headline], ratio: float) -> str:
    """Say the same of the loss runs, whose senders keep alive and may repeat; nothing where they do not."""
    longest_s = result.settings.get("keep_alive_s")
    if not ratio and longest_s is None:
        return ""
    sent = _sent(
        *(
            [_over(line.rate_hz(ratio, MODEL_SENDER), line.rate_hz(ratio, other)) for line in lines]
            for other in ("baseline", FREE_RECEIVER)
        )
    )
    if not sent:
        return ""
    lost = [f"{100 * ratio:.4g} % of the messages lost"] if ratio else []
    kept = [] if longest_s is None else [f"a message at least every {longest_s:g} s"]
    return f" With {' and '.join(lost + kept)}, it sent {sent}."


def _over(own_hz: float | None, other_hz: float | None) -> float | None:
    return None if own_hz is None or not other_hz else own_hz / other_hz


def _erred(lines: Sequence[Headline], ratio: float) -> str:
    held = (
        ("the better baseline", _cells(lines, (ratio,), EQUAL_RATE_POLICIES)),
        (_FREE, _cells(lines, (ratio,), (FREE_MATCHED,))),
    )
    errors = [
        f"{verdict(over, ERROR)} {name}'s ({range_text(over)} times as large)"
        for name, cells in held
        if (over := [cell.over for cell in cells])
    ]
    if not errors:
        return ""
    lost = f"with {100 * ratio:.4g} % of the messages lost" if ratio else "without loss"
    return f" At the same rate, {lost}, its error (90th percentile) was {' and '.join(errors)}."


def _words(result: EvaluationResult, lines: Sequence[Headline]) -> str:
    """What a newcomer has to know to read the rest."""
    meant = [f"{sender_label(result)}: {sender_words(result)}"]
    if any(line.baseline is not None for line in lines):
        meant.append(f"baseline: {BASELINE_WORDS}")
    if any(line.free is not None for line in lines):
        meant.append(f"{_FREE.removeprefix('the ')}: {free_words(result.settings)}")
    meant.append("error: how far the receiver believes the vehicle to be from where it is")
    return f"{'; '.join(meant)}."


def _repeating(result: EvaluationResult, lines: Sequence[Headline]) -> str:
    """Say who repeats under loss, which the baseline does not; nothing where nobody does or none is lost."""
    names = {MODEL_SENDER: sender_label(result), FREE_RECEIVER: f"{_FREE}'s sender"}
    repeats = expecting(result)
    lossy = [ratio for ratio in evaluated_ratios(result) if ratio > 0.0]
    if not repeats or not lossy:
        return ""
    times = numbers(
        _over(line.rate_hz(ratio, name), line.rate_hz(0.0, name))
        for line in lines
        for name in repeats
        for ratio in lossy
    )
    who = " and ".join(names[name] for name in repeats)
    repeat, know, send = (
        ("repeat", "they know", "send") if len(repeats) > 1 else ("repeats", "it knows", "sends")
    )
    much = f" and {send} up to {max(times):.1f} times as much" if times else ""
    baseline = " The baseline does not repeat." if any(line.baseline is not None for line in lines) else ""
    told = f" Under losses {who} also {repeat}: {know} the share lost{much}."
    return f"{told}{baseline} Where believe is sent, nobody does."


def _not_found(result: EvaluationResult, lines: Sequence[Headline]) -> str:
    ratios = evaluated_ratios(result)
    lossy = [ratio for ratio in ratios if ratio > 0.0]
    saved = _saved(result, lines)
    if not ratios:
        return f"Errors were not measured, so nothing is said of what these messages are worth.{saved}"
    shown = lossy or ratios
    rivals = (
        ("the baseline's", "baseline", EQUAL_RATE_POLICIES),
        (f"{_FREE}'s", FREE_RECEIVER, (FREE_MATCHED,)),
    )
    parts = [
        text
        for name, same, matched in rivals
        if (text := worse_text(name, _cells(lines, shown, (same,)), _cells(lines, shown, matched)))
    ]
    if not parts:
        return f"Nobody's errors were measured beside {sender_label(result)}'s.{saved}"
    rival, matched = "free receiver", _cells(lines, shown, (FREE_MATCHED,))
    if not matched:
        rival, matched = "better baseline", _cells(lines, shown, EQUAL_RATE_POLICIES)
    kind = "cases (thresholds and loss ratios)" if lossy else "cases (thresholds)"
    unlost = "" if lossy else " No message was lost, so nothing is said of losses."
    worse, repeating = ", ".join(parts), _repeating(result, lines)
    larger = f"Of the {kind}, {sender_label(result)}'s error was larger than {worse}."
    return f"{larger}{chance_text(matched, rival)}{saved}{repeating}{unlost}"


def _saved(result: EvaluationResult, lines: Sequence[Headline]) -> str:
    """Say how much of the baseline's messages a receiver saves without a model, and how much the sender."""
    shares = [
        (1.0 - line.free.total_rate_hz / of, 1.0 - line.mbc.total_rate_hz / of)
        for line in lines
        if line.mbc is not None
        and line.baseline is not None
        and line.free is not None
        and (of := line.baseline.total_rate_hz) > 0.0
    ]
    if not shares:
        return ""
    shown = [[round(share, 2) + 0.0 for share in own] for own in zip(*shares, strict=True)]
    free, own = (range_text(of) for of in shown)
    more = " Below 0 it sends more." if min(map(min, shown)) < 0.0 else ""
    saved = f"saves {free} of the baseline's messages, {sender_label(result)} {own}"
    return f" Without loss {_FREE} {saved}.{more}"


def _data(result: EvaluationResult) -> str:
    trips = result.trips
    text = data_text(
        [trip.source for trip in trips],
        sum(trip.duration_s for trip in trips),
        [_protocol(result, name) for name in sorted({trip.protocol for trip in trips})],
    )
    return f"{text}{_understood(trips)}"


def _understood(trips: Sequence[TripRow]) -> str:
    """Say which columns were taken for what; of several ways, that the list of trips has them."""
    ways = list(
        {tuple(trip.understood.items()): trip.understood for trip in trips if trip.understood}.values()
    )
    if not ways:
        return ""
    if len(ways) > 1:
        listed = "which report.html lists above the trips"
        return f" Their files were understood in {len(ways)} ways, {listed}."
    if "columns" not in ways[0]:
        return ""
    read = sum(bool(trip.understood) for trip in trips)
    taken = "Columns taken" if read == len(trips) else f"Of {read} of {len(trips)} trips: columns taken"
    words = {"columns": taken, "assumed": "only assumed", "not used": "not used"}
    said = [f"{word}: {_short(ways[0][name])}" for name, word in words.items() if name in ways[0]]
    return f" {'; '.join(said)}."


def _short(text: str) -> str:
    """Text that is long cut at a word."""
    return shorten(text, _LONGEST_UNUSED, placeholder=" and more")


def _protocol(result: EvaluationResult, name: str) -> str:
    own = [trip for trip in result.trips if trip.protocol == name]
    of = "" if len(own) == len(result.trips) else f" ({len(own)} of them)"
    smoothed = sum(trip.conditioned for trip in own)
    truth = "" if not smoothed else " (smoothed)" if smoothed == len(own) else f" ({smoothed} smoothed)"
    return protocol_text(name, result.settings.get("sensor"), of=of, truth=truth)


def _cells(lines: Iterable[Headline], ratios: Iterable[float], others: Sequence[str]) -> list[HeldErrors]:
    """The cells in which both are known; of several others the one that errs least."""
    found: list[HeldErrors] = []
    asked = list(ratios)
    for line in lines:
        for ratio in asked:
            own = line.tracking.get((ratio, MODEL_SENDER))
            rows = [line.tracking[ratio, other] for other in others if (ratio, other) in line.tracking]
            rows = [row for row in rows if isfinite(row.pte_p90_m) and row.pte_p90_m > 0.0]
            if own is not None and isfinite(own.pte_p90_m) and rows:
                best = min(rows, key=lambda row: row.pte_p90_m)
                found.append(_held(line.threshold_m, ratio, own, best))
    return found


def _held(threshold_m: float, ratio: float, own: Row, other: Row) -> HeldErrors:
    """Two rows held against one another."""
    known = own.pte_p90_low_m is not None and other.pte_p90_low_m is not None
    overlaps = known and bool(
        own.pte_p90_low_m <= other.pte_p90_high_m and other.pte_p90_low_m <= own.pte_p90_high_m
    )
    return HeldErrors(
        threshold_m,
        ratio,
        own_m=own.pte_p90_m,
        other_m=other.pte_p90_m,
        paid=own.message_rate_hz / other.message_rate_hz,
        may_be_chance=overlaps if known else None,
    )
