"""Candidates side by side: messages and bytes against threshold, tracking error against loss."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from matplotlib.typing import LineStyleType

from modelcast.report.figures.panels import drawable, empty_figure
from modelcast.report.headline import REFERENCE_LABELS
from modelcast.report.style import INK, PAGE_IN, new_figure, style
from modelcast.study.compare.result import ComparisonResult
from modelcast.study.result import POOLED
from modelcast.study.table import Row

__all__ = ["plot_comparison", "rival_rows_of", "worst_rows"]

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
    """Return a row of panels a protocol: messages, airtime, 90th and 99th percentile over the baseline's.

    Tracking panels show the worst threshold at each packet error ratio, against the harder of the two
    readings of the equal-rate baseline. Hybrids are drawn thicker and dashed. Where candidates are compared
    against another than the baseline, a second row follows: messages, bytes and airtime over that one's, and
    the share of trips beyond both bounds.

    Parameters
    ----------
    result
        The comparison.
    """
    protocols = list(dict.fromkeys(row.protocol for row in result.ratios))
    with style():
        if not protocols:
            return empty_figure("Nothing was compared.")
        looks = _looks(result)
        height_in = _HEIGHT_IN if len(looks) <= _CROWD else _CROWDED_HEIGHT_IN
        legend_in = 0.14 * -(-(len(looks) + 5) // _legend_columns(looks))
        each = 1 if result.rival is None else 2
        figure = new_figure(PAGE_IN, 0.35 + legend_in + height_in * each * len(protocols))
        panels = figure.subplots(each * len(protocols), 4, squeeze=False)
        grid = panels[::each]
        if result.rival is not None:
            for axes, protocol in zip(panels[1::2], protocols, strict=True):
                _draw_rival(axes, result, protocol, looks)
        for axes, protocol in zip(grid, protocols, strict=True):
            _draw_messages(axes[0], result, protocol, looks)
            _draw_airtime(axes[1], result, protocol, looks)
            _draw_tracking(axes[2], result, protocol, looks, percentile=90)
            _draw_tracking(axes[3], result, protocol, looks, percentile=99)
            axes[0].set_ylabel(f"{protocol}\nratio to the baseline")
        titles = ("Messages", "Airtime", "p90, worst threshold", "p99, worst threshold")
        for row in grid[:1] if result.rival is None else grid:
            for axes, title in zip(row, titles, strict=True):
                axes.set_title(title)
        for row in grid[-1:] if result.rival is None else grid:
            for at, axes in enumerate(row):
                axes.set_xlabel("Threshold [cm]" if at < 2 else "Packet error ratio [%]")
        _legend(figure, [row[0] for row in grid], _legend_columns(looks))
        return figure


def rival_rows_of(result: ComparisonResult, candidate: str, protocol: str) -> list[Row]:
    """Return a candidate's rows over the one compared against, by rising threshold.

    Parameters
    ----------
    result
        The comparison.
    candidate, protocol
        Whose.
    """
    own = (row for row in result.rivals if (row.candidate, row.protocol) == (candidate, protocol))
    return sorted(own, key=lambda row: row.threshold_m)


def _draw_rival(
    row: Sequence[Axes], result: ComparisonResult, protocol: str, looks: dict[str, _Look]
) -> None:
    """Draw a row of panels over the candidate compared against, and the share of trips beyond the bounds."""
    ratios = [one for one in result.ratios if one.protocol == protocol]
    for axes in row:
        _threshold_axis(axes, ratios)
    rivals = {name: rival_rows_of(result, name, protocol) for name in looks}
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


def worst_rows(result: ComparisonResult, candidate: str, protocol: str, percentile: int) -> list[float]:
    """Return the largest ratio over the thresholds at each packet error ratio, rising.

    Parameters
    ----------
    result
        The comparison.
    candidate, protocol
        Whose.
    percentile
        90 or 99.
    """
    found: dict[float, float] = {}
    for row in result.tracking:
        if (row.trip, row.candidate, row.protocol) == (POOLED, candidate, protocol):
            known = found.get(row.packet_error_ratio, float("nan"))
            ratio = getattr(row, f"p{percentile}_ratio")
            found[row.packet_error_ratio] = float(np.fmax(known, ratio))
    return [found[ratio] for ratio in sorted(found)]


def _looks(result: ComparisonResult) -> dict[str, _Look]:
    """Return how each candidate is drawn: members first, then hybrids."""
    ordered = sorted(result.candidates, key=lambda row: row.is_hybrid)
    spread = min(_SPREAD, _APART * (len(ordered) - 1))
    asides = np.linspace(-0.5, 0.5, len(ordered)) * spread
    return {
        row.name: _Look(
            _COLOURS[at % len(_COLOURS)],
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
    _baseline(axes)
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
    axes: Axes, result: ComparisonResult, protocol: str, looks: dict[str, _Look], *, percentile: int
) -> None:
    """Draw the worst threshold's ratio at each loss ratio, 2 as far off as 1/2."""
    ratios = sorted({row.packet_error_ratio for row in result.tracking})
    if not ratios:
        axes.text(0.5, 0.5, "not evaluated", transform=axes.transAxes, ha="center", color="#666666")
        axes.set_xticks([])
        return
    axes.set_yscale("log", base=2)
    for name, look in looks.items():
        values = np.array(worst_rows(result, name, protocol, percentile))
        _draw_line(axes, name, look, values, _worst_limits(result, name, protocol, percentile))
    _baseline(axes)
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:.3g}")
    axes.set_xticks(range(len(ratios)), [f"{100 * ratio:.4g}" for ratio in ratios])
    axes.set_xlim(-0.5, len(ratios) - 0.5)
    axes.grid(visible=False, axis="x")


def _worst_limits(
    result: ComparisonResult, name: str, protocol: str, percentile: int
) -> list[tuple[float | None, float | None]]:
    """Return the interval of the threshold that `worst_rows` names, at each loss ratio."""
    by_ratio: dict[float, list[Row]] = {}
    for row in result.tracking:
        if (row.trip, row.candidate, row.protocol) == (POOLED, name, protocol):
            by_ratio.setdefault(row.packet_error_ratio, []).append(row)
    key = attrgetter(f"p{percentile}_ratio")
    limits = attrgetter(f"p{percentile}_low", f"p{percentile}_high")
    return [limits(max(by_ratio[ratio], key=key)) for ratio in sorted(by_ratio)]


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


def _baseline(axes: Axes) -> None:
    axes.axhline(1.0, color=INK, linewidth=1.1, label="Baseline (CV)", zorder=1)
