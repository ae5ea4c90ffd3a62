"""The report of a reproduction of the paper: figures, one HTML file that needs nothing else, and Markdown."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Group, RenderableType

from modelcast.core.cells import Cells, escape, markdown, number
from modelcast.core.version import package_version
from modelcast.report.captions import captions
from modelcast.report.console import failures_table, scope_line, skipped_lines, warning_texts
from modelcast.report.console_table import console_table
from modelcast.report.figures.distribution import plot_distribution
from modelcast.report.figures.files import Drawing, drawn, write_report_files
from modelcast.report.figures.loss import plot_loss
from modelcast.report.figures.manoeuvre import plot_manoeuvre
from modelcast.report.figures.rates import plot_rates
from modelcast.report.figures.readings import plot_readings
from modelcast.report.figures.system import plot_algorithm, plot_system
from modelcast.report.figures.timeline import plot_timeline
from modelcast.report.figures.traffic import TRAFFIC_FIGURES
from modelcast.report.literal import Prose, literal
from modelcast.report.page import CSS, embedded_figure, page
from modelcast.report.paper_texts import CAPTIONS, INTRODUCTION, READING_NOTE, TITLES, WHY_THEY_DIFFER
from modelcast.report.style import style
from modelcast.report.traffic import traffic_section
from modelcast.report.warnings import warning_lines
from modelcast.study.paper.choices import CHOICES, ENDS, PLAIN_LABEL
from modelcast.study.paper.result import ClaimRow, PaperResult, ReadingResult
from modelcast.study.result import TRACKING, EvaluationResult
from modelcast.trips.manoeuvres.base import KINDS, ManoeuvreCounts

__all__ = ["draw_paper", "paper_console", "paper_markdown", "paper_page", "write_paper_report"]

_MOST_TRIPS = 20
_CLAIM_HEAD = ("claim", "the paper, in our words", "plain reading", "other readings", "measured")
_READING_HEAD = ("reading", "messages", "updates", "airtime", "p90", "p99")


def write_paper_report(result: PaperResult, folder: str | Path) -> list[Path]:
    """Write ``report.html``, ``claims.md`` and a folder ``figures``; return the paths.

    Parameters
    ----------
    result
        The reproduction.
    folder
        An existing folder.
    """
    drawings = draw_paper(result)
    texts = {"report.html": paper_page(result, drawings), "claims.md": paper_markdown(result)}
    return write_report_files(texts, drawings, folder, figures="figures")


def draw_paper(result: PaperResult) -> list[Drawing]:
    """Draw all figures of a reproduction, in the order of `TITLES`, then those of traffic where it was run.

    Parameters
    ----------
    result
        The reproduction.
    """
    whole = _illustrated(result)
    by_update, by_total = (_on_basis(whole, basis) for basis in ("update", "total"))
    with style():
        figures = {
            "system": plot_system(),
            "algorithm": plot_algorithm(),
            "message_rate": plot_rates(whole),
            "distribution_update": plot_distribution(by_update),
            "distribution_total": plot_distribution(by_total),
            "loss_update": plot_loss(by_update),
            "loss_total": plot_loss(by_total),
            "sub_models": plot_timeline(whole),
            "manoeuvre": plot_manoeuvre(whole),
            "readings": plot_readings(result),
        }
        drawings = [drawn(name, figures[name]) for name in TITLES]
        if result.traffic:
            own = result.traffic
            drawings += [drawn(name, plot(own)) for name, (_, plot) in TRAFFIC_FIGURES.items()]
        return drawings


def _illustrated(result: PaperResult) -> EvaluationResult:
    """The evaluation with the stretch and the manoeuvre that show what the paper shows, if there are any."""
    shared = result.complement
    return replace(result.evaluation, timeline=shared.timeline, manoeuvre=shared.manoeuvre)


def _on_basis(result: EvaluationResult, basis: str) -> EvaluationResult:
    """The evaluation with the equal-rate baselines of one basis alone."""
    kept = {None, basis}
    return replace(
        result,
        tracking=TRACKING.table(row for row in result.tracking if row.rate_basis in kept),
        ecdfs=tuple(curve for curve in result.ecdfs if curve.rate_basis in kept),
    )


def paper_page(result: PaperResult, drawings: Iterable[Drawing]) -> str:
    """Return the report as one HTML document.

    Parameters
    ----------
    result
        The reproduction.
    drawings
        What `draw_paper` returned for it.
    """
    warned = warning_lines((trip.id, trip.warnings) for trip in result.evaluation.trips)
    items = "".join(f"<li>{escape(line)}.</li>" for line in warned)
    scope = scope_line(result.evaluation)
    body = [
        "<h1>The paper's evaluation on these trips</h1>",
        f'<p class="scope">{escape(scope)}. modelcast {escape(package_version())}.</p>',
        f'<p class="note">{escape(result.picked)}</p>' if result.picked else "",
        f'<h2>Warnings</h2><ul class="warnings">{items}</ul>' if items else "",
        "<h2>The paper in short</h2>",
        *(f"<p>{escape(text)}</p>" for text in INTRODUCTION),
        "<h2>Claims</h2>",
        _claims(result).html(),
        f'<p class="note">{escape(READING_NOTE)}</p>',
        "<h2>What is left open</h2>",
        Cells(("choice", "question", "stated", "options"), _choice_cells()).html(),
        "<h2>Readings</h2>",
        _readings(result).html(),
        f'<p class="note">{escape(WHY_THEY_DIFFER)}</p>',
        "<h3>What the combinations took</h3>",
        Cells(("reading", "options that are not the plain ones"), _combined_cells(result)).html(),
        "<h2>Verdicts by reading</h2>",
        _verdict_table(result),
        "<h2>Figures</h2>",
        *_figures(result, drawings),
        traffic_section(result.traffic) if result.traffic else "",
        "<h2>How it was measured</h2>",
        Cells(
            ("claim", "measure", "worst trip", "figure", "command"),
            [
                [row.name, row.measure, row.worst or "-", row.shown_in or "-", row.command]
                for row in result.claims
            ],
        ).html(),
        "<h2>Manoeuvres</h2>",
        _manoeuvre_table(result.manoeuvres),
        "<h2>Left out</h2>",
        _left_out(result),
    ]
    return page("modelcast: the paper", CSS, body)


def _figures(result: PaperResult, drawings: Iterable[Drawing]) -> list[str]:
    whole = _illustrated(result)
    by_basis = {basis: captions(_on_basis(whole, basis)) for basis in ("update", "total")}
    texts = {
        "message_rate": captions(whole)["message_rate"],
        **{f"distribution_{basis}": own["tracking_distribution"] for basis, own in by_basis.items()},
        **{f"loss_{basis}": own["tracking_loss"] for basis, own in by_basis.items()},
        **CAPTIONS,
        **{name: caption for name, (caption, _) in TRAFFIC_FIGURES.items()},
    }
    return [
        embedded_figure(drawing, place, TITLES.get(drawing.name, "In traffic"), texts[drawing.name])
        for place, drawing in enumerate(drawings, start=1)
    ]


def _claims(result: PaperResult) -> Cells:
    return Cells(_CLAIM_HEAD, [_claim_cells(row) for row in result.claims])


def _readings(result: PaperResult) -> Cells:
    return Cells(_READING_HEAD, [_reading_cells(one) for one in result.readings])


def _claim_cells(row: ClaimRow) -> list[str]:
    return [row.name, row.sentence, row.verdicts[PLAIN_LABEL], _others(row), row.figure]


def _others(row: ClaimRow) -> str:
    """How the verdict fares under the other readings: which differ from the plain one."""
    others = {label: verdict for label, verdict in row.verdicts.items() if label != PLAIN_LABEL}
    if not others:
        return "judged in the plain reading only"
    plain = row.verdicts[PLAIN_LABEL]
    differing = [f"{label}: {verdict}" for label, verdict in others.items() if verdict != plain]
    if not differing:
        return f"the same in all {len(others)}"
    same = len(others) - len(differing)
    return "; ".join(differing) + (f"; the same in {same} more" if same else "")


def _choice_cells() -> list[list[str]]:
    return [
        [
            choice.title,
            choice.question,
            "the paper" if choice.stated else "open",
            "; ".join(f"{option.label}: {option.text}" for option in choice.options),
        ]
        for choice in CHOICES
    ]


def _combined_cells(result: PaperResult) -> list[list[str]]:
    """What each combination took, where it is not the plain option."""
    plain = result.readings[0].labelled.reading
    rows: list[list[str]] = []
    for one in result.readings:
        own = one.labelled
        if own.label not in ENDS:
            continue
        taken = [
            f"{choice.title}: {option.label}"
            for choice in CHOICES
            for option in choice.options
            if option.value == getattr(own.reading, choice.field) != getattr(plain, choice.field)
        ]
        rows.append([own.label, "; ".join(taken) or "none"])
    return rows


def _reading_cells(one: ReadingResult) -> list[str]:
    tracking = one.rows.pooled(one.labelled.reading)
    return [
        one.labelled.label,
        _ratios((row.message_ratio, row.message_low, row.message_high) for row in one.rows.messages),
        _ratios((row.message_ratio, row.message_low, row.message_high) for row in one.rows.updates),
        _ratios((row.airtime_ratio, row.airtime_low, row.airtime_high) for row in one.rows.messages),
        _ratios((row.p90_ratio, row.p90_low, row.p90_high) for row in tracking),
        _ratios((row.p99_ratio, row.p99_low, row.p99_high) for row in tracking),
    ]


def _ratios(ratios: Iterable[tuple[float, float | None, float | None]]) -> str:
    """Ratios at rising thresholds, with the widest interval's ends where there are intervals."""
    rows = list(ratios)
    shown = " / ".join(f"{value:.2f}" for value, _, _ in rows)
    lows = [low for _, low, _ in rows if low is not None]
    highs = [high for _, _, high in rows if high is not None]
    return f"{shown} ({min(lows):.2f} to {max(highs):.2f})" if lows and highs else shown


