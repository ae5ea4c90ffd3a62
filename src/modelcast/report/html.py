"""The report: one HTML file with everything in it, that needs no network, and for its figures no script.

Figures are embedded as SVG images, so that names inside two of them cannot clash. The file holds no time
stamp and no path; the same result gives the same bytes.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from modelcast.core.cells import Cells, escape, number
from modelcast.core.version import package_version
from modelcast.io.output import written_into
from modelcast.report.captions import PROTOCOLS, TITLES, captions, loss_conditions
from modelcast.report.console import scope_line, training_lines
from modelcast.report.figures import Drawing, draw_figures
from modelcast.report.figures.files import write_report_files
from modelcast.report.findings import findings
from modelcast.report.headline import (
    REFERENCE_LABELS,
    SAME_RATE,
    SAME_THRESHOLD,
    Headline,
    headlines,
    loss_title,
    policy_label,
    pooled_reference,
    rate_basis,
    role_of,
    sender_label,
    shown_ratios,
)
from modelcast.report.model_words import velocity_words
from modelcast.report.page import CSS, embedded_figure, findings_paragraphs, page
from modelcast.report.player import player, player_css
from modelcast.report.scripts import PLAYBACK_SCRIPTS, script
from modelcast.report.settings_section import settings_section
from modelcast.report.warnings import warning_lines
from modelcast.study.result import POOLED, EvaluationResult, HoldsEvaluation, TripRow, result_of
from modelcast.study.settings import EvaluationSettings
from modelcast.study.table import Row

__all__ = ["report_document", "write_report"]

_MOST_TRACKING_ROWS = 600
"""Above this, the rows of single trips are left to ``summary.json``: a browser must open the page at once."""


def write_report(result: EvaluationResult | HoldsEvaluation, folder: str | Path) -> list[Path]:
    """Draw the figures once; write ``report.html`` and a folder ``figures``; return the paths.

    Parameters
    ----------
    result
        The evaluation.
    folder
        Made where it is missing.

    Raises
    ------
    ConfigError
        Where the folder cannot be made or written into.
    """
    found = result_of(result)
    drawings = draw_figures(found)
    texts = {"report.html": report_document(found, drawings)}
    return written_into(folder, lambda place: write_report_files(texts, drawings, place, figures="figures"))


def report_document(result: EvaluationResult, drawings: Iterable[Drawing]) -> str:
    """Return the report as one HTML document.

    Parameters
    ----------
    result
        The evaluation.
    drawings
        What `draw_figures` returned for it.
    """
    body = [
        "<h1>Model-based communication: evaluation</h1>",
        f'<p class="scope">{escape(scope_line(result))}. modelcast {escape(package_version())}.</p>',
        *findings_paragraphs(findings(result)),
        _warnings(result.trips),
        *(f'<p class="note">{escape(line)}.</p>' for line in training_lines(result)),
        _protocols(result),
        "<h2>Result</h2>",
        _headline_table(result),
        "<h2>Figures</h2>",
        *_figures(result, drawings),
        player(result),
        "<h2>Trips</h2>",
        _understood(result.trips),
        _trip_table(result.trips),
        "<h2>Tracking</h2>",
        _tracking_section(result),
        "<h2>Settings</h2>",
        settings_section(result.settings, EvaluationSettings().as_plain()),
        "<h2>Not evaluated</h2>",
        _failures(result.failures),
        _skipped(result.skipped),
    ]
    if result.playback is None:
        return page("modelcast evaluation", CSS, body)
    return page("modelcast evaluation", CSS + player_css(), body, [script(*PLAYBACK_SCRIPTS)])


def _warnings(trips: Sequence[TripRow]) -> str:
    """What must be known before the figures; nothing where there is nothing to say."""
    lines = warning_lines((trip.id, trip.warnings) for trip in trips)
    if not lines:
        return ""
    items = "".join(f"<li>{escape(line)}.</li>" for line in lines)
    return f'<h2>Warnings</h2><ul class="warnings">{items}</ul>'


def _protocols(result: EvaluationResult) -> str:
    counts: dict[str, int] = {}
    for trip in result.trips:
        counts[trip.protocol] = counts.get(trip.protocol, 0) + 1
    items = [
        f"<li><b>{escape(name)}</b>, {count} of {len(result.trips)} trips: "
        f"{escape(PROTOCOLS.get(name, 'see the documentation'))}.</li>"
        for name, count in sorted(counts.items())
    ]
    return f"<ul>{''.join(items)}</ul>" if items else ""


def _headline_table(result: EvaluationResult) -> str:
    return _rate_table(result) + _reference_table(result) + _loss_tables(result)


def _rate_table(result: EvaluationResult) -> str:
    """Messages and what they are beside the rivals'; then what they cost on the air."""
    sender = sender_label(result)
    lines = headlines(result)
    each = [(line.mbc, line.free, line.baseline) for line in lines]
    names = (sender, "free receiver", "baseline")
    named = any(line.mbc is not None and line.mbc.identifications for line in lines)
    head = ["threshold [cm]", *(f"{name} [1/s]" for name in names)]
    head += [f"{sender} / free receiver", f"{sender} / baseline"]
    head += [f"{sender} identifications [1/s]"] if named else []
    rows = [
        [
            _threshold(line),
            *(number(row and row.total_rate_hz) for row in rates),
            *(number(ratio) for ratio in (line.free_ratio, line.ratio)),
            *([number(line.mbc and line.mbc.identification_rate_hz)] if named else []),
        ]
        for line, rates in zip(lines, each, strict=True)
    ]
    costs = ["threshold [cm]", *(f"{name} {what}" for what in ("[byte/s]", "[ms/s]") for name in names)]
    costs.append(f"airtime, {sender} / baseline")
    spent = [
        [
            _threshold(line),
            *(number(row and row.bytes_per_s) for row in rates),
            *(number(row and 1000 * row.airtime_per_s) for row in rates),
            number(line.airtime_ratio),
        ]
        for line, rates in zip(lines, each, strict=True)
    ]
    return _titled(
        "Same threshold, without loss: messages",
        Cells(head, rows, 0),
        "Messages on an ideal channel without keep-alive, all trips pooled by time. All are error-driven at "
        "the same threshold; baseline and free receiver are sent plain messages.",
    ) + _titled(
        "Same threshold, without loss: bytes, and time on the air",
        Cells(costs, spent, 0),
        "Bytes are those of the messages in their frames; airtime, in ms a second, counts all layers and the "
        "security header, at 6 Mb/s.",
    )


