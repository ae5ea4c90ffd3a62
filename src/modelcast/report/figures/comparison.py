"""Candidates side by side: messages and airtime against threshold, tracking error against loss."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from matplotlib.typing import LineStyleType

from modelcast.report.comparison_rows import (
    Limited,
    loss_ratios,
    pooled_rows,
    protocols,
    rival_rows_of,
    worst_rows,
)
from modelcast.report.comparison_tables import shown_rivals
from modelcast.report.figures.panels import drawable, empty_figure
from modelcast.report.headline import REFERENCE_LABELS
from modelcast.report.style import INK, PAGE_IN, POLICY_COLOURS, new_figure, style
from modelcast.study.compare.result import ComparisonResult
from modelcast.study.table import Row

__all__ = ["plot_comparison"]

_COLOURS = (
    "#332288",
    "#117733",
    "#88ccee",
    "#cc6677",
    "#999933",
    "#aa4499",
    "#44aa99",
    "#882255",
    "#ddaa33",
    "#777777",
)
_MARKERS = "osD^v<>PX*"
_REFERENCE_LINES: dict[str, LineStyleType] = {
    "clairvoyant-1": "-",
    "clairvoyant-2": (0, (3.5, 1.0)),
    "clairvoyant-3": (0, (1.0, 0.8)),
    "cam": (0, (5.0, 1.2, 1.0, 1.2)),
}
_SPREAD = 0.55
"""Most of the distance between two ticks that candidates are spread over, so that intervals do not hide."""

_APART = 0.1
"""The same between neighbours, where candidates are few."""

_LONGEST_NAME = 44
_SHORT_NAME = 24
"""With a longer name than this the legend has three columns instead of four."""

_CROWD = 8
_HEIGHT_IN, _CROWDED_HEIGHT_IN = 2.15, 2.9
"""Height of a row of panels, with up to eight candidates and with more [in]."""

_TALLEST_RATIO = 1.1
"""A reference this much above all candidates would squeeze them: it is named instead of drawn."""


@dataclass(frozen=True, slots=True)
class _Look:
    """How one candidate is drawn, and how far beside its tick, as a share of the distance between ticks."""

    colour: str
    marker: str
    line: LineStyleType
    width: float
    aside: float


def plot_comparison(result: ComparisonResult) -> Figure:
    """Return rows of panels, for each protocol one over the baseline and one over the free receiver.

    In a row messages and airtime at the same threshold without loss, then the 90th percentile of the error
    under loss at the same threshold, and at the same rate; errors at the worst threshold for each packet
    error ratio, at the same rate against the harder of the two readings of the equal-rate baseline. Hybrids
    are drawn thicker and dashed. Where candidates are compared against a third one, a row follows with
    messages, bytes and airtime over that one's, and the share of trips beyond both bounds.

    Parameters
    ----------
    result
        The comparison.
    """
    run = protocols(result)
    with style():
        if not run:
            return empty_figure("Nothing was compared.")
        looks = _looks(result)
        height_in = _HEIGHT_IN if len(looks) <= _CROWD else _CROWDED_HEIGHT_IN
        legend_in = 0.14 * -(-(len(looks) + 5) // _legend_columns(looks))
        third = result.rival if result.rival != result.free else None
        each = [None, *shown_rivals(result)]
        rows = [(rival, protocol) for protocol in run for rival in each]
        figure = new_figure(PAGE_IN, 0.35 + legend_in + height_in * len(rows))
        panels = figure.subplots(len(rows), 4, squeeze=False)
        for axes, (rival, protocol) in zip(panels, rows, strict=True):
            if rival is not None and rival == third:
                _draw_third(axes, result, protocol, looks)
            else:
                _draw_row(axes, result, protocol, rival, looks)
        _legend(figure, [row[0] for row in panels], _legend_columns(looks))
        return figure


_TITLES = (
    "Messages,\nsame threshold",
    "Airtime,\nsame threshold",
    "p90, same threshold,\nwith losses",
    "p90, same rate,\nwith losses",
)


def _draw_row(
    row: Sequence[Axes], result: ComparisonResult, protocol: str, rival: str | None, looks: dict[str, _Look]
) -> None:
    """Draw a row of panels over the baseline, or over the free receiver."""
    if rival is None:
        _draw_messages(row[0], result, protocol, looks)
        _draw_airtime(row[1], result, protocol, looks)
    else:
        rows = {name: rival_rows_of(result, name, protocol, rival) for name in looks}
        for axes, figure in zip(row, ("message", "airtime"), strict=False):
            _threshold_axis(axes, [one for one in result.ratios if one.protocol == protocol])
            top = _draw_ratios(axes, rows, figure, looks)
            _one(axes, _FREE)
            axes.set_ylim(0.0, 1.1 * top)
    prefix = "baseline" if rival is None else "free"
    same = {name: _worst_same(result, name, protocol, prefix) for name in looks}
    _draw_tracking(row[2], result, same, looks, prefix)
    figure = "p90" if rival is None else "p90_over_free"
    matched = {name: worst_rows(result, name, protocol, figure) for name in looks}
    _draw_tracking(row[3], result, matched, looks, prefix)
    for at, (axes, title) in enumerate(zip(row, _TITLES, strict=True)):
        axes.set_title(title)
        axes.set_xlabel("Threshold [cm]" if at < len(row) // 2 else "Packet error ratio [%]")
    row[0].set_ylabel(f"{protocol}\nratio to the {'baseline' if rival is None else 'free receiver'}")


def _worst_same(result: ComparisonResult, name: str, protocol: str, prefix: str) -> list[Limited]:
    """The largest ratio of p90 to somebody's at the same threshold, at each packet error ratio."""
    found: list[Limited] = []
    for ratio in loss_ratios(result):
        rows = pooled_rows(result, name, protocol, ratio)
        pairs = [(row.p90_m, getattr(row, f"{prefix}_p90_m")) for row in rows]
        values = [own_m / other_m for own_m, other_m in pairs if other_m]
        found.append((max(values, default=float("nan")), None, None))
    return found


