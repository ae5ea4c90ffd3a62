"""What an evaluation found, what it did not, and on which data, in words made from its rows.

They stand before any table. Rates at one threshold beside errors at one rate would say together what neither
says: so each sentence names its reading, and the free receiver is held against the model-based sender
wherever the baseline is.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from math import degrees, isfinite
from typing import Any, cast

from modelcast.report.headline import (
    EQUAL_RATE_POLICIES,
    Headline,
    evaluated_ratios,
    headlines,
    nearest_ratio,
    sender_label,
)
from modelcast.study.result import EvaluationResult, TripRow
from modelcast.study.rules import FREE_MATCHED, FREE_RECEIVER, MODEL_SENDER
from modelcast.study.table import Row
from modelcast.study.wording import centimetres

__all__ = ["findings"]

_MODELS = (
    "a vehicle sends a small model of its motion, and the next one when that errs by more than the threshold"
)
_MESSAGES = ("fewer messages than", "as many messages as", "more messages than")
_ERROR = ("smaller than", "as large as", "larger than")
_ALIKE = 0.03
"""Ratios that are no farther from 1 are about 1."""

_FREE = "the free receiver"
_GENERATED = "generated"


@dataclass(frozen=True, slots=True)
class _Cell:
    """The errors of two at one threshold and loss ratio.

    Parameters
    ----------
    threshold_m, ratio
        Which cell.
    own, other
        Tracking rows of the model-based sender and of whom it is held against.
    """

    threshold_m: float
    ratio: float
    _: KW_ONLY
    own: Row
    other: Row

    @property
    def over(self) -> float:
        """90th percentile over the other's."""
        return self.own.pte_p90_m / self.other.pte_p90_m

    @property
    def is_worse(self) -> bool:
        """Whether the model-based sender's is larger."""
        return self.own.pte_p90_m > self.other.pte_p90_m

    @property
    def has_intervals(self) -> bool:
        """Whether both have limits over the seeds."""
        return self.own.pte_p90_low_m is not None and self.other.pte_p90_low_m is not None

    @property
    def may_be_chance(self) -> bool:
        """Whether the intervals over the seeds overlap."""
        return self.has_intervals and bool(
            self.own.pte_p90_low_m <= self.other.pte_p90_high_m
            and self.other.pte_p90_low_m <= self.own.pte_p90_high_m
        )


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
    held = (("the baseline", [line.ratio for line in lines]), (_FREE, [line.free_ratio for line in lines]))
    counted = [(name, _numbers(ratios)) for name, ratios in held]
    sent = [
        f"{_verdict(ratios, _MESSAGES)} {name} ({_range(ratios)} times as many)"
        for name, ratios in counted
        if ratios
    ]
    text = f"At the same threshold {named} sent {' and '.join(sent)}." if sent else f"{named} was run alone."
    ratio = nearest_ratio(evaluated_ratios(result))
    if ratio is None:
        return text
    held_at_rate = (
        ("the better baseline", _cells(lines, (ratio,), EQUAL_RATE_POLICIES)),
        (_FREE, _cells(lines, (ratio,), (FREE_MATCHED,))),
    )
    errors = [
        f"{_verdict(over, _ERROR)} {name}'s ({_range(over)} times as large)"
        for name, cells in held_at_rate
        if (over := [cell.over for cell in cells])
    ]
    if not errors:
        return text
    lost = f"with {100 * ratio:.4g} % of the messages lost" if ratio else "without loss"
    return f"{text} At the same rate, {lost}, its error (90th percentile) was {' and '.join(errors)}."


def _words(result: EvaluationResult, lines: Sequence[Headline]) -> str:
    """What a newcomer has to know to read the rest."""
    meant = [f"{sender_label(result)}: {_MODELS}"]
    if any(line.baseline is not None for line in lines):
        meant.append("baseline: plain messages, coasted at constant velocity")
    if any(line.free is not None for line in lines):
        meant.append(
            f"{_FREE.removeprefix('the ')}: plain messages, coasted with their acceleration and turn as well"
        )
    meant.append("error: how far the receiver believes the vehicle to be from where it is")
    return f"{'; '.join(meant)}."