def _titled(title: str, cells: Cells, note: str) -> str:
    """A table under its title and above its note."""
    return f'<h3>{escape(title)}</h3>{cells.html()}<p class="note">{escape(note)}</p>'


def _threshold(line: Headline) -> str:
    return f"{100 * line.threshold_m:.4g}"


def _reference_table(result: EvaluationResult) -> str:
    if not result.references:
        return ""
    head = ["threshold [cm]", *(f"{label} [1/s]" for label in REFERENCE_LABELS.values())]
    rows: list[list[str]] = []
    for line in headlines(result):
        found = [pooled_reference(result, name, line.threshold_m) for name in REFERENCE_LABELS]
        rows.append([_threshold(line), *(number(row and row.rate_hz) for row in found)])
    undecided = sum(row.undecided for row in result.references if row.trip == POOLED)
    note = (
        "Messages over time observed: the fewest messages of a sender that knows the future and "
        "sends one polynomial of that degree for each axis, and the triggering rules of ETSI EN 302 637-2. "
        f"Undecided tests, taken as failed: {undecided}."
    )
    return _titled("References", Cells(head, rows, 0), note)


def _loss_tables(result: EvaluationResult) -> str:
    """Both readings under loss: at the same threshold messages and errors, at the same rate errors."""
    places = [(ratio, line) for ratio in shown_ratios(result) for line in headlines(result)]
    if not places:
        return ""
    sender = sender_label(result)
    names = (sender, "free receiver", "baseline")
    starts = [[_threshold(line), f"{100 * ratio:.4g}"] for ratio, line in places]
    first = [
        "threshold [cm]",
        "lost [%]",
        *(f"{name} {what}" for what in ("[1/s]", "p90 [m]") for name in names),
    ]
    same = [
        [
            *start,
            *(number(line.rate_hz(ratio, role)) for role in SAME_THRESHOLD),
            *(number(line.p90_m(ratio, role)) for role in SAME_THRESHOLD),
        ]
        for start, (ratio, line) in zip(starts, places, strict=True)
    ]
    matched = (sender, "free receiver", "baseline, error-driven", "baseline, periodic")
    head = ["threshold [cm]", "lost [%]", *(f"{name} p90 [m]" for name in matched)]
    equal = [
        [*start, *(number(line.p90_m(ratio, role)) for role in SAME_RATE)]
        for start, (ratio, line) in zip(starts, places, strict=True)
    ]
    return _titled(
        f"Same threshold, {loss_title(result)}",
        Cells(first, same, 0),
        "At the same threshold: messages sent, keep-alives among them, and 90th percentile of the position "
        f"tracking error after the instant's message, with {loss_conditions(result)}.",
    ) + _titled(
        f"Same rate, {loss_title(result)}",
        Cells(head, equal, 0),
        f"At the same rate: the same percentile where all send at {sender}'s {rate_basis(result)} rate; "
        "the threshold of the others is then their own.",
    )


def _figures(result: EvaluationResult, drawings: Iterable[Drawing]) -> list[str]:
    texts = captions(result)
    return [
        embedded_figure(drawing, place, TITLES[drawing.name], texts[drawing.name])
        for place, drawing in enumerate(drawings, start=1)
    ]