def _draw_third(
    row: Sequence[Axes], result: ComparisonResult, protocol: str, looks: dict[str, _Look]
) -> None:
    """Draw a row over a third candidate compared against, and the share of trips beyond the bounds."""
    ratios = [one for one in result.ratios if one.protocol == protocol]
    for axes in row:
        _threshold_axis(axes, ratios)
    rivals = {name: rival_rows_of(result, name, protocol, result.rival) for name in looks}
    for axes, figure in zip(row, ("message", "bytes", "airtime"), strict=False):
        top = _draw_ratios(axes, rivals, figure, looks)
        axes.axhline(1.0, color=INK, linewidth=1.1, zorder=1)
        axes.set_ylim(0.0, 1.1 * top)
    for name, look in looks.items():
        over = [
            100.0 * max(one.trips_over / one.trips, two.trips_over / two.trips)
            for one, two in zip(rivals[name], _by_threshold(ratios, name), strict=True)
        ]
        _draw_line(row[3], name, look, np.array(over), [(None, None)] * len(over))
    row[3].set_ylim(bottom=0.0)
    for axes, title in zip(row, ("Messages", "Bytes", "Airtime", "Trips over a bound [%]"), strict=True):
        axes.set_title(title)
        axes.set_xlabel("Threshold [cm]")
    row[0].set_ylabel(f"{protocol}\nratio to {drawable(str(result.rival), _SHORT_NAME)}")


def _legend_columns(names: Iterable[str]) -> int:
    return 4 if max(len(name) for name in names) <= _SHORT_NAME else 3


def _legend(figure: Figure, panels: Sequence[Axes], columns: int) -> None:
    """Name what any of the panels shows: a reference may lie off the scale of some."""
    named: dict[str, Artist] = {}
    for axes in panels:
        handles, labels = axes.get_legend_handles_labels()
        named.update(zip(labels, handles, strict=True))
    order = [*(name for name in named if name not in REFERENCE_LABELS.values())]
    order += [name for name in REFERENCE_LABELS.values() if name in named]
    figure.legend(
        [named[name] for name in order], order, loc="outside upper center", ncols=columns, columnspacing=1.4
    )