def _not_found(result: EvaluationResult, lines: Sequence[Headline]) -> str:
    ratios = evaluated_ratios(result)
    lossy = [ratio for ratio in ratios if ratio > 0.0]
    saved = _saved_by_free(lines)
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
        if (text := _worse(name, _cells(lines, shown, (same,)), _cells(lines, shown, matched)))
    ]
    if not parts:
        return f"Nobody's errors were measured beside {sender_label(result)}'s.{saved}"
    rival, matched = "free receiver", _cells(lines, shown, (FREE_MATCHED,))
    if not matched:
        rival, matched = "better baseline", _cells(lines, shown, EQUAL_RATE_POLICIES)
    kind = "cases (thresholds and loss ratios)" if lossy else "cases (thresholds)"
    unlost = "" if lossy else " No message was lost, so nothing is said of losses."
    worse = ", ".join(parts)
    larger = f"Of the {kind}, {sender_label(result)}'s error was larger than {worse}."
    return f"{larger}{_chance(matched, rival)}{saved}{unlost}"


def _worse(name: str, same: Sequence[_Cell], matched: Sequence[_Cell]) -> str:
    """Say in how many cells the model-based sender errs more than another, by reading, and where most."""
    readings = (("at the same threshold", same), ("at the same rate", matched))
    parts = [f"in {_many(cells)} {at}{_most(cells, at)}" for at, cells in readings if cells]
    return f"{name} {' and '.join(parts)}" if parts else ""


def _many(cells: Sequence[_Cell]) -> str:
    return _share(sum(cell.is_worse for cell in cells), len(cells))


def _share(some: int, of: int) -> str:
    """So many of all in words.

    Examples
    --------
    >>> _share(0, 4), _share(3, 4), _share(4, 4), _share(1, 1)
    ('none of 4', '3 of 4', 'all 4', 'the only one')
    """
    if some == of:
        return "the only one" if of == 1 else f"all {of}"
    return f"{some or 'none'} of {of}"


def _most(cells: Sequence[_Cell], at: str) -> str:
    """Where the model-based sender errs most, and at the same threshold what that saved."""
    worse = [cell for cell in cells if cell.is_worse]
    if not worse:
        return ""
    most = max(worse, key=lambda cell: cell.over)
    place = centimetres(most.threshold_m) + (f", {100 * most.ratio:.4g} % lost" if most.ratio else "")
    paid = most.own.message_rate_hz / most.other.message_rate_hz
    price = f", for {paid:.2f} times the messages" if at == "at the same threshold" else ""
    return f" (most at {place}: {most.own.pte_p90_m:.2f} against {most.other.pte_p90_m:.2f} m{price})"


def _chance(cells: Sequence[_Cell], rival: str) -> str:
    """Say where the seeds cannot tell the harder comparison from chance."""
    known = [cell for cell in cells if cell.has_intervals]
    if not known:
        return " One seed has no interval that tells this from chance." if cells else ""
    alike = _share(sum(cell.may_be_chance for cell in known), len(known))
    return f" At the same rate its interval over the seeds and the {rival}'s overlap in {alike}."


def _saved_by_free(lines: Sequence[Headline]) -> str:
    """Say how much of the saving needs no model."""
    shares = [
        (line.baseline.total_rate_hz - line.free.total_rate_hz)
        / (line.baseline.total_rate_hz - line.mbc.total_rate_hz)
        for line in lines
        if line.mbc is not None
        and line.baseline is not None
        and line.free is not None
        and line.baseline.total_rate_hz > line.mbc.total_rate_hz
    ]
    if not shares:
        return ""
    if max(shares) <= 0.0:
        return " The free receiver saves no message over the baseline."
    shares = [max(share, 0.0) for share in shares]
    return (
        f" The free receiver alone saves {_range(shares)} of the messages that are saved over the baseline."
    )


def _data(result: EvaluationResult) -> str:
    trips = result.trips
    hours = sum(trip.duration_s for trip in trips) / 3600.0
    long = f"{hours:.1f} h" if hours >= 1.0 else f"{60.0 * hours:.1f} min"
    alone = " One trip says nothing of others." if len(trips) == 1 else ""
    protocols = "; ".join(_protocol(result, name) for name in sorted({trip.protocol for trip in trips}))
    return f"{_count(len(trips), 'trip')}, {long}, {_origin(trips)}; {protocols}.{alone}"


