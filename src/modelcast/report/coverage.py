"""Coverage in the terminal and as figures: shares inside ellipses, and expected against observed times."""

from math import isnan
from pathlib import Path

from rich.console import Group, RenderableType

from modelcast.core.cells import Cells
from modelcast.models.calibration import LEVELS
from modelcast.report.console_table import ConsoleTable, console_table
from modelcast.report.figures.coverage import plot_coverage, plot_times
from modelcast.report.figures.files import drawn, write_drawings
from modelcast.report.style import style
from modelcast.study.coverage import FORMS, CoverageResult

__all__ = ["coverage_report", "write_coverage_figures"]

_SHOWN_S = (0.5, 1.0, 2.0, 3.0)


def coverage_report(result: CoverageResult) -> RenderableType:
    """Return the tables of a coverage run.

    Parameters
    ----------
    result
        What was found.
    """
    return Group(_coverage_table(result), _times_table(result))


def write_coverage_figures(result: CoverageResult, folder: Path) -> list[Path]:
    """Write the figures ``coverage`` and ``times`` as PNG, SVG and PDF; return the paths.

    Parameters
    ----------
    result
        What was found.
    folder
        An existing folder.
    """
    with style():
        figures = {"coverage": plot_coverage(result.rows), "times": plot_times(result.times)}
        return write_drawings([drawn(name, figure) for name, figure in figures.items()], folder)


def _coverage_table(result: CoverageResult) -> ConsoleTable:
    found = {(r.sub_model, r.form, r.horizon_s, r.level): r.covered_ratio for r in result.rows}
    rows: list[list[str]] = []
    for name in dict.fromkeys(row.sub_model for row in result.rows):
        for form in FORMS:
            cells = [
                "/".join(
                    f"{100 * found[key]:.0f}" if (key := (name, form, horizon_s, level)) in found else "-"
                    for level in LEVELS
                )
                for horizon_s in _SHOWN_S
            ]
            rows.append([name if form == FORMS[0] else "", form, *cells])
    heads = ["sub-model", "ellipse", *(f"{horizon_s:g} s" for horizon_s in _SHOWN_S)]
    return console_table(Cells(heads, rows, 2), "Errors inside the ellipses of 50/90/95 % [%]")


def _times_table(result: CoverageResult) -> ConsoleTable:
    rows = [
        [
            row.sub_model,
            row.form,
            f"{100 * row.threshold_m:.4g} cm",
            f"{row.expected_s:.2f} / {row.observed_s:.2f}",
            "-" if isnan(row.rank_correlation) else f"{row.rank_correlation:.2f}",
        ]
        for row in result.times
    ]
    heads = ("sub-model", "ellipse", "threshold", "expected / observed", "correlation")
    return console_table(Cells(heads, rows, 2), "Time until the threshold [s]")