def _understood(trips: Sequence[TripRow]) -> str:
    """What the files were taken for, each way once, with the trips that were read so."""
    ways: dict[tuple[tuple[str, str], ...], list[str]] = {}
    for trip in trips:
        if trip.understood:
            ways.setdefault(tuple(trip.understood.items()), []).append(trip.id)
    if not ways:
        return ""
    items = "".join(
        f"<li>{escape(_named(names))}: "
        + "; ".join(f"<b>{escape(subject)}</b> {escape(text)}" for subject, text in way)
        + ".</li>"
        for way, names in ways.items()
    )
    return f'<p class="note">What the files were taken for:</p><ul>{items}</ul>'


def _named(names: Sequence[str]) -> str:
    """The first of some trips, and how many more there are."""
    more = len(names) - 1
    return names[0] + (f" and {more} more" if more else "")


def _trip_table(trips: Sequence[TripRow]) -> str:
    head = ["trip", "format", "protocol", "skipped", "repaired", "velocity from"]
    head += ["duration [s]", "standing [s]", "samples", "step [s]", "gaps", "rows", "grid E, N [mm]"]
    rows = [
        [
            trip.id,
            trip.source,
            trip.protocol,
            _pairs(trip.skipped),
            _pairs(trip.repaired),
            velocity_words(trip.velocity_estimator),
            number(trip.duration_s, 5),
            number(trip.standing_s, 5),
            str(trip.samples),
            number(trip.dt_s),
            str(trip.gaps) + (", resampled" if trip.resampled else ""),
            str(trip.rows),
            ", ".join(number(1000 * step) for step in trip.grid_m),
        ]
        for trip in trips
    ]
    return Cells(head, rows, 6).html() + _conditioning_table(trips)


def _tracking_section(result: EvaluationResult) -> str:
    pooled = [row for row in result.tracking if row.trip == POOLED]
    single = [row for row in result.tracking if row.trip != POOLED]
    parts = [_details(f"All trips pooled ({len(pooled)} rows)", pooled, result)]
    if pooled and not single:
        parts.append('<p class="note">Rows of single trips are in the tables of parts/.</p>')
    elif len(single) <= _MOST_TRACKING_ROWS:
        parts.append(_details(f"Each trip ({len(single)} rows)", single, result))
    else:
        parts.append(f'<p class="note">The {len(single)} rows of single trips are in summary.json.</p>')
    return "".join(parts)


def _details(title: str, rows: Sequence[Row], result: EvaluationResult) -> str:
    sender = sender_label(result)
    head = [
        "trip",
        "policy",
        "bank",
        "threshold [cm]",
        "PER [%]",
        "seeds",
        "rate [1/s]",
        "PTE mean [m]",
        "PTE p50 [m]",
    ]
    head += ["PTE p90 [m]", "p90, 95 % interval [m]", "PTE p95 [m]", "PTE p99 [m]"]
    head += ["p90 before the message [m]", "p90 along the track [m]", "p90 across the track [m]"]
    head += ["time over 1.5 m [%]", "age p95 [s]", "samples left out"]
    cells = [
        [
            "all trips" if row.trip == POOLED else row.trip,
            policy_label(role_of(result, row.policy), row.rate_basis or "", sender=sender),
            row.bank,
            f"{100 * row.threshold_m:.4g}",
            f"{100 * row.packet_error_ratio:.4g}",
            str(row.seeds),
            number(row.message_rate_hz),
            *(number(value) for value in (row.pte_mean_m, row.pte_p50_m, row.pte_p90_m)),
            ""
            if row.pte_p90_low_m is None
            else f"{number(row.pte_p90_low_m)} to {number(row.pte_p90_high_m)}",
            *(number(value) for value in (row.pte_p95_m, row.pte_p99_m, row.pte_before_p90_m)),
            *(number(value) for value in (row.along_p90_m, row.cross_p90_m, 100 * row.beyond_lane_ratio)),
            number(row.information_age_p95_s),
            str(row.excluded_samples),
        ]
        for row in rows
    ]
    body = Cells(head, cells, 3).html()
    return f"<details><summary>{escape(title)}</summary>{body}</details>"


def _failures(failures: Mapping[str, str]) -> str:
    if not failures:
        return "<p>Every trip was evaluated.</p>"
    return Cells(["trip", "reason"], sorted(failures.items())).html()


def _skipped(skipped: Mapping[str, str]) -> str:
    if not skipped:
        return ""
    heading = '<p class="note">These held no trip:</p>'
    return heading + Cells(["file or vehicle", "reason"], sorted(skipped.items())).html()


def _conditioning_table(trips: Sequence[TripRow]) -> str:
    """The smoother's figures, one row a trip whose truth was smoothed; nothing where none was."""
    smoothed = [(trip.id, trip.conditioning) for trip in trips if trip.conditioning]
    if not smoothed:
        return ""
    names = list(smoothed[0][1])
    rows = [[trip, *(f"{figures[name]:.4g}" for name in names)] for trip, figures in smoothed]
    heading = '<p class="note">Truth smoothed; the smoother found:</p>'
    return heading + Cells(["trip", *(name.replace("_", " ") for name in names)], rows, 1).html()


def _pairs(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{reason}: {count}" for reason, count in sorted(counts.items())) or "0"
