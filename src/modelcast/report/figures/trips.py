"""Message rate and tracking error of each trip."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelcast.report.figures.panels import drawable, empty_figure, policy_labels
from modelcast.report.headline import (
    SAME_THRESHOLD,
    detail_threshold_m,
    evaluated_ratios,
    main_bank,
    role_of,
    tracking_of,
)
from modelcast.report.style import (
    FAINT,
    PAGE_IN,
    POLICY_COLOURS,
    POLICY_LINES,
    POLICY_MARKERS,
    new_figure,
    style,
)
from modelcast.study.loss_ratios import nearest_ratio
from modelcast.study.result import POOLED, EvaluationResult
from modelcast.study.rules import FREE_MATCHED, FREE_RECEIVER, MODEL_SENDER
from modelcast.study.table import Row
from modelcast.study.wording import centimetres

__all__ = ["MOST_ROWS", "plot_trips"]

MOST_ROWS = 60
"""More trips than this are drawn as a distribution over the trips."""

_ByTrip = Mapping[str, float]
_OUTLINED = (FREE_RECEIVER, FREE_MATCHED)
_SHOWN = {"same threshold": SAME_THRESHOLD, "same rate": (MODEL_SENDER, FREE_MATCHED, "baseline-matched")}
"""Whose errors are drawn in each reading: of the equal-rate baselines the error-driven one alone."""


def plot_trips(result: EvaluationResult) -> Figure:
    """Return the message rate of every trip and its tracking error in both readings, at one threshold.

    Parameters
    ----------
    result
        The evaluation.
    """
    threshold_m = detail_threshold_m(result)
    with style():
        if threshold_m is None or all(row.trip == POOLED for row in result.rates):
            return empty_figure("Rows of single trips are not in this result.")
        rates = _rates(result, threshold_m)
        ratio = nearest_ratio(evaluated_ratios(result))
        errors = {name: _errors(result, roles, threshold_m, ratio) for name, roles in _SHOWN.items()}
        names = sorted({name for by_trip in rates.values() for name in by_trip}, reverse=True)
        names.sort(key=lambda name: rates["baseline"].get(name, 0.0))
        rows = len(names) if len(names) <= MOST_ROWS else 0
        figure = new_figure(PAGE_IN, 1.35 + 0.125 * rows if rows else 3.2)
        panels = list(figure.subplots(1, 1 + len(_SHOWN), sharey=True))
        for axes, values in zip(panels, (rates, *errors.values()), strict=True):
            if rows:
                _draw_rows(axes, names, values)
            else:
                _draw_distribution(axes, values)
        _label(panels, threshold_m, ratio)
        if rows:
            panels[0].set_yticks(range(rows), _short(names), fontsize=6.0)
            panels[0].set_ylim(-0.8, rows - 0.2)
        else:
            panels[0].set_ylabel(f"Share of {len(names)} trips")
        _legend(figure, result)
        return figure


def _short(names: Sequence[str]) -> list[str]:
    """The names, of several trips from one file without the file's."""
    files = {name.rpartition("/")[0] for name in names}
    shared = len(names) > 1 and len(files) == 1
    return [drawable(name.rpartition("/")[2] if shared else name, 30) for name in names]


def _rates(result: EvaluationResult, threshold_m: float) -> dict[str, _ByTrip]:
    bank = main_bank(result)
    found: dict[str, dict[str, float]] = {role: {} for role in SAME_THRESHOLD}
    for row in result.rates:
        role = role_of(result, row.policy)
        if row.trip == POOLED or row.threshold_m != threshold_m or role not in found:
            continue
        if role != MODEL_SENDER or row.bank == bank:
            found[role].setdefault(row.trip, row.total_rate_hz)
    return dict(found)


def _errors(
    result: EvaluationResult, roles: Sequence[str], threshold_m: float, ratio: float | None
) -> dict[str, _ByTrip]:
    found: dict[str, dict[str, float]] = {role: {} for role in roles}
    by_trip: dict[tuple[str, str], list[Row]] = {}
    for row in result.tracking:
        role = role_of(result, row.policy)
        shown = row.threshold_m == threshold_m and row.packet_error_ratio == ratio
        if shown and row.trip != POOLED and role in found:
            by_trip.setdefault((role, row.trip), []).append(row)
    for (role, trip), rows in by_trip.items():
        for row in tracking_of(result, rows):
            found[role][trip] = row.pte_p90_m
    return dict(found)


def _draw_rows(axes: Axes, names: Sequence[str], values: Mapping[str, _ByTrip]) -> None:
    """Draw a dot for each policy on the trip's row, joined by a line so that the eye finds them."""
    places = np.arange(len(names))
    columns = {
        policy: np.array([by.get(name, np.nan) for name in names]) for policy, by in values.items() if by
    }
    if columns:
        values_of = np.stack(list(columns.values()))
        known = np.isfinite(values_of).any(axis=0)
        low, high = np.nanmin(values_of[:, known], axis=0), np.nanmax(values_of[:, known], axis=0)
        axes.hlines(places[known], low, high, color=FAINT, linewidth=1.4, zorder=1)
    for policy, column in reversed(columns.items()):
        # The free receiver is often where MBC is: it is drawn as an outline about it.
        outlined = policy in _OUTLINED
        colour = POLICY_COLOURS[policy]
        axes.plot(
            column,
            places,
            POLICY_MARKERS[policy],
            color=colour,
            markerfacecolor="none" if outlined else colour,
            markeredgecolor=colour if outlined else "white",
            markeredgewidth=0.9 if outlined else 0.4,
            markersize=6.5 if outlined else 4.5,
            label=policy,
            zorder=3 if outlined else 2,
        )
    axes.tick_params(axis="y", length=0)


def _draw_distribution(axes: Axes, values: Mapping[str, _ByTrip]) -> None:
    for policy, by_trip in values.items():
        if by_trip:
            axes.ecdf(
                list(by_trip.values()),
                color=POLICY_COLOURS[policy],
                linestyle=POLICY_LINES[policy],
                label=policy,
            )
    axes.set_ylim(0.0, 1.02)


def _label(panels: Sequence[Axes], threshold_m: float, ratio: float | None) -> None:
    rates, *errors = panels
    rates.set_title(f"Threshold {centimetres(threshold_m)}, without loss")
    rates.set_xlabel("Message rate [1/s]")
    _from_zero(rates)
    for axes, reading in zip(errors, _SHOWN, strict=True):
        if ratio is None:
            axes.set_axis_off()
            continue
        axes.set_title(f"{reading.capitalize()}, {100 * ratio:.4g} % lost")
        axes.set_xlabel("90th percentile of the PTE [m]")
        _from_zero(axes)


def _from_zero(axes: Axes) -> None:
    """Start at 0 and leave room for a whole marker at the largest value."""
    axes.set_xlim(
        0.0, 1.06 * axes.dataLim.x1 if np.isfinite(axes.dataLim.x1) and axes.dataLim.x1 > 0 else 1.0
    )


def _legend(figure: Figure, result: EvaluationResult) -> None:
    named = policy_labels(result)
    drawn = {str(line.get_label()): line for axes in figure.axes for line in axes.get_lines()}
    shown = [(drawn[role], label) for role, label in named.items() if role in drawn]
    figure.legend(
        [handle for handle, _ in shown],
        [label for _, label in shown],
        loc="outside lower center",
        ncols=3,
        columnspacing=1.2,
    )