def _verdict_table(result: PaperResult) -> str:
    labels = [one.labelled.label for one in result.readings]
    claims = [row for row in result.claims if len(row.verdicts) > 1]
    head = ["reading", *(row.name for row in claims)]
    rows = [[label, *(row.verdicts.get(label, "-") for row in claims)] for label in labels]
    return Cells(head, rows).html()


def _manoeuvre_table(counts: Sequence[ManoeuvreCounts]) -> str:
    """The trips richest in manoeuvres, as ``modelcast trips --rank`` ranks them."""
    head = ["trip", "duration [s]", "distance [km]", "all", *(kind.value for kind in KINDS)]
    rows = [
        [
            one.trip_id,
            number(one.duration_s, 4),
            number(one.distance_m / 1000.0),
            str(one.total),
            *(str(one.by_kind[kind]) for kind in KINDS),
        ]
        for one in counts[:_MOST_TRIPS]
    ]
    more = len(counts) - len(rows)
    note = f'<p class="note">{more} more trips are in summary.json.</p>' if more else ""
    return Cells(head, rows, 1).html() + note


def _left_out(result: PaperResult) -> str:
    rows = [*sorted(result.failures.items()), *sorted(result.skipped.items())]
    if not rows:
        return "<p>Every trip was evaluated.</p>"
    return Cells(("trip, file or vehicle", "reason"), rows).html()


