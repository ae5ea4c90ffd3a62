"""What a comparison found, what it did not, and on which data, in words made from its rows.

Candidates are held against the baseline and the free receiver, in the sentences of an evaluation
(`modelcast.report.findings`): messages at the same threshold, errors in both readings.
"""

from collections.abc import Mapping, Sequence
from math import isfinite
from statistics import fmean

from modelcast.core.near_names import listed
from modelcast.report.comparison_rows import (
    candidate_rows,
    loss_ratios,
    pooled_rows,
    protocols,
    rival_rows_of,
)
from modelcast.report.data_words import data_text, protocol_text
from modelcast.report.held_errors import HeldErrors, worse_text
from modelcast.report.ratio_words import MESSAGES, numbers, range_text, share_text, verdict
from modelcast.report.senders import BASELINE_WORDS, free_words
from modelcast.study.compare.result import ComparisonResult
from modelcast.study.loss_ratios import nearest_ratio
from modelcast.study.table import Row

__all__ = ["comparison_findings"]

_MOST_NAMES = 4
"""Of more candidates with one verdict the first are named, the others counted."""

_MOST_JUDGED = 2
"""Of so many candidates, those with the fewest messages, is told where they err more."""


def comparison_findings(result: ComparisonResult) -> list[tuple[str, str]]:
    """Return what was found and what not, a protocol each, on which data, and what the words mean.

    Parameters
    ----------
    result
        The comparison; nothing is said of one without rows.

    Returns
    -------
    list of tuple
        A title and its text each.
    """
    run = protocols(result)
    if not run or not result.trips:
        return []
    of = {name: f", {name}" if len(run) > 1 else "" for name in run}
    return [
        *((f"Found{of[name]}", _found(result, name)) for name in run),
        *((f"Not found{of[name]}", _not_found(result, name)) for name in run),
        ("Data", _data(result, run)),
        ("Words", _words(result)),
    ]


def _judged(result: ComparisonResult) -> list[str]:
    """Candidates that are neither the baseline nor the free receiver; all, where there are no others."""
    names = [row.name for row in result.candidates]
    plain = {result.free, *(name for name in names if result.is_baseline(name))}
    return [name for name in names if name not in plain] or names


def _measure(result: ComparisonResult) -> str | None:
    """Beside whom candidates may err more: the free receiver; where it is judged, the baseline, as None."""
    return None if _judged(result) == [result.free] else result.free


def _rivals(result: ComparisonResult) -> list[str | None]:
    """Whom candidates are held against: the baseline, which has no name, and the free receiver."""
    return [None] if result.free is None else [None, result.free]


def _named(rival: str | None) -> str:
    return "the baseline" if rival is None else "the free receiver"


_BETTER = "the better baseline"
"""The one of both baselines at the same rate that errs less."""

_SENT = "sent {verdict} {rival} ({ratios} times as many)"
_ERRED = "erred {verdict} {rival} ({ratios} times as much)"
_OF_UPDATES = "at the rate of its updates alone"
"""The reading in which rivals send as many messages as a candidate sends updates, not all its messages."""

_MUCH = ("less than", "as much as", "more than")


def _found(result: ComparisonResult, protocol: str) -> str:
    names = _judged(result)
    parts: list[str] = []
    for rival in _rivals(result):
        ratios = {
            name: numbers(row.message_ratio for row in _message_rows(result, name, protocol, rival))
            for name in names
            if name != rival
        }
        parts += _by_verdict(ratios, MESSAGES, _SENT, _named(rival))
    text = f"At the same threshold, without loss, {'; '.join(parts)}."
    ratio = nearest_ratio(loss_ratios(result))
    if ratio is None:
        return text
    parts = []
    for rival in _rivals(result):
        who = _BETTER if rival is None else _named(rival)
        ratios = {
            name: _error_ratios(result, name, protocol, rival, ratio) for name in names if name != rival
        }
        parts += _by_verdict(ratios, _MUCH, _ERRED, who)
    if not parts:
        return text
    lost = f"with {100 * ratio:.4g} % of the messages lost" if ratio else "without loss"
    at = _at_rate(result)
    return f"{text} {at[0].upper()}{at[1:]}, {lost}, by the 90th percentile, {'; '.join(parts)}."


def _at_rate(result: ComparisonResult) -> str:
    return _OF_UPDATES if result.settings.get("rate_basis") == "update" else "at the same rate"


def _by_verdict(
    ratios: Mapping[str, Sequence[float]], words: tuple[str, str, str], form: str, rival: str
) -> list[str]:
    """Group candidates of one verdict, and say of each group what its ratios are; nothing without any."""
    groups: dict[str, list[str]] = {}
    for name, own in ratios.items():
        if own:
            groups.setdefault(verdict(own, words), []).append(name)
    said: list[str] = []
    for found, group in groups.items():
        shown = range_text([value for name in group for value in ratios[name]])
        said.append(f"{_names(group)} {form.format(verdict=found, rival=rival, ratios=shown)}")
    return [", ".join(said)] if said else []


def _names(names: Sequence[str]) -> str:
    if len(names) <= _MOST_NAMES:
        return listed(names, "and")
    return f"{', '.join(names[: _MOST_NAMES - 1])} and {len(names) - _MOST_NAMES + 1} others"


def _message_rows(result: ComparisonResult, name: str, protocol: str, rival: str | None) -> list[Row]:
    if rival is None:
        return candidate_rows(result, name, protocol)
    return rival_rows_of(result, name, protocol, rival)


