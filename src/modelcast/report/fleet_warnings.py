"""What hosts of fleets on the air warned of, for people: headline and table."""

from collections.abc import Sequence

import numpy as np
from rich.console import Group, RenderableType

from modelcast.core.cells import Cells
from modelcast.report.console_table import placed_table
from modelcast.report.figures.fleet_warnings import plot_warned_map, plot_warnings
from modelcast.report.figures.senders import density_text, threshold_text
from modelcast.report.literal import Prose
from modelcast.report.parts import Part
from modelcast.report.warning_texts import ENOUGH, late_text, over_text, percent_text, plain_text
from modelcast.study.network.mixed import mixed_of
from modelcast.study.network.rows import NO_BANK, NetworkResult
from modelcast.study.network.warning_rows import ALL_SENDERS
from modelcast.study.table import Row

__all__ = [
    "policy_text",
    "warnings_console",
    "warnings_headline",
    "warnings_markdown",
    "warnings_part",
]

_SCOPE = (
    "What hosts warn of by what they hear, against the same application with perfect knowledge, where the "
    "true margin is near zero. Missed and false are shares of instants; late and never of whole warnings. In "
    "brackets: 95 % intervals over warnings (hosts, of false ones) and seeds. Over: against the rival's, at "
    "the same true warnings."
)
_HEADS = (
    "application", "density", "radio", "policy", "bank", "threshold", "of", "read as", "messages/s", "busy",
    "warnings", "missed", "over", "false", "over", "false/h", "never", "late p50", "p90", "p99",
)  # fmt: skip
_TEXT_COLUMNS = 8
_FIGURE = (
    "Instants near the decision at which a host did not warn and perfect knowledge does, and at which it "
    "warned without reason, against the messages of a vehicle; and how late warnings come: where a curve "
    "ends below 100 %, the rest never came."
)
_MAP = (
    "Missed and false warnings over the shares of vehicles that send by the last policy and that read "
    "models; the others read as legacy receivers do."
)


def policy_text(policy: str) -> str:
    """Return a policy as people read it.

    Examples
    --------
    >>> policy_text("baseline+mbc@25"), policy_text("cam")
    ('25 % mbc, else baseline', 'cam')
    """
    mixed = mixed_of(policy)
    if not mixed.is_mixed:
        return policy
    *others, new = mixed.senders
    return f"{100.0 * mixed.senders_ratio:g} % {new}, else {', '.join(others)}"


def _short(policy: str) -> str:
    """A policy in a table of one fleet: of a mixed one the share of new senders."""
    mixed = mixed_of(policy)
    return f"{100.0 * mixed.senders_ratio:g} % {mixed.senders[-1]}" if mixed.is_mixed else policy


def _order(row: Row) -> tuple[str, str, str, float]:
    """Place in a table; rows that are alike stay as they are."""
    return (
        row.application,
        density_text(row.density_per_km).zfill(9),
        row.radio,
        mixed_of(row.policy).senders_ratio,
    )


def warnings_headline(result: NetworkResult) -> list[str]:
    """Return how many true warnings there were, by application, density and radio.

    Parameters
    ----------
    result
        All runs.
    """
    found: dict[tuple[str, str], dict[int, None]] = {}
    for row in _whole(result):
        found.setdefault((row.application, density_text(row.density_per_km)), {})[row.events] = None
    lines: list[str] = []
    for (application, density), events in found.items():
        counts = " and ".join(map(str, events))
        place = "" if density == "-" else f", {density}/km"
        few = f": fewer than {ENOUGH}, its ratios are anecdotes" if min(events) < ENOUGH else ""
        lines.append(f"{application}{place}: {counts} true warnings{few}")
    return lines


def _whole(result: NetworkResult) -> list[Row]:
    """Rows over all senders of their fleets."""
    return [
        row
        for row in result.pooled_warnings
        if row.sender == (ALL_SENDERS if mixed_of(row.policy).is_mixed else row.policy)
    ]


def _cells(result: NetworkResult) -> Cells:
    ordered = sorted(result.pooled_warnings, key=_order)
    rows = [
        [
            row.application,
            density_text(row.density_per_km),
            row.radio,
            policy_text(row.policy),
            row.bank,
            threshold_text(row.threshold_m),
            row.sender,
            row.reading,
            plain_text(row.message_rate_hz, "{:.2f}"),
            percent_text(row.busy_ratio),
            str(row.events),
            _share(row.missed_ratio, row.missed_low, row.missed_high),
            over_text(row, "missed"),
            _share(row.false_ratio, row.false_low, row.false_high),
            over_text(row, "false"),
            plain_text(row.false_per_hour, "{:.1f}"),
            percent_text(row.never_ratio),
            *(late_text(value) for value in (row.delay_p50_s, row.delay_p90_s, row.delay_p99_s)),
        ]
        for row in ordered
        if row.events or row.negatives
    ]
    return Cells(_HEADS, rows, _TEXT_COLUMNS)


def _share(value: float, low: float | None, high: float | None) -> str:
    """A share in percent with the ends of its interval, where it has one."""
    shown = percent_text(value)
    return shown if low is None or high is None else f"{shown} ({100 * low:.2f}-{100 * high:.2f})"


def warnings_markdown(result: NetworkResult) -> list[str]:
    """Return headline and table as lines of Markdown; none where hosts had no application.

    Parameters
    ----------
    result
        All runs.
    """
    if not result.pooled_warnings:
        return []
    lines = [f"- {line}" for line in warnings_headline(result)]
    return [*lines, "", _SCOPE, "", *_cells(result).markdown()]


def warnings_part(result: NetworkResult) -> list[Part]:
    """Return the part of a page, none where hosts had no application.

    Parameters
    ----------
    result
        All runs.
    """
    if not result.pooled_warnings:
        return []
    figures = {"warnings": (_FIGURE, plot_warnings(result))}
    if result.pairings:
        ratios = sorted({row.receivers_ratio for row in result.penetration})
        figures = {"warned_map": (_MAP, plot_warned_map(result, ratios))}
    return [
        Part(
            "Warnings",
            _SCOPE,
            notes=warnings_headline(result),
            cells=_cells(result),
            figures=figures,
        )
    ]


def warnings_console(result: NetworkResult) -> RenderableType:
    """Return headline and a short table for the terminal: a line a policy and reading, over all senders.

    Parameters
    ----------
    result
        All runs.
    """
    heads = ("policy", "1/s", "missed", "over", "false", "over", "never", "late p90")
    places: list[str] = []
    rows: list[Sequence[str]] = []
    for row in sorted(_whole(result), key=_order):
        density = "" if np.isnan(row.density_per_km) else f", {density_text(row.density_per_km)}/km"
        places.append(f"{row.application}, {row.radio}{density}")
        told = [_short(row.policy)]
        told += [row.reading] if row.sender == ALL_SENDERS else []
        told += [row.bank] if len(result.banks) > 1 and row.bank != NO_BANK else []
        told += [threshold_text(row.threshold_m)] if len(result.thresholds_m) > 1 else []
        cells = (
            ", ".join(told),
            plain_text(row.message_rate_hz, "{:.2f}"),
            percent_text(row.missed_ratio),
            plain_text(row.missed_over, "{:.2f}"),
            percent_text(row.false_ratio),
            plain_text(row.false_over, "{:.2f}"),
            percent_text(row.never_ratio),
            late_text(row.delay_p90_s),
        )
        rows.append(cells)
    shown = placed_table(Cells(heads, rows, 1), places)
    return Group(*map(Prose, warnings_headline(result)), shown)
