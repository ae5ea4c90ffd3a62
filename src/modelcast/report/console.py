"""What a user sees in the terminal after a run: what was found, tables of pooled figures, and what failed.

Nothing is printed here; the command line hands what `console_report` returns to a rich console.
"""

from collections.abc import Iterable, Mapping

from rich.console import Group, RenderableType

from modelcast.core.cells import Cells
from modelcast.report.console_table import ConsoleTable, console_table
from modelcast.report.findings import findings
from modelcast.report.headline import (
    SAME_RATE,
    SAME_THRESHOLD,
    Headline,
    headlines,
    loss_title,
    rate_basis,
    sender_label,
    shown_ratios,
)
from modelcast.report.literal import Prose, literal
from modelcast.report.training_trips import training_note
from modelcast.report.warnings import warning_lines
from modelcast.study.result import EvaluationResult

__all__ = [
    "conditioning_lines",
    "console_report",
    "failures_table",
    "left_out_text",
    "rates_table",
    "scope_line",
    "skipped_lines",
    "tracking_tables",
    "training_lines",
    "warning_texts",
]

_MISSING = "-"
_SHOWN_TRIPS = 5
_SMOOTHER = (
    "jerk_density_m2ps5",
    "position_noise_m",
    "velocity_noise_mps",
    "position_nis",
    "velocity_nis",
    "correction_rms_m",
)


def console_report(result: EvaluationResult) -> RenderableType:
    """Return the tables of a run, at most 100 columns wide.

    Parameters
    ----------
    result
        The evaluation.
    """
    parts: list[RenderableType] = warning_texts((trip.id, trip.warnings) for trip in result.trips)
    parts += [Prose(line) for line in (scope_line(result), *training_lines(result))]
    for title, text in findings(result):
        parts += [literal(""), Prose(f"{title}: {text}")]
    parts.append(literal(""))
    parts.append(rates_table(result))
    if result.tracking:
        parts += tracking_tables(result)
    parts += [literal(line) for line in conditioning_lines(result)]
    parts += [literal(line) for line in skipped_lines(result.skipped)]
    if result.failures:
        parts.append(failures_table(result.failures))
    return Group(*parts)


def warning_texts(trips: Iterable[tuple[str, Mapping[str, str]]]) -> list[RenderableType]:
    """Return what must be known before the figures, for the terminal.

    Parameters
    ----------
    trips
        Identifier and warnings of every trip.
    """
    return [literal(f"warning: {line}", "bold") for line in warning_lines(trips)]


def training_lines(result: EvaluationResult) -> list[str]:
    """Return a line that names the trips which the profile was trained on, where there are any.

    Parameters
    ----------
    result
        The evaluation.
    """
    return training_note([trip.id for trip in result.trips if trip.in_training], len(result.trips))


def conditioning_lines(result: EvaluationResult) -> list[str]:
    """Return one line a trip whose truth was smoothed, with what the smoother found; the first few.

    Parameters
    ----------
    result
        The evaluation.
    """
    smoothed = [trip for trip in result.trips if trip.conditioning]
    lines = [
        f"truth of {trip.id} smoothed: "
        + ", ".join(
            f"{name} {trip.conditioning[name]:.3g}" for name in _SMOOTHER if name in trip.conditioning
        )
        for trip in smoothed[:_SHOWN_TRIPS]
        if trip.conditioning
    ]
    if len(smoothed) > _SHOWN_TRIPS:
        lines.append(f"... and of {len(smoothed) - _SHOWN_TRIPS} more trips (report.html)")
    return lines


def left_out_text(failures: Mapping[str, str], skipped: Mapping[str, str]) -> str:
    """Return how many trips failed, and how many files and vehicles held none, as the end of a line.

    Parameters
    ----------
    failures, skipped
        Names with reasons.

    Examples
    --------
    >>> left_out_text({"a": "too short"}, {"b.md": "no format", "c.md": "no format"})
    ', 1 failed, 2 skipped'
    """
    counts = ((len(failures), "failed"), (len(skipped), "skipped"))
    return "".join(f", {count} {word}" for count, word in counts if count)


