"""What hosts of fleets on the air miss and warn of wrongly, against what is sent; and over a mixed fleet."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelcast.core.arrays import FloatArray
from modelcast.report.figures.maps import draw_map
from modelcast.report.figures.panels import drawable, empty_figure, top_legend
from modelcast.report.figures.senders import Marker, sender_look, threshold_text
from modelcast.report.style import PAGE_IN, new_figure
from modelcast.station.receiver.reading import Reading
from modelcast.study.network.mixed import mixed_of
from modelcast.study.network.rows import NetworkResult
from modelcast.study.network.warning_rows import ALL_SENDERS
from modelcast.study.table import Row

__all__ = ["plot_warned_map", "plot_warnings"]

_ROW_IN, _HEAD_IN, _MAP_IN = 2.1, 0.6, 2.4
_LONGEST_S = 2.0


def plot_warnings(result: NetworkResult) -> Figure:
    """Return missed and false warnings against messages, and how late they come: a row a place.

    Parameters
    ----------
    result
        Runs of fleets of one kind, whose hosts have applications.
    """
    rows = [row for row in result.pooled_warnings if row.events and not mixed_of(row.policy).is_mixed]
    places = list(dict.fromkeys((row.application, row.radio, repr(row.density_per_km)) for row in rows))
    if not places:
        return empty_figure("There was no true warning.")
    names = list(dict.fromkeys(row.policy for row in rows))
    figure = new_figure(PAGE_IN, _HEAD_IN + _ROW_IN * len(places))
    panels = figure.subplots(len(places), 3, squeeze=False)
    for line, place in zip(panels, places, strict=True):
        own = [row for row in rows if (row.application, row.radio, repr(row.density_per_km)) == place]
        for name in names:
            mine = sorted(
                (row for row in own if row.policy == name), key=lambda row: (row.bank, row.message_rate_hz)
            )
            colour, marker = sender_look(name)
            for axes, field in ((line[0], "missed"), (line[1], "false")):
                _draw_shares(axes, mine, field, (drawable(name, 30), colour, marker))
            for row, width in zip(mine, np.linspace(1.4, 0.7, len(mine)), strict=True):
                _draw_delays(line[2], result, row, colour, float(width))
        density = own[0].density_per_km
        where = f"{place[0]}, {place[1]}" + (f", {density:g}/km" if np.isfinite(density) else "")
        line[0].set_ylabel(f"{where}\nMissed [%]")
        line[1].set_ylabel("False [%]")
        line[2].set_ylabel("Warnings given [%]")
        line[2].set_ylim(0.0, 101.0)
        for axes in line[:2]:
            axes.set_ylim(bottom=0.0)
            axes.set_xlim(left=0.0)
    for axes, label in zip(
        panels[-1], ("Messages [1/s]", "Messages [1/s]", "Late by at most [s]"), strict=True
    ):
        axes.set_xlabel(label)
    top_legend(figure, panels[0, 0])
    return figure


def _draw_shares(axes: Axes, own: Sequence[Row], field: str, how: tuple[str, str, Marker]) -> None:
    """Draw a policy's shares with their intervals; banks and thresholds are written beside."""
    name, colour, marker = how
    rate = [row.message_rate_hz for row in own]
    value: FloatArray = 100.0 * np.array([getattr(row, f"{field}_ratio") for row in own])
    ends = [[getattr(row, f"{field}_{end}") for row in own] for end in ("low", "high")]
    low, high = (np.array([np.nan if one is None else 100.0 * one for one in side]) for side in ends)
    bars = np.nan_to_num(np.abs(np.stack([value - low, high - value])))
    axes.errorbar(
        rate,
        value,
        yerr=bars,
        marker=marker,
        markersize=4,
        color=colour,
        linewidth=0.8,
        elinewidth=0.8,
        label=name,
    )
    if len(own) > 1:
        for row, x, y in zip(own, rate, value.tolist(), strict=True):
            text = threshold_text(row.threshold_m)
            axes.annotate(text, (x, y), textcoords="offset points", xytext=(4, 3), fontsize=5.5, color=colour)


def _draw_delays(axes: Axes, result: NetworkResult, row: Row, colour: str, width: float) -> None:
    keys = ("density_per_km", "radio", "policy", "bank", "threshold_m", "application", "reading")
    late_s = np.sort(
        [
            one.delay_s
            for one in result.warned_events
            if all(repr(getattr(one, key)) == repr(getattr(row, key)) for key in keys)
        ]
    )
    level = 100.0 * np.arange(1, late_s.size + 1) / late_s.size
    shown = late_s <= _LONGEST_S
    axes.step(
        np.concatenate([[0.0], late_s[shown], [_LONGEST_S]]),
        np.concatenate([[0.0], level[shown], [level[shown][-1] if shown.any() else 0.0]]),
        where="post",
        color=colour,
        linewidth=width,
    )


def plot_warned_map(result: NetworkResult, receivers_ratios: Sequence[float]) -> Figure:
    """Return the penetration maps of missed and of false warnings: a row an application and place.

    A share of the hosts reads models and the others read as legacy receivers do; hosts of both are assessed
    in every run, so a cell weights the two.

    Parameters
    ----------
    result
        Runs of mixed fleets, whose hosts have applications.
    receivers_ratios
        Shares of model receivers, 0..1.
    """
    rows = [row for row in result.pooled_warnings if row.sender == ALL_SENDERS and row.events]
    places = list(dict.fromkeys((row.application, row.radio, repr(row.density_per_km)) for row in rows))
    if not places or not receivers_ratios:
        return empty_figure("There was no true warning.")
    figure = new_figure(PAGE_IN, 0.3 + _MAP_IN * len(places))
    grid = figure.subplots(len(places), 2, squeeze=False)
    for line, place in zip(grid, places, strict=True):
        own = [row for row in rows if (row.application, row.radio, repr(row.density_per_km)) == place]
        by_share = {(mixed_of(row.policy).senders_ratio, row.reading): row for row in own}
        senders = sorted({share for share, _ in by_share})
        receivers = sorted(set(receivers_ratios))
        for axes, field, title in (
            (line[0], "missed_ratio", "Missed [%]"), (line[1], "false_ratio", "False [%]"),
        ):  # fmt: skip
            ends = [
                np.array([100.0 * getattr(by_share[share, reading.name.lower()], field) for share in senders])
                for reading in (Reading.LEGACY, Reading.MODEL)
            ]
            cells = np.stack([(1.0 - ratio) * ends[0] + ratio * ends[1] for ratio in receivers])
            draw_map(axes, cells, senders, receivers)
            axes.set_title(title)
        density = own[0].density_per_km
        where = f"{place[0]}, {place[1]}" + (f", {density:g}/km" if np.isfinite(density) else "")
        line[0].set_ylabel(f"{where}\nread models [%]")
    for axes in grid[-1]:
        axes.set_xlabel("send by the last policy [%]")
    return figure
