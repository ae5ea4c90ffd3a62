"""What runs of fleets found, what they did not, and on which traffic, in words made from the pooled rows.

A sender of models is held against those that differ from it in the model alone: of plain messages by the
same rules, which receivers coast with their acceleration and turn (the free one) or at constant velocity.
Where the latter sends unfiltered motion, that is told; where it has other timers, it is left out.
Messages and errors stand together, for neither is equal in these runs.
"""

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

from modelcast.report.ratio_words import ERROR, MESSAGES, counted, numbers, range_text, share_text, verdict
from modelcast.study.network.rows import NO_BANK, NetworkResult
from modelcast.study.table import Row

__all__ = ["network_findings"]

_MODELS = "mbc"
_SENT, _ERRED = "message_rate_hz", "pte_p90_m"
_MOST_SENDERS = 4

_UNFILTERED = ("j2945", "j3161")
"""Senders of what was measured, whose counterparts with models send the filtered motion."""

_Place = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Beside:
    """One sender of models beside a rival, over all densities and radios that both ran at.

    ``messages`` and ``errors`` are its own over the rival's, as far as both are known; ``alike`` tells of
    each place with intervals of both errors over the seeds whether these overlap.
    """

    sender: str
    rival: str
    is_free: bool
    messages: list[float]
    errors: list[float]
    alike: list[bool]


def network_findings(
    result: NetworkResult, options: Mapping[str, Any] | None = None
) -> list[tuple[str, str]]:
    """Return what was found, what not, and on which traffic; nothing where no sender of models was run.

    Parameters
    ----------
    result
        All runs.
    options
        What they were run with, as plain values; where None, nothing is said of the traffic.

    Returns
    -------
    list of tuple
        A title and its text each.
    """
    pairs = _pairs(result)
    senders = list(dict.fromkeys(_label(result, row) for row in result.pooled if _sends_models(row.policy)))
    if not senders:
        return []
    data = [] if options is None else [("Data", _data(result, options))]
    places = _places(result)
    return [
        ("Found", _found(pairs, senders, places)),
        ("Not found", _not_found(pairs, senders, places)),
        *data,
    ]


def _sends_models(policy: str) -> bool:
    return "+" not in policy and _MODELS in policy.partition(":")[0].split("-")


def _rivals(policy: str, run: Container[str]) -> list[tuple[str, str, bool]]:
    """Who differs from a sender of models in the model alone, what it is called, and whether it is free.

    The free one is first. The plain one of a sender of filtered motion is filtered too where that was run,
    else told as unfiltered; one of other timers has none.
    """
    head, colon, words = policy.partition(":")
    parts = head.split("-")
    at = parts.index(_MODELS)
    free = f"{'-'.join('free' if part == _MODELS else part for part in parts)}{colon}{words}"
    if at + 1 < len(parts):
        return [(free, free, True)]
    name = "-".join(parts[:at]) or "baseline"
    plain, filtered = f"{name}{colon}{words}", f"{name}-filtered{colon}{words}"
    if name not in _UNFILTERED:
        return [(free, free, True), (plain, plain, False)]
    rival = (filtered, filtered) if filtered in run else (plain, f"unfiltered {plain}")
    return [(free, free, True), (*rival, False)]


def _label(result: NetworkResult, row: Row) -> str:
    is_told = len(result.banks) > 1 and row.bank != NO_BANK
    return f"{row.policy} ({row.bank})" if is_told else row.policy


def _pairs(result: NetworkResult) -> list[_Beside]:
    """Every sender of models beside each of its rivals that was run."""
    by_sender: dict[tuple[str, str], dict[_Place, dict[str, Row]]] = {}
    for row in result.pooled:
        places = by_sender.setdefault((row.policy, _label(result, row)), {})
        place = repr(row.density_per_km), row.radio, repr(row.threshold_m)
        places.setdefault(place, {})[row.figure] = row
    found: list[_Beside] = []
    for (policy, label), own in by_sender.items():
        if not _sends_models(policy):
            continue
        run = {name for name, _ in by_sender}
        for rival, called, is_free in _rivals(policy, run):
            other = by_sender.get((rival, rival))
            if other is None:
                continue
            both = [(own[place], other[place]) for place in own if place in other]
            if both:
                found.append(_beside(label, called, both, is_free=is_free))
    return found