def _looks(result: ComparisonResult) -> dict[str, _Look]:
    """Return how each candidate is drawn: members first, then hybrids."""
    ordered = sorted(result.candidates, key=lambda row: row.is_hybrid)
    spread = min(_SPREAD, _APART * (len(ordered) - 1))
    asides = np.linspace(-0.5, 0.5, len(ordered)) * spread
    return {
        row.name: _Look(
            POLICY_COLOURS["free"] if row.name == result.free else _COLOURS[at % len(_COLOURS)],
            _MARKERS[(at + 3 * (at // len(_COLOURS))) % len(_MARKERS)],
            (0, (3.0, 1.0)) if row.is_hybrid else "-",
            1.6 if row.is_hybrid else 0.9,
            float(aside),
        )
        for at, (row, aside) in enumerate(zip(ordered, asides, strict=True))
    }


def _draw_messages(axes: Axes, result: ComparisonResult, protocol: str, looks: dict[str, _Look]) -> None:
    thresholds_m, tallest = _draw_over_baseline(axes, result, protocol, looks, "message")
    for reference, dashes in _REFERENCE_LINES.items():
        found = {
            row.threshold_m: row.message_ratio
            for row in result.references
            if (row.reference, row.protocol) == (reference, protocol)
        }
        if not found:
            continue
        values = [found[threshold_m] for threshold_m in thresholds_m]
        label = REFERENCE_LABELS[reference]
        if min(values) > _TALLEST_RATIO * tallest:
            note = f"{label}: {min(values):.1f} and more"
            axes.text(
                0.98, 0.985, note, transform=axes.transAxes, ha="right", va="top", fontsize=5.5, color=INK
            )
            continue
        places = [float(at) for at in range(len(values))]
        if len(values) == 1:  # one threshold has a line too
            places, values = [-0.4, 0.4], 2 * values
        axes.plot(places, values, color=INK, linestyle=dashes, linewidth=0.8, label=label, zorder=1)
    axes.set_ylim(0.0, 1.15 * tallest)


def _draw_airtime(axes: Axes, result: ComparisonResult, protocol: str, looks: dict[str, _Look]) -> None:
    _, tallest = _draw_over_baseline(axes, result, protocol, looks, "airtime")
    axes.set_ylim(0.0, 1.1 * tallest)


def _draw_over_baseline(
    axes: Axes, result: ComparisonResult, protocol: str, looks: dict[str, _Look], figure: str
) -> tuple[list[float], float]:
    """Draw all candidates' ratios of one figure; return the thresholds and the highest point drawn."""
    rows = [row for row in result.ratios if row.protocol == protocol]
    thresholds_m = _threshold_axis(axes, rows)
    tallest = _draw_ratios(axes, {name: _by_threshold(rows, name) for name in looks}, figure, looks)
    _one(axes, _BASELINE)
    return thresholds_m, tallest


def _draw_ratios(
    axes: Axes, rows: Mapping[str, Sequence[Row]], figure: str, looks: dict[str, _Look]
) -> float:
    """Draw candidates' ratios of messages, bytes or airtime; return the highest point, 1 or more."""
    tallest = 1.0
    for name, look in looks.items():
        values = np.array([getattr(row, f"{figure}_ratio") for row in rows[name]])
        limits = [(getattr(row, f"{figure}_low"), getattr(row, f"{figure}_high")) for row in rows[name]]
        tallest = max(tallest, _draw_line(axes, name, look, values, limits))
    return tallest


def _draw_tracking(
    axes: Axes,
    result: ComparisonResult,
    values: Mapping[str, Sequence[Limited]],
    looks: dict[str, _Look],
    prefix: str,
) -> None:
    """Draw the worst threshold's ratio at each loss ratio, 2 as far off as 1/2."""
    ratios = loss_ratios(result)
    if not ratios:
        axes.text(0.5, 0.5, "not evaluated", transform=axes.transAxes, ha="center", color="#666666")
        axes.set_xticks([])
        return
    axes.set_yscale("log", base=2)
    for name, look in looks.items():
        ends = [(low, high) for _, low, high in values[name]]
        _draw_line(axes, name, look, np.array([value for value, _, _ in values[name]]), ends)
    _one(axes, _BASELINE if prefix == "baseline" else _FREE)
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:.3g}")
    axes.set_xticks(range(len(ratios)), [f"{100 * ratio:.4g}" for ratio in ratios])
    axes.set_xlim(-0.5, len(ratios) - 0.5)
    axes.grid(visible=False, axis="x")


def _draw_line(
    axes: Axes,
    name: str,
    look: _Look,
    values: np.ndarray[tuple[int], np.dtype[np.float64]],
    limits: Sequence[tuple[float | None, float | None]],
) -> float:
    """Draw one candidate with its intervals, a little beside the ticks; return the highest point drawn."""
    places = np.arange(values.size) + look.aside
    axes.plot(
        places,
        values,
        color=look.colour,
        marker=look.marker,
        linestyle=look.line,
        linewidth=look.width,
        markersize=3.0,
        label=drawable(name, _LONGEST_NAME),
        zorder=3,
    )
    low, high = np.array(limits, dtype=np.float64).reshape(-1, 2).T
    axes.vlines(places, low, high, color=look.colour, linewidth=0.8, zorder=2)
    tops = np.concatenate([values, high])
    return float(np.nanmax(tops)) if np.isfinite(tops).any() else 0.0


def _by_threshold(rows: Sequence[Row], name: str) -> list[Row]:
    return sorted((row for row in rows if row.candidate == name), key=lambda row: row.threshold_m)


def _threshold_axis(axes: Axes, rows: Sequence[Row]) -> list[float]:
    thresholds_m = sorted({row.threshold_m for row in rows})
    axes.set_xticks(range(len(thresholds_m)), [f"{100 * item:.4g}" for item in thresholds_m])
    axes.set_xlim(-0.5, len(thresholds_m) - 0.5)
    axes.grid(visible=False, axis="x")
    axes.yaxis.set_major_locator(MaxNLocator(nbins=6, steps=[1, 2, 5, 10]))
    return thresholds_m


_BASELINE = "Baseline (CV)"
_FREE = "Free receiver"


def _one(axes: Axes, label: str) -> None:
    """Draw the line of whom ratios are to."""
    colour, line = (INK, "-") if label == _BASELINE else (POLICY_COLOURS["free"], "--")
    axes.axhline(1.0, color=colour, linestyle=line, linewidth=1.1, label=label, zorder=1)
