"""An evaluation of a safety application in the terminal, as Markdown and as a page."""

from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Any

from rich.console import Group, RenderableType

from modelcast.core.cells import Cells, escape, markdown
from modelcast.report.beside import show_beside
from modelcast.report.console import failures_table, skipped_lines
from modelcast.report.console_table import placed_table
from modelcast.report.figures.files import drawn, write_report_files
from modelcast.report.figures.film import plot_film
from modelcast.report.figures.safety import SAFETY_FIGURES
from modelcast.report.literal import Prose, literal
from modelcast.report.losses import loss_words, shown_ratios
from modelcast.report.page import CSS, figure, page
from modelcast.report.settings_section import settings_section
from modelcast.report.style import style
from modelcast.report.training_trips import training_note
from modelcast.report.warning_texts import ENOUGH, late_text, over_text, percent_text, plain_text
from modelcast.study.rules import FREE_RECEIVER, MODEL_SENDER
from modelcast.study.safety.result import SafetyResult, kind_of
from modelcast.study.safety.settings import SafetySettings
from modelcast.study.settings import EvaluationSettings
from modelcast.study.table import Row

__all__ = ["safety_console", "safety_headline", "safety_markdown", "write_safety_report"]

_SCOPE = (
    "The host of each pair follows the sender. What it warns of from messages is held against the same "
    "application with perfect knowledge, where the true margin is near zero. Missed and false are shares of "
    "instants; late and never of whole warnings. In brackets: 95 % intervals over warnings (pairs, of false "
    "ones) and runs."
)
_HEADS = (
    "sensor", "losses", "loss", "at equal", "sender", "threshold", "messages/s", "airtime", "missed",
    "over {against}", "false", "over {against}", "false/h", "never", "late p50", "p90", "p99",
)  # fmt: skip
_TEXT_COLUMNS = 5
_FILM = (
    "The true warning at which the two senders of the headline differ most, in one run: the road from above, "
    "the host at the left and red where a warning is right; the margin as perfect knowledge and each host "
    "has it; and the messages."
)


def safety_headline(result: SafetyResult) -> list[str]:
    """Return what was found in a few sentences, how many true warnings there were first.

    Parameters
    ----------
    result
        The evaluation.
    """
    against, budget = result.settings["against"], result.settings["budget"]
    sender = result.settings.get("decided_by", MODEL_SENDER)
    lines = [
        (
            f"{result.events} true warnings in {result.pairs} pairs: {result.positives} of "
            f"{result.counted} instants near the decision"
        ),
        *(
            []
            if sender == MODEL_SENDER
            else [f"{sender} decides when the senders send, but for the baseline cv"]
        ),
    ]
    if result.events == 0:
        return [*lines, "no true warning: there is nothing to miss, and shares of false ones alone are shown"]
    if result.events < ENOUGH:
        lines.append(f"fewer than {ENOUGH} true warnings: the ratios below are anecdotes")
    shown = shown_ratios(result.pooled)
    basis = "airtime" if any(row.basis == "airtime" for row in result.pooled) else result.pooled[0].basis
    for reading in dict.fromkeys((basis, "threshold")):
        own = [row for row in result.pooled if row.basis == reading]
        for row in own:
            at = shown[kind_of(row)]
            if row.packet_error_ratio != at or row.candidate == against:
                continue
            if reading != basis and row.candidate != budget:  # the table has the others
                continue
            equal = (
                f"at the same threshold ({_rates_text(row, own, against)})"
                if reading == "threshold"
                else f"equal {reading} (what {budget} needs)"
            )
            lines.append(
                f"{row.sensor}, {loss_words(kind_of(row))}, {100 * at:.4g} % lost, {equal}: "
                f"{_beside(row, against)}{_beside_free(row, own)}"
            )
    return lines


def _alike(row: Row, own: Sequence[Row]) -> dict[str, Row]:
    """The rows of the same sensor and losses by candidate."""
    place = kind_of(row), row.packet_error_ratio
    return {one.candidate: one for one in own if (kind_of(one), one.packet_error_ratio) == place}


def _rates_text(row: Row, own: Sequence[Row], against: str) -> str:
    """How often each of those told of sends, where none is held to another's rate."""
    alike = _alike(row, own)
    told = (name for name in dict.fromkeys((row.candidate, against, FREE_RECEIVER)) if name in alike)
    rates = ", ".join(f"{name} {alike[name].message_rate_hz:.2f}" for name in told)
    return f"messages a second: {rates}"


def _beside(row: Row, against: str) -> str:
    """What a sender misses and falsely warns of over another's, as far as there is a ratio."""
    missed, false = (over_text(row, name) for name in ("missed", "false"))
    parts = [] if missed == "-" else [f"misses {missed} of what {against} misses"]
    if false != "-":
        parts.append(f"with {false} of its false ones" if parts else f"has {false} of {against}'s false ones")
    return f"{row.candidate} {', '.join(parts) or f'has no ratio over {against}'}"


def _beside_free(row: Row, own: Sequence[Row]) -> str:
    """The same over the free receiver's, of whoever is not it; nothing where it was not run."""
    free = _alike(row, own).get(FREE_RECEIVER)
    if free is None or row.candidate == FREE_RECEIVER:
        return ""
    parts = [
        f"{own_ratio / other:.2f} {name}"
        for name in ("missed", "false")
        for own_ratio, other in [(getattr(row, f"{name}_ratio"), getattr(free, f"{name}_ratio"))]
        if other > 0.0 and isfinite(own_ratio)
    ]
    if not parts:
        return ""
    return f"; over {FREE_RECEIVER}'s {' and '.join(parts)}, for which there is no interval"