def paper_markdown(result: PaperResult) -> str:
    """Return claims and readings as Markdown.

    Parameters
    ----------
    result
        The reproduction.
    """
    parts = [
        f"{markdown(scope_line(result.evaluation))}; {result.plan.seeds} seeds.",
        "",
        *_claims(result).markdown(),
        "",
        *_readings(result).markdown(),
        "",
        *(f"- {label}: {markdown(taken)}" for label, taken in _combined_cells(result)),
    ]
    return "\n".join(parts) + "\n"


def _holds(verdicts: Sequence[str]) -> str:
    held = sum(verdict == "holds" for verdict in verdicts)
    return f"{held} of {len(verdicts)} readings" if len(verdicts) > 1 else ""


def paper_console(result: PaperResult) -> RenderableType:
    """Return what a terminal shows: the claims with the verdicts, and the readings.

    Parameters
    ----------
    result
        The reproduction.
    """
    verdicts = [
        [row.name, row.verdicts[PLAIN_LABEL], _holds(list(row.verdicts.values()))] for row in result.claims
    ]
    claims = console_table(Cells(("claim", "plain reading", "holds in"), verdicts), "Claims")
    means = [[one.labelled.label, number(one.messages), number(one.tracking)] for one in result.readings]
    heads = ("reading", "messages", f"p90, PER {100 * result.plan.headline_ratio:g} %")
    readings = console_table(Cells(heads, means, 1), "Over the baseline, mean of the thresholds")
    warned = warning_texts((trip.id, trip.warnings) for trip in result.evaluation.trips)
    parts = [*warned, Prose(scope_line(result.evaluation)), claims, readings]
    parts += [literal(line) for line in skipped_lines(result.skipped)]
    if result.failures:
        parts.append(failures_table(result.failures))
    return Group(*parts)