def _pooled(result: ComparisonResult, name: str, protocol: str) -> list[Row]:
    return [row for ratio in loss_ratios(result) for row in pooled_rows(result, name, protocol, ratio)]


def _error_ratios(
    result: ComparisonResult, name: str, protocol: str, rival: str | None, ratio: float
) -> list[float]:
    rows = pooled_rows(result, name, protocol, ratio)
    return numbers(row.p90_ratio if rival is None else row.p90_over_free for row in rows)


def _not_found(result: ComparisonResult, protocol: str) -> str:
    names = _judged(result)
    if not result.tracking:
        said = "Errors were not measured, so nothing is said of what these messages are worth."
        return f"{said}{_chance_of_messages(result, protocol)}"
    lossy = any(row.packet_error_ratio for row in result.tracking)
    kind = "cases (thresholds and loss ratios)" if lossy else "cases (thresholds)"
    rival = f"{_named(_measure(result))}'s"
    parts = [
        text
        for name in sorted(names, key=lambda name: _mean_messages(result, name, protocol))
        if name != _measure(result)
        and (
            text := worse_text(
                name, *_held(result, name, protocol, with_loss=lossy), at_rate=_at_rate(result)
            )
        )
    ]
    unlost = "" if lossy else " No message was lost, so nothing is said of losses."
    if not parts:
        return f"Nobody's errors were measured beside {rival}.{_chance_of_messages(result, protocol)}{unlost}"
    shown = parts[:_MOST_JUDGED]
    more = len(parts) - len(shown)
    rest = f"; the tables have {more} more" if more else ""
    larger = f"Of the {kind}, the error was larger than {rival}: {'; '.join(shown)}{rest}."
    chance = _chance(result, protocol, with_loss=lossy)
    return f"{larger}{chance}{_chance_of_messages(result, protocol)}{unlost}"


def _mean_messages(result: ComparisonResult, name: str, protocol: str) -> float:
    """Messages over the baseline's, mean of the thresholds."""
    return fmean(row.message_ratio for row in candidate_rows(result, name, protocol))


def _held(
    result: ComparisonResult, name: str, protocol: str, *, with_loss: bool
) -> tuple[list[HeldErrors], list[HeldErrors]]:
    """A candidate's cases beside whom it is held against, by reading."""
    same: list[HeldErrors] = []
    matched: list[HeldErrors] = []
    for row in _pooled(result, name, protocol):
        if with_loss and row.packet_error_ratio == 0.0:
            continue
        if _measure(result) is not None:
            pairs = (
                (same, row.free_p90_m, row.free_rate_hz),
                (matched, row.free_matched_p90_m, row.free_matched_rate_hz),
            )
        else:
            harder_m, rate_hz = min(
                (row.matched_p90_m, row.matched_rate_hz), (row.periodic_p90_m, row.periodic_rate_hz)
            )
            pairs = ((same, row.baseline_p90_m, row.baseline_rate_hz), (matched, harder_m, rate_hz))
        for cases, other_m, other_hz in pairs:
            if other_m and isfinite(other_m) and isfinite(row.p90_m) and other_hz:
                cases.append(
                    HeldErrors(
                        row.threshold_m,
                        row.packet_error_ratio,
                        own_m=row.p90_m,
                        other_m=other_m,
                        paid=row.message_rate_hz / other_hz,
                        may_be_chance=None,
                    )
                )
    return same, matched


def _chance(result: ComparisonResult, protocol: str, *, with_loss: bool) -> str:
    """Say where other trips might turn the verdict on errors."""
    rival = _measure(result)
    ends = ("p90_low", "p90_high") if rival is None else ("p90_over_free_low", "p90_over_free_high")
    rows = [row for name in _judged(result) if name != rival for row in _pooled(result, name, protocol)]
    limits = [
        tuple(row.picked(ends).values()) for row in rows if row.packet_error_ratio > 0.0 or not with_loss
    ]
    known = [(low, high) for low, high in limits if low is not None and high is not None]
    if not known:
        return " One trip, or one route, has no interval that tells this from chance."
    alike = share_text(sum(low <= 1.0 <= high for low, high in known), len(known))
    over = f"the error over {_BETTER if rival is None else _named(rival)}'s {_at_rate(result)}"
    return f" The interval over the trips of {over} holds 1 in {alike}."


def _chance_of_messages(result: ComparisonResult, protocol: str) -> str:
    """Say the same of messages at the same threshold."""
    rival = _measure(result)
    rows = [
        row
        for name in _judged(result)
        if name != rival
        for row in _message_rows(result, name, protocol, rival)
    ]
    known = [row for row in rows if row.message_low is not None and row.message_high is not None]
    if not known:
        return ""
    alike = share_text(sum(row.message_low <= 1.0 <= row.message_high for row in known), len(known))
    over = f"messages over {_named(rival)}'s at the same threshold"
    return f" The interval over the trips of {over} holds 1 in {alike}."


def _data(result: ComparisonResult, run: Sequence[str]) -> str:
    sensor = result.settings.get("sensor")
    return data_text(
        [trip.source for trip in result.trips],
        sum(trip.duration_s for trip in result.trips),
        [protocol_text(name, sensor) for name in run],
    )


def _words(result: ComparisonResult) -> str:
    meant = ["candidate: a bank of sub-models with its rules", f"baseline: {BASELINE_WORDS}"]
    if result.free is not None:
        meant.append(f"free receiver: {free_words(result.settings)}")
    meant.append("error: how far the receiver believes the vehicle to be from where it is")
    return f"{'; '.join(meant)}."