def safety_console(result: SafetyResult) -> RenderableType:
    """Return the headline and a table for the terminal: a line a sender, under its sensor and losses.

    The basis is airtime where that was asked for; the page and ``table.md`` have them all.

    Parameters
    ----------
    result
        The evaluation.
    """
    bases = [row.basis for row in result.pooled]
    basis = "airtime" if "airtime" in bases else bases[0]
    against = result.settings["against"]
    heads = ("sender", "1/s", "missed", f"over {against}", "false", f"over {against}", "never", "late p50")
    rows: dict[str, list[tuple[str, ...]]] = {}
    for row in result.pooled:
        if row.basis == basis:
            place = f"{row.sensor}, {loss_words(kind_of(row))}, {100 * row.packet_error_ratio:.4g} % lost"
            rows.setdefault(place, []).append(_console_cells(row))
    places = [place for place, own in rows.items() for _ in own]
    cells = Cells(heads, [one for own in rows.values() for one in own], 1)
    shown: list[RenderableType] = [placed_table(cells, places, f"At equal {basis}")]
    shown += [literal(line) for line in skipped_lines(result.skipped)]
    if result.failures:
        shown.append(failures_table(result.failures))
    return Group(*map(Prose, safety_headline(result)), *shown)


def _console_cells(row: Row) -> tuple[str, ...]:
    return (
        row.candidate,
        f"{row.message_rate_hz:.2f}",
        percent_text(row.missed_ratio),
        over_text(row, "missed"),
        percent_text(row.false_ratio),
        over_text(row, "false"),
        percent_text(row.missed_events),
        late_text(row.delay_p50_s),
    )


def safety_markdown(result: SafetyResult) -> str:
    """Return the headline and the table as Markdown.

    Parameters
    ----------
    result
        The evaluation.
    """
    lines = [f"- {markdown(line)}" for line in safety_headline(result)]
    return "\n".join([*lines, "", _SCOPE, "", *_cells(result).markdown()]) + "\n"


def write_safety_report(
    result: SafetyResult,
    folder: str | Path,
    *,
    training_trips: Sequence[str],
    trips: int,
    beside: Sequence[Path] = (),
    defaults: Mapping[str, Any] | None = None,
) -> list[Path]:
    """Write ``table.md``, ``report.html`` and the figures; return their paths.

    Parameters
    ----------
    result
        The evaluation.
    folder
        An existing folder.
    training_trips, trips
        Trips that a bank was trained on, and how many there were.
    beside
        Output folders of other commands whose figures are shown too.
    defaults
        As for `settings_section`; those of `SafetySettings` where None.
    """
    with style():
        shown = {name: (caption, plot(result)) for name, (caption, plot) in SAFETY_FIGURES.items()}
        if result.film is not None:
            shown["film"] = (_FILM, plot_film(result.film))
        drawings = [drawn(name, plot) for name, (_, plot) in shown.items()]
    logs = [f"recorded losses: {log}" for log in result.settings.get("losses", ())]
    notes = [*safety_headline(result), *logs, *training_note(tuple(training_trips), trips)]
    body = ["<h1>Warnings from messages</h1>", *(f"<p>{escape(line)}.</p>" for line in notes)]
    body += [figure(f"{name}.svg", caption) for name, (caption, _) in shown.items()]
    body += show_beside(beside, Path(folder))
    body += [
        "<h2>All figures</h2>",
        f'<p class="scope">{escape(_SCOPE)}</p>',
        _cells(result).html(),
    ]
    if result.failures or result.skipped:
        left_out = [*result.failures.items(), *result.skipped.items()]
        body += ["<h2>Left out</h2>", Cells(["what", "why"], left_out).html()]
    usual = SafetySettings(EvaluationSettings(protocol="sensor")).as_plain() if defaults is None else defaults
    body += [
        "<h2>Options</h2>",
        settings_section(result.settings, usual),
    ]
    html = page("modelcast: warnings from messages", CSS, body)
    return write_report_files({"table.md": safety_markdown(result), "report.html": html}, drawings, folder)


def _cells(result: SafetyResult) -> Cells:
    rows = [
        [
            row.sensor,
            loss_words(kind_of(row)),
            f"{100 * row.packet_error_ratio:.4g} %",
            row.basis,
            row.candidate,
            f"{row.threshold_m:.3g} m",
            f"{row.message_rate_hz:.2f}",
            f"{100 * row.airtime_ratio:.3f} %",
            percent_text(row.missed_ratio),
            over_text(row, "missed"),
            percent_text(row.false_ratio),
            over_text(row, "false"),
            plain_text(row.false_per_hour, "{:.1f}"),
            percent_text(row.missed_events),
            *(late_text(value) for value in (row.delay_p50_s, row.delay_p90_s, row.delay_p99_s)),
        ]
        for row in result.pooled
    ]
    heads = [head.format(against=result.settings["against"]) for head in _HEADS]
    return Cells(heads, rows, _TEXT_COLUMNS)