def _origin(trips: Sequence[TripRow]) -> str:
    made = [trip for trip in trips if trip.source == _GENERATED]
    formats = ", ".join(sorted({trip.source for trip in trips if trip.source != _GENERATED}))
    if not made:
        return f"recorded ({formats})"
    generated = "generated by a program, not recorded"
    return generated if not formats else f"{len(made)} of them {generated}, the others recorded ({formats})"


def _protocol(result: EvaluationResult, name: str) -> str:
    own = [trip for trip in result.trips if trip.protocol == name]
    of = "" if len(own) == len(result.trips) else f" ({len(own)} of them)"
    if name != "sensor":
        return f"protocol {name}{of}, in which the log is both what the sender saw and the truth"
    smoothed = sum(trip.conditioned for trip in own)
    truth = "" if not smoothed else " (smoothed)" if smoothed == len(own) else f" ({smoothed} smoothed)"
    sensor = result.settings.get("sensor")
    known = _sensor(cast("Mapping[str, Any]", sensor)) if isinstance(sensor, Mapping) else "simulated sensors"
    return f"protocol sensor{of}, in which the sender saw the truth{truth} through {known}"


def _sensor(sensor: Mapping[str, Any]) -> str:
    """The errors of a sensor in words."""
    sizes = (
        ("position_noise_m", "{:.3g} m in position", 1.0),
        ("slow_position_noise_m", "{:.3g} m that drift", 1.0),
        ("multipath_noise_m", "{:.3g} m of multipath", 1.0),
        ("speed_noise_mps", "{:.3g} m/s in speed", 1.0),
        ("heading_noise_rad", "{:.3g}° in heading", degrees(1.0)),
        ("acceleration_noise_mps2", "{:.3g} m/s² in acceleration", 1.0),
        ("yaw_rate_noise_radps", "{:.3g} °/s in yaw rate", degrees(1.0)),
        ("latency_s", "{:.3g} s of latency", 1.0),
    )
    errors = [form.format(unit * sensor[name]) for name, form, unit in sizes if sensor.get(name)]
    if not errors:
        return "sensors without errors"
    listed = errors[0] if len(errors) == 1 else f"{', '.join(errors[:-1])} and {errors[-1]}"
    return f"sensors with standard errors of {listed}"


def _cells(lines: Iterable[Headline], ratios: Iterable[float], others: Sequence[str]) -> list[_Cell]:
    """The cells in which both are known; of several others the one that errs least."""
    found: list[_Cell] = []
    asked = list(ratios)
    for line in lines:
        for ratio in asked:
            own = line.tracking.get((ratio, MODEL_SENDER))
            rows = [line.tracking[ratio, other] for other in others if (ratio, other) in line.tracking]
            rows = [row for row in rows if isfinite(row.pte_p90_m) and row.pte_p90_m > 0.0]
            if own is not None and isfinite(own.pte_p90_m) and rows:
                best = min(rows, key=lambda row: row.pte_p90_m)
                found.append(_Cell(line.threshold_m, ratio, own=own, other=best))
    return found


def _numbers(values: Iterable[float | None]) -> list[float]:
    return [value for value in values if value is not None and isfinite(value)]


def _range(values: Sequence[float]) -> str:
    """Smallest to largest, in two places."""
    low, high = f"{min(values):.2f}", f"{max(values):.2f}"
    return low if low == high else f"{low} to {high}"


def _verdict(ratios: Sequence[float], words: tuple[str, str, str]) -> str:
    """The word for ratios below, at and above 1, as they read in two places; two words where they differ."""
    shown = [round(ratio, 2) for ratio in ratios]
    less, same, more = words
    first, last = less.split(" ")[0], more.split(" ")[0]
    rest = less.removeprefix(first)
    low, high = min(shown), max(shown)
    if round(max(high - 1.0, 1.0 - low), 2) <= _ALIKE:
        return same if low == high == 1.0 else f"about {same}"
    if high <= 1.0:
        return less if high < 1.0 else f"no {last}{rest}"
    if low >= 1.0:
        return more if low > 1.0 else f"no {first}{rest}"
    return f"{first} or {last}{rest}"


def _count(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
