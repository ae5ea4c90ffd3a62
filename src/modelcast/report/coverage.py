"""Coverage in the terminal: shares inside the ellipses, and expected against observed times."""

from math import isnan

from rich.console import Group, RenderableType
from rich.table import Table

from modelcast.models.calibration import LEVELS
from modelcast.report.literal import literal
from modelcast.study.coverage import FORMS, CoverageResult

__all__ = ["coverage_report"]

_SHOWN_S = (0.5, 1.0, 2.0, 3.0)


def coverage_report(result: CoverageResult) -> RenderableType:
    """Return the tables of a coverage run.

    Parameters
    ----------
    result
        What was found.
    """
    return Group(_coverage_table(result), _times_table(result))


def _coverage_table(result: CoverageResult) -> Table:
    table = Table(title="Errors inside the ellipses of 50/90/95 % [%]", title_justify="left")
    table.add_column("sub-model")
    table.add_column("ellipse")
    for horizon_s in _SHOWN_S:
        table.add_column(f"{horizon_s:g} s", justify="right")
    found = {(r.sub_model, r.form, r.horizon_s, r.level): r.covered_ratio for r in result.rows}
    for name in dict.fromkeys(row.sub_model for row in result.rows):
        for form in FORMS:
            cells = [
                "/".join(
                    f"{100 * found[key]:.0f}" if (key := (name, form, horizon_s, level)) in found else "-"
                    for level in LEVELS
                )
                for horizon_s in _SHOWN_S
            ]
            table.add_row(literal(name if form == FORMS[0] else ""), form, *cells)
    return table


def _times_table(result: CoverageResult) -> Table:
    table = Table(title="Time until the threshold [s]", title_justify="left")
    for heading in ("sub-model", "ellipse", "threshold", "expected / observed", "correlation"):
        table.add_column(heading, justify="left" if heading in {"sub-model", "ellipse"} else "right")
    for row in result.times:
        correlation = "-" if isnan(row.rank_correlation) else f"{row.rank_correlation:.2f}"
        table.add_row(
            literal(row.sub_model),
            row.form,
            f"{100 * row.threshold_m:.4g} cm",
            f"{row.expected_s:.2f} / {row.observed_s:.2f}",
            correlation,
        )
    return table