def _beside(
    sender: str, rival: str, both: Sequence[tuple[Mapping[str, Row], Mapping[str, Row]]], *, is_free: bool
) -> _Beside:
    errors = [(own[_ERRED], other[_ERRED]) for own, other in both]
    return _Beside(
        sender,
        rival,
        is_free=is_free,
        messages=numbers(_over(own[_SENT].value, other[_SENT].value) for own, other in both),
        errors=numbers(_over(one.value, two.value) for one, two in errors),
        alike=[
            one.low <= two.high and two.low <= one.high
            for one, two in errors
            if len(numbers((one.low, one.high, two.low, two.high))) == 4
        ],
    )


def _over(own: float, other: float) -> float | None:
    return own / other if other > 0.0 else None


def _found(pairs: Sequence[_Beside], senders: Sequence[str], places: str) -> str:
    shown = senders[:_MOST_SENDERS]
    held = [one for sender in shown for one in pairs if one.sender == sender]
    said = [text for one in held if (text := _held(one))]
    more = len(senders) - _MOST_SENDERS
    rest = f" The table has {more} more senders of models." if more > 0 else ""
    if not said:
        why = "nothing was measured beside a rival" if held else "no rival was run beside them"
        return f"{', '.join(shown)}: {why}.{rest}"
    by = ", by the 90th percentile" if any(one.errors for one in held) else ""
    return f"Over all {places}{by}: {'; '.join(said)}.{rest}"


def _held(one: _Beside) -> str:
    """Say how many messages a sender sent beside its rival and how it erred, each where it is known."""
    sent = ""
    if one.messages:
        many = f"({range_text(one.messages)} times as many)"
        sent = f"{one.sender} sent {verdict(one.messages, MESSAGES)} {one.rival} {many}"
    if not one.errors:
        return sent
    erred = f"with an error {verdict(one.errors, ERROR)}"
    over = f"({range_text(one.errors)} times as large)"
    return f"{sent} {erred} its {over}" if sent else f"{one.sender} sent {erred} {one.rival}'s {over}"


def _not_found(pairs: Sequence[_Beside], senders: Sequence[str], places: str) -> str:
    lines: list[str] = []
    for sender in senders[:_MOST_SENDERS]:
        free = next((one for one in pairs if one.sender == sender and one.is_free), None)
        if free is None:
            lines.append(f"{sender} was not held against a free receiver by the same rules")
            continue
        if not free.errors:
            lines.append(f"no error of {sender} was measured beside {free.rival}'s")
            continue
        worse = share_text(sum(ratio > 1.0 for ratio in free.errors), len(free.errors))
        text = f"the error of {sender} was larger than {free.rival}'s in {worse}"
        if free.alike:
            overlapping = share_text(sum(free.alike), len(free.alike))
            text += f", and intervals over the seeds overlap in {overlapping}"
        lines.append(text)
    return f"Of the cases ({places}), {'; '.join(lines)}." + (
        " One seed has no interval that tells this from chance."
        if any(one.is_free and one.errors and not one.alike for one in pairs)
        else ""
    )


def _places(result: NetworkResult) -> str:
    """What the cases differ in: thresholds too, where there are several."""
    several = len({row.threshold_m for row in result.pooled if isfinite(row.threshold_m)}) > 1
    return "densities, radios and thresholds" if several else "densities and radios"


_SUMO = "sumo"
_RECORDED = ("platoon", "trips")
_ENDING = ("platoon",)
"""A run of these, as one from a file, ends with its recording, if that is before the time asked for."""


def _data(result: NetworkResult, options: Mapping[str, Any]) -> str:
    """Which traffic, for how long, and how often; of classes of traffic not where they have it from."""
    seeds = max((row.seeds for row in result.pooled), default=0)
    many, scenario = counted(seeds, "seed"), options.get("scenario")
    most = "at most " if scenario is not None and (scenario in _ENDING or "." in scenario) else ""
    lasts = f", {most}{options['duration_s']:g} s each" if "duration_s" in options else ""
    if scenario is None:
        classes = ", ".join(dict.fromkeys(options.get("scenarios", ())))
        return f"traffic {classes}; {many}{lasts}." if classes else f"{many}{lasts}."
    if scenario in _RECORDED:
        origin = f"recorded trips ({', '.join(options.get('trips', ()))})"
    elif scenario.startswith(_SUMO) or "." in scenario:
        origin = "simulated or read from a file, not generated here"
    else:
        origin = "generated by a program, not recorded"
    return f"traffic {scenario}, {origin}; {many}{lasts}."