def skipped_lines(skipped: Mapping[str, str], *, rest: str = "summary.json") -> list[str]:
    """Return one line for each file and vehicle that held no trip; the first few.

    Parameters
    ----------
    skipped
        Their names, with the reason.
    rest
        Where all are to be found.
    """
    found = sorted(skipped.items())
    lines = [f"no trip from {name}: {reason}" for name, reason in found[:_SHOWN_TRIPS]]
    if len(found) > _SHOWN_TRIPS:
        lines.append(f"... nor from {len(found) - _SHOWN_TRIPS} more ({rest})")
    return lines


def scope_line(result: EvaluationResult) -> str:
    """Return in one line how many trips of which kind were evaluated."""
    hours = sum(trip.duration_s for trip in result.trips) / 3600.0
    protocols = ", ".join(sorted({trip.protocol for trip in result.trips})) or "none"
    left_out = left_out_text(result.failures, result.skipped)
    return f"{_counted(len(result.trips), 'trip')}, {hours:.2f} h, protocol: {protocols}{left_out}"


def rates_table(result: EvaluationResult) -> ConsoleTable:
    """Return the pooled message rates at each threshold, the model-based sender's beside its rivals'."""
    sender = sender_label(result)
    lines = headlines(result)
    named = any(line.mbc is not None and line.mbc.identifications for line in lines)
    heads = ["threshold", sender, *([f"{sender}\nidentif."] if named else []), "free\nreceiver", "baseline"]
    heads += [f"{sender} /\nfree", f"{sender} /\nbaseline", f"airtime, {sender} /\nbaseline"]
    rows = [
        [
            _threshold(line),
            _number(line.mbc and line.mbc.total_rate_hz),
            *([_number(line.mbc and line.mbc.identification_rate_hz)] if named else []),
            _number(line.free and line.free.total_rate_hz),
            _number(line.baseline and line.baseline.total_rate_hz),
            *(_number(ratio) for ratio in (line.free_ratio, line.ratio, line.airtime_ratio)),
        ]
        for line in lines
    ]
    return console_table(Cells(heads, rows, 0), "Same threshold: messages per second without loss, all trips")


def tracking_tables(result: EvaluationResult) -> list[ConsoleTable]:
    """Return the pooled 90th percentile of the tracking error in both readings, and the first one's messages.

    Without loss, and near a packet error ratio of 0.4.
    """
    sender = sender_label(result)
    places = [(line, ratio) for ratio in shown_ratios(result) for line in headlines(result)]
    starts = [[_threshold(line), f"{100 * ratio:g} %"] for line, ratio in places]
    names = (sender, "free", "baseline")
    heads = [f"{name}\n{what}" for what in ("1/s", "p90") for name in names]
    rows = [
        [
            *start,
            *(_number(line.rate_hz(ratio, role)) for role in SAME_THRESHOLD),
            *(_number(line.p90_m(ratio, role), 3) for role in SAME_THRESHOLD),
        ]
        for start, (line, ratio) in zip(starts, places, strict=True)
    ]
    title = f"Same threshold, {loss_title(result)}: messages per second, p90 of the error in metres"
    same = console_table(Cells(["threshold", "PER", *heads], rows, 0), title)
    names = (f"{sender}\np90", "free\nmatched", "baseline\nmatched", "baseline\nperiodic")
    rows = [
        [*start, *(_number(line.p90_m(ratio, role), 3) for role in SAME_RATE)]
        for start, (line, ratio) in zip(starts, places, strict=True)
    ]
    title = f"Same {rate_basis(result)} rate as {sender}, {loss_title(result)}: p90 of the error in metres"
    return [same, console_table(Cells(["threshold", "PER", *names], rows, 0), title)]


def failures_table(failures: Mapping[str, str]) -> ConsoleTable:
    """Return the trips that could not be evaluated, each with its reason."""
    title = f"Not evaluated: {_counted(len(failures), 'trip')}"
    return console_table(Cells(("trip", "reason"), sorted(failures.items())), title, longest=36)


def _threshold(line: Headline) -> str:
    return f"{100 * line.threshold_m:g} cm"


def _number(value: float | None, digits: int = 2) -> str:
    return _MISSING if value is None or value != value else f"{value:.{digits}f}"  # noqa: PLR0124  NaN


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
