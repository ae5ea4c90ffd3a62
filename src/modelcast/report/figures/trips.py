"""Message rate and tracking error of each trip."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelcast.report.figures.panels import drawable, empty_figure, policy_labels
from modelcast.report.headline import (
    HEADLINE_RATIO,
    evaluated_ratios,
    main_bank,
    nearest_ratio,
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
from modelcast.study.result import POOLED, EvaluationResult
from modelcast.study.wording import centimetres

__all__ = ["MOST_ROWS", "plot_trips"]

MOST_ROWS = 60
"""More trips than this are drawn as a distribution over the trips."""

_ByTrip = Mapping[str, float]
_THRESHOLD_M = 0.5


def plot_trips(result: EvaluationResult) -> Figure:
    """Return the message rate and the tracking error of every trip at the threshold nearest to 50 cm.

    Parameters
    ----------
    result
        The evaluation.
    """
    thresholds_m = sorted({row.threshold_m for row in result.rates if row.trip != POOLED})
    with style():
        if not thresholds_m:
            return empty_figure("Rows of single trips are not in this result.")
        threshold_m = min(thresholds_m, key=lambda item: abs(item - _THRESHOLD_M))
        rates = _rates(result, threshold_m)
        ratio = nearest_ratio(evaluated_ratios(result), HEADLINE_RATIO)
        errors = _errors(result, threshold_m, ratio)
        names = sorted({name for by_trip in rates.values() for name in by_trip}, reverse=True)
        names.sort(key=lambda name: rates["baseline"].get(name, 0.0))
        rows = len(names) if len(names) <= MOST_ROWS else 0
        figure = new_figure(PAGE_IN, 1.1 + 0.125 * rows if rows else 3.0)
        left, right = figure.subplots(1, 2, sharey=True)
        for axes, values in ((left, rates), (right, errors)):
            if rows:
                _draw_rows(axes, names, values)
            else:
                _draw_distribution(axes, values)
        _label((left, right), threshold_m, ratio)
        if rows:
            left.set_yticks(range(rows), _short(names), fontsize=6.0)
            left.set_ylim(-0.8, rows - 0.2)
        else:
            left.set_ylabel(f"Share of {len(names)} trips")
        _legend(figure, result)
        return figure


def _short(names: Sequence[str]) -> list[str]:
    """The names, without the file's where all trips come from one."""
    files = {name.rpartition("/")[0] for name in names}
    shown = [name.rpartition("/")[2] for name in names] if len(files) == 1 else names
    return [drawable(name, 30) for name in shown]


def _rates(result: EvaluationResult, threshold_m: float) -> dict[str, _ByTrip]:
    bank = main_bank(result)
    found: dict[str, dict[str, float]] = {"mbc": {}, "baseline": {}}
    for row in result.rates:
        role = role_of(result, row.policy)
        if row.trip == POOLED or row.threshold_m != threshold_m or role not in found:
            continue
        if role != "mbc" or row.bank == bank:
            found[role].setdefault(row.trip, row.total_rate_hz)
    return dict(found)


def _errors(result: EvaluationResult, threshold_m: float, ratio: float | None) -> dict[str, _ByTrip]:
    found: dict[str, dict[str, float]] = {"mbc": {}, "baseline-matched": {}}
    rows = [
        row
        for row in result.tracking
        if row.trip != POOLED and row.threshold_m == threshold_m and row.packet_error_ratio == ratio
    ]
    by_trip: dict[tuple[str, str], list[int]] = {}
    for at, row in enumerate(rows):
        role = role_of(result, row.policy)
        if role in found:
            by_trip.setdefault((role, row.trip), []).append(at)
    for (policy, trip), places in by_trip.items():
        for row in tracking_of(result, [rows[at] for at in places]):
            found[policy][trip] = row.pte_p90_m
    return dict(found)


def _draw_rows(axes: Axes, names: Sequence[str], values: Mapping[str, _ByTrip]) -> None:
    """Draw a dot for each policy on the trip's row, joined by a line so that the eye finds the pair."""
    places = np.arange(len(names))
    columns = {policy: np.array([by.get(name, np.nan) for name in names]) for policy, by in values.items()}
    first, second = columns.values()
    both = np.isfinite(first) & np.isfinite(second)
    axes.hlines(places[both], first[both], second[both], color=FAINT, linewidth=1.4, zorder=1)
    for policy, column in reversed(columns.items()):
        axes.plot(
            column,
            places,
            POLICY_MARKERS[policy],
            color=POLICY_COLOURS[policy],
            markeredgecolor="white",
            markeredgewidth=0.4,
            markersize=4.5,
        )
    axes.tick_params(axis="y", length=0)


def _draw_distribution(axes: Axes, values: Mapping[str, _ByTrip]) -> None:
    for policy, by_trip in values.items():
        if by_trip:
            axes.ecdf(list(by_trip.values()), color=POLICY_COLOURS[policy], linestyle=POLICY_LINES[policy])
    axes.set_ylim(0.0, 1.02)


def _label(panels: tuple[Axes, Axes], threshold_m: float, ratio: float | None) -> None:
    left, right = panels
    left.set_title(f"Threshold {centimetres(threshold_m)}, without loss")
    left.set_xlabel("Message rate [1/s]")
    _from_zero(left)
    if ratio is None:
        right.set_axis_off()
        return
    right.set_title(f"Threshold {centimetres(threshold_m)}, packet error ratio {100 * ratio:.4g} %")
    right.set_xlabel("90th percentile of the tracking error [m]")
    _from_zero(right)


def _from_zero(axes: Axes) -> None:
    """Start at 0 and leave room for a whole marker at the largest value."""
    axes.set_xlim(
        0.0, 1.06 * axes.dataLim.x1 if np.isfinite(axes.dataLim.x1) and axes.dataLim.x1 > 0 else 1.0
    )


def _legend(figure: Figure, result: EvaluationResult) -> None:
    handles = figure.axes[0].get_lines() + figure.axes[1].get_lines()
    named = policy_labels(result)
    labels = {POLICY_COLOURS[role]: named[role] for role in ("mbc", "baseline", "baseline-matched")}
    by_colour = {str(handle.get_color()): handle for handle in handles}
    shown = [(by_colour[colour], label) for colour, label in labels.items() if colour in by_colour]
    figure.legend(
        [handle for handle, _ in shown],
        [label for _, label in shown],
        loc="outside lower center",
        ncols=len(shown),
        columnspacing=1.2,
    )
